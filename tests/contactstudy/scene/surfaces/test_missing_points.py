import numpy as np
import pytest

import contactstudy as cs

X, Y = np.meshgrid(np.arange(12.0), np.arange(9.0), indexing="ij")
HARMONIC = 2 - X + 3 * Y + X**2 - Y**2 + X * Y  # on five points too
HOLES = np.zeros(X.shape, dtype=bool)
HOLES[3:6, 4:7] = HOLES[8, 2] = True


def test_holes_in_a_harmonic_surface_are_filled_with_it() -> None:
    filled = cs.HarmonicFill().fill(np.where(HOLES, np.nan, HARMONIC))
    np.testing.assert_allclose(filled, HARMONIC, rtol=1e-12)


def test_no_filled_point_is_beyond_those_around_it() -> None:
    rough = np.random.default_rng(0).standard_normal(X.shape)
    holes = HOLES.copy()
    holes[0, :3] = holes[-1, -1] = True  # at the edge and in a corner
    filled = cs.HarmonicFill(up_to=0.5).fill(np.where(holes, np.nan, rough))
    np.testing.assert_array_equal(filled[~holes], rough[~holes])
    assert np.isfinite(filled).all()
    assert filled.min() >= rough[~holes].min()
    assert filled.max() <= rough[~holes].max()


def test_missing_points_are_refused_with_their_count() -> None:
    heights = np.where(HOLES, np.nan, HARMONIC)
    with pytest.raises(cs.InvalidInput, match="has 10 missing points of 108: fill them, or give"):
        cs.MeasuredSurface(heights)
    with pytest.raises(cs.InvalidInput, match=r"has 10 missing points of 108, a fraction of 0\.093: give"):
        cs.MeasuredSurface(heights, missing=cs.HarmonicFill(up_to=0.05))
    assert cs.MeasuredSurface(heights, missing=cs.HarmonicFill())
