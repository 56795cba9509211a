"""The steps of a march by hand: times, loads, parts of jumps, halves of abrupt steps, scales."""

from dataclasses import dataclass, field
from math import log2, sqrt
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.march import Instant, March, unloaded
from contactstudy.evolution.steps import STAGE, Scheme
from contactstudy.problem.problem import Scales
from contactstudy.solvers.solution import worst
from tests.conftest import LineContact

LOAD = cs.LoadHistory(times=(0.0, 10.0), per_length=(0.0, 20.0))
NOTHING = np.zeros((1, 1))


@dataclass(frozen=True, eq=False)
class Told(March):
    """A march that writes its stages down in place of solving them."""

    told: list[Any] = field(default_factory=list)

    def _stage(self, instant: Instant, step: Any) -> Any:
        self.told.append(step)
        return Instant(step.end, step.loads[1], NOTHING, (step.end,)), [len(self.told)]


def march(scheme: Scheme = Scheme.IMPLICIT, *, stages: bool = True, joint: Any = None) -> Told:
    memory: Any = SimpleNamespace(has_stages=stages)
    return Told(None, LOAD, {}, (memory,), joint, scheme, None)  # type: ignore[arg-type]


def at(time: float, load: float) -> Instant:
    return Instant(time, load, NOTHING, (time,))


def test_two_stages_part_a_step_and_its_load_at_their_own_time() -> None:
    told = march(Scheme.TWO_STAGE)
    after, solutions = told.advance(at(2.0, 4.0), 4.0, 8.0)
    first, second = told.told
    middle = 2 + 2 * STAGE
    assert (first.start, first.end, second.start, second.end) == pytest.approx(
        (2, middle, middle, 4)
    )
    assert (first.loads, second.loads) == (
        pytest.approx((4, 2 * middle)),
        pytest.approx((2 * middle, 8)),
    )
    # the load is linear
    assert first.mean_load == pytest.approx((4 + 2 * middle) / 2)
    assert first.explicit == 0
    assert second.explicit == Scheme.TWO_STAGE.stages[1][1]
    assert (after.time, after.load, solutions) == (4.0, 8.0, [1, 2])
    assert second.duration == pytest.approx(4 - middle)
    # the last stage ends under the load that is given, such as the one before a jump
    after, _ = told.advance(at(2.0, 4.0), 4.0, 9.0)
    assert (after.load, told.told[-1].loads[1]) == (9, 9)


def test_what_has_no_stages_is_stepped_at_once_and_a_jump_takes_no_time() -> None:
    told = march(Scheme.TWO_STAGE, stages=False)
    told.advance(at(2.0, 4.0), 4.0, 8.0)
    assert len(told.told) == 1
    assert told.told[0].explicit == 0
    told.advance(at(4.0, 8.0), 4.0, 3.0)
    jump = told.told[-1]
    assert (jump.start, jump.end, jump.loads, jump.mean_load) == (4.0, 4.0, (8.0, 3.0), 3.0)
    assert jump.duration == 0


def test_a_jump_by_parts_goes_by_equal_loads() -> None:
    told = march()
    after, solutions = told.jump(at(4.0, 2.0), 10.0, 4, 0)
    assert [step.loads[1] for step in told.told] == [4.0, 6.0, 8.0, 10.0]
    assert (after.time, after.load, solutions) == (4.0, 10.0, [1, 2, 3, 4])


def test_an_abrupt_step_is_halved_as_often_as_told() -> None:
    joint: Any = SimpleNamespace(abrupt=lambda before, after: True, has_stages=False)
    told = march(joint=joint)
    _, solutions = told.advance(at(2.0, 4.0), 4.0, 8.0, 2)
    # the whole, then each half, and each of its halves
    spans = [(step.start, step.end, step.loads[1]) for step in told.told]
    assert spans == [
        (2, 4, 8), (2, 3, 6), (2, 2.5, 5), (2.5, 3, 6), (3, 4, 8), (3, 3.5, 7), (3.5, 4, 8),
    ]  # fmt: skip
    assert len(solutions) == 7
    jumps = march(joint=joint)
    jumps.advance(at(4.0, 2.0), 4.0, 8.0, 1)
    assert [step.loads[1] for step in jumps.told] == [8, 5, 8]
    smooth = march(joint=SimpleNamespace(abrupt=lambda before, after: False, has_stages=False))
    smooth.advance(at(2.0, 4.0), 4.0, 8.0, 2)
    assert len(smooth.told) == 1
    off = march(joint=joint)
    off.advance(at(2.0, 4.0), 4.0, 8.0)
    assert len(off.told) == 1


@pytest.mark.parametrize(
    ("wide", "length", "pressure"),
    # a curved contact: the power of two next to 64 / sqrt(32); one as wide as its grid: a quarter
    [(10.0, sqrt(2), 2.0 ** round(log2(64 / sqrt(32)))), (1.0, 1.0, 16.0)],
)
def test_a_curved_contact_grows_like_the_roots_of_load_and_compliance(
    wide: float, length: float, pressure: float
) -> None:
    problem: Any = SimpleNamespace(
        scales=Scales(length=1.0, pressure=64.0, gap=3.0), grid=cs.Grid((4, 1), (wide, 1.0))
    )
    told: Any = Told(problem, LOAD, {}, (), None, Scheme.IMPLICIT, None)  # type: ignore[arg-type]
    # a quarter of the largest load, eight times as soft
    found = told._scales(5.0, 8.0)
    assert found.gap == pytest.approx(3 * 0.25 * 8)
    assert found.length == pytest.approx(length)
    assert found.pressure == pressure


def test_bodies_that_just_touch_approach_by_the_least_gap(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((8, 2), 1.0), cs.ExactPeriodicity())
    found = unloaded(problem)
    assert found.gap.min() == 0
    np.testing.assert_array_equal(found.gap + found.approach, problem.undeformed_gap)
    assert not found.pressure.any()
    assert not found.displacement.any()
    assert (found.iterations, found.convolutions, found.residual) == (0, 0.0, 0.0)


def test_the_most_serious_status_counts() -> None:
    status = cs.Status
    assert worst([]) is status.CONVERGED
    assert worst([status.CONVERGED, status.CONTACT_AT_EDGE, status.STALLED]) is status.STALLED
    assert worst([status.YIELD_AT_EDGE, status.CONVERGED]) is status.YIELD_AT_EDGE
    assert worst([status.STALLED, status.NOT_FINITE]) is status.NOT_FINITE
