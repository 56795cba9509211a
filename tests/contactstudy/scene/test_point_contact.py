"""Bodies that are hollow, and point contacts under newtons, against Hertz's closed forms."""

from dataclasses import replace
from math import pi

import pytest

import contactstudy as cs
from tests.conftest import STEEL

BODIES = (STEEL, STEEL)


def test_a_roller_in_a_raceway_is_that_of_the_difference_of_the_curvatures() -> None:
    shapes = (cs.Cylinder(5e-3), cs.Cylinder(-30e-3))
    scene = cs.Scene(cs.LineLoad(1e5), BODIES, shapes)
    assert scene.radius == pytest.approx(6e-3)
    equivalent = replace(scene, shapes=(cs.Cylinder(6e-3),))
    peak, expected = (cs.solve(one).quantities["peak_pressure"].value for one in (scene, equivalent))
    assert peak == pytest.approx(expected)
    for kind in (cs.Cylinder, cs.Sphere):
        with pytest.raises(cs.InvalidInput, match="the hollow body must have the larger radius"):
            replace(scene, shapes=(kind(5e-3), kind(-5e-3)))


def test_a_ball_under_newtons_needs_neither_length_nor_padding_nor_grid() -> None:
    contact = cs.solve(cs.Scene(cs.TotalLoad(100.0), BODIES, (cs.Sphere(0.01),)), error=0.05)
    ball = cs.analytic.HertzPoint(100.0, 0.01, contact.scene.contact_modulus)
    assert contact.met
    for name, exact in (("peak_pressure", ball.peak_pressure), ("approach", ball.approach)):
        number = contact.quantities[name]
        assert number.value == pytest.approx(exact, abs=number.bound)
    assert contact.quantities["total_load"].value == pytest.approx(100.0)
    assert "load_per_length" not in contact.quantities


@pytest.mark.parametrize("radii", [(0.01, 0.08), (0.08, 0.01)])
def test_an_ellipse_has_the_table_of_hertz_and_is_met_by_the_solution(radii: tuple[float, float]) -> None:
    # the fit of Brewe & Hamrock (1977) to Hertz's ratio of semi-axes, 1.0339 D^0.636, is within 3 %
    scene = cs.Scene(cs.TotalLoad(200.0), BODIES, (cs.Ellipsoid(*radii),))
    short, long = sorted(scene.ellipse.semi_axes)
    assert scene.ellipse.semi_axes == ((long, short) if radii[0] > radii[1] else (short, long))
    assert long / short == pytest.approx(1.0339 * 8**0.636, rel=0.03)
    peak = cs.solve(scene, error=0.05).quantities["peak_pressure"]
    assert peak.value == pytest.approx(scene.ellipse.peak_pressure, abs=peak.bound)
    assert peak.bound < 0.05 * peak.value


def test_the_ellipse_of_a_ball_is_its_circle() -> None:
    ellipse = cs.Scene(cs.TotalLoad(100.0), BODIES, (cs.Sphere(0.01),)).ellipse
    ball = cs.analytic.HertzPoint(100.0, 0.01, ellipse.contact_modulus)
    nearly = cs.analytic.HertzEllipse(100.0, 100.0, 100.01, ellipse.contact_modulus)
    assert ellipse.semi_axes == pytest.approx((ball.contact_radius,) * 2)
    assert nearly.semi_axes[0] == pytest.approx(ball.contact_radius, rel=1e-4)
    assert ellipse.line.half_width == pytest.approx(ball.contact_radius)
    assert ellipse.line.peak_pressure == pytest.approx(ball.peak_pressure)


def test_a_ball_in_a_groove_is_that_of_the_sums_of_curvatures() -> None:
    apart = cs.Scene(cs.TotalLoad(50.0), BODIES, (cs.Sphere(5e-3), cs.Ellipsoid(0.02, -5.2e-3)))
    across, along = 1 / 5e-3 + 1 / 0.02, 1 / 5e-3 - 1 / 5.2e-3
    together = replace(apart, shapes=(cs.Ellipsoid(1 / across, 1 / along),))
    assert apart.ellipse.semi_axes == pytest.approx(together.ellipse.semi_axes)


def test_a_ball_first_yields_at_the_pressure_of_johnson() -> None:
    assert cs.analytic.first_yield_of_ball(1.0, 0.3) == pytest.approx(1.6, rel=0.01)
    steel = cs.material("steel")
    contact = cs.solve(cs.Scene(cs.TotalLoad(100.0), (steel, steel), (cs.Sphere(0.01),)), error=0.2)
    # Johnson (1985), eq. 6.9
    modulus, strength = contact.scene.contact_modulus, steel.yield_stress
    load = pi**3 * 0.01**2 / (6 * modulus**2) * (1.6 * strength) ** 3
    said = contact.error.warnings[0].partition("first yields in a smooth point contact at ")[2]
    assert float(said.split()[0]) == pytest.approx(load, rel=0.03)
