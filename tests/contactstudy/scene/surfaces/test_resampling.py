import numpy as np
import pytest

from contactstudy.domain.fields import Array
from contactstudy.scene.surfaces.preparation import Ends, cell_means

ROUGH = np.random.default_rng(0).standard_normal((5, 24)) + 7


def resampled(cells: int, width: float = 1.0, *, ends: Ends = "periodic") -> Array:
    return cell_means(ROUGH, 1, extent=1.0, cells=cells, width=width, ends=ends)


def test_a_period_of_three_shows_the_surface_thrice() -> None:
    three = resampled(90, 3.0)
    np.testing.assert_allclose(three, np.tile(resampled(30), 3), rtol=1e-13)


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("ends", ["periodic", "not-a-knot"])
def test_few_points_keep_their_means_too(count: int, ends: Ends) -> None:
    few = ROUGH[:, :count]
    fine = cell_means(few, 1, extent=1.0, cells=4 * count, width=1.0, ends=ends)
    np.testing.assert_allclose(fine.reshape(5, count, 4).mean(axis=2), few, rtol=1e-13)
