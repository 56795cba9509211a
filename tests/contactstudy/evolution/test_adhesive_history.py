from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.units import readable
from contactstudy.evolution.quasi_static import follow_load

SOFT, RIGID = cs.HalfSpace(1.0, 0.0), cs.HalfSpace(inf, 0.3)
# R = E* = 1 and w = pi: loads over pi have the unit of Johnson, Kendall & Roberts
SCENE = cs.Scene(
    cs.LoadHistory((0.0, 1.0, 3.0), (0.1 * pi, pi, -2 * pi)),
    (SOFT, RIGID),
    (cs.Cylinder(1.0),),
    adhesion=cs.Adhesion(pi, 2.0),
)
GRID, LINE = cs.Grid((256, 1), (24.0, 1.0)), cs.ExactPeriodicity()
TIMES = (0.0, 0.5, 1.0, 1.3, 1.6, 1.9, 2.2, 2.4, 2.5, 3.0)


@pytest.fixture(scope="module")
def loop() -> cs.Evolution:
    """Approach and separation of a cylinder."""
    evolution = cs.solve(SCENE, GRID, LINE, times=TIMES)
    assert isinstance(evolution, cs.Evolution)
    return evolution


def test_a_history_pulls_until_contact_is_lost_at_the_pull_off_load() -> None:
    pulled = cs.solve(replace(SCENE, load=cs.PullOff(pi)), GRID, LINE)
    # by more than the error that a PullOff may have
    loads = np.array([0.99, 1.01]) * pulled.load_per_length
    lost = cs.solve(SCENE, GRID, LINE, times=(0.0, 1.0, *(1 + (pi - loads) / (1.5 * pi)), 3.0))
    held = [frame.status is not cs.Status.DETACHED for frame in lost.frames]
    assert held == [True, True, True, False, False]
    pull_off = lost.quantities["pull_off"]
    assert pull_off.value == pytest.approx(-loads[0])
    assert readable(-loads[1], "N m-1") in pull_off.detail
    assert pull_off.bound == inf  # by cells and range


def test_a_state_follows_from_the_one_before_however_many_lie_between(loop: cs.Evolution) -> None:
    direct = cs.solve(SCENE, GRID, LINE, times=(0.0, 1.0, 2.4))
    last, other = direct.frames[-1], loop.frames[7]
    # the passes leave 1e-5 of the attraction, which the contact multiplies as pull-off comes near
    np.testing.assert_allclose(last.pressure, other.pressure, atol=1e-3 * other.pressure.max())


def test_the_net_work_is_the_integral_of_load_over_approach_bounded_while_contact_lasts(
    loop: cs.Evolution,
) -> None:
    few, many = (
        cs.solve(SCENE, GRID, LINE, times=times).quantities["net_work"]
        for times in ((0.0, 1.0, 2.0), np.linspace(0, 2, 17))
    )
    assert 0 < abs(few.value - many.value) <= few.bound < np.inf
    assert many.bound < few.bound
    lost = loop.quantities["net_work"]
    assert lost.bound == np.inf
    assert "lost between two instants" in lost.reason
    held = [frame for frame in loop.frames if frame.status is not cs.Status.DETACHED]
    loads = np.array([frame.load_per_length for frame in held])
    approaches = np.array([frame.quantities["approach"].value for frame in held])
    by_hand = np.sum((loads[1:] + loads[:-1]) / 2 * np.diff(approaches))
    assert lost.value == pytest.approx(by_hand, rel=1e-6)


def test_the_net_work_has_no_bound_where_the_load_turns_between_two_instants() -> None:
    sine = replace(SCENE, load=cs.SineLoad(2.0, 1.5, 1.0, pi / 6))
    missed, few, many = (
        cs.solve(sine, GRID, LINE, times=times).quantities["net_work"]
        for times in (
            (0.0, 1 / 6, 0.4, 0.9),
            (0.0, 1 / 6, 2 / 3, 0.9),
            cs.TimeSteps(end=0.9, instants=28),
        )
    )
    assert missed.bound == inf
    assert "turns between two instants" in missed.reason
    assert 0 < abs(few.value - many.value) <= few.bound < inf


def test_solves_and_iterations_of_instants_that_are_not_recorded_count_for_the_next_that_is() -> None:
    all_recorded, one_missing = (follow_load(SCENE, GRID, LINE, times=times) for times in ((0.0, 1.0, 2.0), (0.0, 2.0)))
    for name in ("solves", "iterations", "convolutions"):
        total, _ = all_recorded.counts[name]
        assert one_missing.counts[name][0] == total > getattr(all_recorded.frames[-1], name)
    last = one_missing.frames[-1]
    assert last.adhesion is not None
    assert last.solves > last.adhesion.outer_iterations


def test_a_limit_that_stops_a_contact_between_two_instants_is_said_of_the_next() -> None:
    grid = cs.Grid((96, 1), (14.0, 1.0))
    found, lost = (
        cs.solve(
            replace(SCENE, load=cs.LoadHistory((0.0, 1.0, 2.0), (pi, 20 * pi, last))), grid, LINE, times=(0.0, 2.0)
        )
        for last in (pi, -20 * pi)
    )
    at_turn = cs.solve(replace(SCENE, load=cs.LineLoad(20 * pi)), grid, LINE).status
    assert at_turn is not cs.Status.CONVERGED
    assert [frame.status for frame in found.frames] == [cs.Status.CONVERGED, at_turn]
    # the gravest is said
    assert lost.frames[1].status is lost.status is cs.Status.DETACHED


