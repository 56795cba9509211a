"""Friction over normal contacts that are written here."""

from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem, Scales
from contactstudy.solvers import friction
from contactstudy.solvers.friction import (
    FullSliding,
    Superposed,
    uneven_change,
)

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


def test_without_shear_all_of_the_contact_sticks() -> None:
    found = Superposed(0.5, 0.0).solved(PROBLEM, *Told(ONE).asking(1e-9))
    assert found.shear.shape == (2, 5, 1)
    assert not found.shear.any()
    assert found.stick.ravel().tolist() == [False, True, True, True, True]
    assert found.traction is not None
    assert found.traction.passes == 1
