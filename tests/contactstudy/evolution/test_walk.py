"""The way of a march and its companion, of a pressure that decays by implicit steps of first order."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.errors import ErrorParts
from contactstudy.evolution import walk as walking
from contactstudy.evolution.march import Instant
from contactstudy.evolution.steps import Mark, StepControl, schedule
from contactstudy.evolution.walk import ONSET, REMEMBERED, YIELDED, Walk

GRID = cs.Grid((8, 1), (4.0, 2.5))
CELLS = np.array([0, 0, 1, 1, 1, 1, 0, 0.0])[:, None]


def estimate(cells: float) -> Any:
    return SimpleNamespace(l1=ErrorParts(0.001, cells, 0.0001), warnings=("coarse",))


@pytest.fixture(autouse=True)
def estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Contacts that are known to 2 %."""
    monkeypatch.setattr(Walk, "_heights", None)
    monkeypatch.setattr(walking, "error_estimate", lambda _, heights: estimate(0.02))


@dataclass(eq=False)
class Decaying:
    """Each step of h times ``second`` divides the pressure by 1 + h; a jump of the load adds it."""

    load: Any
    joint: Any = None
    told: list[tuple[float, float, float]] = field(default_factory=list)
    jumps: list[tuple[float, int]] = field(default_factory=list)
    onsets: list[int] = field(default_factory=list)
    fails_from: float = np.inf
    second: float = 1.0
    all_memories: Any = (SimpleNamespace(fields=lambda state: {"age": state}),)
    memories: Any = ()
    is_first_order: bool = False

    @property
    def problem(self) -> Any:
        return SimpleNamespace(grid=GRID)

    def start(self, time: float) -> Instant:
        return Instant(time, 0.0, 0 * CELLS, (time,))

    def at_rest(self) -> Any:
        return self._solution(0 * CELLS)

    def _solution(self, pressure: np.ndarray, residual: float = 1e-9) -> Any:
        return SimpleNamespace(
            pressure=pressure, gap=1 - CELLS, approach=0.5, residual=residual, iterations=3,
            convolutions=4.5, status=cs.Status.CONVERGED,
        )  # fmt: skip

    def advance(self, instant: Instant, end: float, load: float, onset: int) -> Any:
        self.told.append((instant.time, end, load))
        self.onsets.append(onset)
        pressure = instant.pressure / (1 + (end - instant.time) / self.second)
        residual = np.inf if end > self.fails_from else 1e-9
        return Instant(end, load, pressure, (end,)), [self._solution(pressure, residual)]

    def jump(self, instant: Instant, load: float, parts: int, onset: int) -> Any:
        self.jumps.append((load, parts))
        self.onsets.append(onset)
        # a part that is left out shows where the path counts
        pressure = instant.pressure + CELLS * (load - instant.load) * (1 + 0.1 / parts)
        after = Instant(instant.time, load, pressure, (instant.time,))
        return after, [self._solution(pressure)] * parts


HELD = cs.LoadHistory((0.0, 4.0), (2.0, 2.0))


def walked(times: Any, *, control: StepControl | None = None, **more: Any) -> tuple[Walk, Any]:
    march = more.pop("march", None) or Decaying(HELD)
    marks: tuple[Mark, ...] = schedule(march.load, times)
    walk = Walk(
        march=march,
        marks=marks,
        control=control,
        companion=more.pop("companion", True),
        records_all=times is None,
        checkpoint=None,
        progress=more.pop("progress", None),
    )
    walk.go()
    return walk, march


def heights(walk: Walk) -> list[float]:
    return [float(frame.pressure.max()) for frame in walk.frames]


def test_a_single_step_is_taken_in_halves_beside_a_companion_s_whole_one() -> None:
    walk, march = walked([0.0, 4.0])
    first = 2 * 1.1
    assert march.told == [(0, 2, 2), (2, 4, 2), (0, 4, 2)]
    half, whole = first / 9, first / 5
    assert heights(walk) == pytest.approx([first, half])
    # the difference of both over the pressure of the march
    assert [frame.step_error for frame in walk.frames] == pytest.approx([0, (whole - half) / half])
    last = walk.frames[-1]
    assert (last.steps, last.iterations, last.convolutions) == (3, 9, 13.5)
    assert (last.time, last.load, last.approach, last.residual) == (4.0, 2.0, 0.5, 1e-9)
    assert last.fields == {"age": 4.0}
    # a jump, and the companion's
    assert walk.frames[0].steps == 2


