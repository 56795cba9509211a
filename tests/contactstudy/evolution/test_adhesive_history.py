from dataclasses import replace
from math import inf, pi
from types import SimpleNamespace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.validation import readable
from contactstudy.io.quantities.evolution_quantities import net_work
from tests.contactstudy.evolution.creeping import EXACT, RIGID

SOFT = cs.HalfSpace(1.0, 0.0)
# R = E* = 1 and w = pi: loads over pi have the unit of Johnson, Kendall & Roberts
SCENE = cs.Scene(
    cs.LoadHistory((0.0, 1.0, 3.0), (0.1 * pi, pi, -2 * pi)),
    (SOFT, RIGID),
    (cs.Cylinder(1.0),),
    adhesion=cs.Adhesion(pi, 2.0),
)
HELD = replace(SCENE, load=cs.LineLoad(pi))
GRID, COARSE = cs.Grid((256, 1), (24.0, 1.0)), cs.Grid((96, 1), (14.0, 1.0))


def test_a_history_pulls_until_contact_is_lost_at_the_pull_off_load() -> None:
    pulled = cs.solve(replace(SCENE, load=cs.PullOff(pi)), GRID, EXACT)
    # by more than the error that a PullOff may have
    loads = np.array([0.99, 1.01]) * pulled.load_per_length
    lost = cs.solve(SCENE, GRID, EXACT, times=(0.0, 1.0, *(1 + (pi - loads) / (1.5 * pi)), 3.0))
    held = [frame.status is not cs.Status.DETACHED for frame in lost.frames]
    assert held == [True, True, True, False, False]
    pull_off = lost.quantities["pull_off"]
    assert pull_off.value == pytest.approx(-loads[0])
    assert readable(-loads[1], "N m-1") in pull_off.detail
    assert pull_off.bound == inf  # by cells and range
    net_work = lost.quantities["net_work"]
    assert (net_work.bound, "lost between two instants" in net_work.reason) == (inf, True)


def test_elastic_bodies_that_roll_under_a_history_have_the_bounds_of_coarser_cells() -> None:
    last = cs.solve(replace(SCENE, rolling=cs.Rolling(1.0)), GRID, EXACT, times=(0.0, 1.0)).frames[-1]
    assert last.quantities["approach"].bound < inf


def test_a_state_follows_from_the_one_before_however_many_lie_between() -> None:
    few, many = (
        cs.solve(SCENE, GRID, EXACT, times=times).frames[-1]
        for times in ((0.0, 1.0, 2.4), (0.0, 0.5, 1.0, 1.3, 1.6, 1.9, 2.2, 2.4))
    )
    # the passes leave 1e-5 of the attraction, which the contact multiplies as pull-off comes near
    np.testing.assert_allclose(few.pressure, many.pressure, atol=1e-3 * many.pressure.max())


def test_the_net_work_is_the_integral_of_load_over_approach() -> None:
    """It has no bound where the load turns between two instants."""
    sine = replace(SCENE, load=cs.SineLoad(2.0, 1.5, 1.0, pi / 6))
    missed, few, many = (
        cs.solve(sine, COARSE, EXACT, times=times)
        for times in ((0.0, 1 / 6, 0.4, 0.9), (0.0, 1 / 6, 2 / 3, 0.9), cs.TimeSteps(end=0.9, instants=28))
    )
    work, exact = few.quantities["net_work"], many.quantities["net_work"]
    assert 0 < abs(work.value - exact.value) <= work.bound < inf
    loads, approaches = (few.over_time(name) for name in ("load_per_length", "approach"))
    assert work.value == pytest.approx(np.trapezoid(loads, approaches), rel=1e-6)
    no_bound = missed.quantities["net_work"]
    assert (no_bound.bound, "turns between two instants" in no_bound.reason) == (inf, True)


def test_a_limit_that_stops_a_contact_between_two_instants_is_said_of_the_next() -> None:
    sine = cs.SineLoad(10.5 * pi, 9.5 * pi, 0.5, -pi / 2)  # pi at the instants, and 20 pi between them
    found = cs.solve(replace(SCENE, load=sine), COARSE, EXACT, times=(0.0, 2.0))
    at_turn = cs.solve(replace(SCENE, load=cs.LineLoad(20 * pi)), COARSE, EXACT).status
    assert at_turn is not cs.Status.CONVERGED
    assert [frame.status for frame in found.frames] == [cs.Status.CONVERGED, at_turn]


def test_contact_that_is_made_again_jumps_in_as_soon_as_the_load_presses() -> None:
    history = cs.LoadHistory((0.0, 1.0, 2.0, 3.0), (1.0, 1.0, -8.0, 1.0))
    zero = 2 + 8 / 9
    again = cs.solve(replace(SCENE, load=history), GRID, EXACT, times=(0.0, 2.0, zero - 1e-3, zero + 1e-3))
    made = again.quantities["jump_in"]
    assert made.value == pytest.approx(9e-3)
    assert readable(-9e-3, "N m-1") in made.detail


