import numpy as np

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.plane_strain_operator import (
    PLANE_STRAIN_BASIS,
    OuterStrain,
    PlaneStrainOperator,
)
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume

MODULI = Moduli(2.0, 0.3)
DX = 0.2
EDGES = (0.0, 0.2, 0.4, 0.7, 1.1)


def volume(cells: int, first: int, last: int) -> Volume:
    return Volume(cs.Grid((cells, 1), (cells * DX, 1.0)), first, last, EDGES)


def test_strain_that_is_the_same_everywhere_leaves_stress_in_its_own_layer_and_a_flat_surface() -> None:
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
    deviator = around.stress(strain, strain) - operator.negative_residual_stress(cells)
    np.testing.assert_allclose(deviator, np.einsum("ct,tlxy->clxy", PLANE_STRAIN_BASIS * (1, 1, 1, 2, 2, 2), stress),
                               atol=1e-12)  # fmt: skip
    surface = operator.residual_displacement(cells) + around.residual_displacement(strain, strain)
    np.testing.assert_allclose(surface, surface[0, 0], atol=1e-12)