def test_contact_that_is_made_again_jumps_in_as_soon_as_the_load_presses() -> None:
    history = cs.LoadHistory((0.0, 1.0, 2.0, 3.0), (1.0, 1.0, -8.0, 1.0))
    zero = 2 + 8 / 9
    again = cs.solve(replace(SCENE, load=history), GRID, LINE, times=(0.0, 2.0, zero - 1e-3, zero + 1e-3))
    assert isinstance(again, cs.Evolution)
    made = again.quantities["jump_in"]
    assert made.value == pytest.approx(9e-3)
    assert readable(-9e-3, "N m-1") in made.detail


def test_bodies_that_creep_are_held_at_a_load_near_zero_as_at_zero() -> None:
    body = cs.ViscoelasticHalfSpace(0.5, 0.0, ((0.5, 1.0),))
    near, at_zero = (
        cs.solve(
            replace(SCENE, solids=(body, RIGID), load=cs.LoadHistory((0.0, 1.0), (pi, last))),
            GRID,
            LINE,
            times=(0.0, 1.0),
        ).frames[-1]
        for last in (1e-12, 0.0)
    )
    assert near.status is at_zero.status is cs.Status.CONVERGED
    np.testing.assert_allclose(near.pressure, at_zero.pressure, rtol=1e-6)


def test_creep_under_a_constant_load_ends_in_the_relaxed_contact_however_many_its_steps() -> None:
    """The contact grows from that of the instantaneous modulus, and the error of the steps holds all the way."""
    scene = replace(SCENE, load=cs.LineLoad(pi))
    sudden, relaxed = (
        cs.solve(replace(scene, solids=(cs.HalfSpace(modulus, 0.0), RIGID)), GRID, LINE) for modulus in (4.0, 1.0)
    )
    # the deformation is delayed by 4 s
    creeping = replace(scene, solids=(cs.ViscoelasticHalfSpace(1.0, 0.0, ((3.0, 1.0),)), RIGID))
    few, many = (
        cs.solve(creeping, GRID, LINE, times=(*np.linspace(0, 8, steps + 1), 40, 80, 120)).frames for steps in (8, 32)
    )
    for frames in (few, many):
        widths = [frame.quantities["half_width"].value for frame in frames]
        assert np.all(np.diff(widths) >= 0)
        for frame, static in ((frames[0], sudden), (frames[-1], relaxed)):
            bound = frame.error.l1.steps + frame.error.l1.residual + static.error.l1.residual
            difference = np.abs(frame.pressure - static.pressure).sum()
            assert difference < bound * static.pressure.sum() < 1e-3 * static.pressure.sum()
    for frame, other in zip(few[1:9], many[4:33:4], strict=True):
        difference = np.abs(frame.pressure - other.pressure).sum() / other.pressure.sum()
        assert other.error.l1.steps < 0.5 * frame.error.l1.steps
        assert difference < frame.error.l1.steps + other.error.l1.steps < 0.1


def test_cells_hold_the_cohesive_zone_of_bodies_that_have_crept() -> None:
    """The zone shrinks with the modulus, here to a sixteenth; the range without limit is that of the relaxed bodies."""
    body = cs.ViscoelasticHalfSpace(1.0, 0.0, ((15.0, 1.0),))
    scene = replace(SCENE, load=cs.LineLoad(pi), solids=(body, RIGID))
    # at last 1.7 cells of pi E* rho^2 / (4 w), and 27 at first
    with pytest.raises(cs.InvalidInput, match=r"is 1\.7 cells .* crept"):
        cs.solve(replace(scene, adhesion=cs.Adhesion(pi, 0.8)), GRID, LINE, times=(0.0, 1.0))
    limit = replace(scene, adhesion=cs.Adhesion(pi))
    last = cs.solve(limit, GRID, LINE, times=(0.0, 16.0, 300.0)).frames[-1]
    relaxed = cs.solve(replace(limit, solids=(SOFT, RIGID)), GRID, LINE)
    assert last.adhesion.range == pytest.approx(relaxed.adhesion.range)
    assert last.adhesion.cells_in_zone == pytest.approx(relaxed.adhesion.cells_in_zone)
    assert relaxed.error.l1.range <= last.error.l1.range < inf
    assert last.quantities["peak_pressure"].bound == inf


DELAYED, WIDER = cs.ViscoelasticHalfSpace(1.0, 0.0, ((4.0, 1.0),)), cs.Grid((192, 1), (30.0, 1.0))


def test_delayed_deformation_holds_a_contact_that_an_elastic_one_loses() -> None:
    load = cs.LoadHistory((0.0, 50.0, 50.01, 50.02), (pi, pi, -1.3 * pi, -1.3 * pi))
    elastic, creeping = (
        cs.solve(replace(SCENE, load=load, solids=(one, RIGID)), WIDER, LINE, times=(0.0, 50.0, 50.01))
        for one in (SOFT, DELAYED)
    )
    assert elastic.frames[-1].status is cs.Status.DETACHED
    assert creeping.frames[-1].pressure.any()


def test_bodies_that_creep_make_contact_again_that_was_lost_between_two_instants() -> None:
    load = cs.LoadHistory((0.0, 1.0, 2.0), (pi, -20 * pi, pi))
    scene = replace(SCENE, load=load, solids=(DELAYED, RIGID))
    remade = cs.solve(scene, WIDER, LINE, times=(0.0, 2.0)).frames[-1]
    assert remade.status is cs.Status.CONVERGED
    assert remade.pressure.any()
