"""Friction over normal contacts that are written here."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem, Scales
from contactstudy.solvers import friction
from contactstudy.solvers.friction import (
    CoulombDisks,
    Disks,
    FullSliding,
    Superposed,
    _with_traction,
    uneven_change,
)
from contactstudy.solvers.solution import Traction

Array = np.ndarray


def field(*values: float) -> Array:
    return np.array(values)[:, None]


GRID = cs.Grid((5, 1), (10.0, 1.0))
GAP = field(3.0, 2.0, 1.0, 2.0, 3.0)
SCALES = Scales(length=1.0, pressure=1.0, gap=2.0)
PROBLEM = Problem(GRID, GAP, None, None, PrescribedLoad(10.0), SCALES)  # type: ignore[arg-type]


class Told:
    """Solves each problem with the next of these pressures, the last one for ever."""

    def __init__(self, *pressures: Array, status: cs.Status = cs.Status.CONVERGED) -> None:
        self.pressures, self.status = pressures, status
        self.asked: list[tuple[Problem, Any]] = []

    def __call__(self, problem: Problem, start: Any) -> cs.Solution:
        self.asked.append((problem, start))
        pressure = self.pressures[min(len(self.asked), len(self.pressures)) - 1]
        return cs.Solution(
            problem, pressure, 0.5 * pressure, 0 * pressure, 0.25, self.status, 3, 4.5, 0.01, "said."
        )  # fmt: skip

    def asking(self, tolerance: float, most: int = 50) -> tuple[cs.SolveOptions, Array, cs.Cpu]:
        """Return options whose solves are told, a first start, and a device."""
        told = self

        class Asking(cs.SolveOptions):
            def solved(self, problem: Problem, start: Any = None, on: Any = None) -> cs.Solution:
                return told(problem, start)

        return Asking(tolerance, most), field(7.0), cs.Cpu()


# Half of the sums from the left of the second are 2, 3, 3.5 and 4 m in its contact; those of the first begin at 1 m.
ONE, TWO = field(0.0, 2, 4, 1, 1), field(0.0, 4, 2, 1, 1)


def accumulated(pressure: Array) -> Array:
    return np.cumsum(pressure, axis=0)


SLIDING = FullSliding(0.5, accumulated)  # type: ignore[arg-type]


def test_a_gap_that_all_of_the_contact_shares_is_not_felt() -> None:
    change = field(9.0, 1, 3, 3.5, 4)
    # a mean of 2.875 in the contact
    assert uneven_change(change, ONE) == 1.875
    assert uneven_change(-change, ONE) == 1.875
    assert uneven_change(change + 5, ONE) == 1.875
    assert uneven_change(change, 0 * ONE) == 0


def test_the_shear_of_a_pass_moves_the_gap_of_the_next_until_it_stays() -> None:
    told = Told(ONE, TWO)
    found = SLIDING.solved(PROBLEM, *told.asking(1e-9))
    gaps = [problem.undeformed_gap for problem, _ in told.asked]
    np.testing.assert_array_equal(gaps[0], GAP)
    np.testing.assert_array_equal(gaps[1], GAP + 0.5 * accumulated(ONE))
    np.testing.assert_array_equal(gaps[2], GAP + 0.5 * accumulated(TWO))
    # from the start that was given, and then from the pass before
    assert [start.ravel().tolist() for _, start in told.asked] == [
        [7], ONE.ravel().tolist(), TWO.ravel().tolist(),
    ]  # fmt: skip
    np.testing.assert_array_equal(found.displacement, 0.5 * TWO + 0.5 * accumulated(TWO))
    np.testing.assert_array_equal(found.shear, [0.5 * TWO, 0 * TWO])
    assert not found.stick.any()
    assert found.problem is PROBLEM
    # three solves, and the shear of each
    assert (found.iterations, found.convolutions) == (9, 3 * 4.5 + 3)
    assert (found.status, found.residual) == (cs.Status.CONVERGED, 0.01)
    assert found.note == "said. 3 passes over the shear."


def test_a_change_of_the_gap_by_the_tolerance_is_small_enough() -> None:
    """The second pass changes it by 1 m in one of four cells: 0.75 m beside the mean, on a scale of 2 m."""
    told = Told(ONE, TWO)
    found = SLIDING.solved(PROBLEM, *told.asking(0.375))
    assert len(told.asked) == 2
    assert (found.status, found.residual) == (cs.Status.CONVERGED, 0.375)
    np.testing.assert_array_equal(found.displacement, 0.5 * TWO + 0.5 * accumulated(ONE))
    once = Told(ONE)
    SLIDING.solved(PROBLEM, *once.asking(0.9375))
    assert len(once.asked) == 1


def test_passes_that_do_not_settle_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(friction, "MOST_PASSES", 2)
    told = Told(ONE, TWO)
    found = SLIDING.solved(PROBLEM, *told.asking(1e-9))
    assert len(told.asked) == 2
    assert found.status is cs.Status.STALLED
    edge = SLIDING.solved(PROBLEM, *Told(ONE, TWO, status=cs.Status.CONTACT_AT_EDGE).asking(1e-9))
    assert edge.status is cs.Status.CONTACT_AT_EDGE
    lost = FullSliding(0.5, lambda pressure: np.nan * pressure)  # type: ignore[arg-type]
    told = Told(ONE)
    assert lost.solved(PROBLEM, *told.asking(1e-9)).status is cs.Status.STALLED
    assert len(told.asked) == 1


def test_without_a_coupling_one_pass_is_all() -> None:
    found = FullSliding(0.5, None).solved(PROBLEM, *Told(ONE).asking(1e-9))
    assert found.traction is not None
    assert (found.traction.passes, found.traction.method) == (1, "full sliding")
    np.testing.assert_array_equal(found.shear, [0.5 * ONE, 0 * ONE])


WHOLE, INNER = field(2.0, 3, 4, 0.5, 0), field(0.0, 1, 5, 0, 0)


@pytest.mark.parametrize("sign", [1, -1])
def test_shear_of_partial_slip_is_that_of_two_contacts_with_the_resultant_asked_for(
    sign: int,
) -> None:
    """0.5 (2, 2, 0, 0.5) Pa, brought to 0.5 of 0.4 of the load of 9.5 Pa."""
    told = Told(WHOLE, INNER)
    found = Superposed(0.5, sign * 0.4).solved(PROBLEM, *told.asking(1e-9))
    assert [problem.resultant for problem, _ in told.asked] == [
        PrescribedLoad(10.0), PrescribedLoad(6.0),
    ]  # fmt: skip
    assert [start.ravel()[0] for _, start in told.asked] == [7, 2]
    expected = sign * field(1.0, 1, 0, 0.25, 0) * (0.5 * 0.4 * 9.5 / 2.25)
    np.testing.assert_allclose(found.shear[0], expected, rtol=1e-15)
    assert not found.shear[1].any()
    assert found.stick.ravel().tolist() == [False, True, True, False, False]
    assert found.traction is not None
    assert found.traction.passes == 2
    assert (found.iterations, found.convolutions) == (6, 9)
    np.testing.assert_array_equal(found.pressure, WHOLE)


def test_without_shear_all_of_the_contact_sticks() -> None:
    found = Superposed(0.5, 0.0).solved(PROBLEM, *Told(WHOLE).asking(1e-9))
    assert found.shear.shape == (2, 5, 1)
    assert not found.shear.any()
    assert found.stick.ravel().tolist() == [True, True, True, True, False]
    assert found.traction is not None
    assert found.traction.passes == 1


def test_the_worse_status_and_residual_count() -> None:
    traction = Traction(np.zeros((2, 5, 1)), np.zeros((5, 1), dtype=bool), "by hand", 1)
    good = Told(ONE)(PROBLEM, None)
    bad = replace(good, status=cs.Status.STALLED, residual=0.2)
    assert _with_traction(good, cs.Status.CONVERGED, 0.005, 1, 1.0, traction).residual == 0.01
    found = _with_traction(good, cs.Status.ITERATION_LIMIT, 0.3, 10, 20.0, traction)
    assert (found.status, found.residual) == (cs.Status.ITERATION_LIMIT, 0.3)
    assert (found.iterations, found.convolutions) == (13, 24.5)
    assert found.traction is traction
    assert (
        _with_traction(bad, cs.Status.CONVERGED, 0.1, 1, 1.0, traction).status is cs.Status.STALLED
    )


def stiff(factor: float) -> Any:
    """Cells that give way by themselves alone."""

    class Response:
        largest = factor

        def __call__(self, shear: Array) -> Array:
            return factor * shear

    return Response()


DISKS = CoulombDisks(0.5, -0.4, stiff(4.0))
# The disks of WHOLE are 1, 1.5, 2 and 0.25 Pa wide, and -1.9 Pa are asked for: -0.475 in each, or on the rim.
SLIPPED = field(-0.55, -0.55, -0.55, -0.25, 0)


def test_cells_of_one_stiffness_share_what_no_rim_holds_back() -> None:
    """One step brings it there, and a second one shows that it stays."""
    told = Told(WHOLE, INNER)
    found = DISKS.solved(PROBLEM, *told.asking(1e-9))
    np.testing.assert_allclose(found.shear[0], SLIPPED, atol=1e-12)
    np.testing.assert_allclose(found.shear[1], 0, atol=1e-12)
    assert found.stick.ravel().tolist() == [True, True, True, False, False]
    assert found.status is cs.Status.CONVERGED
    assert found.traction is not None
    assert (found.traction.method, found.traction.passes) == ("Coulomb disks", 2)
    # two contacts of 3 iterations and 4.5 convolutions, two steps of two
    assert (found.iterations, found.convolutions) == (8, 9 + 4)
    assert found.residual == 0.01


def test_the_residual_is_the_change_of_a_step_as_a_displacement_over_the_gap_scale() -> None:
    """Of the start by two contacts, in a step of a quarter of the shear over its displacement."""
    start = -field(1.0, 1, 0, 0.25, 0) * (0.5 * 0.4 * 9.5 / 2.25)
    change = np.abs(SLIPPED - start).sum() / np.abs(SLIPPED).sum()
    # friction times the gap scale is 1 m
    left = change * 0.55 / (0.25 * 1.0)
    found = DISKS.solved(PROBLEM, *Told(WHOLE, INNER).asking(1e-9, most=1))
    assert found.status is cs.Status.ITERATION_LIMIT
    assert found.residual == pytest.approx(left)
    wider = replace(PROBLEM, scales=replace(SCALES, gap=6.0))
    found = DISKS.solved(wider, *Told(WHOLE, INNER).asking(1e-9, most=1))
    assert found.residual == pytest.approx(left / 3)
    enough = DISKS.solved(PROBLEM, *Told(WHOLE, INNER).asking(1.01 * left))
    assert (enough.status, enough.iterations) == (cs.Status.CONVERGED, 7)


def test_disks_are_not_asked_where_there_is_no_shear_or_no_contact() -> None:
    none = replace(DISKS, share=0.0).solved(PROBLEM, *Told(WHOLE).asking(1e-9))
    lost = DISKS.solved(
        PROBLEM, *Told(WHOLE, INNER, status=cs.Status.NO_ADMISSIBLE_PRESSURE).asking(1e-9)
    )
    for found in (none, lost):
        assert found.traction is not None
        assert found.traction.method == "Ciavarella-Jaeger"


def test_the_nearest_field_is_shifted_and_cut_off_towards_the_middles_of_the_disks() -> None:
    """Of three disks, the one of 1 Pa holds (0.6, 0.8) of a trial that is 2 Pa long."""
    radius = field(5.0, 1.0, 4.0, 0.0)
    trial = np.stack([field(1.0, 1.2, -1.0, 9.0), field(2.0, 1.6, 0.0, 9.0)])
    still = np.array([1.0 + 0.6 - 1.0, 2.0 + 0.8])
    np.testing.assert_allclose(
        Disks(radius, still).nearest(trial)[:, :, 0], [[1, 0.6, -1, 0], [2, 0.8, 0, 0]], atol=1e-9
    )
    # one shift for all, whose cut-off sums to the total
    total = np.array([1.5, 2.0])
    found = Disks(radius, total).nearest(trial)
    assert found.sum(axis=(1, 2)) == pytest.approx(total)
    shift = found[:, 0, 0] - trial[:, 0, 0]
    assert found[:, 2, 0] == pytest.approx(trial[:, 2, 0] + shift)
    moved = trial[:, 1, 0] + shift
    assert found[:, 1, 0] == pytest.approx(moved / np.hypot(*moved))
    assert not found[:, 3].any()


def test_a_shift_that_belonged_to_another_trial_does_no_harm() -> None:
    """The first trial leaves a shift that brings all cells of the second one to their rims, on the wrong side."""
    radius = field(*np.sqrt(1 - np.linspace(-0.99, 0.99, 60) ** 2))
    disks = Disks(radius, np.array([-0.6 * radius.sum(), 0.0]))
    for far in (1e3, -1e3, 1e6, 0.0):
        trial = np.stack([radius + far, 0 * radius])
        found = disks.nearest(trial)
        assert found.sum(axis=(1, 2)) == pytest.approx([-0.6 * radius.sum(), 0], rel=1e-8)


def test_all_cells_on_their_rims_carry_all_that_friction_can() -> None:
    radius = field(1.0, 0.5, 0.25)
    trial = np.stack([field(0.1, -0.3, 0.2), field(0.0, 0.1, -0.1)])
    found = Disks(radius, np.array([1.75 * 0.999, 0.0])).nearest(trial)
    assert found.sum(axis=(1, 2)) == pytest.approx([1.75 * 0.999, 0], abs=1e-9)
    assert (np.hypot(*found) <= radius * (1 + 1e-12)).all()
