"""Each number that a sweep stores, against a value found by hand."""

from dataclasses import dataclass, replace
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.special import erf

import contactstudy as cs
from studies.definitions import stability
from studies.definitions.speed import SLOPE, self_affine
from studies.engine.run import run
from studies.model.case import OperatorCase
from studies.reference.line_contact import HERTZ, SCENE
from studies.registry import load
from tests.studies.conftest import quiet

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


def test_memory_of_a_solve_is_counted_in_fields_of_eight_bytes_a_cell() -> None:
    found = load("solvers").measures(Hoard(40_000_000), TOUCHING)  # type: ignore[arg-type]
    assert float(found["memory"]) == pytest.approx(40_000_000 / (64 * 4 * 8), rel=1e-2)
    assert float(found["contact_fraction"]) == 0.25


@pytest.mark.parametrize(
    ("padding", "padded"),
    [
        (cs.ZeroPadding(), (2 * 64) * (2 * 4)),
        (cs.Superposition(3), (2 * 64) * (2 * 4)), (cs.DuplicatedPadding(), (2 * 64) * 4),
        (cs.CircularSuperposition(3), (2 * 64) * 4), (cs.ExactPeriodicity(), (2 * 64) * 4),
    ],
    ids=str,
)  # fmt: skip
def test_only_an_axis_that_does_not_wrap_is_doubled(padding: cs.Padding, padded: int) -> None:
    case = OperatorCase(1e11, LINE, padding, datum=1.0)
    assert int(case.record(case.prepare())["padded_cells"]) == padded


@pytest.mark.whole
def test_the_error_of_creep_falls_with_the_steps_under_its_estimate(tmp_path: Path) -> None:
    study = load("creep").override({"steps": "10,20,40", "grid": "64,512"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    assert (dataset["solver_status"] == 0).all()
    fine = dataset.sel(grid=512)
    error = fine["pressure_error_l1"].values
    # by the 1.5th power at least, until the cells count
    assert (error[:-1] / error[1:] > 2).all()
    # the estimate is of the steps alone; 512 cells leave 0.35 (dx / a)^1.5 = 2e-4
    assert (fine["step_error"].values + 3e-4 > error).all()
    # creep multiplies compliance by 1 + 1.5 (1 - exp(-2))
    widest = float(fine["half_width"].isel(steps=-1, time=-1))
    assert abs(widest - np.sqrt(1 + 1.5 * (1 - np.exp(-2)))) < 0.36 / 512 / 0.1


@pytest.mark.whole
def test_explicit_wear_breaks_before_its_limit_and_implicit_never(tmp_path: Path) -> None:
    study = load("wear").override({"steps": "16,32,128"})
    stored = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    dataset = stored.isel(grid=0)
    error = dataset["pressure_error_l1"]
    stable = dataset["longest_explicit"].sel(scheme="explicit") > 1
    assert stable.values.tolist() == [False, False, True]
    assert (error.sel(scheme="explicit")[:2] > 0.5).all()
    assert error.sel(scheme="explicit")[2] < 1e-2
    assert (error.sel(scheme="implicit") < 2e-2).all()
    assert (error.sel(scheme="two-stage") < error.sel(scheme="implicit")).all()
    assert float(dataset["volume_error"].max()) < 1e-13
    # between the rigid law and that of the cubes added, and a little above: 2 and 9^(1/3) = 2.08
    last = float(dataset["half_width"].sel(scheme="two-stage").isel(steps=-1, distance=-1))
    assert 2 < last < 2.2


@pytest.mark.whole
def test_a_contact_that_yields_nears_the_known_one_and_a_hardness_does_not(tmp_path: Path) -> None:
    """Errors are of first order in the steps: 0.75 % of the pressure with 8, by finite elements too."""
    study = load("plastic").override({"pressure": "1.5,3", "steps": "4,8", "grid": "48"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet).isel(grid=0, hardening=0)
    assert (dataset["solver_status"] == 0).all()
    known = dataset.sel(pressure=3.0)
    error = known["peak_pressure_error"].values
    assert error[1] < 1.5e-2
    assert 1.4 < error[0] / error[1] < 2.5
    # a cell is a seventh of the half-width, a layer down there two of them
    assert float(known["half_width_error"][1]) < 0.1
    assert float(known["plastic_depth_error"][1]) < 0.1
    assert float(known["dent_error"][1]) < 0.03
    # on 48 cells the lower edge of the layer in which the known depth lies, or of the one above
    assert 2.3 < float(known["plastic_depth"][1]) < 2.7
    elastic = dataset.sel(pressure=1.5).isel(steps=-1)
    assert float(elastic["plastic_depth"]) == 0.0
    assert float(elastic["dent"]) == 0.0
    assert float(elastic["hardness_limited_difference"]) < 1e-6
    # 2.8 Y over 3 Y, not 0.787
    assert float(known["hardness_limited_pressure"][1]) == pytest.approx(2.8 / 3, abs=1e-9)
    assert float(known["hardness_limited_difference"][1]) > 0.1


POINT = {
    "surface": "self-affine", "hurst": 0.5, "cut_off": 4.0, "fraction": 0.3, "precision": "double",
    "device": "cpu", "threads": 1, "grid": 32,
}  # fmt: skip


def test_a_self_affine_surface_bears_the_load_of_its_share_and_ends_at_so_many_cells() -> None:
    """Persson (2001): the fraction is erf(sqrt(2) p / (E* slope)), p the mean pressure."""
    grid = cs.Grid((64, 64), (3e-3, 3e-3))
    scene = self_affine(grid, 0.5, 4.0, 0.3)
    mean = scene.load.largest / 3e-3
    shape = scene.shapes[0]
    assert shape.rms == cs.RmsSlope(0.1)
    assert shape.roll_off == pytest.approx(3e-3 / 4)
    assert erf(np.sqrt(2) * mean / (SCENE.contact_modulus * SLOPE)) == pytest.approx(0.3)
    waves = np.abs(np.fft.rfft2(scene.shapes[0].gap(grid)))  # type: ignore[union-attr]
    index = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.rfftfreq(64), indexing="ij"))
    assert waves[index > 1.001 / 4].max() < 1e-12 * waves.max() < waves[index > 0.9 / 4].max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fraction": 1.0}, r"^fraction is 1\.0: give a fraction between 0 and 1\."),
        ({"cut_off": 0.0}, r"^cut_off is 0\.0: give a number of cells above 0\."),
        ({"threads": 0}, r"^threads is 0: must be a whole number of threads, at least 1\."),
        ({"device": "gpu"}, "^Gpu "),
        ({"surface": "smoth"}, "^surface is 'smoth': did you mean 'smooth'"),
        ({"precision": "half"}, "^precision is 'half': give 'single' or 'double'"),
    ],
)
def test_a_point_that_is_none_is_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(cs.InvalidInput, match=message):
        load("speed").case_at(POINT | change)


