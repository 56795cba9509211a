"""What a dataset holds of passes that are written here."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.repeated_rolling import RepeatedRolling
from contactstudy.io.dataset import passes_dataset
from contactstudy.scene.scene import PosedScene
from tests.conftest import LineContact
from tests.contactstudy.evolution.test_repeated_rolling import (
    BASIS,
    FIRST,
    GRID,
    SECOND,
    THREE,
    one,
)


def test_passes_are_counted_from_one_and_the_window_is_that_of_the_last(
    line_contact: LineContact,
) -> None:
    passes = (one(FIRST, 7.0), one(SECOND, 8.0, cs.Status.STALLED), one(SECOND, 9.0))
    strain = np.arange(3 * 2 * 4, dtype=float).reshape(3, 2, 4, 1)
    stress = np.arange(6 * 2 * 4, dtype=float).reshape(6, 2, 4, 1)
    track: Any = SimpleNamespace(operator=THREE.track.operator, strain=strain)
    removed: Any = SimpleNamespace(residual_stress=lambda: stress)
    posed = PosedScene(line_contact.scene, GRID, cs.ExactPeriodicity())
    found = passes_dataset(RepeatedRolling(passes, track, removed, posed), {})
    assert found["pass"].values.tolist() == [1, 2, 3]
    assert found["z"].values.tolist() == [0.5, 2.0]
    assert found["x"].values.tolist() == [-1.5, -0.5, 0.5, 1.5]
    assert found["pressure"].values.tolist() == [0, 9, 4.5, 0]
    assert found["peak_pressure"].values.tolist() == [7, 8, 9]
    assert found["distance"].values.tolist() == [5, 5, 5]
    meanings = found["status"].attrs["flag_meanings"].split()
    assert meanings[int(found["status"][1])] == "STALLED"
    expected = sum(BASIS[k][:, None, None] * strain[k, :, :, 0] for k in range(3))
    assert found["window_plastic_strain"].values == pytest.approx(np.asarray(expected))
    np.testing.assert_array_equal(found["window_residual_stress"], stress[..., 0])
    np.testing.assert_array_equal(found["residual_stress"].dims, ("pass", "component", "z"))
