"""Scenes with adhesion: what is refused and why, the zone on the grid, and an approach in place of a load."""

from dataclasses import replace
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.validation import readable

SOFT, RIGID = cs.HalfSpace(1e6, 0.5), cs.HalfSpace(inf, 0.3)
SCENE = cs.Scene(cs.LineLoad(2.0), (SOFT, RIGID), (cs.Cylinder(0.01),), adhesion=cs.Adhesion(work=0.05))
GRID = cs.Grid((256, 1), (1.5e-3, 1.0))
LINE = cs.ExactPeriodicity()
# R = E* = 1 and w = pi: loads over pi have the unit of Johnson, Kendall & Roberts
UNITS = cs.Scene(cs.LineLoad(pi), (cs.HalfSpace(1.0, 0.0), RIGID), (cs.Cylinder(1.0),), adhesion=cs.Adhesion(pi, 2.0))
WIDE = cs.Grid((256, 1), (24.0, 1.0))


def test_elastic_bodies_that_roll_adhere_as_at_rest_and_lose_nothing() -> None:
    grid = cs.Grid((192, 1), (4e-3, 1e-3))
    still, rolled = (cs.solve(replace(SCENE, rolling=rolling), grid, LINE) for rolling in (None, cs.Rolling(0.1)))
    np.testing.assert_array_equal(rolled.pressure, still.pressure)
    np.testing.assert_array_equal(rolled.adhesion.attraction, still.adhesion.attraction)
    resistance = rolled.quantities["rolling_resistance"]
    assert (resistance.value, resistance.bound) == (0.0, 0.0)


@pytest.mark.parametrize("load", [cs.LineLoad(0.0), cs.LoadHistory((0.0, 1.0), (-1.0, 1.0))])
def test_bodies_from_afar_need_a_load_that_brings_them_together(load: Any) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.load begins with .* together with Adhesion"):
        replace(SCENE, load=load)
    replace(SCENE, load=load, adhesion=cs.Adhesion(0.05, branch="from full contact"))


def test_a_range_that_the_grid_cannot_hold_names_the_range_and_the_cell_that_would_do() -> None:
    work, modulus, cell = 0.05, SCENE.contact_modulus, GRID.cell_size[0]
    short = replace(SCENE, adhesion=cs.Adhesion(work, 1e-9))
    # two cells in pi E* rho^2 / (4 w)
    enough = sqrt(8 * cell * work / (pi * modulus))
    said = rf"^Adhesion\.range is 1e-09: its cohesive zone of .* a range of at least {readable(enough)}"
    with pytest.raises(cs.InvalidInput, match=said):
        short.problem(GRID, LINE)
    solution = cs.solve(replace(SCENE, adhesion=cs.Adhesion(work, 1.001 * enough)), GRID, LINE)
    assert solution.adhesion.cells_in_zone == pytest.approx(2 * 1.001**2)


@pytest.mark.cases(3)
@pytest.mark.parametrize(
    ("adhesion", "solver"),
    [(None, cs.PolonskyKeer()), (None, cs.PreconditionedCG()), (cs.Adhesion(0.05), cs.PreconditionedCG())],
)
def test_the_approach_of_a_loaded_contact_gives_back_its_load(adhesion: cs.Adhesion | None, solver: cs.Solver) -> None:
    near = replace(SCENE, adhesion=adhesion, load=cs.Approach(4e-5))
    held = cs.solve(near, GRID, LINE, tolerance=1e-10, solver=solver)
    assert held.approach == 4e-5
    attraction = 0.0 if held.adhesion is None else held.adhesion.attraction
    load = float((held.pressure - attraction).sum()) * GRID.cell_size[0]
    problem = replace(SCENE, adhesion=adhesion, load=cs.LineLoad(load)).problem(GRID, LINE)
    held_operator = replace(problem, operator=held.problem.operator)
    loaded = cs.solve(held_operator, start=held.pressure, tolerance=1e-10)
    assert loaded.approach == pytest.approx(4e-5, rel=1e-6)
    np.testing.assert_allclose(loaded.pressure, held.pressure, atol=1e-4 * held.pressure.max())


