from math import pi

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.settings import case_at
from studies.model.case import Case
from studies.reference.line_contact import (
    HERTZ,
    HERTZ_HEIGHT,
    SCENE,
    WIDTH,
    hertz_errors,
    hertz_means,
    measures,
)
from studies.registry import load

CELLS = 96
CASE = case_at({"padding": "exact", "images": 0, "period": 2.4, "grid": CELLS})
X = CASE.grid.x[:, None]
# of the domain over Hertz's half-width, and its square root's rate at an edge
CELL = WIDTH / CELLS


def errors_of(pressure: np.ndarray) -> dict[str, float]:
    return hertz_errors(HERTZ, CASE.grid, np.broadcast_to(pressure, CASE.grid.cells))


def largest_l1_error(grid: cs.Grid, padding: cs.Padding = CASE.padding) -> float:
    """That which is stored: the largest over places of the edge in its cell."""
    case = Case(SCENE, grid, padding, CASE.options)
    return float(measures(case, case.run(case.prepare()))["pressure_error_l1"])


def test_the_scene_is_hertz_s_with_the_numbers_of_the_paper() -> None:
    modulus = 210e9 / (2 * (1 - 0.3**2))
    half_width = (4 * 1e5 * 0.01 / (pi * modulus)) ** 0.5
    assert HERTZ.half_width == pytest.approx(half_width, rel=1e-12)
    assert HERTZ.peak_pressure == pytest.approx(2 * 1e5 / (pi * half_width), rel=1e-12)
    assert CASE.grid.extent == pytest.approx((2.4 * half_width, 2.4 * half_width), rel=1e-12)
    # the cylinder's height a half-width from its axis
    assert pytest.approx(half_width**2 / (2 * 0.01), rel=1e-12) == HERTZ_HEIGHT


def test_the_true_pressure_has_no_error_but_that_of_its_samples() -> None:
    sampled, mean = errors_of(HERTZ.pressure(X)), errors_of(hertz_means(HERTZ, CASE.grid))
    assert mean["pressure_error_l1"] < 1e-12
    assert abs(mean["axis_pressure_error"]) < 1e-12
    assert sampled["pressure_error_max"] == sampled["length_variation"] == 0
    # half a cell from the peak, over the mean of the same cell by Simpson's rule
    beside = (1 - (CELL / 2) ** 2) ** 0.5
    of_cell = (1 + 4 * beside + (1 - CELL**2) ** 0.5) / 6
    for name in ("axis_pressure_error", "peak_pressure_error"):
        assert sampled[name] == pytest.approx(beside / of_cell - 1, rel=1e-3)


def test_a_uniform_excess_is_its_share_of_the_load_in_l1() -> None:
    """A tenth of p_H over 2.4 a, of a load of pi a p_H / 2."""
    found = errors_of(HERTZ.pressure(X) + 0.1 * HERTZ.peak_pressure)
    means = errors_of(hertz_means(HERTZ, CASE.grid) + 0.1 * HERTZ.peak_pressure)
    assert means["pressure_error_l1"] == pytest.approx(0.1 * 2.4 / (pi / 2), rel=1e-12)
    assert found["pressure_error_max"] == pytest.approx(0.1, rel=1e-12)
    for name in ("peak_pressure_error", "axis_pressure_error"):
        assert found[name] == pytest.approx(0.1, abs=CELL**2)


def test_the_error_of_a_grid_falls_with_the_power_three_halves() -> None:
    """Without luck: 24 and 60 cells over 2.4 a have the edge on a border of cells, 35 and 81 elsewhere."""
    for cells in (24, 35, 60, 81):
        error = largest_l1_error(cs.Grid((cells, 1), (WIDTH * HERTZ.half_width, HERTZ.half_width)))
        # the width may differ by half a cell per half-width
        difference = 1.5 * 0.5 * WIDTH / cells
        assert error / (WIDTH / cells) ** 1.5 == pytest.approx(0.43, rel=0.01 + difference)


def test_the_pressure_of_fig_5_is_that_in_the_middle_of_the_length() -> None:
    """A window of one image makes the pressure vary along the length, so that the place matters."""
    study = load("paper").override({"padding": "superposed", "images": "1"})
    [case] = study.cases()
    solution = case.run(case.prepare())
    found = study.measures(case, solution)
    scaled = solution.pressure / HERTZ.peak_pressure
    assert found["pressure"].values == pytest.approx(scaled[:, 80], rel=1e-12)
    assert scaled[:, 80] != pytest.approx(scaled[:, 50], rel=1e-3)
    true = HERTZ.pressure(case.grid.x) / HERTZ.peak_pressure  # type: ignore[attr-defined]
    assert found["pressure_true"].values == pytest.approx(true, rel=1e-12)
    # pressure is constant in each cell, whose borders stand beside its centre
    borders = found[found["x"].attrs["bounds"]].values
    assert borders[:, 0] == pytest.approx(found["x"].values - 1.2 / 128, abs=1e-12)
