"""How long a pass goes on, on a track whose strain is written here."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution import repeated_rolling as rolling
from contactstudy.evolution.plastic import layers
from contactstudy.evolution.repeated_rolling import (
    LONGEST,
    RepeatedRolling,
    _Rolling,
    _strain_change,
)
from contactstudy.evolution.track import DepthProfile
from tests.contactstudy.evolution.test_roll_repeatedly import COARSE, EXACT, E, roll, scene

# Cells of 0.5 m.
GRID = cs.Grid((4, 1), (2.0, 1.0))
VOLUME = Volume(GRID, 0, 4, (0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Road:
    """After so many steps: what is left, what is behind and how much has yielded, by the number of steps."""

    strain: Any
    behind_it: Any = lambda step: 1.0
    yielded: Any = lambda step: np.zeros(4)
    step: int = 0
    shares: tuple[float, ...] = ()

    @property
    def operator(self) -> Any:
        return SimpleNamespace(volume=VOLUME)

    @property
    def rear(self) -> DepthProfile:
        return DepthProfile(np.array([[self.strain(self.step)]]), np.zeros(1))

    @property
    def behind(self) -> np.ndarray:
        return np.array([[self.behind_it(self.step)]])

    @property
    def equivalent(self) -> np.ndarray:
        return self.yielded(self.step)[None, :, None]

    def rolled(self, share: float) -> "Road":
        return replace(self, shares=(*self.shares, share))


class Told(_Rolling):
    """A step is one more, and takes so many iterations as it has come."""

    def step(self, track: Any) -> Any:
        after = replace(track, step=track.step + 1)
        solution = SimpleNamespace(status=cs.Status.CONVERGED, number=after.step)
        return after, (solution, after.step)


def passed(road: Road, steps: int | None = None, first: tuple[Any, ...] = ()) -> tuple[Any, Any]:
    """With a contact of two cells, steady to 0.25."""
    told = Told(None, 1e-8, 1.0, lag=2, steps=steps, steady=0.25)  # type: ignore[arg-type]
    return told.one_pass(road, first)  # type: ignore[arg-type]


def settles_at(step: int) -> Any:
    return lambda now: 1.0 if now >= step else 0.0


def test_a_pass_over_a_distance_takes_a_step_for_each_cell() -> None:
    pressed = SimpleNamespace(status=cs.Status.STALLED, number=0), 10
    track, found = passed(Road(settles_at(99)), 3, (pressed,))
    assert (track.step, found.distance, found.steps) == (3, 1.5, 4)
    assert found.iterations == 10 + 1 + 2 + 3
    assert found.solution.number == 3
    # the worst of all of them, and what is not steady is not said of a distance
    assert found.status is cs.Status.STALLED
    # a mean over half of the window's four cells
    assert track.shares == (0.5, 0.5, 0.5)
    assert found.profile.strain == 0


@pytest.mark.parametrize(
    ("road", "steps"),
    [
        # a window of four cells and a contact of two have to pass before anything is compared
        (Road(settles_at(0)), 7 - 1),
        # two cells apart
        (Road(settles_at(5)), 7),
        # what is behind has to be like what is left, too
        (Road(settles_at(0), settles_at(9)), 9),
        (Road(settles_at(0), lambda now: 0.76 if now > 7 else 0.75), 8),
    ],
)
def test_a_pass_ends_when_what_it_leaves_is_steady(road: Road, steps: int) -> None:
    track, found = passed(road)
    assert (track.step, found.distance) == (steps, 0.5 * steps)
    assert found.status is cs.Status.CONVERGED


def test_a_pass_that_never_is_ends_and_says_so() -> None:
    for road in (Road(settles_at(0), lambda _: 0.75), Road(lambda now: float(now))):
        track, found = passed(road)
        assert track.step == 4 * LONGEST
        assert found.status is cs.Status.NOT_CONVERGED


@pytest.mark.parametrize(
    ("last", "said"),
    [
        ((0.0, 0.3, 0.3, 0.0), cs.Status.CONVERGED),
        ((0.25, 0.0, 0.0, 0.0), cs.Status.CONVERGED),
        ((0.26, 0.0, 0.0, 0.0), cs.Status.YIELD_AT_EDGE),
        ((0.0, 0.0, 0.0, 0.26), cs.Status.YIELD_AT_EDGE),
    ],
)
def test_yield_at_the_edges_of_the_window_in_the_last_step_is_said(
    last: tuple[float, ...], said: cs.Status
) -> None:
    """Beside what had yielded there before."""
    before = np.array([7.0, 1.0, 2.0, 9.0])
    road = Road(settles_at(0), yielded=lambda now: before + (now == 3) * np.array(last))
    assert passed(road, 3)[1].status is said


def test_a_change_is_the_largest_of_any_layer_to_one_that_may_be_deeper() -> None:
    one = np.array([[1.0, 2.0], [3.0, 4.0]])
    assert _strain_change(one, np.array([[1.5, 2.0, 0.25], [3.0, 3.25, 0.5]])) == 0.75
    assert _strain_change(one, one) == 0
    assert _strain_change(np.zeros((2, 1)), np.array([[0.0, 0.1], [0.2, -0.5]])) == 0.5
    assert _strain_change(np.zeros((2, 0)), np.zeros((2, 0))) == 0


def asked(
    monkeypatch: pytest.MonkeyPatch, grid: cs.Grid, **named: Any
) -> tuple[dict[str, Any], list[Any], RepeatedRolling]:
    """What is known of the steps, the tracks and first steps of the passes, and the result."""
    known: dict[str, Any] = {}
    begun: list[Any] = []

    @dataclass(frozen=True, eq=False)
    class Way:
        front: Any = "fresh"
        rear: Any = "left by none"

        def settled(self, *_: object) -> tuple[str, None]:
            return "lifted", None

    class Rolls:
        def step(self, track: Any) -> tuple[Way, str]:
            known["volume"] = track.operator.volume
            return Way(), "pressed"

        def one_pass(self, track: Way, first: tuple[str, ...]) -> tuple[Way, str]:
            begun.append((track.front, first))
            return replace(track, rear=f"left by {len(begun)}"), f"pass {len(begun)}"

    def rolls(*_: object, **more: Any) -> Rolls:
        known.update(more)
        return Rolls()

    monkeypatch.setattr(rolling, "_Rolling", rolls)
    monkeypatch.setattr(rolling, "rolling_contact", lambda *_: None)
    # four times the load is twice the half-width
    wide = scene(4.0)
    body = replace(wide.solids[0], yield_stress=2.5)  # type: ignore[type-var]
    posed = replace(wide, load=cs.LineLoad(4 * wide.load.largest), solids=(body, wide.solids[1]))
    found = roll(posed, grid, EXACT, **named)
    return known, begun, found


def test_a_half_width_is_as_many_cells_and_a_distance_as_many_steps(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known, _, _ = asked(monkeypatch, COARSE, passes=1)
    assert (known["lag"], known["steps"]) == (10, None)
    # of the yield strain
    assert known["steady"] == pytest.approx(5e-3 * 2.5 / E)
    volume = known["volume"]
    assert (volume.first, volume.last) == (0, 24)
    assert volume.edges == layers(COARSE, 2.0, 2.0 * rolling.DEPTH)
    known, _, _ = asked(monkeypatch, COARSE, passes=1, distance=0.62, steady=0.04)
    assert (known["lag"], known["steps"]) == (10, 3)
    assert known["steady"] == pytest.approx(0.04 * 2.5 / E)
    # one at the least
    coarser = cs.Grid((8, 1), (48.0, 1.0))
    known, _, _ = asked(monkeypatch, coarser, passes=1, distance=0.1)
    assert (known["lag"], known["steps"]) == (1, 1)


def test_a_pass_follows_on_what_the_one_before_has_left(monkeypatch: pytest.MonkeyPatch) -> None:
    _, begun, found = asked(monkeypatch, COARSE, passes=3)
    assert begun == [("fresh", ("pressed",)), ("left by 1", ()), ("left by 2", ())]
    assert found.passes == ("pass 1", "pass 2", "pass 3")  # type: ignore[comparison-overlap]
    assert found.removed == "lifted"  # type: ignore[comparison-overlap]
