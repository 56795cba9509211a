"""What the study of coated bodies records, and stress in a layer on a rigid base and in a thin one, in closed form."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.coated import CoatedHalfSpace
from studies.definitions import coating

MODULUS = 70e9


def body(ratio: float, above: float, below: float, thickness: float = 1.0) -> CoatedHalfSpace:
    return CoatedHalfSpace(
        cs.HalfSpace(ratio * MODULUS, above), thickness, cs.HalfSpace(MODULUS, below)
    )


@pytest.mark.parametrize("nu", [0.2, 0.4])
def test_stress_at_a_rigid_base_is_that_of_a_layer_bonded_to_it(nu: float) -> None:
    """Airy's function ``c ((1 - 2 nu) S + t C) + d (t S - 2 (1 - nu) C)`` is still at the base, t above it.

    S and C are the hyperbolic sine and cosine of t; it is 1 and flat at the top, where t is k.
    """
    k = np.array([0.3, 1.0, 2.5])
    s, c = np.sinh(k), np.cosh(k)
    value = np.array([(1 - 2 * nu) * s + k * c, k * s - 2 * (1 - nu) * c])
    slope = np.array([2 * (1 - nu) * c + k * s, k * c - (1 - 2 * nu) * s])
    det = value[0] * slope[1] - value[1] * slope[0]
    first, second = slope[1] / det, -slope[0] / det
    shear, along = coating._at_interface(body(1e-9, nu, 0.3), k)
    # the base gives way by its fraction of the moduli
    np.testing.assert_allclose(shear, -2 * (1 - nu) * first, rtol=1e-6)
    np.testing.assert_allclose(along, 2 * nu * second, rtol=1e-6)


@pytest.mark.parametrize(("ratio", "above", "below"), [(3.0, 0.2, 0.4), (0.5, 0.35, 0.1)])
def test_a_thin_layer_is_stretched_like_the_surface_under_it(
    ratio: float, above: float, below: float
) -> None:
    """Under a pressure p the surface of a half-plane bears -p along it as well, and so contracts.

    By ``(1 + nu) (1 - 2 nu) p / E``; the layer does the same under the same pressure across.
    """
    k = np.array([1e-4])
    shear, along = coating._at_interface(body(ratio, above, below), k)
    stretched = ratio * (1 + below) * (1 - 2 * below)
    wanted = -(stretched + above * (1 + above)) / (1 - above**2)
    # what bends is of the order of the wave number; balance along the layer leaves its thickness' worth of shear
    np.testing.assert_allclose(along, wanted, rtol=20 * k[0])
    np.testing.assert_allclose(shear, k * wanted, rtol=20 * k[0])


@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_known_contacts_are_met_to_the_square_of_the_cell(ratio: float) -> None:
    # a thin coating and one as thick as the contact is wide to one side
    assert [wide for known, wide, *_ in coating.REFERENCE if known == ratio] == [0.2, 1.0]
    found = coating._reference_error(ratio, 96)
    assert found is not None
    # half-widths of one in a width of 2.4
    assert found < (2.4 / 96) ** 2
