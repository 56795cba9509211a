import numpy as np
import pytest

from contactstudy.domain.fields import Array
from contactstudy.scene.surfaces.preparation import Ends, cell_means

ROUGH = np.random.default_rng(0).standard_normal((5, 24)) + 7


def resampled(cells: int, width: float = 1.0, *, ends: Ends = "periodic") -> Array:
    return cell_means(ROUGH, 1, extent=1.0, cells=cells, width=width, ends=ends)


@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
def test_cells_of_whole_points_have_their_mean(ends: Ends) -> None:
    coarse = resampled(6, ends=ends)
    np.testing.assert_allclose(coarse, ROUGH.reshape(5, 6, 4).mean(axis=2), rtol=1e-14)
    np.testing.assert_array_equal(resampled(24, ends=ends), ROUGH)


@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
@pytest.mark.parametrize("cells", [7, 24, 50])
def test_smaller_cells_make_up_the_mean_of_a_larger_one(cells: int, ends: Ends) -> None:
    fine = resampled(3 * cells, ends=ends)
    coarse = fine.reshape(5, cells, 3).mean(axis=2)
    np.testing.assert_allclose(resampled(cells, ends=ends), coarse, rtol=1e-13)


def test_a_narrower_grid_shows_the_middle() -> None:
    middle = resampled(10, 10 / 24, ends="not-a-knot")
    np.testing.assert_allclose(middle, ROUGH[:, 7:17], rtol=1e-13)


def test_a_period_of_three_shows_the_surface_thrice() -> None:
    three = resampled(90, 3.0)
    np.testing.assert_allclose(three, np.tile(resampled(30), 3), rtol=1e-13)


@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
def test_finer_points_show_a_smooth_surface_at_third_order(ends: Ends) -> None:
    """The derivative of a cubic spline: the means of cells on a grid that is no multiple of theirs."""

    def mean(count: int) -> Array:
        edges = np.linspace(-0.5, 0.5, count + 1)
        return np.diff(np.sin(2 * np.pi * edges + 0.4))[None, :] * count / (2 * np.pi)

    errors = []
    for count in (16, 32, 64):
        found = cell_means(mean(count), 1, extent=1.0, cells=37, width=1.0, ends=ends)
        errors.append(np.abs(found - mean(37)).max())
    rate = np.log2(errors[0] / errors[2]) / 2
    assert rate > 2.7, errors


def test_a_constant_stays_one() -> None:
    flat = cell_means(np.full((3, 5), 2.0), 0, extent=1.0, cells=7, width=0.3, ends="not-a-knot")
    np.testing.assert_allclose(flat, np.full((7, 5), 2.0), rtol=1e-15)


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
def test_few_points_keep_their_means_too(count: int, ends: Ends) -> None:
    few = ROUGH[:, :count]
    fine = cell_means(few, 1, extent=1.0, cells=4 * count, width=1.0, ends=ends)
    np.testing.assert_allclose(fine.reshape(5, count, 4).mean(axis=2), few, rtol=1e-13)
