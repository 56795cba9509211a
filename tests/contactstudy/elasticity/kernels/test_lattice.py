import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from contactstudy.elasticity.kernels.displacement_periodic import boussinesq_cell_doubly_periodic
from tests.contactstudy.elasticity.kernels.test_cell import EXACT, TOLERANCE_DIGITS
from tests.contactstudy.elasticity.kernels.test_row import judged_lattice
from tests.fifty_digits import stored

row = judged_lattice.__wrapped__  # its places are in fifty digits, and none is stored


@stored
def judged_double_lattice(x: float, y: float, dx: float, dy: float, width: float, period: float) -> mp.mpf:
    """Rows one by one, and the logarithms of all others as an integral of Gamma functions."""
    rows = int(np.ceil(7 * period / width)) + 1  # exp(-14 pi) is left
    with mp.workdps(TOLERANCE_DIGITS):
        x, width = mp.mpf(x), mp.mpf(width)

        def others(u: mp.mpf) -> mp.mpf:
            return mp.loggamma(rows + 1 + u / width) + mp.loggamma(rows + 1 - u / width)

        total = mp.fsum(row(x + m * width, y, dx, dy, period) for m in range(-rows, rows + 1))
        mean = mp.quad(others, [x - dx / 2, x + dx / 2]) / dx
        shift = (2 * rows + 1) * mp.log(width) - mp.log(2 * mp.pi)
        return total + 2 * mp.mpf(dx) * dy / period * (shift + mean)


@pytest.mark.parametrize(("nx", "ny"), [(1, 3), (300, 200), (8, 1)])
@pytest.mark.parametrize(("width", "period"), [(1.2, 0.8), (3.0, 0.05), (900.0, 700.0)])
def test_lattice_is_exact(width: float, period: float, nx: int, ny: int) -> None:
    dx, dy = width / nx, period / ny
    x, y = np.array([0, 0.5, 0.21, 0.5]) * width, np.array([0, 0.1, 0.37, 0.5]) * period
    found = boussinesq_cell_doubly_periodic(x, y, dx, dy, width, period)
    expected = [judged_double_lattice(u, v, dx, dy, width, period) for u, v in zip(x, y, strict=True)]
    error = np.array([abs(float(f - e)) for f, e in zip(found, expected, strict=True)])
    fraction = dx * dy / min(width, period)
    assert (error < EXACT * np.maximum(np.abs(np.array(expected, float)), fraction)).all()


def test_offsets_count_modulo_the_periods_and_without_sign() -> None:
    x, y = 0.31, 0.17
    base = boussinesq_cell_doubly_periodic(x, y, 0.1, 0.1, 1.2, 0.8)
    for sx, sy in ((1, -1), (-1, 1), (-1, -1)):
        mirrored = boussinesq_cell_doubly_periodic(sx * x, sy * y, 0.1, 0.1, 1.2, 0.8)
        assert_array_equal(mirrored, base)
    moved = boussinesq_cell_doubly_periodic(x + 1.2, y - 0.8, 0.1, 0.1, 1.2, 0.8)
    assert_allclose(moved, base, rtol=1e-13)
