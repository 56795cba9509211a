import numpy as np
import pytest
from scipy.integrate import quad

import contactstudy as cs

LINE = cs.analytic.HertzLine(load_per_length=1e5, radius=0.01, contact_modulus=1.15e11)
POINT = cs.analytic.HertzPoint(load=100.0, radius=0.01, contact_modulus=1.15e11)


def test_hertz_line_surfaces_touch_inside_and_part_outside() -> None:
    a = LINE.half_width
    x = np.array([0.0, 0.3, 0.8, 1.0, 1.2, 3.0]) * a
    gap = x**2 / (2 * LINE.radius) + LINE.displacement(x, a) - LINE.displacement(0.0, a)
    np.testing.assert_allclose(gap[:4], 0, rtol=0, atol=4e-16 * LINE.displacement(0.0, a))
    assert (np.diff(gap[3:]) > 0).all()


def test_hertz_line_displacement_is_the_logarithmic_potential_of_its_pressure() -> None:
    a, datum = LINE.half_width, 2.5 * LINE.half_width
    for x in (0.4 * a, 1.7 * a, 30 * a):
        kink = [np.arcsin(x / a)] if x < a else None
        potential = quad(
            lambda t, x=x: LINE.pressure(a * np.sin(t)) * a * np.cos(t)
            * np.log(datum / abs(x - a * np.sin(t))),
            -np.pi / 2, np.pi / 2, points=kink, epsrel=1e-11, limit=200,
        )[0]  # fmt: skip
        expected = 2 / (np.pi * LINE.contact_modulus) * potential
        assert LINE.displacement(x, datum) == pytest.approx(expected, rel=1e-8)


def test_stress_on_the_axis_of_a_line_contact_is_johnsons() -> None:
    """Eqs. 4.46 and 4.47 (1985): the greatest shear is 0.300 of the peak pressure at 0.786 half-widths."""
    t = np.linspace(0, 2, 2001)
    assert not LINE.stress(LINE.half_width, 0.0).any()  # the surface beyond is free of stress
    xx, zz, xz = LINE.stress(0.0, t * LINE.half_width) / LINE.peak_pressure
    np.testing.assert_allclose(xx, 2 * t - (1 + 2 * t**2) / np.hypot(1, t), atol=1e-14)
    np.testing.assert_allclose(zz, -1 / np.hypot(1, t), atol=1e-14)
    assert not xz.any()
    shear = (xx - zz) / 2
    assert (t[shear.argmax()], shear.max()) == pytest.approx((0.786, 0.300283), abs=1e-6)


@pytest.mark.parametrize(("ratio", "peak"), [(0.3, 1.793), (0.5, 1.9227)])
def test_a_line_contact_first_yields_where_johnson_says(ratio: float, peak: float) -> None:
    """Von Mises: 1.79 at 0.3; at 0.5 that of the largest shear, 0.3003 (Johnson 1985, sects. 4.2, 6.1)."""
    first = cs.analytic.first_yield(0.01, 1.15e11, 1e9, ratio)
    assert first.peak_pressure == pytest.approx(peak * 1e9, rel=1e-3)
    assert first.load_per_length == pytest.approx(np.pi * 0.01 * first.peak_pressure**2 / 1.15e11, rel=1e-12)


def test_hertz_point_surfaces_touch_inside_and_part_outside() -> None:
    a = POINT.contact_radius
    r = np.array([0.0, 0.5, 1.0, 1.1, 2.0]) * a
    gap = r**2 / (2 * POINT.radius) + POINT.displacement(r) - POINT.approach
    np.testing.assert_allclose(gap[:3], 0, rtol=0, atol=4e-16 * POINT.approach)
    assert (np.diff(gap[2:]) > 0).all()


def test_hertz_point_looks_like_a_point_force_from_afar() -> None:
    r = 1e3 * POINT.contact_radius
    expected = POINT.load / (np.pi * POINT.contact_modulus * r)
    assert POINT.displacement(r) == pytest.approx(expected, rel=1e-6)


def test_hertz_point_peak_pressure_carries_its_load() -> None:
    a = POINT.contact_radius
    load = quad(lambda r: 2 * np.pi * r * POINT.pressure(r), 0, a, epsrel=1e-11)[0]
    assert load == pytest.approx(POINT.load, rel=1e-8)


