import math
import re
from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import CELLS, grid, noise
from studies.reference.line_contact import P_H, SCENE, A
from tests.hard_cases.cases import EXACT

ENDS = [5e-324, 1e-310, 1e-200, 1e200, 1.7e308]
# of a solid, a load, a radius, a width and a period, in their own units
FIELDS = ["modulus", "load", "radius", "width", "period"]


def made(field: str, value: float) -> tuple[cs.Scene, cs.Grid]:
    body = cs.HalfSpace(value if field == "modulus" else 210e9, 0.3)
    load = cs.LineLoad(value if field == "load" else 1e5)
    radius = value if field == "radius" else 0.01
    extent = (value if field == "width" else 2.4 * A, value if field == "period" else A)
    return cs.Scene(load, (body, body), (cs.Cylinder(radius),)), cs.Grid(CELLS, extent)


@pytest.mark.parametrize("value", [1e-60, 1e60])
@pytest.mark.parametrize("field", ["modulus", "load", "radius"])
@pytest.mark.parametrize("padding", [EXACT, (EXACT, EXACT)], ids=str)
def test_what_is_admitted_is_right_however_small_or_large(
    field: str, value: float, padding: cs.Padding | cs.Paddings
) -> None:
    """Either the cylinder is a flat, or all rows but the two in the middle are out of reach."""
    scene, on = made(field, value)
    solution = cs.solve(scene.problem(on, padding))
    assert solution.residual <= 1e-8
    flat = (value > 1) == (field != "modulus")
    assert (solution.pressure > 0).all() == flat
    if not flat:
        assert set(np.flatnonzero(solution.pressure.any(axis=1))) == {11, 12}


# heights of shapes, and sizes that others follow from, in their own units
SIZES: dict[str, Callable[[float], object]] = {
    "Crown end_drop": lambda size: cs.Crown.of_drop(size, A),
    "Waviness.amplitude": lambda size: cs.Waviness(-size, along=0.6 * A),
    "Dimple.depth": lambda size: cs.Texture(cs.Dimple(size, 0.3 * A), (0.6 * A, 0.6 * A)),
    "Texture.pitch[0]": lambda size: cs.Texture(cs.Groove(1e-6, 1e-60), (size, math.inf)),
    "Roughness.rms": lambda size: cs.Roughness(size, 0.8, A, 0.3 * A),
    "RmsSlope.slope": lambda size: cs.Roughness(cs.RmsSlope(size), 0.8, A, 0.3 * A),
    "MeasuredSurface.extent[1]": lambda size: cs.MeasuredSurface(np.zeros((8, 8)), (A, size)),
}


def test_a_size_that_no_product_can_bear_is_refused() -> None:
    for field, size in product(FIELDS, ENDS):
        with pytest.raises(cs.InvalidInput, match=r"between 1e-60 and 1e\+60\.$"):
            made(field, size)
    for field, size in product(SIZES, ENDS):
        named = rf"^{re.escape(field)} is -?{re.escape(repr(size))}: give "
        with pytest.raises(cs.InvalidInput, match=rf"{named}.* between 1e-60 and 1e\+60\.$"):
            SIZES[field](size)


@pytest.mark.parametrize("size", [0.0, 1e-60, 1e30, 1e60])
def test_heights_that_are_admitted_end_well(size: float) -> None:
    """None, one that is none beside what the contact flattens, and ones that leave little in contact."""
    smooth = cs.solve(SCENE.problem(grid(), EXACT)).pressure
    for field in ("Waviness.amplitude", "Dimple.depth", "Roughness.rms"):
        scene = replace(SCENE, shapes=(*SCENE.shapes, SIZES[field](size)))
        solution = cs.solve(scene.problem(grid(), EXACT))
        assert solution.residual <= 1e-8
        if size < 1:
            np.testing.assert_allclose(solution.pressure, smooth, rtol=0, atol=1e-8 * P_H if size else 0)


def test_heights_beyond_all_numbers_end_in_a_status() -> None:
    rough = replace(SCENE, shapes=(*SCENE.shapes, cs.MeasuredSurface(np.clip(noise(), -1, 1) * 1.7e308)))
    for solver in (cs.PreconditionedCG(), cs.PolonskyKeer()):
        solution = cs.solve(rough.problem(grid(), EXACT), solver=solver)
        assert solution.status is cs.Status.NOT_FINITE
        assert "check the heights" in str(solution.status)