def test_an_approach_presses_a_cylinder_as_hertz_says() -> None:
    datum = 2e-3
    scene = replace(SCENE, adhesion=None, load=cs.Approach(4e-5, datum))
    solution = cs.solve(scene, cs.Grid((2048, 1), (1.5e-3, 1.0)), LINE)
    load = float(solution.pressure.sum()) * 1.5e-3 / 2048
    hertz = cs.analytic.HertzLine(load, 0.01, SCENE.contact_modulus)
    # of first order in the cell
    assert float(hertz.displacement(0.0, datum)) == pytest.approx(4e-5, rel=1.5e-3 / 2048 / hertz.half_width)


@pytest.mark.parametrize(
    ("friction", "status"),
    [
        (cs.PartialSlip(0.3, 0.0), cs.Status.CONVERGED),
        (cs.Fretting(0.3, (1.0, 0.0)), cs.Status.DETACHED),
        (cs.TractiveRolling(0.3, tangential=1.0), cs.Status.DETACHED),
    ],
)
def test_an_approach_that_leaves_a_gap_bears_no_pressure_and_says_that_it_holds_no_force(
    friction: Any, status: cs.Status
) -> None:
    apart = replace(SCENE, adhesion=None, load=cs.Approach(-1e-6), friction=friction, solids=(SOFT, SOFT))
    contact = cs.solve(apart, GRID, LINE)
    assert contact.status is status
    assert not contact.pressure.any()
    assert contact.gap.min() == pytest.approx(1e-6, rel=1e-3)
    assert contact.quantities["traction_coefficient"].value == 0


WITH_RANGE = replace(SCENE, adhesion=cs.Adhesion(work=0.05, range=2e-6))
# incompressible on rigid: elastically similar; forces of more than under the load alone, which is 2 N/m
FRICTIONS = [cs.Sliding(0.3), cs.Fretting.cycle(0.3, 0.61), cs.TractiveRolling(0.3, longitudinal=1e-3, lateral=1e-3)]


@pytest.mark.cases(3)
@pytest.mark.parametrize("friction", FRICTIONS)
def test_friction_is_limited_by_the_pressure_that_the_attraction_adds_to(friction: Any) -> None:
    alone, found = (cs.solve(replace(WITH_RANGE, friction=law), GRID, LINE, tolerance=1e-7) for law in (None, friction))
    assert found.status is cs.Status.CONVERGED
    np.testing.assert_allclose(found.pressure, alone.pressure, atol=1e-5 * alone.pressure.max())
    assert (np.hypot(*found.shear) <= 0.3 * found.pressure * (1 + 1e-9)).all()
    coefficient = found.quantities["traction_coefficient"].value
    assert coefficient == pytest.approx(found.shear[0].sum() * GRID.cell_size[0] / 2)


def test_a_force_of_more_than_pressure_and_attraction_transmit_is_refused() -> None:
    transmitted = 0.3 * cs.solve(WITH_RANGE, GRID, LINE, tolerance=1e-7).pressure.sum() * GRID.cell_size[0]
    with pytest.raises(cs.InvalidInput, match=r"Scene\.friction .* transmits less than .* N/m"):
        cs.solve(replace(WITH_RANGE, friction=cs.PartialSlip(0.3, 1.001 * transmitted)), GRID, LINE)


def test_the_coefficient_of_sliding_bodies_that_adhere_is_over_the_repulsion() -> None:
    """Over the load it changes with the repulsion on each grid, within its bound."""
    grids = GRID, cs.Grid((2 * GRID.cells[0], GRID.cells[1]), GRID.extent)
    coarse, fine = (cs.solve(replace(WITH_RANGE, friction=cs.Sliding(0.3)), grid, LINE).quantities for grid in grids)
    over_repulsion, over_load = coarse["traction_over_repulsion"], coarse["traction_coefficient"]
    assert (abs(over_repulsion.value), over_repulsion.bound) == (pytest.approx(0.3), 0.0)
    change = abs(fine["traction_coefficient"].value - over_load.value)
    assert 0 < change <= over_load.bound < 0.1 * over_load.value


