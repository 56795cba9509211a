import numpy as np
import pytest
from mpmath import asinh, atan, mp, mpf, sqrt

from contactstudy.elasticity.kernels.displacement_cell import boussinesq_cell
from contactstudy.elasticity.kernels.layer.buried_potential import buried_cell
from tests.fifty_digits import over_decades, stored


def corner(x: mpf, y: mpf, c: mpf) -> mpf:
    r = sqrt(x * x + y * y + c * c)
    lines = x * asinh(y / sqrt(x * x + c * c)) + y * asinh(x / sqrt(y * y + c * c))
    return lines - c * atan(x * y / (c * r))


@stored
def judged_buried_cell(x: float, y: float, dx: float, dy: float, depth: float) -> mpf:
    with mp.workdps(50):
        ends = [[mpf(a) + s * mpf(d) / 2 for s in (1, -1)] for a, d in ((x, dx), (y, dy))]
        signed = (
            (s * t, ends[0][i], ends[1][j])
            for i, s in enumerate((1, -1))
            for j, t in enumerate((1, -1))
        )
        return sum(sign * corner(u, v, mpf(depth)) for sign, u, v in signed)


def test_a_cell_is_its_closed_form_at_any_aspect_depth_and_distance() -> None:
    chance = np.random.default_rng(5)
    for _ in range(600):
        dx, x, y = (over_decades(chance, -3, high) for high in (3, 4, 4))
        depth = over_decades(chance, -4, 5) * chance.choice([dx, 1.0])
        x, y = x * dx * chance.choice([0, 1, 1]), y * chance.choice([0, 1, 1])
        wanted = float(judged_buried_cell(x, y, dx, 1.0, depth))
        # the error that is stated
        assert float(buried_cell(x, y, dx, 1.0, depth)) == pytest.approx(wanted, rel=1e-14)


def test_without_depth_it_is_the_loaded_cell_itself() -> None:
    x, y = np.arange(6.0)[:, None] * 0.7, np.arange(7.0) * 1.3
    loaded = boussinesq_cell(x, y, 0.7, 1.3)
    np.testing.assert_allclose(buried_cell(x, y, 0.7, 1.3, 1e-30), loaded, rtol=1e-14)
