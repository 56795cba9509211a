"""What passes of a contact leave, of plastic strain that is written here."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.evolution.rolling.repeated_rolling import RepeatedRolling, RollingPass
from contactstudy.evolution.rolling.track import DepthProfile

GRID = cs.Grid((4, 1), (4.0, 1.0))
# an orthonormal basis: xx against zz, yy against the others, and the shear xz
BASIS = np.array(
    [
        np.array([1, 0, -1, 0, 0, 0]) / 2**0.5,
        np.array([-1, 2, -1, 0, 0, 0]) / 6**0.5,
        np.array([0, 0, 0, 0, 1, 0]) / 2**0.5,
    ]
)


def left(*strains: tuple[float, float, float], equivalent: tuple[float, ...]) -> DepthProfile:
    """Of layers with these components in the basis."""
    return DepthProfile(np.array(strains).T, np.array(equivalent))


def one(profile: DepthProfile, peak: float, status: cs.Status = cs.Status.CONVERGED) -> RollingPass:
    solution: Any = SimpleNamespace(pressure=np.array([[0.0], [peak], [peak / 2], [0.0]]))
    return RollingPass(profile, 5.0, solution, status, 10, 40)


def rolled(*passes: RollingPass) -> RepeatedRolling:
    operator = SimpleNamespace(
        volume=Volume(GRID, 0, 4, (0.0, 1.0, 3.0)), moduli=Moduli(91.0, 0.3), basis=BASIS
    )
    track: Any = SimpleNamespace(operator=operator)
    return RepeatedRolling(passes, track, track, None)  # type: ignore[arg-type]


# the second pass yields a layer deeper, the third nowhere
FIRST = left((0.002, 0.0, 0.004), equivalent=(0.005,))
SECOND = left((0.002, 0.001, 0.006), (0.0, 0.0, 0.001), equivalent=(0.008, 0.001))
THREE = rolled(one(FIRST, 7.0), one(SECOND, 8.0), one(SECOND, 8.0, cs.Status.STALLED))


def test_strain_of_each_pass_is_that_of_its_basis_down_to_the_deepest_layer() -> None:
    strain = THREE.plastic_strain
    assert strain.shape == (3, 6, 2)
    root2, root6 = 2**0.5, 6**0.5
    assert strain[0, :, 0] == pytest.approx([0.002 / root2, 0, -0.002 / root2, 0, 0.004 / root2, 0])
    assert strain[0, :, 1] == pytest.approx(np.zeros(6))
    assert strain[1, 0, 0] == pytest.approx(0.002 / root2 - 0.001 / root6)
    assert strain[1, 1, 0] == pytest.approx(0.002 / root6)
    assert strain[1, 4] == pytest.approx(np.array([0.006, 0.001]) / root2)
    assert THREE.equivalent_plastic_strain.tolist() == [[0.005, 0], [0.008, 0.001], [0.008, 0.001]]
    assert THREE.depths.tolist() == [0.5, 2.0]
    assert THREE.grid == GRID


def test_stress_is_what_holds_the_strain_in_plane() -> None:
    """Far behind the contact xx and yy alone: plates that cannot stretch, E / (1 - nu^2) = 100."""
    strain, stress = THREE.plastic_strain, THREE.residual_stress
    assert stress[:, 0] == pytest.approx(-100 * (strain[:, 0] + 0.3 * strain[:, 1]))
    assert stress[:, 1] == pytest.approx(-100 * (strain[:, 1] + 0.3 * strain[:, 0]))
    assert not stress[:, 2:].any()


def test_what_a_pass_adds_is_counted_from_the_pass_before() -> None:
    assert THREE.plastic_strain_increment == pytest.approx([0.005, 0.003, 0])
    root2 = 2**0.5
    shear = 2 / root2 * np.array([[0.004, 0], [0.002, 0.001], [0, 0]])
    assert THREE.shear_strain_increment == pytest.approx(shear)
    # over layers of 1 m and 2 m
    assert THREE.forward_displacement == pytest.approx(shear @ [1.0, 2.0])
    assert THREE.peak_pressure.tolist() == [7, 8, 8]


def test_it_has_shaken_down_from_the_first_pass_on_that_adds_nothing() -> None:
    assert THREE.shakedown_pass == 3
    assert rolled(*THREE.passes[:2]).shakedown_pass is None
    more = left((0.002, 0.001, 0.007), equivalent=(0.009,))
    assert rolled(one(FIRST, 7.0), one(SECOND, 8.0), one(more, 8.0)).shakedown_pass is None
    nowhere = left((0.0, 0.0, 0.0), equivalent=(0.0,))
    assert rolled(one(nowhere, 1.0), one(nowhere, 1.0)).shakedown_pass == 1
    assert THREE.status is cs.Status.STALLED
