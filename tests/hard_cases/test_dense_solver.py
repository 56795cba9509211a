import numpy as np
import pytest

from tests.hard_cases import dense_solver


@pytest.mark.parametrize("count", [2, 3, 7])
def test_the_smallest_eigenvalue_is_that_of_modes_that_shift_no_mean(count: int) -> None:
    """Free cells alone move, and the load keeps their sum: the compliance among sums of zero."""
    rng = np.random.default_rng(count)
    root = rng.standard_normal((9, 9))
    matrix = root @ root.T + np.eye(9)
    free = np.isin(np.arange(9), rng.choice(9, count, replace=False))
    # an orthonormal basis of the sums of zero: what is left of the plane wave of no length
    basis = np.linalg.qr(np.column_stack([np.ones(count), np.eye(count)[:, 1:]]))[0][:, 1:]
    among = basis.T @ matrix[np.ix_(free, free)] @ basis
    expected = np.linalg.eigvalsh(among)[0]
    # eigenvalues to some machine epsilons of the largest
    assert dense_solver._smallest_eigenvalue(matrix, free) == pytest.approx(
        expected, abs=1e-12 * np.trace(matrix)
    )
