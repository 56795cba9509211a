from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.hard_case import CELLS, EXACT, FREE, A, grid, noise
from studies.line_contact import SCENE
from tests.hard_cases.judged import ends_well, every

ENDS = [5e-324, 1e-310, 1e-200, 1e200, 1.7e308]
# of a solid, a load, a radius, a width and a period, in their own units
FIELDS = ["modulus", "load", "radius", "width", "period"]


def made(field: str, value: float) -> tuple[cs.Scene, cs.Grid]:
    body = cs.HalfSpace(value if field == "modulus" else 210e9, 0.3)
    load = cs.LineLoad(value if field == "load" else 1e5)
    radius = value if field == "radius" else 0.01
    extent = (value if field == "width" else 2.4 * A, value if field == "period" else A)
    return cs.Scene(load, (body, body), (cs.Cylinder(radius),)), cs.Grid(CELLS, extent)


@every("units")
def test_case_ends_well(name: str, padding: str, solver: str) -> None:
    ends_well(name, padding, solver)


@pytest.mark.parametrize("value", ENDS)
@pytest.mark.parametrize("field", FIELDS)
def test_what_no_product_can_bear_is_refused(field: str, value: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"between 1e-60 and 1e\+60\.$"):
        made(field, value)


@pytest.mark.parametrize("value", [1e-60, 1e-30, 1e30, 1e60])
@pytest.mark.parametrize("field", ["modulus", "load", "radius"])
@pytest.mark.parametrize("padding", [FREE, EXACT, (EXACT, EXACT)], ids=str)
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


@pytest.mark.parametrize("aspect", [1e-10, 1e10])
def test_cells_beyond_any_shape_are_refused(aspect: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Grid\.extent is .* as long as wide"):
        grid(CELLS, 2.4, 1.2 * aspect)


@pytest.mark.parametrize("height", [1e300, 1.7e308])
def test_heights_beyond_all_numbers_end_in_a_status(height: float) -> None:
    rough = replace(
        SCENE, shapes=(*SCENE.shapes, cs.MeasuredSurface(np.clip(noise(), -1, 1) * height))
    )
    for solver in (cs.PreconditionedCG(), cs.PolonskyKeer()):
        solution = cs.solve(rough.problem(grid(), EXACT), solver=solver)
        assert solution.status is cs.Status.NOT_FINITE
        assert "check the heights" in str(solution.status)
