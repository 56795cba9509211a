import numpy as np

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.periodic_operator import PeriodicOperator
from contactstudy.elasticity.eigenstrain.plane_strain_operator import PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import EigenstrainOperator, Moduli, Volume
from tests.conftest import STEEL

EXACT = cs.ExactPeriodicity()


def deviator(operator: EigenstrainOperator, tensor: np.ndarray) -> np.ndarray:
    """Deviatoric components (C, ...) of a tensor xx, yy, zz, yz, xz, xy (6, ...)."""
    return np.einsum("ct,t...->c...", operator.basis * (1, 1, 1, 2, 2, 2), tensor)


def test_shear_below_a_pressed_cell_is_the_stress_of_cerruti() -> None:
    """Means over cells beside points in the middle of cells five times as fine."""
    fine = cs.Grid((5 * 32, 1), (5 * 32e-6, 1.0))
    shear = np.repeat(np.r_[np.zeros(10), np.linspace(1, 2, 8), np.zeros(14)], 5)[:, None]
    edges = (0.0, 5e-6, 15e-6)
    operator = PlaneStrainOperator(Volume(cs.Grid((32, 1), fine.extent), 0, 32, edges), Moduli(2e11, 0.3))
    depths = np.r_[(np.arange(6) + 0.5) * 5e-6 / 6, 5e-6 + (np.arange(6) + 0.5) * 10e-6 / 6]
    below = cs.SubsurfaceStress(tuple(depths)).of((STEEL, STEEL), fine, (cs.ZeroPadding(), EXACT))
    points = below.with_shear(np.stack([shear, 0 * shear]))(0 * shear)
    wanted = deviator(operator, points.reshape(6, 2, 6, 32, 5, 1).mean(axis=(2, 4)))
    np.testing.assert_allclose(operator.stress_of_shear(shear[::5]), wanted, atol=0.01)


def test_shear_below_a_pressed_cell_is_that_of_cerruti_where_it_varies_along() -> None:
    """Means over cells beside points in the middle of cells three times as fine, for all six components."""
    fine, part = cs.Grid((72, 36), (72e-6, 54e-6)), 3
    grid = cs.Grid((24, 12), fine.extent)
    x, y = grid.x[:, None] / 36e-6, 2 * np.pi * grid.y / 54e-6
    shear = np.where(abs(x) < 0.5, 1 + 0.5 * x + 0.7 * np.cos(y) + 0.3 * np.sin(2 * y), 0.0)
    edges = (3e-6, 6e-6, 12e-6)
    operator = PeriodicOperator(Volume(grid, 0, 24, edges), Moduli(2e11, 0.3))
    nodes = (np.arange(4) + 0.5) / 4
    depths = np.concatenate([edges[0] + nodes * 3e-6, edges[1] + nodes * 6e-6])
    below = cs.SubsurfaceStress(tuple(depths)).of((STEEL, STEEL), fine, (cs.ZeroPadding(), EXACT))
    across = shear.repeat(part, axis=0).repeat(part, axis=1)
    points = below.with_shear(np.stack([across, 0 * across]))(0 * across)
    wanted = deviator(operator, points.reshape(6, 2, 4, 24, part, 12, part).mean(axis=(2, 4, 6)))
    np.testing.assert_allclose(operator.stress_of_shear(shear), wanted, atol=0.015)
