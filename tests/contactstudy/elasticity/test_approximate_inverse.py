"""What of a padded grid's spectrum a division on the unpadded grid takes."""

import numpy as np
import pytest

from contactstudy.elasticity.approximate_inverse import sampled

# Of 15 rows and 15 columns, of which those up to the shortest wave are kept: each is its own number.
SPECTRUM = 100.0 * np.arange(15)[:, None] + np.arange(8) + 1


@pytest.mark.parametrize(
    ("cells", "rows", "columns"),
    [
        # every second wave but for rounding; of 7.5 the longest that there is
        ((8, 8), [0, 2, 4, 6, 8, 9, 11, 13], [0, 2, 4, 6, 7]),
        ((5, 3), [0, 3, 6, 9, 12], [0, 5]),
        ((15, 15), [*range(15)], [*range(8)]),
    ],
)
def test_a_wave_of_the_grid_has_the_nearest_of_the_padded_one(
    cells: tuple[int, int], rows: list[int], columns: list[int]
) -> None:
    np.testing.assert_array_equal(
        sampled(SPECTRUM, cells, (15, 15)), SPECTRUM[np.ix_(rows, columns)]
    )


def test_none_is_below_a_thousandth_of_the_smallest() -> None:
    """In size, and but for the first row, whose first is a mean; of one row, of the largest."""
    spectrum = np.array([[0.0, 1e-9], [-4.0, 2.0]])
    found = sampled(spectrum, (2, 2), (2, 2))
    np.testing.assert_array_equal(found, [[2e-3, 2e-3], [2e-3, 2.0]])
    found = sampled(np.array([[1e-9, 3.0, -5.0]]), (1, 4), (1, 4))
    np.testing.assert_array_equal(found, [[5e-3, 3.0, 5e-3]])
