"""Chapters of effects: scene files with [vary], and the closed forms drawn beside their numbers."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.advice.reference_error import against
from studies.engine.run import run
from studies.registry import SCENES, chapter_file, load_drawing
from studies.report.drawings import effects
from studies.scene_study.study_of import study_of
from tests.studies.cli.conftest import said
from tests.studies.conftest import labelled, quiet

E1, MEAN_SPEED = "solids.0.coating.youngs_modulus", "lubrication.mean_speed"
# The ends of every chapter, or fewer points.
FEW: Mapping[str, Mapping[str, Any]] = {
    "coating": {E1: "52.5,840 GPa", "solids.0.thickness": "2,20,700 um"},
    "friction": {"friction.tangential": "9,27 N/mm"},
    "sliding": {"friction.coefficient": "0,0.2,0.4"},
    "creep": {"time_steps.end": "0.1,0.4 s"},
    "wear": {"time_steps.end": "1,3 s"},
    "plastic": {"solids.0.hardening_modulus": "0,20 GPa", "load.per_length.1": "300,1200 kN/m"},
    "films": {"lubrication.lubricant.pressure_viscosity": "20 1/GPa", MEAN_SPEED: "0.5,5 m/s"},
    "roughness": {"shapes.1.peklenik": [1.0, 2.0], "shapes.1.seed": [1, 2], "shapes.1.rms": "0.01,0.1 um"},
    "rough-paddings": {
        "shapes.1.seed": [1, 2], "shapes.1.rms": "0,0.06 um",
        "padding": ["DuplicatedPadding", {"kind": "Superposition", "images": 6},
                    {"kind": "CircularSuperposition", "images": 6}, "ExactPeriodicity"],
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, xr.Dataset]:
    """Datasets of few points of each chapter, made when they are first asked for."""

    class Stored(dict[str, xr.Dataset]):
        def __missing__(self, name: str) -> xr.Dataset:
            study = study_of(chapter_file(name), FEW[name], name=name)
            study = against(study, "padding", SCENES[name]) if SCENES[name] else study
            self[name] = run(study, tmp_path_factory.mktemp(name), workers=0, repeats=0, log=quiet)
            return self[name]

    return Stored()


@pytest.mark.parametrize("name", SCENES)
def test_a_chapter_is_a_scene_file_that_a_user_copies(name: str, tmp_path: Path) -> None:
    copy = tmp_path / f"{name}.toml"
    assert f"run {copy} runs its sweep" in said("new", name, "--out", copy)
    assert copy.read_text(encoding="utf-8") == chapter_file(name).read_text(encoding="utf-8")
    assert {path for group in cs.read_scene(copy).vary for path in group} == set(FEW[name])


@pytest.mark.parametrize("name", SCENES)
def test_a_chapter_has_a_figure_and_states_what_it_claims(name: str, stored: Mapping[str, xr.Dataset]) -> None:
    drawing = load_drawing(name)
    (figure,) = drawing.figure(stored[name])
    assert all(ax.lines for ax in figure.figure.axes)
    stated = "".join(one.claim + one.measured for one in drawing.findings(stored[name]))
    assert "{" not in stated.replace("_{", "")
    assert "%" in stated or name in ("coating", "sliding", "plastic", "roughness")  # which claim no number


def test_a_law_is_drawn_in_the_units_of_its_measure(stored: Mapping[str, xr.Dataset]) -> None:
    (figure,) = load_drawing("creep").figure(stored["creep"])
    width, peak = figure.figure.axes
    for ax, law, size in (
        (width, 2 * effects.HELD.half_width([0.1, 0.4]), 1e-3),
        (peak, effects.held_peak(np.array([0.1, 0.4])), 1e3),
    ):
        _, drawn = labelled(ax)["Lee & Radok (1960)"]
        assert drawn[[0, -1]] == pytest.approx(law / size)


def test_every_padding_is_drawn_over_the_roughness_as_its_median(stored: Mapping[str, xr.Dataset]) -> None:
    (figure,) = load_drawing("rough-paddings").figure(stored["rough-paddings"])
    lines = labelled(figure.figure.axes[0])
    assert set(lines) == {"duplicated", "superposed, n = 6", "circular, n = 6"}
    heights, errors = lines["duplicated"]
    assert heights == pytest.approx([0, 60])  # nm
    # a window of reach L leaves out a^2 / (2 pi L^2), L = 2.4 a, on a smooth surface
    assert errors[0] == pytest.approx(100 / (2 * np.pi * 2.4**2), rel=0.2)
