"""Contacts that are too large for half-spaces: the headline says so first, and by how much."""

from dataclasses import replace
from math import inf, pi

import pytest

import contactstudy as cs
from contactstudy.accuracy.plausibility import beyond_half_space, pin_in_hole

STEEL, RIGID = cs.HalfSpace(210e9, 0.3), cs.HalfSpace(inf, 0.3)
RUBBER = cs.HalfSpace(10e6, 0.5)
ROLL = cs.Scene(cs.LineLoad(5e3), (RUBBER, RIGID), (cs.Cylinder(0.05),))


def test_a_contact_wider_than_a_quarter_of_the_radius_is_said_first() -> None:
    wide = cs.solve(replace(ROLL, load=cs.LineLoad(3e4)))
    assert wide.scene is not None
    a = wide.scene.hertz.half_width
    assert a > 0.05 / 8
    assert wide.accuracy.startswith("The half-space is not a good approximation: the contact is ")
    assert f"its load by about {100 * 3 / 8 * (a / 0.05) ** 2:.2g} %" in wide.accuracy
    assert "1 % met" in wide.accuracy
    assert not beyond_half_space(replace(ROLL, load=cs.LineLoad(1e3)))


def test_a_pin_in_a_hole_is_compared_with_the_conforming_contact_of_persson() -> None:
    # far below conformity it is Hertz's: p R / W = 2 / (pi a / R), a^2 = 8 R^2 load / pi
    assert pin_in_hole(1e-6) == pytest.approx(2 / (pi * (8e-6 / pi) ** 0.5), rel=1e-4)
    # without a clearance the pressure does not depend on the load
    assert pin_in_hole(1e9) == pytest.approx(pin_in_hole(1e7), rel=1e-3)
    pin = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(5e-3), cs.Cylinder(-5.001e-3)))
    said = beyond_half_space(pin)
    assert "times that of a pin in a hole" in said
    assert 0.3 < float(said.partition("peak pressure is ")[2].split()[0]) < 0.9


def test_a_body_thinner_than_four_half_widths_is_compared_with_a_bonded_layer() -> None:
    a = ROLL.hertz.half_width
    thin = replace(ROLL, solids=(replace(RUBBER, thickness=2 * a), RIGID))
    said = beyond_half_space(thin)
    assert "Scene.solids[0] is 2 half-widths thick, and bonded to a rigid base" in said
    layer = cs.CoatedHalfSpace(RUBBER, 2 * a, RIGID)
    remedied = replace(ROLL, solids=(layer, RIGID))
    stiffer = float(said.partition("rigid base ")[2].split()[0])
    assert stiffer > 1.1
    # the width of a contact goes with the square root of the compliance
    narrower = (ROLL.hertz.half_width / remedied.hertz.half_width) ** 2
    assert narrower == pytest.approx(stiffer, rel=0.25)
    assert not beyond_half_space(replace(ROLL, solids=(replace(RUBBER, thickness=5 * a), RIGID)))
