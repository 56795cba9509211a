from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL
from tests.contactstudy.evolution import test_adhesion_of_yielding_bodies as yielding
from tests.contactstudy.evolution import test_sliding_in_time as sliding
from tests.contactstudy.evolution.creeping import LOAD, rolling_cylinder
from tests.contactstudy.evolution.test_adhesive_history import SCENE as ADHESIVE
from tests.contactstudy.evolution.test_plastic import NU, RIGID, YIELD, YOUNG, grid_of, pressed
from tests.contactstudy.scene.test_fretting import LINE, MU

RISING = rolling_cylinder(cs.HalfSpace(1.0, 0.0), cs.LoadHistory((0.0, 3.0), (LOAD / 2, LOAD)))
FRETTING = replace(LINE, friction=cs.Fretting(MU, (0.0, 0.12, -0.12, 0.12), times=(0.0, 1.0, 2.0, 3.0)))
PULLED = replace(ADHESIVE, load=cs.LoadHistory((0.0, 1.0, 3.0), (pi, pi, -2 * pi)))
PRESSED = replace(pressed(3), solids=(cs.HalfSpace(YOUNG, NU), RIGID))
ADHERING = yielding.scene(cs.HalfSpace(yielding.YOUNG, yielding.NU), last=-0.9)
SLOW = cs.ViscoelasticHalfSpace(110e9, 0.3, ((100e9, 1e9),))
HARD = cs.ElasticPlasticHalfSpace(210e9, 0.3, 3e8, 1e10)
CREEPS = cs.ViscoelasticHalfSpace(105e9, 0.3, ((105e9, 0.4),))
STRIP, WIDE, STEELS = (
    cs.Grid((cells, 1), extent) for cells, extent in ((128, (0.9, 1.0)), (128, (24.0, 1.0)), (48, (8e-4, 1e-3)))
)  # fmt: skip
INSTANTS = (0.0, 0.5, 1.0, 1.5, 2.0)


def crept(scene: cs.Scene, fraction: float, delay: float) -> cs.Scene:
    """The first body of a scene, whose modulus relaxes by a half: from its own (1), or to it (a half)."""
    solid = scene.solids[0]
    modulus, nu = solid.youngs_modulus, solid.poisson_ratio
    body = cs.ViscoelasticHalfSpace(fraction * modulus, nu, ((0.5 * modulus, delay),))
    return replace(scene, solids=tuple(body if one == solid else one for one in scene.solids))


def yields_at(scene: cs.Scene, stress: float, hardening: float = 0.0) -> cs.Scene:
    solid = scene.solids[0]
    body = cs.ElasticPlasticHalfSpace(solid.youngs_modulus, solid.poisson_ratio, stress, hardening)
    return replace(scene, solids=(body, scene.solids[1]))


def on_steel(solid: object, load: object, wear: cs.Wear | None = None) -> cs.Scene:
    return cs.Scene(load, (STEEL, solid), (cs.Cylinder(0.01),), wear=wear)


def coated(scene: cs.Scene) -> cs.Scene:
    """The same with a coating of its own material."""
    return replace(scene, solids=(cs.CoatedHalfSpace(STEEL, 5e-5, STEEL), scene.solids[1]))


HELD, WEAR = cs.LineLoad(1e5), cs.Wear(1e-15, 6.0)
GROWING = cs.LoadHistory((0.0, 1.0), (5e4, 1e5))
SLID = replace(sliding.SCENE, solids=(HARD, STEEL))
# a scene without an effect, the same with one of no strength, where and when; the difference that the solvers leave
CASES = {
    "no wear": (RISING, replace(RISING, wear=cs.Wear(0.0, 1.0)), STRIP, (0.0, 1.0), 0.0),
    "creep without a term": (
        RISING, replace(RISING, solids=(cs.ViscoelasticHalfSpace(1.0, 0.0), RIGID)), STRIP, (0.0, 3.0), 1e-5,
    ),
    "an infinite yield stress": (PRESSED, yields_at(PRESSED, inf), grid_of(3, 0.1), INSTANTS, 0.0),
    "a yield stress that is not reached": (
        PRESSED, yields_at(PRESSED, 1e3 * YIELD, 2e10), grid_of(3, 0.1), INSTANTS, 1e-6,
    ),
    "the same with adhesion": (
        ADHERING, yields_at(ADHERING, 1e13, yielding.HARDENING), yielding.GRID, INSTANTS, 1e-4,
    ),
    "no friction on bodies that yield": (
        replace(SLID, friction=None), replace(SLID, friction=cs.Sliding(0.0)), STEELS, (0.0, 1.0), 0.0,
    ),
    "slow creep beside yield": (
        on_steel(HARD, GROWING), replace(on_steel(HARD, GROWING), solids=(SLOW, HARD)), STEELS, (0.0, 1.0), 1e-4,
    ),
    "a coating that wears": (
        on_steel(STEEL, HELD, WEAR), coated(on_steel(STEEL, HELD, WEAR)), STEELS, (0.0, 0.5, 1.0), 1e-5,
    ),
    "a coating on a body that creeps": (
        on_steel(CREEPS, HELD), coated(on_steel(CREEPS, HELD)), STEELS, (0.0, 0.5, 1.0), 1e-5,
    ),
    "a coating on a body that yields": (
        on_steel(HARD, GROWING), coated(on_steel(HARD, GROWING)), STEELS, (0.0, 0.5, 1.0), 1e-4,
    ),
} | {
    f"{name} creep{beside}": (scene, crept(scene, fraction, delay), grid, times, off)
    for beside, scene, grid, times, off in (
        ("", RISING, STRIP, (0.0, 1.0, 3.0), 1e-5),
        (" beside fretting", FRETTING, cs.Grid((220, 1), (2.2, 1.0)), (0.0, 1.0, 2.0, 3.0), 1e-4),
        (" beside adhesion", PULLED, WIDE, (0.0, 1.0, 1.6, 2.2), 1e-3),
    )
    for name, fraction, delay in (("slow", 0.5, 1e9), ("quick", 1.0, 1e-6))
}  # fmt: skip


@pytest.mark.cases(len(CASES))
@pytest.mark.parametrize("name", CASES)
def test_an_effect_of_no_strength_leaves_the_contact_as_it_is_without_it(name: str) -> None:
    without, with_it, grid, times, off = CASES[name]
    wanted, found = (
        cs.solve(scene, grid, cs.ExactPeriodicity(), times=times, tolerance=1e-8).frames for scene in (without, with_it)
    )
    is_quick = name.startswith("quick")  # what creeps at the first instants is over at later ones
    for one, other in list(zip(wanted, found, strict=True))[is_quick:]:
        assert other.status is one.status is cs.Status.CONVERGED
        assert other.load_per_length == pytest.approx(one.load_per_length)
        np.testing.assert_allclose(other.pressure, one.pressure, atol=off * one.pressure.max())
        if one.traction is not None:
            np.testing.assert_allclose(other.shear, one.shear, atol=off * np.abs(one.shear).max())
        kept = {} if is_quick else one.state
        for field, values in kept.items():
            scale = np.abs(values.values).max()
            np.testing.assert_allclose(other.state[field].values, values.values, atol=off * scale)
        if not off:
            assert other.state.keys() == one.state.keys()
            np.testing.assert_array_equal(other.gap, one.gap)
