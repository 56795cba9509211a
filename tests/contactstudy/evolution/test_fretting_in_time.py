import sys
from dataclasses import replace
from itertools import pairwise
from math import log, pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.integration.time_stepper import TimeStepper
from contactstudy.evolution.states.fretting_state import FrettingState
from contactstudy.evolution.states.state_variables import State
from tests.conftest import STEEL
from tests.contactstudy.scene.test_fretting import BODY, LINE, MU, STRIP, energy_per_cycle

FORCE, NU = 0.18, BODY.poisson_ratio
EXACT = cs.ExactPeriodicity()
CYCLE = cs.Fretting(MU, (0.0, FORCE, -FORCE, FORCE), times=(0.0, 1.0, 2.0, 3.0))


def fretted(
    friction: cs.Fretting,
    times: object,
    scene: cs.Scene = LINE,
    grid: cs.Grid = STRIP,
    **parts: Any,
) -> cs.Evolution:
    scene = replace(scene, friction=friction, **parts)
    found = cs.solve(scene, grid, EXACT, times=times, tolerance=1e-8)
    assert isinstance(found, cs.Evolution)
    return found


def energy(frame: cs.Contact) -> float:
    return float(frame.state["friction_energy"].values.sum() * STRIP.cell_area)


def hertz(load: float) -> np.ndarray:
    """Pressure under a `load`, whose half-width is its root."""
    return np.sqrt(np.maximum(load - STRIP.x**2, 0)) * 2 / pi


def test_the_largest_force_in_time_has_no_sign() -> None:
    back = replace(CYCLE, forces=(0.0, -FORCE, FORCE, -FORCE))
    for friction in (CYCLE, back):
        found = fretted(friction, [0.0, 1.0, 2.0, 3.0]).quantities["traction_coefficient"]
        assert found.value == pytest.approx(FORCE, rel=1e-6)


def test_a_cycle_in_time_loses_the_energy_of_the_closed_form() -> None:
    found = fretted(CYCLE, [0.0, 1.0, 3.0])
    lost = energy(found.frames[2]) - energy(found.frames[1])
    assert lost == pytest.approx(energy_per_cycle(FORCE / MU), rel=2e-3)
    # one step a half cycle is exact, and the doubled steps show it
    assert found.error.l1.steps < 1e-6
    for frame, force in zip(found.frames, (0.0, FORCE, FORCE), strict=True):
        assert frame.quantities["traction_coefficient"].value == pytest.approx(force, abs=1e-9)


@pytest.mark.parametrize(
    "history", [CYCLE, cs.Fretting(MU, (0.0, FORCE, -FORCE / 4, -FORCE / 4), times=(0.0, 1.0, 1.0, 3.0))],
    ids=["ramps", "a jump"],
)  # fmt: skip
def test_forces_in_time_beside_a_constant_load_are_those_one_after_another(
    history: cs.Fretting,
) -> None:
    found = fretted(history, [0.0, 3.0]).frames[-1]
    one_after_another = cs.Fretting(MU, history.forces[1:])
    rest = cs.solve(replace(LINE, friction=one_after_another), STRIP, EXACT, tolerance=1e-8)
    np.testing.assert_allclose(found.shear, rest.shear, atol=1e-5 * rest.shear.max())


def test_a_load_that_falls_at_once_slips_once_also_where_a_step_stands_for_many_cycles() -> None:
    load = cs.LoadHistory((0.0, 1.5, 1.5, 3.5, 3.5, 4.0), (1.0, 1.0, 0.95, 0.95, 0.9, 0.9))
    lost = []
    for period in (None, 0.1):
        friction = cs.Fretting(MU, (0.0, FORCE, FORCE), times=(0.0, 1.0, 2.0), period=period)
        instants = fretted(friction, [1.0, 2.0, 4.0], replace(LINE, load=load)).frames
        lost.append(np.diff([energy(frame) for frame in instants]))
    assert (lost[0] > 0).all()
    np.testing.assert_allclose(lost[1], lost[0], rtol=1e-6)


