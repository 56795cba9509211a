"""What a plan says of a coat and of friction, and why."""

from dataclasses import replace

import contactstudy as cs
from contactstudy.planning.grid_requirements import requirements_of
from contactstudy.planning.plan import plan
from tests.conftest import STEEL

BODY = cs.CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 2e-6, STEEL)
PLAIN = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),))
ROUGH = cs.Roughness(2e-7, hurst=0.8, roll_off=6e-5, cut_off=1.2e-5)


def test_a_plan_says_how_thick_a_coat_is_in_cells_and_half_widths() -> None:
    scene = replace(PLAIN, solids=(BODY, STEEL))
    planned = plan(scene, error=1e-2)
    (said,) = (reason for reason in planned.reasons if reason.startswith("coat"))
    cells, widths = 2e-6 / planned.grid.cell[0], 2e-6 / scene.hertz.half_width
    assert f"{widths:.3g} half-widths and {cells:.3g} cells" in said
    assert not planned.warnings
    assert not any(reason.startswith("coat") for reason in plan(PLAIN, error=1e-2).reasons)


def test_a_grid_that_does_not_show_a_stiff_coat_is_said_to_err_more() -> None:
    soft = replace(STEEL, youngs_modulus=STEEL.youngs_modulus / 30)
    stiff = cs.CoatedHalfSpace(STEEL, 2e-6, soft)
    scene = replace(PLAIN, solids=(stiff, STEEL))
    width = 3 * scene.hertz.half_width
    coarse, fine = (
        plan(scene, grid=cs.Grid((cells, 1), (width, width))).warnings for cells in (64, 8192)
    )
    assert any("cells in a coating" in said for said in coarse)
    assert not any("cells in a coating" in said for said in fine)


def test_a_plan_says_how_friction_is_solved() -> None:
    rough = replace(PLAIN, shapes=(*PLAIN.shapes, ROUGH))
    slip = cs.PartialSlip(0.3, 1e4)
    for scene, words in (
        (replace(PLAIN, friction=cs.Sliding(0.2)), "alike in shear"),
        (replace(PLAIN, friction=slip), "superposition"),
        (replace(rough, friction=slip), "both components"),
    ):
        assert words in requirements_of(scene).shear
    assert requirements_of(PLAIN).shear == ""
