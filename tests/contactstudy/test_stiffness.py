from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.validation import readable
from contactstudy.io.quantities.quantity import Quantity
from contactstudy.stiffness import normal_stiffness, stiffness_error
from tests.conftest import STEEL

EXACT = cs.ExactPeriodicity()
LINE = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),))


@pytest.mark.parametrize("cells", [46, 256])
def test_the_stiffness_of_a_cylinder_is_hertz_s_within_its_bound(cells: int) -> None:
    """Johnson (1985), sect. 5.6, counted from a point 2 R away: the approach has the logarithm of that distance."""
    contact = cs.solve(LINE, cs.Grid((cells, 1), (4e-4, 4e-4)), EXACT)
    hertz, found = LINE.hertz, normal_stiffness(contact)
    compliance = 2 * np.log(2 * 2 * hertz.radius / hertz.half_width) / (np.pi * hertz.contact_modulus)
    error = abs(found * compliance - 1)
    assert error <= stiffness_error(contact, found) < 0.1


def test_the_stiffness_of_a_rough_contact_is_the_slope_of_its_load() -> None:
    # loads that differ by 1e-3, between which few cells come into contact
    rough = cs.Roughness(1e-7, 0.8, roll_off=1.2e-4, cut_off=6e-5, seed=3, extent=(4.8e-4, 4.8e-4))
    scene = replace(LINE, shapes=(*LINE.shapes, rough))
    before, here, after = (
        cs.solve(replace(scene, load=cs.LineLoad(at)), cs.Grid((96, 96), (4.8e-4, 4.8e-4)), EXACT, tolerance=1e-9)
        for at in (9.99e4, 1e5, 1.001e5)
    )  # fmt: skip
    slope = 2e2 / (after.approach - before.approach)
    # it jumps with each cell that comes in, up to some 1 in 100 of those in contact
    assert normal_stiffness(here) == pytest.approx(slope, rel=3e-2)


def test_the_stiffness_of_an_adhesive_contact_counts_how_the_attraction_changes() -> None:
    """It is the slope of the load over the approach, which falls as pull-off comes near."""
    solids = cs.HalfSpace(1e6, 0.49), cs.HalfSpace(np.inf, 0.3)
    adhesion = cs.Adhesion(0.05, 1e-5, branch="from full contact")
    scene = cs.Scene(cs.LineLoad(-1.0), solids, (cs.Cylinder(0.01),), adhesion=adhesion)
    grid, step = cs.Grid((256, 1), (6e-3, 1e-3)), 2e-3
    before, here, after = (
        cs.solve(replace(scene, load=cs.LineLoad(-1.0 + more)), grid, EXACT, tolerance=1e-9)
        for more in (-step, 0.0, step)
    )
    slope = 2 * step / (after.approach - before.approach)
    # differences are first order in the cells that come in
    assert normal_stiffness(here) == pytest.approx(slope, rel=5e-3)
    assert normal_stiffness(replace(here, adhesion=None)) > 1.01 * slope


def johnson(load: float, half: float, radii: tuple[float, float], depth: float) -> tuple[float, float]:
    """Approach of the axes, or of a point below a flat body, and load over its rise (Johnson 1985, sect. 5.6)."""
    of_body = [
        2 * np.log(4 * radius / half) - 1 if np.isfinite(radius) else 2 * np.log(2 * depth / half) - 0.3 / 0.7
        for radius in radii
    ]
    factor = (1 - 0.3**2) / (np.pi * 210e9)
    return load * factor * sum(of_body), 1 / (factor * (sum(of_body) - 2))


@pytest.mark.parametrize("radii", [(0.01, 0.02), (np.inf, 0.01)])
def test_axes_of_cylinders_approach_as_johnson_has_it(radii: tuple[float, float]) -> None:
    shapes = tuple(cs.Cylinder(radius) for radius in radii if np.isfinite(radius))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), shapes)
    contact = cs.solve(scene, cs.Grid((128, 1), (4e-4, 4e-4)), EXACT)
    found = cs.distant_approach(contact, radii, depth="5 mm")
    approach, stiffness = johnson(1e5, scene.hertz.half_width, radii, 5e-3)
    assert abs(found.approach.value - approach) <= found.approach.bound < 0.01 * approach
    assert abs(found.stiffness.value - stiffness) <= found.stiffness.bound < 0.1 * stiffness
    assert "the axis" in found.approach.detail
    near = cs.contact_stiffness(contact)
    assert near.value < found.stiffness.value  # a point 2 R away moves more than the axis
    assert f"{readable(2 * scene.radius)} away" in near.detail


