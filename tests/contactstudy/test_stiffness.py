from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.stiffness import normal_stiffness, stiffness_error

STEEL = cs.HalfSpace(210e9, 0.3)
EXACT = cs.ExactPeriodicity()


@pytest.mark.parametrize("cells", [46, 73, 256])
def test_the_stiffness_of_a_cylinder_is_hertz_s_within_its_bound(cells: int) -> None:
    """Johnson (1985), eq. 4.45 counted from the datum: both bodies move by the logarithm of the distance."""
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),))
    contact = cs.solve(scene, cs.Grid((cells, 1), (4e-4, 4e-4)), EXACT)
    hertz, found = scene.hertz, normal_stiffness(contact)
    assert hertz is not None
    turns = np.log(2 * 2 * hertz.radius / hertz.half_width)
    error = abs(found * 2 * turns / (np.pi * hertz.contact_modulus) - 1)
    assert error <= stiffness_error(contact, found) < 0.1


def test_the_stiffness_of_a_rough_contact_is_the_slope_of_its_load() -> None:
    # no cell changes sides between loads this near, but for a few: differences of 1e-3 in the load
    rough = cs.Roughness(1e-7, 0.8, roll_off=1.2e-4, cut_off=6e-5, seed=3, extent=(4.8e-4, 4.8e-4))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), rough))
    before, here, after = (
        cs.solve(replace(scene, load=cs.LineLoad(at)), cs.Grid((96, 96), (4.8e-4, 4.8e-4)), EXACT, tolerance=1e-9)
        for at in (9.99e4, 1e5, 1.001e5)
    )  # fmt: skip
    slope = 2e2 / (after.approach - before.approach)
    # it jumps with each cell that comes in, some 1 in 100 of those there are
    assert normal_stiffness(here) == pytest.approx(slope, rel=3e-2)


@pytest.mark.parametrize("law", ["exponential", "dugdale"])
@pytest.mark.parametrize("load", [-1.0, 1.0])
def test_the_stiffness_of_an_adhesive_contact_counts_how_the_attraction_changes(
    law: str, load: float
) -> None:
    """It is the slope of the load over the approach, which falls as pull-off comes near."""
    solids = cs.HalfSpace(1e6, 0.49), cs.HalfSpace(np.inf, 0.3)
    adhesion = cs.Adhesion(0.05, 1e-5, law, branch="from full contact")
    scene = cs.Scene(cs.LineLoad(load), solids, (cs.Cylinder(0.01),), adhesion=adhesion)
    grid, step = cs.Grid((256, 1), (6e-3, 1e-3)), 2e-3
    before, here, after = (
        cs.solve(replace(scene, load=cs.LineLoad(at)), grid, EXACT, tolerance=1e-9)
        for at in (load - step, load, load + step)
    )
    slope = 2 * step / (after.approach - before.approach)
    # differences are first order in the cells that come in
    assert normal_stiffness(here) == pytest.approx(slope, rel=5e-3)
    rigid = replace(here, adhesion=None)
    assert normal_stiffness(rigid) > 1.01 * slope
