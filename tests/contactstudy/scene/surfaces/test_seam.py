import numpy as np

import contactstudy as cs

HEIGHTS = np.random.default_rng(0).standard_normal((6, 40)) + 3


def test_tapered_keeps_the_middle_and_meets_the_mean_at_the_ends() -> None:
    closed = cs.Tapered(fraction=0.5).periodic(HEIGHTS)
    mean = HEIGHTS.mean()
    np.testing.assert_allclose(closed[:, 10:30], HEIGHTS[:, 10:30], rtol=1e-14)
    # half a point from the end of a taper of ten, sin^2 is small
    end = np.sin(np.pi / 2 * 0.5 / 10) ** 2
    np.testing.assert_allclose(closed[:, 0] - mean, end * (HEIGHTS[:, 0] - mean), rtol=1e-9)
    np.testing.assert_allclose(closed[:, -1] - mean, end * (HEIGHTS[:, -1] - mean), rtol=1e-9)


def test_a_seam_across_closes_the_width_as_a_seam_along_closes_the_length() -> None:
    along = cs.MeasuredSurface(HEIGHTS, (6e-3, 4e-2), seam=cs.Tapered(0.2))
    across = cs.MeasuredSurface(HEIGHTS.T, (4e-2, 6e-3), seam_across=cs.Tapered(0.2))
    for width, length in ((6e-3, 4e-2), (6e-3, 2e-2)):
        grids = cs.Grid((6, 40), (width, length)), cs.Grid((40, 6), (length, width))
        np.testing.assert_allclose(along.gap(grids[0]), across.gap(grids[1]).T, rtol=1e-9)
    cell_by_cell = cs.MeasuredSurface(HEIGHTS.T, seam_across=cs.Mirrored()).gap(cs.Grid((80, 6), (1.0, 1.0)))
    np.testing.assert_array_equal(cell_by_cell, cell_by_cell[::-1])