def test_a_coating_counts_in_the_approach_of_axes_as_far_as_it_is_thick() -> None:
    coating, depth = cs.HalfSpace(70e9, 0.2), 0.05
    thin, thick = 1e-6, 1.0

    def approach(body: cs.HalfSpace | cs.CoatedHalfSpace) -> Quantity:
        contact = cs.solve(replace(LINE, solids=(body, STEEL)), cs.Grid((64, 1), (4e-4, 4e-4)), EXACT)
        return cs.distant_approach(contact, (0.01, np.inf), depth=depth).approach

    uncoated, of_coating = approach(STEEL), approach(coating)
    on_thin, on_thick = (approach(cs.CoatedHalfSpace(coating, size, STEEL)) for size in (thin, thick))
    # a thin one adds its own compression, of a fraction of its thickness over the half-width
    assert on_thin.value == pytest.approx(uncoated.value, rel=thin / LINE.hertz.half_width)
    assert on_thin.bound < 1e-3 * on_thin.value
    # the substrate of a thick one is felt by the square of the distance over the thickness
    assert on_thick.value == pytest.approx(of_coating.value, rel=(depth / thick) ** 2)


def test_a_coating_counts_on_a_roller_that_ends_too() -> None:
    coating, grid = cs.HalfSpace(70e9, 0.2), cs.Grid((24, 24), (4e-4, 0.08))
    scene = replace(LINE, shapes=(*LINE.shapes, cs.FiniteLength(0.08)))

    def approach(body: cs.HalfSpace | cs.CoatedHalfSpace) -> Quantity:
        contact = cs.solve(replace(scene, solids=(body, STEEL)), grid, cs.ZeroPadding())
        return cs.distant_approach(contact, (0.01, np.inf), depth=5e-3).approach

    uncoated = approach(coating)
    on_thick, on_middle = (approach(cs.CoatedHalfSpace(coating, size, STEEL)) for size in (10.0, 0.01))
    assert on_thick.value == pytest.approx(uncoated.value, rel=1e-3)
    # the substrate of one as thick as the point is distant is felt there
    assert on_middle.bound > 2 * uncoated.bound


def test_axes_of_a_long_roller_that_ends_approach_as_those_of_an_endless_one() -> None:
    scene = replace(LINE, shapes=(*LINE.shapes, cs.FiniteLength(0.08)))
    contact = cs.solve(scene, cs.Grid((48, 48), (4e-4, 0.08)), cs.ZeroPadding())
    found = cs.distant_approach(contact, (0.01, np.inf), depth=5e-3)
    # in the middle the load per length is less than at the ends
    load = contact.net_pressure[:, 24].sum() * contact.grid.cell_size[0]
    half = replace(LINE, load=cs.LineLoad(load)).hertz.half_width
    approach, _ = johnson(load, half, (0.01, np.inf), 5e-3)
    assert found.approach.value == pytest.approx(approach, rel=2e-3)


def test_distant_points_are_refused_for_other_radii_without_a_depth_and_with_images_across() -> None:
    grid = cs.Grid((32, 1), (4e-4, 4e-4))
    contact = cs.solve(LINE, grid, EXACT)
    with pytest.raises(cs.InvalidInput, match="an equivalent radius of"):
        cs.distant_approach(contact, (0.01, 0.02))
    with pytest.raises(cs.InvalidInput, match="depth of a point"):
        cs.distant_approach(contact, (0.01, np.inf))
    with pytest.raises(cs.NotDefined, match="free across"):
        cs.distant_approach(cs.solve(LINE, grid, (EXACT, EXACT)), (0.01, np.inf), depth=0.01)
