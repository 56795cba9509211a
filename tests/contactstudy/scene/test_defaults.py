"""What a body, a shape or a law takes for the numbers that a user leaves out."""

from collections.abc import Callable
from inspect import signature
from math import inf
from typing import Any

import pytest

import contactstudy as cs


@pytest.mark.parametrize(
    ("made", "field", "value"),
    [
        (cs.Carried, "body", 0),
        (cs.Crown, "radius", inf),
        (cs.Detail, "repeat", 0),
        (cs.Detail, "longest", 0),
        (cs.Detail, "roller", 0),
        (cs.Detail, "height", 0),
        (cs.Detail, "slope", 0),
        (cs.Detail, "widest", inf),
        (cs.DowsonHigginson, "compressibility", 0.6e-9),
        (cs.DowsonHigginson, "saturation", 1.7e-9),
        (cs.ElasticPlasticHalfSpace, "hardening_modulus", 0),
        (cs.ElasticPlasticHalfSpace, "kinematic_modulus", 0),
        (cs.Eyring, "reference", 5e6),
        (cs.HalfSpace, "yield_strength", inf),
        (cs.HarmonicFill, "up_to", 0.1),
        (cs.LimitingShear, "coefficient", 0.07),
        (cs.Lubrication, "slide_roll_ratio", 0),
        (cs.LundbergProfile, "straight", 0),
        (cs.Roelands, "exponent", 0.6),
        (cs.Roelands, "reference_pressure", 1.96e8),
        (cs.Roughness, "seed", 0),
        (cs.Roughness, "peklenik", 1),
        (cs.Scene, "hardness", inf),
        (cs.SineLoad, "phase", 0),
        (cs.SubsurfaceStress, "solid", 0),
        (cs.Tapered, "share", 0.1),
        (cs.Waviness, "across", inf),
        (cs.Waviness, "along", inf),
        (cs.Waviness, "phase", 0),
        (cs.Wear, "body", 0),
        (cs.Window, "number", 0),
    ],
)
def test_a_number_that_is_left_out_is_this_one(
    made: Callable[..., Any], field: str, value: float
) -> None:
    assert signature(made).parameters[field].default == value
