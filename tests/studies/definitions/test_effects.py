import numpy as np

import contactstudy as cs
from studies.definitions.effect_cost import P_H, SCENES, YIELD, scene_at


def test_one_cell_along_gives_the_pressure_of_many() -> None:
    one, many = (
        scene_at({"effect": f"smooth, {dimension}", "grid": 128}) for dimension in ("1-D", "2-D")
    )
    assert (one.grid.cells, many.grid.cells) == ((128, 1), (128, 32))
    line, plane = (cs.solve(whole.prepare(), tolerance=1e-12).pressure for whole in (one, many))
    np.testing.assert_allclose(plane, np.broadcast_to(line, plane.shape), atol=1e-9 * line.max())


def test_every_scene_has_one_effect_more_than_the_one_before() -> None:
    def effects(scene: cs.Scene) -> int:
        coats = sum(isinstance(solid, cs.CoatedHalfSpace) for solid in scene.solids)
        slides = scene.friction is not None
        return len(scene.shapes) + coats + np.isfinite(scene.hardness) + len(scene.outputs) + slides

    # the last slides, and has no coating
    assert [effects(scene) for scene in SCENES.values()] == [1, 1, 2, 3, 4, 5, 6, 7, 7]


def test_the_row_of_yield_yields_on_a_quarter_of_the_cells() -> None:
    whole = scene_at({"effect": YIELD, "grid": 128})
    assert whole.grid.cells == (32, 1)
    half, full = whole.run(whole.prepare()).frames
    # Hertz's peak is 1.77 and 2.5 times the yield stress: first yield is at 1.794
    assert not (half.coupled_state["equivalent0"] > 0).any()
    assert (full.coupled_state["equivalent0"] > 0).any()
    assert full.peak_pressure < P_H
