"""A track that grows downwards, by steps whose flow is written here."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.plane_strain import HalfLines, PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.evolution import track as tracks
from contactstudy.evolution.plastic import layers
from contactstudy.evolution.track import DepthProfile, Track, _lowered_twice
from contactstudy.solvers.yielding_bodies import Hardening

GRID = cs.Grid((6, 1), (6.0, 1.0))
VOLUME = Volume(GRID, 0, 6, (0.0, 1.0, 2.0, 4.0))
DEEPER = Volume(GRID, 0, 6, layers(GRID, 2.0, 1.3 * 4.0))
EQUIVALENT = np.arange(18.0).reshape(3, 6, 1)


@dataclass(frozen=True, eq=False)
class Standing(Track):
    """Operators that are not asked, but for the volume and what is told."""

    volume: Volume = VOLUME
    asked: tuple[Volume, ...] = ()

    @property
    def operator(self) -> Any:
        return SimpleNamespace(volume=self.volume, tensor_of_strain=lambda strain: 10 * strain)

    def deeper(self, volume: Volume) -> Any:
        more = volume.shape[0] - 3
        return Standing(
            self.surroundings,
            self.hardening,
            np.pad(self.strain, ((0, 0), (0, more), (0, 0), (0, 0))),
            np.pad(self.equivalent, ((0, more), (0, 0), (0, 0))),
            self.behind,
            self.front,
            volume,
            (*self.asked, volume),
        )


AROUND: Any = SimpleNamespace(
    lift=lambda behind, ahead: 100.0 * behind[0, 0] + ahead[0, 0],
    stress=lambda *_: np.zeros((3, 3, 6, 1)),
    tensor=lambda behind, ahead: behind[0, 0] + 7 * ahead[0, 0],
)


def standing() -> Standing:
    strain = np.ones((3, 3, 6, 1))
    ahead = DepthProfile(np.full((3, 3), 3.0), np.zeros(3))
    hardening: Any = None
    return Standing(AROUND, hardening, strain, EQUIVALENT, np.full((3, 3), 2.0), ahead)


def flowing(layer: int, depth: int = 3) -> np.ndarray:
    flow = np.zeros((depth, 6, 1))
    flow[layer, 2] = 0.5
    return flow


def settled(monkeypatch: pytest.MonkeyPatch, *flows: np.ndarray) -> tuple[Any, list[Any]]:
    asked: list[Any] = []

    def settle(*given: Any) -> Any:
        flow = flows[len(asked)]
        asked.append(given)
        strain = np.repeat(flow.reshape(1, -1), 3, axis=0)
        return SimpleNamespace(flow=flow.reshape(-1), strain=strain)

    monkeypatch.setattr(tracks, "settle", settle)
    contact: Any = SimpleNamespace(tangent="tangent")
    return standing().settled(contact, 1e-6, 2.0)[0], asked


def test_flow_above_the_last_layer_leaves_the_volume_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for layer in (0, 1):
        after, asked = settled(monkeypatch, flowing(layer))
        assert len(asked) == 1
        assert after.asked == ()
        np.testing.assert_array_equal(after.equivalent, EQUIVALENT + flowing(layer))
        np.testing.assert_array_equal(after.strain[1], flowing(layer))


def test_flow_in_the_last_layer_asks_for_more_across_the_whole_window(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    depth = DEEPER.shape[0]
    assert depth > 3
    after, asked = settled(monkeypatch, flowing(-1), flowing(1, depth))
    assert after.asked == (DEEPER,)
    assert len(asked) == 2
    assert after.equivalent.shape == (depth, 6, 1)
    np.testing.assert_array_equal(after.equivalent[:3], EQUIVALENT + flowing(1))


def test_a_contact_is_lowered_by_what_is_around_and_what_is_in_the_window() -> None:
    contact: Any = lambda lift: ("over", lift)  # noqa: E731 (a contact)
    assert _lowered_twice(contact, np.array(2.0), np.array(5.0)) == ("over", 7.0)


def test_residual_stress_is_of_the_window_and_what_is_around() -> None:
    np.testing.assert_array_equal(standing().residual_stress(), np.full((3, 3, 6, 1), 10 + 2 + 21))


def test_a_deeper_track_has_what_it_had_above_and_nothing_below() -> None:
    operator = PlaneStrainOperator(VOLUME, Moduli(91.0, 0.3))
    hardening = Hardening(3.0, 20.0, 10.0)
    fresh = Track.fresh(operator, hardening)
    count = len(operator.basis)
    assert fresh.strain.shape == (count, 3, 6, 1)
    assert not fresh.strain.any()
    assert not fresh.equivalent.any()
    assert fresh.behind.shape == fresh.front.strain.shape == (count, 3)
    strain = 1 + np.arange(count * 18.0).reshape(count, 3, 6, 1)
    ahead = DepthProfile(strain[:, :, 1, 0], np.array([1.0, 2.0, 3.0]))
    track = Track(HalfLines(operator), hardening, strain, EQUIVALENT, strain[:, :, 2, 0], ahead)
    found = track.deeper(DEEPER)
    depth = DEEPER.shape[0]
    assert found.operator.volume == DEEPER
    assert found.operator.moduli == Moduli(91.0, 0.3)
    for ours, had in (
        (found.strain, strain),
        (found.equivalent[None], EQUIVALENT[None]),
        (found.behind, track.behind),
        (found.front.strain, ahead.strain),
        (found.front.equivalent[None], ahead.equivalent[None]),
    ):
        assert ours.shape[1] == depth
        np.testing.assert_array_equal(ours[:, :3], had)
        assert not ours[:, 3:].any()
