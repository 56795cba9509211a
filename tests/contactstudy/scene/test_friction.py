from dataclasses import replace
from math import acos, pi, sin, sqrt, tan
from math import inf as infinite

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.friction import dundurs
from tests.conftest import STEEL

RIGID = cs.HalfSpace(infinite, 0.3)
CYLINDER = (cs.Cylinder(radius=0.01),)
ROUGH = (*CYLINDER, cs.Roughness(4e-7, hurst=0.8, roll_off=1e-4, cut_off=2.5e-5))
LOAD, EXACT = cs.LineLoad(1e5), cs.ExactPeriodicity()
SMOOTH = cs.Scene(LOAD, (STEEL, STEEL), CYLINDER)


def scene(friction: object, **other: object) -> cs.Scene:
    return replace(SMOOTH, friction=friction, **other)


def solved(one: cs.Scene, cells: tuple[int, int] = (128, 1), **options: object) -> cs.Solution:
    grid = cs.Grid(cells, (2.6 * one.hertz.half_width, 3e-4))
    return cs.solve(one.problem(grid, EXACT), **options)


def test_like_bodies_slide_under_the_pressure_of_bodies_that_do_not() -> None:
    without, sliding = (solved(scene(law, shapes=ROUGH), (64, 16)) for law in (None, cs.Sliding(0.7)))
    np.testing.assert_array_equal(sliding.pressure, without.pressure)
    np.testing.assert_array_equal(sliding.shear[0], 0.7 * without.pressure)
    assert not sliding.shear[1].any()
    assert not sliding.stick.any()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("product", [0.05, 0.3])
def test_unlike_bodies_slide_as_in_closed_form(product: float, sign: int) -> None:
    """``cot(pi s) = -beta mu``: half-width, middle and centroid of the contact (Johnson 1985, sect. 8.2)."""
    elastic = cs.HalfSpace(1e9, 0.0)
    solids = (elastic, RIGID) if sign > 0 else (RIGID, elastic)
    assert dundurs(solids) == sign * 0.5
    one = scene(cs.Sliding(2 * product), solids=solids, load=cs.LineLoad(1e4))
    fraction = acos(-product / sqrt(1 + product**2)) / pi
    assert 1 / tan(pi * fraction) == pytest.approx(-product)
    a0, cells = one.hertz.half_width, 800
    half = a0 / (2 * sqrt(fraction * (1 - fraction)))
    grid = cs.Grid((cells, 1), (2.8 * a0, 1e-3))
    solution = cs.solve(one.problem(grid, EXACT), tolerance=1e-9)
    assert solution.status is cs.Status.CONVERGED
    pressure = solution.pressure[:, 0]
    touching = grid.x[pressure > 0]
    dx = grid.cell_size[0]
    assert np.ptp(touching) / 2 == pytest.approx(half, abs=dx)
    assert touching[[0, -1]].mean() == pytest.approx(-sign * half * (2 * fraction - 1), abs=dx)
    centroid = -half * (2 * fraction - 1) * 4 / 3
    # second order in the cell, with some factor below one
    found = sign * (grid.x * pressure).sum() / pressure.sum()
    assert found == pytest.approx(centroid, abs=(dx / a0) ** 2 * a0)
    # p = E* sin(pi s) (half / 2 R) (1 - t)^s (1 + t)^(1 - s)
    t = (sign * grid.x + half * (2 * fraction - 1)) / half
    within = np.clip(1 - np.abs(t), 0, None) > 0
    shape = np.where(within, (1 - np.where(within, t, 0)) ** fraction, 0)
    shape *= (1 + np.where(within, t, 0)) ** (1 - fraction)
    exact = one.contact_modulus * sin(pi * fraction) * half / 0.02 * shape
    # the edges' rate, 1.5
    assert np.abs(pressure - exact).sum() <= (dx / half) ** 1.5 * exact.sum()


@pytest.mark.parametrize(("fraction", "tolerance"), [(0.1, 1e-10), (0.9, 1e-10), (1e-4, 1e-4)])
@pytest.mark.parametrize("sign", [1, -1])
def test_partial_slip_of_a_cylinder_is_cattaneos(fraction: float, tolerance: float, sign: int) -> None:
    """Stick for ``|x| < a sqrt(1 - Q / mu P)``, shear in the middle ``mu p0 (1 - sqrt(1 - Q / mu P))``."""
    mu = 0.3
    one = scene(cs.PartialSlip(mu, sign * fraction * mu * 1e5))
    solution = solved(one, (601, 1), tolerance=tolerance)
    hertz, dx = one.hertz, solution.problem.grid.cell_size[0]
    stick = solution.stick.sum() * dx / 2
    assert stick == pytest.approx(hertz.half_width * sqrt(1 - fraction), abs=dx)
    middle = sign * mu * hertz.peak_pressure * (1 - sqrt(1 - fraction))
    # second order in the cell of either contact, the narrower one counts; first order of a small difference
    narrow = dx / (hertz.half_width * sqrt(1 - fraction))
    error = min(mu * hertz.peak_pressure * narrow**2, abs(middle) * narrow)
    assert solution.shear[0][300, 0] == pytest.approx(middle, abs=error)
    carried = solution.shear[0].sum() * dx
    assert carried == pytest.approx(sign * fraction * mu * 1e5, rel=1e-12)


