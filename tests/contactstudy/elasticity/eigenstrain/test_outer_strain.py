"""Plastic strain that goes on to infinity on both sides of a volume."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.outer_strain import OuterStrain
from contactstudy.elasticity.eigenstrain.plane_strain_operator import (
    PLANE_STRAIN_BASIS,
    PlaneStrainOperator,
)
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume

MODULI = Moduli(2.0, 0.3)
DX = 0.2
EDGES = (0.0, 0.2, 0.4, 0.7, 1.1)


def volume(cells: int, first: int, last: int) -> Volume:
    return Volume(cs.Grid((cells, 1), (cells * DX, 1.0)), first, last, EDGES)


def test_strain_that_is_the_same_everywhere_leaves_stress_in_its_own_layer_and_a_flat_surface() -> (
    None
):
    """xx = -E' (e_xx + nu e_yy), zz = xz = 0: exact, so to rounding."""
    operator = PlaneStrainOperator(volume(14, 0, 14), MODULI)
    strain = np.random.default_rng(0).normal(size=(3, 4))
    cells = np.broadcast_to(strain[:, :, None, None], (3, *operator.volume.shape)).copy()
    around = OuterStrain(operator)
    stress = operator.residual_stress_tensor(cells) + around.tensor(strain, strain)
    xx, yy, *_ = np.einsum("ct,cl->tl", PLANE_STRAIN_BASIS, strain)
    expected = -MODULI.plane_strain * (xx + 0.3 * yy)
    np.testing.assert_allclose(stress[0, ..., 0], expected[:, None] + np.zeros(14), atol=1e-12)
    np.testing.assert_allclose(stress[[2, 4]], 0.0, atol=1e-12)
    deviator = around.stress(strain, strain) - operator.relaxed_stress(cells)
    np.testing.assert_allclose(deviator, np.einsum("ct,tlxy->clxy", PLANE_STRAIN_BASIS * (1, 1, 1, 2, 2, 2), stress),
                               atol=1e-12)  # fmt: skip
    surface = operator.residual_displacement(cells) + around.residual_displacement(strain, strain)
    np.testing.assert_allclose(surface, surface[0, 0], atol=1e-12)


def test_half_lines_are_what_ever_longer_ones_come_to() -> None:
    """What a cut one lacks falls like one over its length: by 4, but for 14 cells in 200."""
    generator = np.random.default_rng(1)
    left, right = generator.normal(size=(2, 3, 4))
    inner = OuterStrain(PlaneStrainOperator(volume(14, 0, 14), MODULI))
    stress, wrong = inner.tensor(left, right), []
    for more in (200, 800):
        cells = 14 + 2 * more
        whole = PlaneStrainOperator(volume(cells, 0, cells), MODULI)
        strain = np.zeros((3, *whole.volume.shape))
        strain[:, :, :more] = left[:, :, None, None]
        strain[:, :, more + 14 :] = right[:, :, None, None]
        cut = whole.residual_stress_tensor(strain)[:, :, more : more + 14]
        wrong.append(np.abs(stress - cut).max() / np.abs(stress).max())
    assert wrong[0] < 2e-2
    assert wrong[1] == pytest.approx(wrong[0] / 4, rel=14 / 200)
