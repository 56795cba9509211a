"""How bodies respond to pressure, in numbers worked out by hand."""

import math

import pytest

import contactstudy as cs
from contactstudy.elasticity.coefficients import Displacement
from contactstudy.scene.bodies import contact_modulus, response, sudden

# E / (1 - nu^2): 80, 75 and 64 GPa
FIRST = cs.HalfSpace(60e9, 0.5)
SECOND = cs.HalfSpace(72e9, 0.2)
YIELDS = cs.ElasticPlasticHalfSpace(60e9, 0.25, 300e6)
CREEPS = cs.ViscoelasticHalfSpace(10e9, 0.5, ((20e9, 1.0), (30e9, 7.0)))
RIGID = cs.HalfSpace(math.inf, -0.5)


@pytest.mark.parametrize(
    ("body", "modulus"),
    [(FIRST, 80e9), (SECOND, 75e9), (YIELDS, 64e9), (CREEPS, 80e9), (RIGID, math.inf)],
)
def test_a_body_gives_way_by_its_plane_modulus(body: cs.Body, modulus: float) -> None:
    """A viscoelastic one by that of a sudden load; the displacement is that over pi."""
    assert body.compliance == pytest.approx(1 / modulus, rel=1e-15)
    weights = body.response(0.5)
    if modulus == math.inf:
        assert weights == {}
    else:
        assert list(weights) == [Displacement(0.5)]
        assert weights[Displacement(0.5)] == pytest.approx(1 / (math.pi * modulus), rel=1e-15)


def test_compliances_and_responses_add_up() -> None:
    both = 1 / (1 / 80e9 + 1 / 75e9)
    assert contact_modulus((FIRST, SECOND)) == pytest.approx(both, rel=1e-15)
    weights = response((FIRST, SECOND), 0.5)
    assert weights[Displacement(0.5)] == pytest.approx(1 / (math.pi * both), rel=1e-15)


def test_of_a_sudden_load_bodies_are_elastic() -> None:
    assert sudden((YIELDS, CREEPS)) == (cs.HalfSpace(60e9, 0.25), cs.HalfSpace(60e9, 0.5))


@pytest.mark.parametrize("ratio", [-0.99, 0.0, 0.5])
def test_ratios_from_above_minus_one_to_a_half_are_bodies(ratio: float) -> None:
    assert cs.HalfSpace(1e9, ratio).compliance == pytest.approx((1 - ratio * ratio) / 1e9)


@pytest.mark.parametrize("ratio", [-1.0, 0.5000001])
def test_ratios_beyond_are_none(ratio: float) -> None:
    remedy = "give a ratio above -1 and up to 0.5"
    for body, arguments in (
        (cs.HalfSpace, (1e9, ratio)),
        (cs.ElasticPlasticHalfSpace, (1e9, ratio, 1e8)),
        (cs.ViscoelasticHalfSpace, (1e9, ratio)),
    ):
        with pytest.raises(cs.InvalidInput, match=remedy):
            body(*arguments)


@pytest.mark.parametrize(
    ("relaxation", "said"),
    [
        (((1e9, 1.0, 2.0),), r"relaxation\[0\] is .*: give pairs of a modulus"),
        (((1e9, 1.0), (1e9,)), r"relaxation\[1\] is"),
        (((1e9, 1.0), (0.0, 1.0)), r"relaxation\[1\]\[0\] is .*: give a modulus above 0 Pa"),
        (((1e9, 1.0), (1e9, 0.0)), r"relaxation\[1\]\[1\] is .*: give a time above 0 s"),
        (1e9, "relaxation is .*: give pairs"),
    ],
)
def test_pairs_that_do_not_relax_are_refused(relaxation: object, said: str) -> None:
    with pytest.raises(cs.InvalidInput, match=said):
        cs.ViscoelasticHalfSpace(1e9, 0.3, relaxation)  # type: ignore[arg-type]


def test_a_maxwell_fluid_needs_what_relaxes() -> None:
    with pytest.raises(cs.InvalidInput, match="equilibrium_modulus is 0 and there is no"):
        cs.ViscoelasticHalfSpace(0.0, 0.3)
    fluid = cs.ViscoelasticHalfSpace(0.0, 0.5, ((3e9, 2.0),))
    assert (fluid.youngs_modulus, fluid.creeps) == (3e9, True)
    assert not cs.ViscoelasticHalfSpace(1.0, 0.3).creeps