def test_the_companion_takes_every_other_of_the_steps_that_are_given() -> None:
    walk, march = walked([1.0, 2.0, 3.0, 4.0])
    assert march.told == [(0, 1, 2), (1, 2, 2), (0, 2, 2), (2, 3, 2), (3, 4, 2), (2, 4, 2)]
    first = 2.2
    assert heights(walk) == pytest.approx([first / 2, first / 4, first / 8, first / 16])
    pairs = [4 / 3 - 1, (4 / 3) ** 2 - 1]
    errors = [frame.step_error for frame in walk.frames]
    # what the companion passes by has the error of where it comes up
    assert errors == pytest.approx([pairs[0], pairs[0], pairs[1], pairs[1]])
    assert [frame.steps for frame in walk.frames] == [3, 2, 1, 2]
    odd, told = walked([1.0, 2.0, 3.0])
    assert told.told[-3:] == [(2, 2.5, 2), (2.5, 3, 2), (2, 3, 2)]
    assert len(odd.frames) == 3


def test_without_a_companion_each_step_is_one_solve_of_no_known_error() -> None:
    walk, march = walked([2.0, 4.0], companion=False)
    assert march.told == [(0, 2, 2), (2, 4, 2)]
    assert [frame.step_error for frame in walk.frames] == [np.inf, np.inf]
    assert [frame.steps for frame in walk.frames] == [2, 1]


def test_pairs_of_steps_begin_with_a_hundredth_and_keep_to_what_they_may_add() -> None:
    control = StepControl(error=0.05, adds=0.002)
    walk, march = walked([4.0], control=control)
    firsts = [step for step in march.told if step[0] == 0]
    # a pair of two hundredths of a second each, and the companion's of four
    assert [end for _, end, _ in firsts[:2]] == pytest.approx([0.02, 0.04])
    assert march.told[0][1] == pytest.approx(0.02)
    assert march.told[1][:2] == pytest.approx((0.02, 0.04))
    ends = sorted({end for _, end, _ in march.told})
    assert ends[-1] == 4.0
    # steps of first order of size h add h^2 / 2 of what there is, twice for the companion
    longest = max(end - start for start, end, _ in march.told)
    assert 0.05 < longest < 0.3
    assert walk.frames[-1].step_error < 0.05
    assert walk.frames[-1].step_error > 0.002


@pytest.mark.parametrize("second", [2.0**-30, 2.0**30])
def test_time_counts_in_parts_of_the_whole(second: float) -> None:
    """Beginning with a pair that is rejected; powers of two leave rounding as it is."""
    control = StepControl(error=0.9, adds=1e-5)
    walk, march = walked([0.0, 4.0], control=control)
    load = cs.LoadHistory((0.0, 4 * second), (2.0, 2.0))
    other = Decaying(load, second=second)
    scaled, _ = walked([0.0, 4 * second], control=control, march=other)
    assert scaled.rejected == walk.rejected >= 1
    assert [end / second for _, end, _ in other.told] == [end for _, end, _ in march.told]


@dataclass(eq=False)
class Jumping(Decaying):
    """The first of every two steps from the beginning is a tenth off, however short it is."""

    begun: int = 0

    def advance(self, instant: Instant, end: float, load: float, onset: int) -> Any:
        found, solutions = super().advance(instant, end, load, onset)
        if instant.time == 0:
            assert end > 1e-13
            self.begun += 1
            found.pressure[:] *= 1 + 0.1 * (self.begun % 2)
        return found, solutions


def test_a_pair_of_a_millionth_of_a_millionth_of_the_whole_is_taken_as_it_is() -> None:
    march = Jumping(HELD)
    walk, _ = walked([0.0, 0.25, 4.0], march=march, control=StepControl(error=0.9, adds=0.01))
    pairs = [end for start, end, _ in march.told if start == 0][1::2]
    assert len(pairs) == walk.rejected + 1
    assert pairs[-1] <= 4e-12 < pairs[-2]
    assert walk.frames[-1].time == 4.0


