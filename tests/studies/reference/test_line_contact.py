from dataclasses import replace
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
    relative_l1,
)

CELLS = 96
POINT = {"padding": "exact", "images": 0, "period": 2.4, "grid": CELLS}
CASE = case_at(POINT)
X = CASE.grid.x[:, None]
# of the domain over Hertz's half-width, and its square root's rate at an edge
CELL = WIDTH / CELLS
TRUE = np.broadcast_to(HERTZ.pressure(X), CASE.grid.cells)


def measured(pressure: np.ndarray) -> dict[str, float]:
    """The errors of this pressure [Pa]."""
    return hertz_errors(HERTZ, CASE.grid, np.array(pressure))


def largest_l1_error(grid: cs.Grid, padding: cs.Padding = CASE.padding) -> float:
    """That which is stored: the largest over places of the edge in its cell."""
    case = Case(SCENE, grid, padding, CASE.options)
    return float(measures(case, case.run(case.prepare()))["pressure_error_l1"])


def test_the_scene_is_hertz_s_with_the_numbers_of_the_paper() -> None:
    modulus = 210e9 / (2 * (1 - 0.3**2))
    assert SCENE.contact_modulus == pytest.approx(modulus, rel=1e-12)
    half_width = (4 * 1e5 * 0.01 / (pi * modulus)) ** 0.5
    assert HERTZ.half_width == pytest.approx(half_width, rel=1e-12)
    assert HERTZ.peak_pressure == pytest.approx(2 * 1e5 / (pi * half_width), rel=1e-12)
    assert CASE.grid.extent == pytest.approx((2.4 * half_width, 2.4 * half_width), rel=1e-12)
    assert CASE.grid.cells == (CELLS, CELLS)
    # the cylinder's height a half-width from its axis
    assert pytest.approx(half_width**2 / (2 * 0.01), rel=1e-12) == HERTZ_HEIGHT


def test_the_true_pressure_has_no_error_but_that_of_its_samples() -> None:
    found = measured(TRUE)
    assert measured(hertz_means(HERTZ, CASE.grid))["pressure_error_l1"] < 1e-12
    assert found["pressure_error_max"] == 0
    assert found["length_variation"] == 0
    # half a cell from the peak
    beside = (1 - (CELL / 2) ** 2) ** 0.5 - 1
    # beside the axis against the mean of the same cell, by Simpson's rule
    mean = (1 + 4 * (1 - (CELL / 2) ** 2) ** 0.5 + (1 - CELL**2) ** 0.5) / 6
    for name in ("axis_pressure_error", "peak_pressure_error"):
        assert found[name] == pytest.approx((1 + beside) / mean - 1, rel=1e-3)
    assert abs(measured(hertz_means(HERTZ, CASE.grid))["axis_pressure_error"]) < 1e-12


def test_a_uniform_excess_is_its_share_of_the_load_in_l1() -> None:
    """A tenth of p_H over 2.4 a, of a load of pi a p_H / 2."""
    found = measured(TRUE + 0.1 * HERTZ.peak_pressure)
    means = measured(hertz_means(HERTZ, CASE.grid) + 0.1 * HERTZ.peak_pressure)
    assert means["pressure_error_l1"] == pytest.approx(0.1 * 2.4 / (pi / 2), rel=1e-12)
    assert found["pressure_error_max"] == pytest.approx(0.1, rel=1e-12)
    assert found["peak_pressure_error"] == pytest.approx(0.1, abs=CELL**2)
    assert found["axis_pressure_error"] == pytest.approx(0.1, abs=CELL**2)


@pytest.mark.parametrize("wider", [-0.07, 0.09])
def test_a_wider_contact_has_a_positive_error_of_its_half_width(wider: float) -> None:
    wide = replace(HERTZ, load_per_length=HERTZ.load_per_length * (1 + wider) ** 2)
    assert wide.half_width == pytest.approx((1 + wider) * HERTZ.half_width, rel=1e-12)
    pressure = np.broadcast_to(wide.pressure(X), CASE.grid.cells)
    # sampled, not solved for: the outer faces of the cells that touch
    assert measured(pressure)["half_width_error"] == pytest.approx(wider, abs=CELL)


@pytest.mark.parametrize(("cells", "along"), [(12, 1), (37, 1), (48, 6)])
def test_no_load_has_a_larger_error_than_that_of_its_grid(cells: int, along: int) -> None:
    """Loads by which the edge moves over one cell: up to 8 % on 12 cells over 2.4 a."""
    padding = cs.CircularSuperposition(6) if along > 1 else cs.ExactPeriodicity()
    grid = cs.Grid((cells, along), (WIDTH * HERTZ.half_width, WIDTH * HERTZ.half_width))
    largest = largest_l1_error(grid, padding)
    errors = []
    for shift in np.linspace(-0.5, 0.5, 11):
        wider = (1 + shift * WIDTH / cells) ** 2  # of Hertz's half-width, so many cells
        scene = replace(SCENE, load=cs.LineLoad(wider * HERTZ.load_per_length))
        pressure = cs.solve(scene.problem(grid, padding), options=cs.SolveOptions(1e-8)).pressure
        assert scene.hertz is not None
        errors.append(relative_l1(pressure, hertz_means(scene.hertz, grid)))
    assert max(errors) <= 1.02 * largest
    # the largest is that of a load among them, and not that of the nominal one
    assert max(errors) > 0.8 * largest > 1.5 * errors[5]


def test_the_error_of_a_grid_falls_with_the_power_three_halves() -> None:
    """Without luck: 24 and 60 cells over 2.4 a have the edge on a border of cells, 35 and 81 elsewhere."""
    for cells in (24, 35, 60, 81):
        grid = cs.Grid((cells, 1), (WIDTH * HERTZ.half_width, HERTZ.half_width))
        error = largest_l1_error(grid)
        # the width may differ by half a cell per half-width
        difference = 1.5 * 0.5 * WIDTH / cells
        assert error / (WIDTH / cells) ** 1.5 == pytest.approx(0.43, rel=0.01 + difference)
