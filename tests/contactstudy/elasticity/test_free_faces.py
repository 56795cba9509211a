from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.elasticity.convolution import FreeFaceCoefficients
from contactstudy.elasticity.free_faces import EndedConvolution, between_faces

FREE = cs.ZeroPadding(), cs.ZeroPadding()
# Displacement times E* over the pressure on |x| < 1/2, 0 < y < 1 of a quarter-space whose face is y = 0, at x = 0 and
# y = 0, 1/2, 1, 3, less that at y = 2; from a dense solution on graded cells and, for 0.3, from finite elements.
QUARTER_SPACE = {
    0.0: (1.3813, 1.1856, 0.6700, -0.1358),
    0.3: (1.6254, 1.2807, 0.7118, -0.1535),
    0.5: (2.0253, 1.4523, 0.7889, -0.1866),
}


def ended(grid: cs.Grid, *bodies: tuple[float, float]) -> EndedConvolution:
    """Operator of bodies of E* = 1 Pa, each with its length and Poisson's ratio."""
    response = {FreeFaceCoefficients.of(*body): 1 / pi for body in bodies}
    operator = between_faces(response, grid, FREE)
    assert isinstance(operator, EndedConvolution)
    return operator


def between(field: np.ndarray, k: int) -> np.ndarray:
    """Value (y,) between the rows k - 1 and k of `field`, by a cubic through four rows."""
    value: np.ndarray = (9 * (field[k - 1] + field[k]) - field[k - 2] - field[k + 1]) / 16
    return value


@pytest.mark.cases(3)
@pytest.mark.parametrize("poisson_ratio", QUARTER_SPACE)
def test_a_patch_beside_a_face_sinks_as_in_a_quarter_space(poisson_ratio: float) -> None:
    grid = cs.Grid((32, 640), (2.0, 40.0))
    pressure = np.zeros(grid.cells)
    pressure[8:24, :16] = 1
    displacement = ended(grid, (40.0, poisson_ratio))(pressure)
    line = between(displacement, 16)
    at_face = 1.5 * line[0] - 0.5 * line[1]
    computed = np.array([at_face, *(between(line[:, None], k)[0] for k in (8, 16, 48))])
    expected = np.array(QUARTER_SPACE[poisson_ratio])
    error = (computed - between(line[:, None], 32)[0] - expected) / expected[0]
    assert np.abs(error[1:]).max() < 5e-4
    assert abs(error[0]) < 2e-3


@pytest.mark.parametrize("half", [32, 37])  # transforms of 128 points, and of twice an odd number
def test_the_operator_is_self_adjoint_and_so_are_its_blocks_of_cells(half: int) -> None:
    grid = cs.Grid((2 * half, 96), (1.0, 2.0))
    operator = ended(grid, (2.0, 0.3), (2.6, 0.2))
    a, b = np.random.default_rng(1).standard_normal((2, *grid.cells))
    size = float(np.abs(operator(np.abs(a))).max() * np.abs(b).sum())
    assert abs(np.vdot(b, operator(a)) - np.vdot(a, operator(b))) < 1e-14 * size
    coarse = operator.coarsened()
    assert coarse.cells == (half, 48)
    blocks = np.repeat(np.repeat(a[:half, :48], 2, axis=0), 2, axis=1)
    means = operator(blocks).reshape(half, 2, 48, 2).mean(axis=(1, 3))
    assert_allclose(coarse(a[:half, :48]), means, rtol=0, atol=1e-13 * float(np.abs(means).max()))


def test_a_grid_within_the_faces_is_a_part_of_one_up_to_them() -> None:
    """Beyond the part there is no pressure."""
    whole, part = cs.Grid((16, 48), (1.0, 3.0)), cs.Grid((16, 40), (1.0, 2.5))
    pressure = np.random.default_rng(2).random(whole.cells)
    pressure[:, :4] = pressure[:, 44:] = 0
    expected = ended(whole, (3.0, 0.3))(pressure)[:, 4:44]
    computed = ended(part, (3.0, 0.3))(pressure[:, 4:44])
    assert_allclose(computed, expected, rtol=2e-4)


def test_far_from_its_faces_a_body_is_a_half_space() -> None:
    """But for a rigid displacement."""
    grid = cs.Grid((16, 24), (1.0, 1.5))
    pressure = np.random.default_rng(3).random(grid.cells)
    half_space = cs.convolution(1.0, grid, cs.ZeroPadding(), 1.0)(pressure)
    change = ended(grid, (3000.0, 0.3))(pressure) - half_space
    assert np.ptp(change) < 1e-5 * half_space.max()