def test_a_march_whose_error_grows_too_large_starts_again_with_shorter_steps() -> None:
    walk, march = walked([4.0], control=StepControl(error=0.02, adds=0.01))
    assert walk.restarts >= 1
    assert walk.control is not None
    assert walk.control.adds < 0.01
    assert walk.frames[-1].step_error <= 0.02
    # what was spent before counts
    assert walk.frames[-1].steps == len(march.told) + 2 * (walk.restarts + 1)
    assert len(walk.frames) == 1


def test_a_pair_that_adds_too_much_is_rejected_and_halved_at_least() -> None:
    walk, march = walked([0.0, 4.0], control=StepControl(error=0.9, adds=1e-5))
    assert walk.rejected >= 1
    spans = [end - start for start, end, _ in march.told]
    # far too much: a fifth
    assert spans[3] == pytest.approx(spans[0] / 5)
    little, steps = walked([0.0, 4.0], control=StepControl(error=0.9, adds=3.5e-4))
    assert little.rejected >= 1
    # a little too much, 1 / 1.04 - 1 / 1.02^2 = 3.7e-4: a half
    spans = [end - start for start, end, _ in steps.told]
    assert spans[3] == pytest.approx(spans[0] / 2)
    # three steps a pair; the next begins where it began
    begins = [start for start, *_ in march.told[::3]]
    assert walk.rejected == len(begins) - len(set(begins))


def test_every_pair_is_recorded_without_times_and_the_last_one_ends_on_the_mark() -> None:
    seen = []
    walk, _ = walked(
        None, control=StepControl(0.5, 0.1), progress=lambda time, end: seen.append((time, end))
    )
    times = [frame.time for frame in walk.frames]
    assert times[-1] == 4.0
    assert len(times) > 3
    assert np.all(np.diff(times) >= 0)
    # the last two pairs are halves of what is left, and not a whole one and a crumb
    spans = np.diff(times)
    assert spans[-1] == pytest.approx(spans[-2])
    assert seen[-1] == (4.0, 4.0)


@pytest.mark.parametrize("first", [0.03, 0.04])
def test_a_mark_that_is_no_farther_than_the_next_pair_is_reached_by_one(first: float) -> None:
    """The first pair would take a hundredth of four seconds."""
    _, march = walked([first, 4.0], control=StepControl(0.9, 0.5))
    assert [end for _, end, _ in march.told[:3]] == pytest.approx([first / 2, first, first])


def test_an_instant_given_twice_is_recorded_before_and_after_its_jump() -> None:
    load = cs.LoadHistory((0.0, 1.0, 1.0, 4.0), (2.0, 2.0, 5.0, 5.0))
    seen = []
    walk, march = walked(
        [1.0, 1.0, 4.0], march=Decaying(load), progress=lambda *times: seen.append(times)
    )
    assert [(frame.time, frame.load) for frame in walk.frames] == [(1, 2), (1, 5), (4, 5)]
    # 2.2 N/m for a second in halves, and 3.3 more
    before = 2.2 / 1.5**2
    assert heights(walk)[:2] == pytest.approx([before, before + 3.3])
    assert [load for load, _ in march.jumps] == [2, 2, 5, 5]
    assert seen == [(1, 4), (1, 4), (4, 4)]


def test_first_yield_is_looked_for_in_the_main_march_of_two_alone() -> None:
    _, march = walked([0.0, 4.0])
    assert march.onsets == [ONSET, 0, ONSET, ONSET, 0]
    _, march = walked([4.0], control=StepControl(0.9, 0.5))
    assert march.onsets[2:5] == [ONSET, ONSET, 0]
    _, alone = walked([0.0, 4.0], companion=False)
    assert alone.onsets == [0, 0]


