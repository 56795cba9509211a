import numpy as np
import pytest

import contactstudy as cs

HEIGHTS = np.random.default_rng(0).standard_normal((6, 40)) + 3


def test_mirrored_meets_itself_at_both_ends() -> None:
    closed = cs.Mirrored().close(HEIGHTS)
    assert closed.shape == (6, 40 * cs.Mirrored().lengths)
    np.testing.assert_array_equal(closed[:, :40], HEIGHTS)
    np.testing.assert_array_equal(closed[:, -1], closed[:, 0])
    np.testing.assert_array_equal(closed[:, 40], closed[:, 39])


def test_tapered_keeps_the_middle_and_meets_the_mean_at_the_ends() -> None:
    closed = cs.Tapered(fraction=0.5).close(HEIGHTS)
    mean = HEIGHTS.mean()
    np.testing.assert_allclose(closed[:, 10:30], HEIGHTS[:, 10:30], rtol=1e-14)
    # half a point from the end of a taper of ten, sin^2 is small
    end = np.sin(np.pi / 2 * 0.5 / 10) ** 2
    np.testing.assert_allclose(closed[:, 0] - mean, end * (HEIGHTS[:, 0] - mean), rtol=1e-9)
    np.testing.assert_allclose(closed[:, -1] - mean, end * (HEIGHTS[:, -1] - mean), rtol=1e-9)


@pytest.mark.parametrize("fraction", [0.0, 1.1, np.nan])
def test_a_taper_that_cannot_be_is_refused(fraction: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Tapered\.fraction is .*: give a fraction"):
        cs.Tapered(fraction)
