import numpy as np
import pytest

from contactstudy.solvers.plasticity import VonMisesPlasticity

TWICE_SHEAR, YIELD = 1.6, 1.0


def stressed(law: VonMisesPlasticity, deviators: list[float]) -> tuple[float, float]:
    """Plastic strain and equivalent strain in tension after tension by these stresses, one after the other."""
    # a bar under s has the deviator sqrt(2/3) s along (2, -1, -1) / sqrt(6), its strain sqrt(3/2) e
    strain, equivalent = np.zeros((3, 1)), np.zeros(1)
    for tension in deviators:
        stress = np.array([[(2 / 3) ** 0.5 * tension], [0.0], [0.0]])
        # dead weights: the strain that makes the trial stress come back to this stress
        guess = strain
        for _ in range(200):
            mapped = law.return_mapping(stress, guess, strain, equivalent)
            if np.abs(mapped.strain - guess).max() < 1e-15:
                break
            guess = mapped.strain
        equivalent = equivalent + (2 / 3) ** 0.5 * np.abs(guess - strain).max(axis=0) * 1.0
        strain = guess
    return float((2 / 3) ** 0.5 * strain[0, 0]), float(equivalent[0])


def law(isotropic: float, kinematic: float) -> VonMisesPlasticity:
    return VonMisesPlasticity(*(np.array([modulus]) for modulus in (TWICE_SHEAR, YIELD, isotropic, kinematic)))


def test_a_bar_in_tension_hardens_by_both_moduli_together() -> None:
    for fraction in (0.0, 0.5, 1.0):
        strains = stressed(law(fraction * 0.8, (1 - fraction) * 0.8), [0.9, 1.2, 1.4])
        assert strains == pytest.approx((0.4 / 0.8, 0.4 / 0.8), rel=1e-12)


def test_isotropic_hardening_widens_the_range_without_yield_and_kinematic_moves_it() -> None:
    """From 1.4 down the one yields at -1.4, the other at -0.6 (Bauschinger), both with a modulus of 0.5."""
    isotropic, kinematic = law(0.5, 0.0), law(0.0, 0.5)
    assert stressed(isotropic, [1.4, -1.4])[0] == pytest.approx(0.8, rel=1e-12)
    assert stressed(isotropic, [1.4, -1.6]) == pytest.approx((0.8 - 0.4, 1.2), rel=1e-12)
    assert stressed(kinematic, [1.4, -0.59])[0] == pytest.approx(0.8, rel=1e-12)
    assert stressed(kinematic, [1.4, -0.8])[0] == pytest.approx(0.8 - 0.2 / 0.5, rel=1e-12)