def test_creep_under_a_constant_load_ends_in_the_relaxed_contact_however_many_its_steps() -> None:
    """The contact grows from that of the instantaneous modulus, and the error of the steps holds all the way."""
    sudden, relaxed = (
        cs.solve(replace(HELD, solids=(cs.HalfSpace(modulus, 0.0), RIGID)), GRID, EXACT) for modulus in (4.0, 1.0)
    )
    # the deformation is delayed by 4 s
    creeping = replace(HELD, solids=(cs.ViscoelasticHalfSpace(1.0, 0.0, ((3.0, 1.0),)), RIGID))
    few, many = (
        cs.solve(creeping, GRID, EXACT, times=(*np.linspace(0, 8, steps + 1), 40, 80, 120)).frames for steps in (8, 32)
    )
    widths = [frame.quantities["half_width"].value for frame in many]
    assert np.all(np.diff(widths) >= 0)
    for frame, static in ((many[0], sudden), (few[0], sudden), (many[-1], relaxed), (few[-1], relaxed)):
        bound = frame.error.l1.steps + frame.error.l1.residual + static.error.l1.residual
        difference = np.abs(frame.pressure - static.pressure).sum()
        assert difference < bound * static.pressure.sum() < 1e-3 * static.pressure.sum()
    for frame, other in zip(few[1:9], many[4:33:4], strict=True):
        difference = np.abs(frame.pressure - other.pressure).sum() / other.pressure.sum()
        assert difference < frame.error.l1.steps + other.error.l1.steps < 0.1


def test_cells_hold_the_cohesive_zone_of_bodies_that_have_crept() -> None:
    """The zone shrinks with the modulus, here to a sixteenth; the range without limit is that of the relaxed bodies."""
    scene = replace(HELD, solids=(cs.ViscoelasticHalfSpace(1.0, 0.0, ((15.0, 1.0),)), RIGID))
    # at last 1.7 cells of pi E* rho^2 / (4 w), and 27 at first
    with pytest.raises(cs.InvalidInput, match=r"is 1\.7 cells .* crept"):
        cs.solve(replace(scene, adhesion=cs.Adhesion(pi, 0.8)), GRID, EXACT, times=(0.0, 1.0))
    limit = replace(scene, adhesion=cs.Adhesion(pi))
    last = cs.solve(limit, GRID, EXACT, times=(0.0, 16.0, 300.0)).frames[-1]
    relaxed = cs.solve(replace(limit, solids=(SOFT, RIGID)), GRID, EXACT)
    assert last.adhesion.range == pytest.approx(relaxed.adhesion.range)
    assert last.adhesion.cells_in_zone == pytest.approx(relaxed.adhesion.cells_in_zone)
    assert relaxed.error.l1.range <= last.error.l1.range < inf


def test_delayed_deformation_holds_a_contact_that_an_elastic_one_loses() -> None:
    load, delayed = cs.LoadHistory((0.0, 50.0, 50.01), (pi, pi, -1.3 * pi)), ((4.0, 1.0),)
    elastic, creeping = (
        cs.solve(replace(SCENE, load=load, solids=(solid, RIGID)), COARSE, EXACT, times=(0.0, 50.0, 50.01))
        for solid in (SOFT, cs.ViscoelasticHalfSpace(1.0, 0.0, delayed))
    )
    assert elastic.frames[-1].status is cs.Status.DETACHED
    assert creeping.frames[-1].pressure.any()


def test_the_bound_of_the_net_work_holds_an_error_of_each_approach() -> None:
    loads, approaches = np.array([2.0, 3.0, 5.0, 4.0]), np.array([0.0, 1.0, 3.0, 2.5])

    def work(approaches: np.ndarray, errors: np.ndarray) -> tuple[float, float]:
        frames = [
            SimpleNamespace(load=load, approach=approach, status=cs.Status.CONVERGED)
            for load, approach in zip(loads.tolist(), approaches.tolist(), strict=True)
        ]
        return net_work(frames, errors.tolist(), cs.LineLoad(1.0))[:2]  # type: ignore[arg-type]

    value, of_steps = work(approaches, np.zeros(4))
    assert value == pytest.approx(2.5 * 1.0 + 4.0 * 2.0 - 4.5 * 0.5)
    for error in 0.1 * np.eye(4):
        moved, bound = work(approaches + error, np.abs(error))[0], work(approaches, error)[1]
        assert abs(moved - value) <= (bound - of_steps) * (1 + 1e-12) < 0.6
