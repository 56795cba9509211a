"""Each number that a sweep stores, against a value found by hand."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.model.case import OperatorCase
from studies.reference.line_contact import HERTZ, SCENE
from studies.registry import load

LINE = cs.Grid(cells=(64, 4), extent=(2.4 * HERTZ.half_width, HERTZ.half_width))


@dataclass(frozen=True)
class Hoard:
    """A computation that holds so many bytes at once, and lets go of them."""

    held: int
    grid: cs.Grid = LINE
    options: cs.SolveOptions = cs.SolveOptions()  # noqa: RUF009 (a frozen value)

    def prepare(self) -> None:
        """Nothing."""

    def run(self, prepared: None) -> np.ndarray:
        """All of it, then a little."""
        return np.ones(self.held, dtype=np.int8)[:1].copy()


# one cell of four
TOUCHING = replace(
    cs.solve(SCENE.problem(LINE, cs.ExactPeriodicity())),
    pressure=np.where(np.arange(64 * 4).reshape(64, 4) % 4 == 0, 1e9, 0.0),
)


def test_memory_of_an_effect_is_in_megabytes() -> None:
    found = load("effect_cost").measures(Hoard(40_000_000), TOUCHING)  # type: ignore[arg-type]
    assert float(found["memory"]) == pytest.approx(40, rel=1e-2)
    assert found["memory"].attrs["units"] == "MB"
    assert float(found["contact_fraction"]) == 0.25


def test_memory_of_a_solve_is_counted_in_fields_of_eight_bytes_a_cell() -> None:
    found = load("solvers").measures(Hoard(40_000_000), TOUCHING)  # type: ignore[arg-type]
    assert float(found["memory"]) == pytest.approx(40_000_000 / (64 * 4 * 8), rel=1e-2)
    assert float(found["contact_fraction"]) == 0.25


@pytest.mark.parametrize(
    ("padding", "padded"),
    [
        (cs.ZeroPadding(), (2 * 64) * (2 * 4)),
        (cs.Superposition(3), (2 * 64) * (2 * 4)),
        (cs.DuplicatedPadding(), (2 * 64) * 4),
        (cs.CircularSuperposition(3), (2 * 64) * 4),
        (cs.ExactPeriodicity(), (2 * 64) * 4),
    ],
    ids=str,
)
def test_only_an_axis_that_does_not_wrap_is_doubled(padding: cs.Padding, padded: int) -> None:
    case = OperatorCase(1e11, LINE, padding, datum=1.0)
    assert int(case.record(case.prepare())["padded_cells"]) == padded


def test_the_error_of_a_window_s_coefficients_is_that_of_its_logarithm() -> None:
    """Images beyond D take ``(x^2 / 2 - y^2) / (2 D^2)`` from the logarithm; half its range counts."""
    kernels = load("kernels")
    point = {"padding": "circular", "images": 6, "period": 2.4, "grid": 32}
    case = kernels.scene_at({axis.name: point[axis.name] for axis in kernels.points})
    found = float(kernels.measures(case, case.run(case.prepare()))["kernel_error"])
    reach = 6.5 * 2.4
    x, y = 2.4 * 31 / 32, 1.2  # the farthest pair across; half a period along
    law = (x**2 / 2 + y**2) / (2 * reach**2) / 2
    # the next order is a fraction (x / D)^2 of it, in a part of the range
    assert found == pytest.approx(law, rel=2 * (x / reach) ** 2)


def smooth(**changed: float) -> xr.Dataset:
    """What the study of rough surfaces says of none, by padding."""
    study = load("roughness")
    point = {"rms": 0.0, "hurst": 0.8, "peklenik": 1.0, "seed": 1, "images": 6, "period": 2.4}
    case = study.scene_at(point | {"grid": 80} | changed)
    return xr.Dataset(study.measures(case, case.run(case.prepare())))


def test_answers_of_a_smooth_contact_are_hertz_s() -> None:
    exact = smooth().sel(padding="exact")
    cell = 3.2 / 80  # in half-widths
    assert float(exact["contact_area"]) == pytest.approx(1, abs=2 * cell)
    assert float(exact["contact_extent"]) == pytest.approx(1, abs=cell)
    # the second moment of cells of constant pressure, a twelfth of a cell squared off, and its edge
    assert float(exact["half_width"]) == pytest.approx(1, abs=cell**1.5)
    assert float(exact["peak_pressure"]) == pytest.approx(1, abs=cell**2)
    assert float(exact["load_spread"]) == pytest.approx(0, abs=1e-7)
    assert float(exact["smooth_difference"]) == pytest.approx(0, abs=1e-6)


def test_a_free_length_is_compared_with_an_endless_one() -> None:
    """Zero padding leaves a short cylinder: what it differs by is found again from both pressures."""
    study = load("roughness")
    point = {
        "rms": 0.0,
        "hurst": 0.8,
        "peklenik": 1.0,
        "seed": 1,
        "images": 0,
        "period": 2.4,
        "grid": 40,
    }
    case = study.scene_at(point)
    solution = case.run(case.prepare())
    zero = xr.Dataset(study.measures(case, solution)).sel(padding="zero")
    scene, grid = case.scene, case.grid
    alone = cs.solve(scene.problem(grid, cs.ZeroPadding())).pressure
    endless = cs.solve(scene.problem(grid, cs.ExactPeriodicity())).pressure
    load_along = alone.mean(axis=0)
    spread = np.sqrt(((load_along - load_along.mean()) ** 2).mean()) / load_along.mean()
    assert float(zero["load_spread"]) == pytest.approx(spread, rel=1e-6)
    l1 = np.abs(alone - endless).mean() / endless.mean()
    assert float(zero["pressure_error_l1"]) == pytest.approx(l1, rel=1e-6)
    highest = (alone.max() - endless.max()) / endless.max()
    assert float(zero["peak_pressure_error"]) == pytest.approx(highest, rel=1e-6)
    largest = max(abs(alone - endless).ravel()) / HERTZ.peak_pressure
    assert float(zero["pressure_error_max"]) == pytest.approx(largest, rel=1e-6)