def test_a_difference_is_over_the_larger_of_two_pressures() -> None:
    walk, _ = walked([0.0])
    small, large = (Instant(0.0, 2.0, size * CELLS, ()) for size in (2.0, 5.0))
    for both in ((small, large), (large, small)):
        assert walk._relative(-CELLS, *both) == pytest.approx(1 / 5)
    assert walk._relative(CELLS, Instant(0.0, 0.0, 0 * CELLS, ())) == 0


PATH = SimpleNamespace()


def test_a_jump_whose_path_counts_is_parted_until_both_marches_agree() -> None:
    march = Decaying(HELD, joint=PATH)
    walk, _ = walked([0.0], march=march, control=StepControl(0.9, 0.01))
    # 8 parts beside 4, then twice as many: they differ by 0.1 (1/4 - 1/8) of 2 N/m on four cells of 0.5 m
    pairs = [(8, 4), (16, 8), (32, 16)]
    # and errors of first order are half as large again
    added = [1.5 * 2 * 4 * 0.5 / 2 * 0.1 * (1 / few - 1 / many) for many, few in pairs]
    assert added == pytest.approx([0.0375, 0.01875, 0.009375])
    assert [parts for _, parts in march.jumps] == [8, 4, 16, 8, 32, 16]
    assert walk.rejected == 2
    assert walk.frames[0].step_error == pytest.approx(added[-1])


def test_without_a_solution_the_march_ends_with_a_frame_that_says_so() -> None:
    walk, _ = walked([2.0, 4.0], march=Decaying(HELD, fails_from=3.0))
    assert walk.frames[-1].residual == np.inf
    assert walk.frames[-1].step_error == np.inf
    assert walk.frames[-1].grid_error == 0.0
    controlled, _ = walked(
        [4.0], march=Decaying(HELD, fails_from=3.0), control=StepControl(0.5, 0.1)
    )
    assert controlled.frames[-1].step_error == np.inf
    assert controlled.frames[-1].time < 3.0


def test_errors_by_cells_are_those_of_each_contact_with_parts_and_reasons() -> None:
    walk, _ = walked([0.0, 4.0])
    for frame in walk.frames:
        assert frame.grid_error_parts == ErrorParts(0.001, 0.02, 0.0001)
        assert frame.grid_error == pytest.approx(0.0211)
        assert frame.warnings == ("coarse",)


@pytest.mark.parametrize("memories", [1, 2])
def test_what_is_remembered_in_error_stays_in_later_frames(
    memories: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The first contact is known to 10 %, the later ones to 1 % of a pressure that decays."""
    factor = REMEMBERED**memories
    errors = iter([0.1, 0.01])
    monkeypatch.setattr(walking, "error_estimate", lambda _, heights: estimate(next(errors)))
    walk, _ = walked([0.0, 4.0], march=Decaying(HELD, memories=(PATH,) * memories))
    first, last = walk.frames
    assert first.grid_error_parts.discretisation == pytest.approx(factor * 0.1)
    carried = 0.1 * first.pressure.sum() / last.pressure.sum()
    assert last.grid_error_parts.discretisation == pytest.approx(factor * carried)


def test_errors_by_cells_of_bodies_that_yield_are_over_the_largest_load() -> None:
    plain, _ = walked([0.0])
    march = Decaying(cs.LoadHistory((0.0, 4.0), (2.0, 8.0)), joint=PATH)
    joint, _ = walked([0.0], march=march)
    # 8.1 of pressures on cells of 0.5 m and a load of 8 N/m, of which two are there
    there = joint.frames[0].pressure.sum() * 0.5 / 8
    one, other = plain.frames[0].grid_error_parts, joint.frames[0].grid_error_parts
    assert other.discretisation == pytest.approx(YIELDED * one.discretisation * there)
    assert other.truncation == pytest.approx(one.truncation * there)


def test_a_first_order_difference_is_a_bound_for_errors_that_fall_like_the_root_of_the_step() -> (
    None
):
    """Errors 1, and 2^1/2 of steps twice as long: their difference is 0.41."""
    walk, _ = walked([4.0], march=Decaying(HELD, is_first_order=True))
    plain, _ = walked([4.0])
    ratio = walk.frames[-1].step_error / plain.frames[-1].step_error
    assert ratio * (2**0.5 - 1) == pytest.approx(1.0)
