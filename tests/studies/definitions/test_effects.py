from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.effect_cost import P_H, SCENES, YIELD, scene_at
from studies.engine.run import run
from studies.registry import load, load_drawing
from studies.report import page as report
from tests.studies.conftest import quiet


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
    assert not (half.joint_state["equivalent0"] > 0).any()
    assert (full.joint_state["equivalent0"] > 0).any()
    assert full.peak_pressure < P_H


@pytest.mark.whole
def test_every_effect_counts_and_is_shown(tmp_path: Path) -> None:
    study = load("effect_cost").override({"grid": "256"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet).isel(grid=0)
    assert (dataset["solver_status"] == 0).all()
    found = {name: dataset.sel(effect=name) for name in SCENES}
    # no shape keeps a field of its own; one cell along asks for a 64th, but for what any solve holds
    shapes = [float(found[name]["memory"]) for name in ("waviness", "texture", "roughness")]
    field = 256 * 64 * 8 / 1e6  # MB
    assert max(shapes) - min(shapes) < field
    assert float(found["smooth, 1-D"]["memory"]) < float(found["smooth, 2-D"]["memory"]) / 16
    # where no coating is set up, which takes more for a while
    assert float(found["sliding, no coating"]["memory"]) > float(found["roughness"]["memory"])
    # stress is found from the solution, which knows nothing of it
    assert found["stress"]["iterations"] == found["hardness"]["iterations"]
    assert found["stress"]["contact_share"] == found["hardness"]["contact_share"]
    # a hardness widens the contact that roughness has left
    assert found["hardness"]["contact_share"] > found["coating"]["contact_share"]
    report.draw(study, load_drawing("effect_cost"), tmp_path)
    assert (tmp_path / "effect_cost" / "effects.png").is_file()
