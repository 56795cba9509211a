"""How a solution differs from that on cells of twice the size, by hand."""

from types import SimpleNamespace

import numpy as np
import pytest

from contactstudy.accuracy.coarser import change


def test_a_change_is_of_the_load_the_peak_the_area_and_the_gap() -> None:
    fine = SimpleNamespace(
        pressure=np.array([[4.0], [2.0], [2.0], [0.0]]),
        mean_gap=2.0,
    )
    coarse = SimpleNamespace(pressure=np.array([[3.0], [0.0]]), mean_gap=3.0)
    seen = change(fine, coarse)  # type: ignore[arg-type]
    # means of 3 and 1 for 3 and 0, of a load of 4; a peak of 4 for 3
    assert seen.l1 == pytest.approx(1 / 4)
    assert seen.peak_pressure == pytest.approx(1 / 3)
    # half in contact for three quarters, a gap of 3 for 2 in the mean
    assert seen.contact_area == pytest.approx(1 / 3)
    assert seen.mean_gap == pytest.approx(1 / 2)
