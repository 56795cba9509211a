from dataclasses import replace
from itertools import pairwise
from math import log, pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.contactstudy.evolution.creeping import EXACT
from tests.contactstudy.scene.test_fretting import BODY, LINE, MU, STRIP, energy_per_cycle

FORCE, THIRDS = 0.18, (0.0, 1.0, 2.0, 3.0)
CYCLE = cs.Fretting(MU, (0.0, FORCE, -FORCE, FORCE), times=THIRDS)
COARSE = cs.Grid((60, 1), (2.2, 1.0))


def fretted(
    friction: cs.Fretting, times: Any, scene: cs.Scene = LINE, grid: cs.Grid = STRIP, **parts: Any
) -> cs.Evolution:
    return cs.solve(replace(scene, friction=friction, **parts), grid, EXACT, times=times, tolerance=1e-8)


def energy(frame: cs.Contact) -> float:
    return float(frame.state["friction_energy"].values.sum() * frame.grid.cell_area)


def test_a_cycle_in_time_loses_the_energy_of_the_closed_form() -> None:
    found = fretted(CYCLE, [0.0, 1.0, 3.0])
    lost = energy(found.frames[2]) - energy(found.frames[1])
    assert lost == pytest.approx(energy_per_cycle(FORCE / MU), rel=2e-3)
    # one step a half cycle is exact, and the doubled steps show it
    assert found.error.l1.steps < 1e-6
    assert found.over_time("traction_coefficient") == pytest.approx([0.0, FORCE, FORCE], abs=1e-9)


def test_forces_in_time_beside_a_constant_load_are_those_one_after_another() -> None:
    """Also in a jump; mirrored forces have the mirrored shear."""
    forces = (0.0, FORCE, -FORCE / 4, -FORCE / 4)
    one, mirrored = (
        fretted(cs.Fretting(MU, tuple(sign * force for force in forces), times=(0.0, 1.0, 1.0, 3.0)), [0.0, 3.0])
        for sign in (1, -1)
    )
    rest = cs.solve(replace(LINE, friction=cs.Fretting(MU, forces[1:])), STRIP, EXACT, tolerance=1e-8)
    np.testing.assert_allclose(one.frames[-1].shear, rest.shear, atol=1e-5 * rest.shear.max())
    np.testing.assert_allclose(one.frames[-1].shear, -mirrored.frames[-1].shear, atol=1e-9)


def test_a_load_that_falls_at_once_slips_once_also_where_a_step_stands_for_many_cycles() -> None:
    load = cs.LoadHistory((0.0, 1.5, 1.5, 3.5, 3.5, 4.0), (1.0, 1.0, 0.95, 0.95, 0.9, 0.9))
    lost = []
    for period in (None, 0.1):
        friction = cs.Fretting(MU, (0.0, FORCE, FORCE), times=(0.0, 1.0, 2.0), period=period)
        instants = fretted(friction, [1.0, 2.0, 4.0], replace(LINE, load=load)).frames
        lost.append(np.diff([energy(frame) for frame in instants]))
    assert (lost[0] > 0).all()
    np.testing.assert_allclose(lost[1], lost[0], rtol=1e-6)


def test_a_falling_load_leaves_the_shear_of_the_closed_form() -> None:
    """``q = mu [p(P) - p(P - T / mu)]`` also where P falls under a constant T."""
    load = cs.LoadHistory((0.0, 1.0, 2.0), (1.0, 1.0, 0.8))
    friction = cs.Fretting(MU, (0.0, FORCE, FORCE), times=(0.0, 1.0, 2.0))
    found = fretted(friction, np.linspace(0, 2, 17), replace(LINE, load=load)).frames[-1]
    # the half-width under a load is its root
    of_load, of_rest = (np.sqrt(np.maximum(load - STRIP.x**2, 0)) * 2 / pi for load in (0.8, 0.8 - FORCE / MU))
    expected = MU * (of_load - of_rest)
    assert np.abs(found.shear[0, :, 0] - expected).mean() < 2e-3 * expected.max()


def test_slip_wears_in_proportion_to_the_energy_and_nowhere_else() -> None:
    friction, wear = cs.Fretting(MU, (0.0, *(FORCE, -FORCE) * 2, 0.0), times=tuple(range(6))), 1.0 / 32
    found = fretted(friction, [0.0, 5.0], wear=cs.Wear(wear, 0.0))
    worn, lost = (found.quantities[name].value for name in ("wear_volume", "friction_energy"))
    assert worn == pytest.approx(wear / MU * lost, rel=1e-12)
    depth = found.frames[-1].state["wear_depth"].values
    # cells within 0.95 of the stick zone, of half-width (1 - T / (mu P))^(1/2)
    assert not depth[np.abs(STRIP.x) < 0.95 * (1 - FORCE / MU) ** 0.5].any()
    # two cycles lose little of the first one's rate, 0.0204 a cycle and unit of wear
    assert worn == pytest.approx(2 * wear * 0.02043, rel=0.1)


