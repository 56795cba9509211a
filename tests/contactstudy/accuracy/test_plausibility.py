from dataclasses import replace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()


@pytest.mark.parametrize(
    ("changed", "fact", "hint"),
    [
        ({}, "", ""),
        ({"shapes": (cs.Cylinder(0.01), cs.Waviness(0.1, across=1e-4))}, "slopes of", "heights given in µm"),
        ({"solids": (cs.HalfSpace(210.0, 0.3),) * 2}, "times the contact modulus", "modulus given in GPa"),
        ({"load": cs.LineLoad(3e8)}, "times the contact modulus", "load or a radius given in another unit"),
    ],
)
def test_a_unit_that_was_mistaken_is_named(
    changed: dict[str, Any], fact: str, hint: str, line_contact: LineContact
) -> None:
    scene = replace(line_contact.scene, **changed)
    grid = cs.Grid((64, 1), (2.4 * scene.hertz.half_width, 1.0))
    found = error_estimate(cs.solve(scene.problem(grid, EXACT), tolerance=1e-5)).warnings
    said = [warning for warning in found if warning.startswith("The input is implausible")]
    assert len(said) == bool(fact)
    assert all(fact in one and hint in one for one in said)


def of_strength(contact: LineContact, **strength: float) -> list[str]:
    """The warnings beside a peak pressure beyond the strength of the first body, in Hertz's peak pressures."""
    limits = {name: fraction * contact.hertz.peak_pressure for name, fraction in strength.items()}
    solid: Any = contact.scene.solids[0]
    scene = replace(contact.scene, solids=(replace(solid, **limits), contact.scene.solids[1]))
    solution = cs.solve(scene.problem(contact.grid((64, 1), 1.0), EXACT), tolerance=1e-5)
    return [one for one in solution.error.warnings if one.startswith("The peak")]


def test_a_pressure_beyond_the_hardness_of_a_body_is_said_with_the_remedy(line_contact: LineContact) -> None:
    (warning,) = of_strength(line_contact, hardness=0.5, yield_stress=0.2)
    assert "2 times the hardness of Scene.solids[0]" in warning
    assert "give Scene.hardness, or a body that yields" in warning
    assert of_strength(line_contact, hardness=1.1) == []


def test_a_pressure_beyond_first_yield_is_said_with_the_load_of_first_yield(line_contact: LineContact) -> None:
    (warning,) = of_strength(line_contact, yield_stress=0.5)
    load = line_contact.scene.largest_load * (0.5 / 0.5577) ** 2
    assert f"first yields in a smooth line contact at {load / 1e3:.3g} N/mm" in warning
    assert of_strength(line_contact, yield_stress=0.6) == []


def test_a_stress_below_the_surface_beyond_the_strength_is_said(line_contact: LineContact) -> None:
    """Friction raises the stress above that of the frictionless contact, whose pressure is no reason to warn."""
    stress = cs.SubsurfaceStress()
    scene = replace(line_contact.scene, friction=cs.Sliding(0.5), outputs=(stress,))
    grid = line_contact.grid((32, 1), 1.4)
    largest = cs.solve(scene, grid, cs.ExactPeriodicity()).quantities["largest_von_mises"].value
    for ratio in (0.97, 1.03):
        bodies = tuple(replace(body, yield_stress=ratio * largest) for body in scene.solids)
        contact = cs.solve(replace(scene, solids=bodies), grid, cs.ExactPeriodicity())
        said = [text for text in contact.error.warnings if "yields" in text]
        assert len(said) == (ratio < 1)


def of_solids(*solids: Any, load: float = 1e5, **effects: Any) -> str:
    """The warnings of a cylinder of 10 mm on two bodies."""
    scene = cs.Scene(cs.LineLoad(load), solids, (cs.Cylinder(0.01),), **effects)  # type: ignore[arg-type]
    return " ".join(cs.solve(scene, error=0.1).error.warnings)


@pytest.mark.parametrize(
    ("strength", "part", "thickness", "is_beyond"),
    [
        ("yield_stress", "coating", 2e-6, True),
        ("hardness", "coating", 2e-6, True),
        ("yield_stress", "substrate", 2e-6, True),
        ("hardness", "substrate", 2e-6, True),
        ("yield_stress", "substrate", 1e-2, False),
    ],
)
def test_a_coating_or_the_substrate_below_it_beyond_its_strength_is_said(
    strength: str, part: str, thickness: float, *, is_beyond: bool
) -> None:
    steel = cs.HalfSpace(210e9, 0.3)
    materials = {"coating": cs.HalfSpace(400e9, 0.25), "substrate": steel}
    materials[part] = replace(materials[part], **{strength: 5e7})
    coated = cs.CoatedHalfSpace(materials["coating"], thickness, materials["substrate"])
    said = of_solids(steel, coated)
    assert (strength.replace("_", " ") in said) is is_beyond
    assert ("Scene.solids[1]" in said) is is_beyond