DONE, LIMIT, STALLED = cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT, cs.Status.STALLED

RIGHT, EXPLAINED, WRONG, NOT = range(4)


@pytest.mark.parametrize(
    ("status", "residual", "padding", "error", "verdict"),
    [
        (DONE, 1e-6, "exact", 0.02, RIGHT), (DONE, 1e-6, "exact", 0.021, WRONG),
        # it claims nothing
        (DONE, 1.1e-6, "exact", 0.01, EXPLAINED),
        # no more can be had of its numbers, and that is a claim
        (LIMIT, 1e-3, "exact", 0.01, RIGHT), (STALLED, 1e-3, "exact", 0.01, WRONG),
        (STALLED, 1e-7, "exact", 0.01, WRONG), (DONE, 1e-7, "zero", 0.01, NOT),
    ],
)  # fmt: skip
def test_a_case_is_right_within_its_stated_error_and_else_must_say_why(
    status: cs.Status,
    residual: float,
    padding: str,
    error: float,
    verdict: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = SimpleNamespace(
        options=cs.SolveOptions(1e-6),
        paddings=("exact",),
        allowed_statuses=lambda _: {DONE, LIMIT},
        error_and_bound=lambda *_: (error, 0.02),
    )
    monkeypatch.setattr(stability, "CASES", {"made up": case})
    one = stability.HardCaseRun("made up", padding, "Polonsky-Keer")
    solution: Any = SimpleNamespace(status=status, residual=residual)
    found = {name: float(of) for name, of in load("stability").measures(one, solution).items()}
    assert found["verdict"] == verdict
    judged = padding == "exact" and (residual <= 1e-6 or status is LIMIT)
    assert found["pressure_error"] == (error if judged else 0)
    assert found["stated_error"] == (0.02 if judged else inf)
