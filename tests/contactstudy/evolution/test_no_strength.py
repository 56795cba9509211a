from dataclasses import replace
from math import pi

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL
from tests.contactstudy.evolution.creeping import EXACT, LOAD, rolling_cylinder
from tests.contactstudy.evolution.test_adhesive_history import SCENE as ADHESIVE
from tests.contactstudy.evolution.test_plastic import NU, RIGID, YIELD, YOUNG, grid_of, pressed
from tests.contactstudy.scene.test_fretting import LINE, MU

RISING = rolling_cylinder(cs.HalfSpace(1.0, 0.0), cs.LoadHistory((0.0, 3.0), (LOAD / 2, LOAD)))
FRETTING = replace(LINE, friction=cs.Fretting(MU, (0.0, 0.12, -0.12, 0.12), times=(0.0, 1.0, 2.0, 3.0)))
PULLED = replace(ADHESIVE, load=cs.LoadHistory((0.0, 1.0, 3.0), (pi, pi, -2 * pi)))
PRESSED = replace(pressed(3), solids=(cs.HalfSpace(YOUNG, NU), RIGID))
STRONG = replace(PRESSED, solids=(cs.ElasticPlasticHalfSpace(YOUNG, NU, 1e3 * YIELD, 2e10), RIGID))
WORN = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),), wear=cs.Wear(1e-15, 6.0))
STRIP, WIDE, WIDTHS, STEELS = (
    cs.Grid((cells, 1), (width, 1.0)) for cells, width in ((128, 0.9), (128, 24.0), (220, 2.2), (48, 8e-4))
)


def crept(scene: cs.Scene, fraction: float, delay: float) -> cs.Scene:
    """The first body of a scene, whose modulus relaxes by a half: from its own (1), or to it (a half)."""
    solid = scene.solids[0]
    modulus = solid.youngs_modulus
    body = cs.ViscoelasticHalfSpace(fraction * modulus, solid.poisson_ratio, ((0.5 * modulus, delay),))
    return replace(scene, solids=tuple(body if one == solid else one for one in scene.solids))


# a scene without an effect, the same with one of no strength, where and when; the difference that the solvers leave
CASES = {
    "no wear": (RISING, replace(RISING, wear=cs.Wear(0.0, 1.0)), STRIP, (0.0, 1.0), 0.0),
    "yield stress not reached": (PRESSED, STRONG, grid_of(3, 0.1), (0.0, 0.5, 1.0, 2.0), 1e-6),
    "coating of the same material": (
        WORN, replace(WORN, solids=(cs.CoatedHalfSpace(STEEL, 5e-5, STEEL), STEEL)), STEELS, (0.0, 0.5, 1.0), 1e-5,
    ),
    "slow creep": (RISING, crept(RISING, 0.5, 1e9), STRIP, (0.0, 1.0, 3.0), 1e-5),
    "quick creep": (RISING, crept(RISING, 1.0, 1e-6), STRIP, (0.0, 1.0, 3.0), 1e-5),
    "slow creep, fretting": (FRETTING, crept(FRETTING, 0.5, 1e9), WIDTHS, (0.0, 1.0, 2.0, 3.0), 1e-4),
    "quick creep, fretting": (FRETTING, crept(FRETTING, 1.0, 1e-6), WIDTHS, (0.0, 1.0, 2.0, 3.0), 1e-4),
    "slow creep, adhesion": (PULLED, crept(PULLED, 0.5, 1e9), WIDE, (0.0, 1.0, 1.6, 2.2), 1e-3),
    "quick creep, adhesion": (PULLED, crept(PULLED, 1.0, 1e-6), WIDE, (0.0, 1.0, 1.6, 2.2), 1e-3),
}  # fmt: skip


@pytest.mark.cases(len(CASES))
@pytest.mark.parametrize("name", CASES)
def test_an_effect_of_no_strength_leaves_the_contact_as_it_is_without_it(name: str) -> None:
    without, with_it, grid, times, off = CASES[name]
    is_quick = name.startswith("quick")  # what creeps at the first instants is over at later ones
    wanted, found = (
        cs.solve(scene, grid, EXACT, times=times, tolerance=1e-8).frames[is_quick:] for scene in (without, with_it)
    )
    for one, other in zip(wanted, found, strict=True):
        assert other.status is one.status is cs.Status.CONVERGED
        np.testing.assert_allclose(other.pressure, one.pressure, atol=off * one.pressure.max())
        if one.traction is not None:
            np.testing.assert_allclose(other.shear, one.shear, atol=off * np.abs(one.shear).max())
        for field, values in () if is_quick else one.state.items():
            scale = np.abs(values.values).max()
            np.testing.assert_allclose(other.state[field].values, values.values, atol=off * scale)
