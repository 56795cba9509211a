"""What a body, a shape or a law takes for the numbers that a user leaves out."""

from math import inf

import contactstudy as cs
from tests.contactstudy.defaults import check_defaults


def test_a_number_that_is_left_out_is_this_one() -> None:
    check_defaults(cs.Carried, body=0)
    check_defaults(cs.Crown, radius=inf, length=inf)
    check_defaults(cs.Detail, repeat=0, longest=0, roller=0, height=0, slope=0, widest=inf)
    check_defaults(cs.DowsonHigginson, compressibility=0.6e-9, saturation=1.7e-9)
    check_defaults(cs.ElasticPlasticHalfSpace, hardening_modulus=0, kinematic_modulus=0)
    check_defaults(cs.Eyring, reference=5e6)
    check_defaults(cs.HalfSpace, yield_strength=inf)
    check_defaults(cs.HarmonicFill, up_to=0.1)
    check_defaults(cs.LimitingShear, coefficient=0.07)
    check_defaults(cs.Lubrication, slide_roll_ratio=0)
    check_defaults(cs.LundbergProfile, straight=0)
    check_defaults(cs.Roelands, exponent=0.6, reference_pressure=1.96e8)
    check_defaults(cs.Roughness, seed=0, peklenik=1)
    check_defaults(cs.Scene, hardness=inf)
    check_defaults(cs.SineLoad, phase=0)
    check_defaults(cs.SubsurfaceStress, solid=0)
    check_defaults(cs.Tapered, fraction=0.1)
    check_defaults(cs.Waviness, across=inf, along=inf, phase=0)
    check_defaults(cs.Wear, body=0)
    check_defaults(cs.Window, number=0)
