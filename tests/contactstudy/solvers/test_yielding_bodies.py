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
            found = law.return_mapping(stress, guess, strain, equivalent)
            if np.abs(found.strain - guess).max() < 1e-15:
                break
            guess = found.strain
        equivalent = equivalent + (2 / 3) ** 0.5 * np.abs(guess - strain).max(axis=0) * 1.0
        strain = guess
    return float((2 / 3) ** 0.5 * strain[0, 0]), float(equivalent[0])


def law(isotropic: float, kinematic: float) -> VonMisesPlasticity:
    return VonMisesPlasticity(*(np.array([one]) for one in (TWICE_SHEAR, YIELD, isotropic, kinematic)))


@pytest.mark.parametrize("fraction", [0.0, 0.5, 1.0])
def test_a_bar_in_tension_hardens_by_both_moduli_together(fraction: float) -> None:
    both = 0.8
    strain, equivalent = stressed(law(fraction * both, (1 - fraction) * both), [0.9, 1.2, 1.4])
    assert strain == pytest.approx(0.4 / both, rel=1e-12)
    assert equivalent == pytest.approx(0.4 / both, rel=1e-12)


def test_isotropic_hardening_widens_the_range_without_yield() -> None:
    strain, _ = stressed(law(0.5, 0.0), [1.4, -1.4])
    assert strain == pytest.approx(0.8, rel=1e-12)
    back, equivalent = stressed(law(0.5, 0.0), [1.4, -1.6])
    assert back == pytest.approx(0.8 - 0.4, rel=1e-12)
    assert equivalent == pytest.approx(1.2, rel=1e-12)


def test_kinematic_hardening_moves_the_range_without_yield() -> None:
    """From 1.4 down it yields at -0.6 (Bauschinger), with a modulus of 0.5."""
    strain, _ = stressed(law(0.0, 0.5), [1.4, -0.59])
    assert strain == pytest.approx(0.8, rel=1e-12)
    back, _ = stressed(law(0.0, 0.5), [1.4, -0.8])
    assert back == pytest.approx(0.8 - 0.2 / 0.5, rel=1e-12)