def test_a_shear_that_meets_the_iteration_limit_has_its_status_though_the_pressure_converged() -> None:
    friction, limits = replace(LINE, friction=CYCLE), {"tolerance": 1e-6, "max_iterations": 12}
    found = cs.solve(friction, STRIP, EXACT, times=[0.0, 3.0], **limits)
    assert [frame.status for frame in found.frames] == [cs.Status.CONVERGED, cs.Status.ITERATION_LIMIT]


def test_pressure_and_slip_that_do_not_converge_together_have_that_status_and_no_bound(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("contactstudy.evolution.time_stepper.MAX_FIXED_POINT_ITERATIONS", 1)
    found = fretted(CYCLE, [0.0, 3.0], grid=COARSE, wear=cs.Wear(1.0 / 32, 0.0))
    assert found.status is cs.Status.NOT_CONVERGED
    assert np.isinf(found.error.l1.total)


def jumping(jumps: list[float], wear: float, cells: int) -> cs.Contact:
    """The last frame of a cycle for each of `jumps`, which stands for so many cycles, after loading once."""
    times, forces = [0.0, 0.5], [0.0, FORCE]
    for jump in jumps:
        times += [times[-1] + jump / 2, times[-1] + jump]
        forces += [-FORCE, FORCE]
    friction = cs.Fretting(MU, tuple(forces), times=tuple(times), period=1.0)
    scene = replace(LINE, friction=friction, wear=cs.Wear(wear, 0.0))
    steps = cs.TimeSteps(times=(0.0, times[-1]), error_estimator="none")
    found = cs.solve(scene, cs.Grid((cells, 1), (2.7, 1.0)), EXACT, times=steps, tolerance=1e-7)
    assert found.status is cs.Status.CONVERGED
    return found.frames[-1]


@pytest.mark.whole
def test_jumps_of_growing_length_reach_the_pressure_that_wears_no_more() -> None:
    """Closed form: what sticks bears the load alone, as a punch with the curvature of the cylinder.

    ``p = [P / pi + E* / (2 R) (c^2 / 2 - x^2)] / (c^2 - x^2)^(1/2)`` within the half-width c of the stick zone. Explicit
    jumps are stable below 0.09 / 0.03 cycles; these grow beyond a thousand.
    """
    frame = jumping([1.3**n for n in range(30)], 1 / 32, 270)
    x, pressure, cell = frame.grid.x, frame.pressure[:, 0], frame.grid.cell_size[0]
    depth = frame.state["wear_depth"].values[:, 0]
    c = (1 - FORCE / MU) ** 0.5
    inside = np.abs(x) < 0.9 * c
    expected = (1 / pi + 2 / pi * (c**2 / 2 - x[inside] ** 2)) / np.sqrt(c**2 - x[inside] ** 2)
    # the stick-slip boundary is known to a cell, which moves the pressure inside by as much
    assert np.abs(pressure[inside] / expected - 1).max() < 2 * cell / c
    assert pressure[np.abs(x) > c + cell].max() < 1e-3 * pressure.max()
    assert not depth[inside].any()
    # the volume in the limit, of a stick zone that may be a cell wider or narrower
    assert depth.sum() * cell == pytest.approx(0.1702123, rel=0.04)


def test_jumps_wear_as_cycle_after_cycle_does() -> None:
    """By 64 cycles of 1/16; a jump of 16 is ten times as long as explicit wear is stable."""
    frame = jumping([16] * 4, 1 / 16, 135)
    depth = frame.state["wear_depth"].values
    # the volume of 128 cycles of 1/32, by another program, and the quarter of a cycle that loads
    assert depth.sum() * frame.grid.cell_area == pytest.approx(0.0931 + 0.25 / 16 * 0.02043, rel=0.06)
    # no saw-tooth: depth rises and falls once on either side
    changes = np.diff(depth[:, 0])
    assert np.count_nonzero(np.diff(np.sign(changes[np.abs(changes) > 1e-9]))) == 3


def test_a_large_displacement_slides_all_of_the_contact() -> None:
    """``4 mu P D`` less the energy of the displacement under full shear, counted from twice the radius.

    A positive displacement of the second body drags the first to larger x.
    """
    friction = cs.Fretting(MU, displacements=(0.0, 1.0, -1.0, 1.0), times=THIRDS)
    found = fretted(friction, [0.0, 1.0, 3.0])
    assert found.frames[-1].quantities["stick_fraction"].value == 0
    assert found.frames[-1].shear[0].sum() > 0
    elastic = 8 * MU**2 / pi * (log(2 * 2 * pi / 4) + 0.25)
    assert energy(found.frames[2]) - energy(found.frames[1]) == pytest.approx(4 * MU - elastic, rel=1e-4)


def test_a_traction_that_vanishes_at_the_end_of_a_doubled_step_is_bounded_as_closely_before() -> None:
    friction = cs.Fretting(0.9, displacements=(0.0, 2e-3, 0.0), times=(0.0, 1.0, 2.0))
    frames = fretted(friction, [0.0, 1.0, 1.5, 2.0], grid=COARSE).frames
    # bodies that stick in every cell have the error of the solver alone, here 1e-8
    assert frames[2].error.l1.by_cause["steps"] < 1e-6
    assert frames[3].error.l1.by_cause["steps"] < 1


@pytest.mark.parametrize("solid", [BODY, cs.ViscoelasticHalfSpace(BODY.youngs_modulus, 0.3, ((1.0, 0.5),))])
def test_load_and_force_in_proportion_slip_nowhere(solid: Any) -> None:
    """Mindlin & Deresiewicz (1953): the shear is that proportion of the pressure."""
    scene = replace(LINE, solids=(solid, solid), load=cs.LoadHistory((0.0, 2.0), (0.0, 0.5)))
    friction = cs.Fretting(MU, (0.0, 0.05), times=(0.0, 2.0))
    last = fretted(friction, np.linspace(0, 2, 9), scene).frames[-1]
    assert last.state["slip_distance"].values.max() < 1e-8
    np.testing.assert_allclose(last.shear[0], 0.1 * last.pressure, atol=1e-6 * last.pressure.max())


FREE, SQUARE = (cs.ZeroPadding(), cs.ZeroPadding()), cs.Grid((24, 12), (2.4, 2.4))
BALL = replace(LINE, shapes=(cs.Sphere(pi / 4),))
CREEPING = replace(LINE, solids=(cs.ViscoelasticHalfSpace(BODY.youngs_modulus, 0.3, ((0.75, 0.35),)),) * 2)


@pytest.mark.parametrize(
    ("scene", "times", "load", "forces", "where", "cuts"),
    [
        # force and load turn in the middle of doubled steps, where errors count the more
        (
            CREEPING, (0.0, 1.133, 1.932, 3.403), (0.452, 0.888, 0.436, 0.508), (0.0, 0.072, -0.0189, -0.0669),
            (STRIP, EXACT), (3, 24),
        ),
        # in three dimensions surfaces give way to shear otherwise than to pressure, and slip turns
        (BALL, THIRDS, (0.3, 1.0, 0.6, 1.0), (0.0, 0.15, -0.05, 0.2), (SQUARE, FREE), (1, 12)),
    ],
    ids=["creep", "a ball"],
)  # fmt: skip
def test_the_shear_of_many_steps_is_within_the_error_by_the_steps(
    scene: cs.Scene, times: Any, load: Any, forces: Any, where: Any, cuts: tuple[int, int]
) -> None:
    scene = replace(scene, load=cs.LoadHistory(times, load), friction=cs.Fretting(MU, forces, times=times))
    instants = (np.unique([np.linspace(*ends, n + 1) for ends in pairwise(times)]) for n in cuts)
    coarse, fine = (cs.solve(scene, *where, times=times, tolerance=1e-8).frames for times in instants)
    finer = cuts[1] // cuts[0]
    for one, other in zip(coarse[1:], fine[finer::finer], strict=True):
        error = np.abs(one.shear - other.shear).sum() / np.abs(one.shear).sum()
        assert error <= one.error.l1.by_cause["steps"]
        if scene.solids == LINE.solids:  # slip that does not wear leaves the pressure
            assert one.error.peak_pressure.by_cause["steps"] < error
    assert one.error.l1.by_cause["steps"] < 1


def test_a_punch_that_a_rising_load_widens_carries_the_force_as_a_rigid_displacement() -> None:
    friction = cs.Fretting(0.9, (0.0, 0.01), times=(0.0, 1.0))
    shapes, load = (*LINE.shapes, cs.FiniteLength(1.6)), cs.LoadHistory((0.0, 1.0), (0.9, 1.0))
    scene = replace(LINE, shapes=shapes, load=load, friction=friction)
    steps = cs.TimeSteps(times=(0.0, 1.0), error_estimator="none")
    first, last = cs.solve(scene, SQUARE, FREE, times=steps, tolerance=1e-9).frames
    moved = friction.response(scene, SQUARE, FREE, last.problem.scales.length)(last.shear)[0]
    assert np.ptp(moved[(first.pressure > 0) & last.stick]) < 1e-6 * moved.max()


def test_the_stick_fraction_at_the_end_is_known_to_a_row_of_cells() -> None:
    coarse, fine = (
        fretted(CYCLE, THIRDS, grid=cs.Grid((cells, 1), (2.2, 1.0))).quantities["final_stick_fraction"]
        for cells in (60, 300)
    )
    assert abs(coarse.value - fine.value) <= coarse.bound < 0.1