def test_bodies_at_an_approach_slip_as_under_its_load() -> None:
    at_approach = replace(scene(cs.Fretting(0.3, (1.5e4, -1e4))), load=cs.Approach(2e-6))
    grid = cs.Grid((64, 1), (4e-4, 1e-3))
    found = cs.solve(at_approach, grid, EXACT, tolerance=1e-10)
    load = found.pressure.sum() * grid.cell_area / grid.length
    wanted = cs.solve(replace(at_approach, load=cs.LineLoad(load)), grid, EXACT, tolerance=1e-10)
    np.testing.assert_allclose(found.shear, wanted.shear, atol=1e-6 * np.abs(wanted.shear).max())
    # the coefficient is over the load, and as known as that
    fine = cs.solve(at_approach, cs.Grid((512, 1), grid.extent), EXACT)
    coarse, better = (each.quantities["traction_coefficient"] for each in (found, fine))
    assert 1e-6 * better.value < abs(coarse.value - better.value) <= coarse.bound + better.bound


def test_a_load_that_no_pressure_carries_leaves_no_traction() -> None:
    fretting = replace(scene(cs.Fretting(0.3, forces=(1e4,))), hardness=1e3)
    found = cs.solve(fretting, cs.Grid((32, 1), (1e-3, 1e-3)), EXACT)
    assert found.status is cs.Status.NO_ADMISSIBLE_PRESSURE
    assert found.quantities["largest_shear"].value == 0


def test_a_body_of_the_users_own_slides_as_the_half_space_of_its_moduli() -> None:
    class Own:
        youngs_modulus, poisson_ratio = STEEL.youngs_modulus, STEEL.poisson_ratio
        compliance, response = STEEL.compliance, STEEL.response

    found, expected = (
        solved(scene(cs.Sliding(0.3), solids=(solid, RIGID)), (64, 1)).pressure for solid in (Own(), STEEL)
    )
    np.testing.assert_array_equal(found, expected)


# Highest von Mises stress over Hertz's pressure under full sliding, nu = 0.3: closed form of the line contact
@pytest.mark.parametrize(("coefficient", "wanted"), [(0.2, 0.58999), (0.4, 0.81584)])
def test_stress_below_sliding_is_as_in_closed_form(coefficient: float, wanted: float) -> None:
    hertz = SMOOTH.hertz
    depths = tuple(hertz.half_width * z for z in (1e-6, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75))
    one = scene(cs.Sliding(coefficient), outputs=(cs.SubsurfaceStress(depths),))
    dataset = solved(one, (1201, 1), tolerance=1e-9).to_dataset()
    # in cells of a / 460 and between depths 0.05 a apart: the maximum is flat to their square
    assert float(dataset.von_mises.max()) / hertz.peak_pressure == pytest.approx(wanted, abs=2e-3)
    x = dataset.x / hertz.half_width
    inside = np.abs(x) < 0.9
    root = np.sqrt(1 - x[inside] ** 2)
    surface = dataset.stress.isel(z=0, y=0)[:, inside] / hertz.peak_pressure
    np.testing.assert_allclose(surface.sel(component="xx"), -root - 2 * coefficient * x[inside], atol=2e-3)
    np.testing.assert_allclose(surface.sel(component="xz"), -coefficient * root, atol=1e-3)


def test_dundurs_constant_of_bodies_that_differ_in_both_moduli() -> None:
    """Johnson (1985), eq. 5.3: by (1 - 2 nu) / G and (1 - nu) / G of either."""
    first, second = cs.HalfSpace(200e9, 0.2), cs.HalfSpace(50e9, 0.4)
    shear1, shear2 = 200e9 / 2.4, 50e9 / 2.8
    above = (1 - 0.4) / shear1 - (1 - 0.8) / shear2
    below = (1 - 0.2) / shear1 + (1 - 0.4) / shear2
    assert dundurs((first, second)) == pytest.approx(above / below / 2)
    assert dundurs((second, first)) == pytest.approx(-above / below / 2)
    assert dundurs((first, first)) == 0


@pytest.mark.parametrize("friction", [cs.PartialSlip, cs.Fretting.cycle])
@pytest.mark.parametrize(("cells", "part"), [(24, 0.1), (47, 0.05)])
def test_where_no_cell_slips_a_zone_of_slip_may_hide_at_the_edges(friction: type, cells: int, part: float) -> None:
    """The half-width that sticks is ``sqrt(1 - Q / mu P)`` of the contact's (Johnson 1985, eq. 7.28)."""
    one = scene(friction(0.3, 0.3 * part * LOAD.per_length))
    grid = cs.Grid((cells, 1), (2.4 * one.hertz.half_width, 3e-4))
    stick = cs.solve(one, grid, EXACT).quantities["stick_fraction"]
    assert stick.value == 1
    assert 1 - sqrt(1 - part) <= stick.bound < 0.2
