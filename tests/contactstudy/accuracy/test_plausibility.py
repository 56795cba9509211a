"""Numbers that no contact of half-spaces has: one warning, with the unit that was likely mistaken."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()


def warned(scene: cs.Scene, grid: cs.Grid) -> list[str]:
    found = cs.error_estimate(cs.solve(scene.problem(grid, EXACT), tolerance=1e-5)).warnings
    return [warning for warning in found if warning.startswith("This can hardly be meant")]


def test_a_contact_of_steel_is_meant(line_contact: LineContact) -> None:
    assert warned(line_contact.scene, line_contact.grid((64, 1), 1.0)) == []


def test_heights_in_micrometres_are_noticed(line_contact: LineContact) -> None:
    grid = line_contact.grid((48, 24), 1.0)
    heights = 0.1 * np.random.default_rng(0).standard_normal((48, 24))
    rough = replace(
        line_contact.scene, shapes=(*line_contact.scene.shapes, cs.MeasuredSurface(heights))
    )
    (warning,) = warned(rough, grid)
    assert "the heights have slopes of" in warning
    assert "are heights given in µm as if they were m?" in warning


def test_a_modulus_in_gigapascals_is_noticed() -> None:
    body = cs.HalfSpace(210.0, 0.3)
    scene = cs.Scene(cs.LineLoad(1e5), (body, body), (cs.Cylinder(0.01),))
    half_width = scene.hertz.half_width  # type: ignore[union-attr]
    (warning,) = warned(scene, cs.Grid((64, 1), (2.4 * half_width, 1.0)))
    assert "times the contact modulus E*" in warning
    assert "is a modulus given in GPa or MPa as if it were Pa?" in warning


def test_a_load_in_newtons_per_millimetre_times_a_thousand_is_noticed(
    line_contact: LineContact,
) -> None:
    scene = replace(line_contact.scene, load=cs.LineLoad(3e3 * line_contact.scene.load.largest))
    half_width: Any = scene.hertz.half_width  # type: ignore[union-attr]
    (warning,) = warned(scene, cs.Grid((64, 1), (2.4 * half_width, 1.0)))
    assert "is the load or a radius given in another unit" in warning


def test_a_grid_a_thousand_times_wider_than_its_contact_is_noticed(
    line_contact: LineContact,
) -> None:
    (warning,) = warned(line_contact.scene, line_contact.grid((4096, 1), 1.0, width=2500.0))
    assert "times as wide as the contact" in warning


@pytest.mark.parametrize(("share", "count"), [(0.2, 1), (0.5, 0)])
def test_pressure_above_three_times_the_strength_is_noticed(
    share: float, count: int, line_contact: LineContact
) -> None:
    strength = share * line_contact.hertz.peak_pressure
    steel = replace(line_contact.scene.solids[0], yield_strength=strength)  # type: ignore[type-var]
    scene = replace(line_contact.scene, solids=(steel, line_contact.scene.solids[1]))
    assert len(warned(scene, line_contact.grid((64, 1), 1.0))) == count