@pytest.mark.parametrize("fraction", [0.3, 3.0])
def test_a_hardness_limits_the_pressure_that_is_left_beside_the_attraction(fraction: float) -> None:
    alone = cs.solve(WITH_RANGE, GRID, LINE)
    net = alone.pressure - alone.adhesion.attraction
    limit = fraction * net.max()
    found = cs.solve(replace(WITH_RANGE, hardness=limit), GRID, LINE)
    assert found.status is cs.Status.CONVERGED
    assert (found.pressure - found.adhesion.attraction).max() == pytest.approx(min(limit, net.max()), rel=1e-6)
    assert found.load_per_length == pytest.approx(2.0)


def test_a_contact_names_what_adhesion_adds() -> None:
    contact = cs.solve(replace(UNITS, load=cs.LineLoad(pi)), WIDE, LINE)
    numbers = contact.quantities
    assert numbers["tabor_parameter"].value == pytest.approx((pi**2 / 8) ** (1 / 3))
    # pi E* w / (4 sigma0^2) with sigma0 = w / rho
    assert numbers["cells_in_zone"].value == pytest.approx(1.0 / (24 / 256))
    assert numbers["attraction_range"].value == 2.0
    assert numbers["detached"].value == 0
    assert numbers["load_per_length"].value == pytest.approx(pi, rel=1e-9)
    assert numbers["energy"].value < 0


@pytest.mark.parametrize(
    ("reach", "grid", "exact", "largest"),
    [(2.0, cs.Grid((128, 1), (24.0, 1.0)), 1.14064, 0.1), (None, cs.Grid((96, 1), (12.0, 1.0)), 1.190551, 0.2)],
    ids=["of a fine grid", "of short ranges in the limit, without a range"],
)  # fmt: skip
def test_the_bound_of_a_pull_off_holds_the_load(
    reach: float | None, grid: cs.Grid, exact: float, largest: float
) -> None:
    scene = replace(UNITS, load=cs.PullOff(pi), adhesion=cs.Adhesion(pi, reach))
    pull_off = cs.solve(scene, grid, LINE).quantities["pull_off"]
    assert abs(pull_off.value / pi - exact) < pull_off.bound / pi < largest


def test_numbers_at_a_given_approach_are_within_their_bounds_of_those_of_a_fine_grid() -> None:
    near = replace(UNITS, load=cs.Approach(1.0, datum=24.0))
    coarse, fine = (cs.solve(near, cs.Grid((cells, 1), WIDE.extent), LINE).quantities for cells in (192, 1024))
    for name in ("load_per_length", "contact_area", "mean_pressure", "mean_gap", "peak_pressure"):
        error = abs(coarse[name].value - fine[name].value)
        # each edge of the mean, at the largest attraction, is known to a cell
        fraction = 0.5 if name == "mean_pressure" else 0.1
        assert error < coarse[name].bound < fraction * abs(fine[name].value), name


def test_a_contact_that_starts_from_an_answer_continues_its_state() -> None:
    grid = cs.Grid((512, 1), (16.0, 1.0))
    short = replace(UNITS, load=cs.Approach(1.0, datum=16.0), adhesion=cs.Adhesion(pi, 1.0))
    touching = cs.solve(short, grid, LINE)
    assert isinstance(touching, cs.Contact)
    away = replace(short, load=cs.Approach(-4.5, datum=16.0))
    # two states are in equilibrium there
    assert cs.solve(away, grid, LINE).status is cs.Status.DETACHED
    continued = cs.solve(away, grid, LINE, start=touching)
    assert continued.status is cs.Status.CONVERGED
    assert continued.adhesion.branch == "continued"