def test_an_iterate_that_is_replaced_counts_as_work_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each step takes two iterates, of which the first does not converge."""
    stepper = sys.modules[TimeStepper.__module__]
    solved, calls = stepper.solved_or_unloaded, {"contacts": 0, "iterates": 0}

    def stopping(*arguments: Any) -> cs.Solution:
        calls["contacts"] += 1
        status = cs.Status.ITERATION_LIMIT if calls["contacts"] % 2 else cs.Status.CONVERGED
        return replace(solved(*arguments), status=status)

    def next_iterate(_: FrettingState, state: State, *rest: object) -> State:
        calls["iterates"] += 1
        return dict(state) if calls["iterates"] % 2 else state

    alone = fretted(CYCLE, [0.0, 3.0])
    monkeypatch.setattr(stepper, "solved_or_unloaded", stopping)
    monkeypatch.setattr(FrettingState, "next_iterate", next_iterate)
    found = fretted(CYCLE, [0.0, 3.0])
    assert found.status is cs.Status.CONVERGED
    assert found.counts["solves"][0] == 2 * alone.counts["solves"][0]


def test_a_falling_load_leaves_the_shear_of_the_closed_form() -> None:
    """``q = mu [p(P) - p(P - T / mu)]`` also where P falls under a constant T."""
    load = cs.LoadHistory((0.0, 1.0, 2.0), (1.0, 1.0, 0.8))
    friction = cs.Fretting(MU, (0.0, FORCE, FORCE), times=(0.0, 1.0, 2.0))
    found = fretted(friction, np.linspace(0, 2, 17), replace(LINE, load=load)).frames[-1]
    expected = MU * (hertz(0.8) - hertz(0.8 - FORCE / MU))
    assert np.abs(found.shear[0, :, 0] - expected).mean() < 2e-3 * expected.max()


def test_slip_wears_in_proportion_to_the_energy_and_nowhere_else() -> None:
    forces = (0.0, *(FORCE, -FORCE) * 2, 0.0)
    friction = cs.Fretting(MU, forces, times=tuple(range(6)))
    wear = 1.0 / 32
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
    pressed, sheared = (frame.status for frame in found.frames)
    assert (pressed, sheared) == (cs.Status.CONVERGED, cs.Status.ITERATION_LIMIT)


def test_pressure_and_slip_that_do_not_converge_together_have_that_status_and_no_bound(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("contactstudy.evolution.integration.time_stepper.MAX_FIXED_POINT_ITERATIONS", 1)
    found = fretted(CYCLE, [0.0, 3.0], wear=cs.Wear(1.0 / 32, 0.0))
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
    jumps = [1.3**n for n in range(30)]
    frame = jumping(jumps, 1 / 32, 270)
    x, pressure = frame.grid.x, frame.pressure[:, 0]
    depth = frame.state["wear_depth"].values[:, 0]
    c = (1 - FORCE / MU) ** 0.5
    inside = np.abs(x) < 0.9 * c
    expected = (1 / pi + 2 / pi * (c**2 / 2 - x[inside] ** 2)) / np.sqrt(c**2 - x[inside] ** 2)
    # the stick-slip boundary is known to a cell, which moves the pressure inside by as much
    assert np.abs(pressure[inside] / expected - 1).max() < 2 * frame.grid.cell_size[0] / c
    assert pressure[np.abs(x) > c + frame.grid.cell_size[0]].max() < 1e-3 * pressure.max()
    assert not depth[inside].any()
    # the volume in the limit, of a stick zone that may be a cell wider or narrower
    assert depth.sum() * frame.grid.cell_size[0] == pytest.approx(0.1702123, rel=0.04)


@pytest.mark.parametrize(
    ("jump", "error"),
    [(16, 0.06), *(pytest.param(jump, 0.03, marks=pytest.mark.whole) for jump in (4, 1))],
)
def test_jumps_wear_as_cycle_after_cycle_does(jump: int, error: float) -> None:
    """By 64 cycles of 1/16; a jump of 16 is ten times as long as explicit wear is stable."""
    wear = 1 / 16
    frame = jumping([jump] * (64 // jump), wear, 135)
    depth, energy = (frame.state[name].values for name in ("wear_depth", "friction_energy"))
    cell = frame.grid.cell_area
    # the volume of 128 cycles of 1/32, by another program, and the quarter of a cycle that loads
    expected = 0.0931 + 0.25 * wear * 0.02043
    assert depth.sum() * cell == pytest.approx(expected, rel=error)
    assert energy.sum() * wear / MU == pytest.approx(depth.sum(), rel=1e-12)
    # no saw-tooth: depth rises and falls once on either side
    turns = np.diff(np.sign(np.diff(depth[:, 0])[np.abs(np.diff(depth[:, 0])) > 1e-9]))
    assert np.count_nonzero(turns) == 3


def test_a_large_displacement_slides_all_of_the_contact() -> None:
    """``4 mu P D`` less the energy of the displacement under full shear, counted from twice the radius.

    A positive displacement of the second body drags the first to larger x.
    """
    far = 1.0
    friction = cs.Fretting(MU, displacements=(0.0, far, -far, far), times=(0.0, 1.0, 2.0, 3.0))
    found = fretted(friction, [0.0, 1.0, 3.0])
    assert found.frames[-1].quantities["stick_fraction"].value == 0
    assert found.frames[-1].shear[0].sum() > 0
    elastic = 8 * MU**2 / pi * (log(2 * 2 * pi / 4) + 0.25)
    cycle = energy(found.frames[2]) - energy(found.frames[1])
    assert cycle == pytest.approx(4 * MU * far - elastic, rel=1e-4)


def test_a_traction_that_vanishes_at_the_end_of_a_doubled_step_is_bounded_as_closely_before() -> None:
    friction = cs.Fretting(0.9, displacements=(0.0, 2e-3, 0.0), times=(0.0, 1.0, 2.0))
    found = fretted(friction, [0.0, 1.0, 1.5, 2.0], grid=cs.Grid((60, 1), (2.2, 1.0)))
    before, vanished = (frame.error.l1.by_cause["steps"] for frame in found.frames[2:])
    # bodies that stick in every cell have the error of the solver alone, here 1e-8
    assert before < 1e-6
    assert vanished < 1


def test_a_force_above_that_of_friction_under_a_total_load_is_refused() -> None:
    friction = cs.Fretting(MU, (0.0, 1.1 * MU), times=(0.0, 1.0))
    loaded = replace(LINE, load=cs.TotalLoad(1.0, length=1.0))
    with pytest.raises(cs.InvalidInput, match="transmits less than"):
        fretted(friction, [0.0, 1.0], loaded, grid=cs.Grid((60, 1), (2.2, 1.0)))


def test_the_mirrored_force_has_the_mirrored_shear_and_a_small_coefficient_takes_none() -> None:
    grid = cs.Grid((60, 1), (2.2, 1.0))
    one, other = (
        fretted(replace(CYCLE, forces=tuple(sign * f for f in CYCLE.forces)), [0.0, 2.0], grid=grid) for sign in (1, -1)
    )
    np.testing.assert_allclose(one.frames[-1].shear, -other.frames[-1].shear, atol=1e-9)
    back = fretted(cs.Fretting(MU, (0.0, -FORCE), times=(0.0, 1.0)), [0.0, 1.0], grid=grid)
    assert back.frames[-1].shear.sum() * grid.cell_area == pytest.approx(-FORCE)
    tiny = fretted(cs.Fretting(1e-9, (0.0, 1e-10), times=(0.0, 1.0)), [0.0, 1.0], grid=grid)
    assert np.abs(tiny.frames[-1].shear).max() <= 1e-9


def test_a_contact_frets_on_a_planned_grid_under_a_load_that_changes() -> None:
    times = (0.0, 1.0, 2.0)
    scene = cs.Scene(
        cs.LoadHistory(times, (5e4, 1e5, 8e4)), (STEEL, STEEL), (cs.Cylinder(0.01),),
        friction=cs.Fretting(0.3, (0.0, 2.5e4, -1e4), times=times), wear=cs.Wear(1e-13, 0.0),
    )  # fmt: skip
    found = cs.solve(scene, error=0.1, times=times)
    assert found.quantities["wear_volume"].value > 0
    force = found.frames[-1].shear[0].sum() * found.grid.cell_area / found.grid.length
    assert force == pytest.approx(-1e4)
    assert {"shear_x", "slip_distance", "wear_depth"} <= set(found.to_dataset())


def creeping(equilibrium: float, relaxing: float, time: float) -> cs.Scene:
    body = cs.ViscoelasticHalfSpace(equilibrium, NU, ((relaxing, time),))
    return replace(LINE, solids=(body, body))


@pytest.mark.parametrize("solid", [BODY, cs.ViscoelasticHalfSpace(BODY.youngs_modulus, NU, ((1.0, 0.5),))])
def test_load_and_force_in_proportion_slip_nowhere(solid: object) -> None:
    """Mindlin & Deresiewicz (1953): the shear is that proportion of the pressure."""
    load = cs.LoadHistory((0.0, 2.0), (0.0, 0.5))
    friction = cs.Fretting(MU, (0.0, 0.05), times=(0.0, 2.0))
    scene = replace(LINE, solids=(solid, solid), load=load)
    last = fretted(friction, np.linspace(0, 2, 9), scene).frames[-1]
    assert last.state["slip_distance"].values.max() < 1e-8
    np.testing.assert_allclose(last.shear[0], 0.1 * last.pressure, atol=1e-6 * last.pressure.max())


FREE, SQUARE = (cs.ZeroPadding(), cs.ZeroPadding()), cs.Grid((24, 12), (2.4, 2.4))
WAVES = cs.Roughness(0.08, hurst=0.8, roll_off=1.0, cut_off=0.4, seed=3)
THIRDS = (0.0, 1.0, 2.0, 3.0)
UNEVEN = (0.0, 1.133, 1.932, 3.403)
# in three dimensions surfaces give way to shear otherwise than to pressure, and slip turns
TURNING = replace(LINE, load=cs.LoadHistory(THIRDS, (0.3, 1.0, 0.6, 1.0)))


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("scene", "forces", "where", "cuts"),
    [
        # the force passes zero in the middle of a doubled step, where errors count the more
        (
            replace(creeping(BODY.youngs_modulus, 1.0, 0.5), load=cs.LineLoad(0.6)),
            cs.Fretting(MU, (0.0, 0.14, -0.12, 0.11), times=THIRDS), (STRIP, EXACT), (2, 16),
        ),
        (
            replace(
                creeping(BODY.youngs_modulus, 0.75, 0.35), load=cs.LoadHistory(UNEVEN, (0.452, 0.888, 0.436, 0.508))
            ),
            cs.Fretting(MU, (0.0, 0.072, -0.0189, -0.0669), times=UNEVEN), (STRIP, EXACT), (3, 24),
        ),
        *(
            (
                replace(TURNING, shapes=shapes), cs.Fretting(MU, (0.0, 0.15, -0.05, 0.2), times=THIRDS),
                (SQUARE, padding), (1, 12),
            )
            for shapes, padding in (
                ((*LINE.shapes, cs.FiniteLength(1.6)), FREE), ((*LINE.shapes, WAVES), EXACT),
                ((cs.Sphere(pi / 4),), FREE),
            )
        ),
    ],
    ids=["creep", "creep where force and load turn", "a length", "rough", "a ball"],
)  # fmt: skip
def test_the_shear_of_many_steps_is_within_the_error_by_the_steps(
    scene: cs.Scene,
    forces: cs.Fretting,
    where: tuple[cs.Grid, cs.Padding | cs.Paddings],
    cuts: tuple[int, int],
) -> None:
    coarse, fine = (
        cs.solve(
            replace(scene, friction=forces),
            *where,
            times=np.unique([np.linspace(*ends, n + 1) for ends in pairwise(forces.times)]),
            tolerance=1e-8,
        ).frames
        for n in cuts
    )
    finer = cuts[1] // cuts[0]
    for one, other in zip(coarse[1:], fine[finer::finer], strict=True):
        error = np.abs(one.shear - other.shear).sum() / np.abs(one.shear).sum()
        bound = one.error.l1.by_cause["steps"]
        assert error <= bound
        if scene.solids == LINE.solids:  # slip that does not wear leaves the pressure
            assert one.error.peak_pressure.by_cause["steps"] < error
    assert bound < 1


def test_a_punch_that_a_rising_load_widens_carries_the_force_as_a_rigid_displacement() -> None:
    scene = replace(
        LINE,
        shapes=(*LINE.shapes, cs.FiniteLength(1.6)),
        load=cs.LoadHistory((0.0, 1.0), (0.9, 1.0)),
        friction=cs.Fretting(0.9, (0.0, 0.01), times=(0.0, 1.0)),
    )
    grid = cs.Grid((32, 16), (2.4, 2.4))
    steps = cs.TimeSteps(times=(0.0, 1.0), error_estimator="none")
    first, last = cs.solve(scene, grid, FREE, times=steps, tolerance=1e-9).frames
    response = scene.friction.response(scene, grid, FREE, last.problem.scales.length)
    moved = response(last.shear)[0]
    stuck = (first.pressure > 0) & last.stick
    assert np.ptp(moved[stuck]) < 1e-6 * moved.max()


def test_the_stick_fraction_at_the_end_is_known_to_a_row_of_cells() -> None:
    law = cs.Fretting(0.36, (0.0, 4.9e4, -4.9e4), times=(0.0, 1.0, 2.0))
    steel = cs.HalfSpace(130e9, 0.29)
    scene = cs.Scene(cs.LineLoad(1.74e5), (steel, steel), (cs.Cylinder(0.0094),), friction=law)
    coarse, fine = (
        cs.solve(scene, cs.Grid((cells, 1), (4.5e-4, 1e-4)), cs.ExactPeriodicity(), times=[0.0, 1.0, 2.0])
        .quantities["final_stick_fraction"]
        for cells in (64, 320)
    )  # fmt: skip
    assert abs(coarse.value - fine.value) <= coarse.bound < 0.1