def westergaard(fraction: float) -> cs.analytic.Westergaard:
    """Of the pressure that closes every gap."""
    closing = np.pi * 2e11 * 1e-6 / 1e-3
    return cs.analytic.Westergaard(fraction * closing, 1e-6, 1e-3, 2e11)


@pytest.mark.parametrize("fraction", [0.01, 0.9, 1.5])
def test_westergaard_pressure_carries_its_load(fraction: float) -> None:
    wave = westergaard(fraction)
    a = wave.half_width
    load = quad(lambda t: wave.pressure(a * np.sin(t)) * a * np.cos(t), -np.pi / 2, np.pi / 2)[0]
    assert load == pytest.approx(wave.mean_pressure * wave.wavelength, rel=1e-9)
    assert wave.pressure(0.0) == pytest.approx(wave.peak_pressure, rel=1e-14)


@pytest.mark.parametrize("fraction", [0.1, 1.0])
def test_westergaard_surface_is_flat_inside(fraction: float) -> None:
    """The slope under its pressure, a row of ``cot(pi (x - t) / wavelength)``, is that of the wave."""
    wave = westergaard(fraction)
    a, length = wave.half_width, wave.wavelength

    def slope(x: float) -> float:
        # both sides of the pole at once, which cancels it
        at, reach = float(wave.pressure(x)), length / 2
        paired = quad(
            lambda t: (wave.pressure(x - t) - wave.pressure(x + t)) / np.tan(np.pi * t / length),
            0, reach, points=sorted({abs(a - x), a + x, 1e-3 * a} - {0.0}), limit=400,
        )[0]  # fmt: skip
        assert at > 0
        return -2 / wave.contact_modulus / length * paired

    for x in (0.2 * a, 0.7 * a):
        wanted = -wave.amplitude * 2 * np.pi / length * np.sin(2 * np.pi * x / length)
        assert slope(x) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize(
    ("load", "viscosity", "regime"),
    [
        (1e-3, 0.0, "rigid, isoviscous"), (1e4, 0.0, "elastic, isoviscous"), (1.0, 1e6, "rigid, piezoviscous"),
        (1e6, 1e3, "elastic, piezoviscous"),
    ],
)  # fmt: skip
def test_the_film_of_moes_is_that_of_its_regime_at_the_ends(load: float, viscosity: float, regime: str) -> None:
    limits = cs.analytic.film_asymptotes(load, viscosity)
    assert cs.analytic.film_regime(load, viscosity) == regime
    assert cs.analytic.moes_film(load, viscosity) == pytest.approx(limits[regime], rel=0.01)


def test_the_film_of_dowson_and_higginson_is_their_formula_in_the_unit_of_moes() -> None:
    speed, material, load = 1e-11, 5000.0, 1e-4  # U, G, W
    both = 2 * speed  # of the sum of the speeds
    film = cs.analytic.dowson_higginson_film(load / both**0.5, material * both**0.25)
    smallest = 2.65 * speed**0.7 * material**0.54 * load**-0.13
    assert film * both**0.5 == pytest.approx(smallest, rel=1e-12)


def test_the_stress_of_a_sliding_line_contact_is_that_of_its_tractions() -> None:
    """At the surface Johnson (1985), eqs. 7.6; with friction 0.5 it yields there, below 1.1 times the yield stress."""
    x = np.array([-1.5, -0.5, 0.5, 1.5]) * LINE.half_width
    xx, zz, xz = LINE.stress(x, 0.0, friction=0.5) / LINE.peak_pressure
    pressure = LINE.pressure(x) / LINE.peak_pressure
    beyond = np.array([-1, 0, 0, 1]) * np.sqrt(1.5**2 - 1)
    np.testing.assert_allclose(zz, -pressure, atol=1e-12)
    np.testing.assert_allclose(xz, -0.5 * pressure, atol=1e-12)
    np.testing.assert_allclose(xx, -pressure - (x / LINE.half_width - beyond), atol=1e-12)
    slides = cs.analytic.first_yield(0.01, 1.15e11, 1e9, 0.3, friction=0.5)
    assert 1e9 < slides.peak_pressure < 1.1e9
