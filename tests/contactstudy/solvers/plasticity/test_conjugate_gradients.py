"""Conjugate gradients beside dense algebra."""

import numpy as np
import pytest

from contactstudy.solvers.plasticity.conjugate_gradients import conjugate_gradients

RNG = np.random.default_rng(3)
HALF = RNG.standard_normal((6, 6))
MATRIX = HALF @ HALF.T + np.eye(6)
WANTED = RNG.standard_normal(6)
RIGHT = np.linalg.solve(MATRIX, WANTED)


def solved(share: float, most: int, diagonal: np.ndarray) -> np.ndarray:
    return conjugate_gradients(
        lambda x: MATRIX @ x,
        lambda r: r / diagonal,
        lambda a, b: float(a @ b),
        WANTED,
        share,
        most,
    )


@pytest.mark.parametrize("diagonal", [np.ones(6), np.diag(MATRIX)])
def test_six_products_solve_six_equations(diagonal: np.ndarray) -> None:
    # to rounding times the condition, some hundreds
    np.testing.assert_allclose(solved(1e-14, 6, diagonal), RIGHT, rtol=1e-9)
    assert np.abs(solved(1e-14, 5, diagonal) - RIGHT).max() > 1e-6


def test_the_first_step_is_that_of_steepest_descent() -> None:
    length = (WANTED @ WANTED) / (WANTED @ MATRIX @ WANTED)
    np.testing.assert_allclose(solved(1e-14, 1, np.ones(6)), length * WANTED)
    assert not solved(1e-14, 0, np.ones(6)).any()


@pytest.mark.parametrize("share", [0.5, 0.1, 0.01])
def test_it_ends_with_the_first_residual_below_the_share(share: float) -> None:
    residuals = [np.linalg.norm(WANTED - MATRIX @ solved(1e-14, n, np.ones(6))) for n in range(7)]
    ends = next(n for n, size in enumerate(residuals) if size <= share * residuals[0])
    np.testing.assert_allclose(solved(share, 100, np.ones(6)), solved(1e-14, ends, np.ones(6)))


def test_without_curvature_it_ends() -> None:
    flat = np.diag([1.0, 0.0])
    found = conjugate_gradients(
        lambda x: flat @ x, lambda r: r, lambda a, b: float(a @ b), np.array([0.0, 1.0]), 1e-9, 9
    )
    assert not found.any()
    nothing = conjugate_gradients(
        lambda x: flat @ x, lambda r: r, lambda a, b: float(a @ b), np.zeros(2), 1e-9, 9
    )
    assert not nothing.any()
