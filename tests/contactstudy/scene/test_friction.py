from dataclasses import replace
from math import acos, pi, sin, sqrt, tan
from math import inf as infinite

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.friction.friction_law import dundurs
from tests.conftest import STEEL

RIGID = cs.HalfSpace(infinite, 0.3)
CYLINDER = (cs.Cylinder(radius=0.01),)
ROUGH = (*CYLINDER, cs.Roughness(4e-7, hurst=0.8, roll_off=1e-4, cut_off=2.5e-5))
LOAD = cs.LineLoad(1e5)


def scene(friction: object, **other: object) -> cs.Scene:
    return replace(cs.Scene(LOAD, (STEEL, STEEL), CYLINDER, friction=friction), **other)


def solved(one: cs.Scene, cells: tuple[int, int] = (128, 1), **options: object) -> cs.Solution:
    grid = cs.Grid(cells, (2.6 * one.hertz.half_width, 3e-4))
    return cs.solve(one.problem(grid, cs.ExactPeriodicity()), **options)


@pytest.mark.parametrize("coefficient", [0.0, 0.2, 0.7])
def test_like_bodies_slide_under_the_pressure_of_bodies_that_do_not(coefficient: float) -> None:
    without = solved(scene(None), (128, 16))
    sliding = solved(scene(cs.Sliding(coefficient)), (128, 16))
    np.testing.assert_array_equal(sliding.pressure, without.pressure)
    np.testing.assert_array_equal(sliding.shear[0], coefficient * without.pressure)
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
    solution = cs.solve(one.problem(grid, cs.ExactPeriodicity()), tolerance=1e-9)
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


@pytest.mark.parametrize(("fraction", "tolerance"), [(0.1, 1e-10), (0.5, 1e-10), (0.9, 1e-10), (1e-4, 1e-4)])
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


def test_disks_meet_every_condition_of_coulombs_law() -> None:
    """With Poisson's ratio, in three dimensions: within the disk no slip, on its rim slip against the shear."""
    mu = 0.25
    one = scene(cs.PartialSlip(mu, -1.4e4), shapes=ROUGH)
    grid = cs.Grid((48, 48), (3e-4, 3e-4))
    problem = one.problem(grid, cs.ExactPeriodicity())
    solution = cs.solve(problem, tolerance=1e-9)
    # two applications of the operator in each step, beside those of the pressure
    pressed = cs.solve(replace(problem, friction=None), tolerance=1e-9)
    assert solution.convolutions - pressed.convolutions == 2 * solution.traction.iterations
    shear, size = solution.shear, np.hypot(*solution.shear)
    radius = mu * solution.pressure
    assert (size <= radius * (1 + 1e-12)).all()
    assert shear.sum(axis=(1, 2)) * grid.cell_area / grid.length == pytest.approx([-1.4e4, 0], abs=1e-5)
    assert np.abs(shear[1]).max() > 0.03 * size.max()
    moved = problem.friction.fretting.response(shear)
    stick = solution.stick
    slip = moved - moved[:, stick].mean(axis=1)[:, None, None]
    scale = mu * problem.scales.gap
    assert np.abs(slip[:, stick]).max() <= 1e-5 * scale
    sliding = (solution.pressure > 0) & ~stick
    against = -(slip * shear).sum(axis=0)[sliding] / size[sliding]
    aside = (slip[0] * shear[1] - slip[1] * shear[0])[sliding] / size[sliding]
    assert against.min() >= -1e-5 * scale
    assert np.abs(aside).max() <= 1e-5 * scale


@pytest.mark.parametrize("friction", [cs.PartialSlip(0.3, 1.5e4), cs.Fretting(0.3, (1.5e4, -1e4))])
def test_bodies_at_an_approach_slip_as_under_its_load(
    friction: cs.PartialSlip | cs.Fretting,
) -> None:
    at_approach = replace(scene(friction), load=cs.Approach(2e-6))
    grid = cs.Grid((64, 1), (4e-4, 1e-3))
    found = cs.solve(at_approach.problem(grid, cs.ExactPeriodicity()), tolerance=1e-10)
    load = found.pressure.sum() * grid.cell_area / grid.length
    loaded = replace(at_approach, load=cs.LineLoad(load))
    wanted = cs.solve(loaded.problem(grid, cs.ExactPeriodicity()), tolerance=1e-10)
    np.testing.assert_allclose(found.shear, wanted.shear, atol=1e-6 * np.abs(wanted.shear).max())
    too_much = replace(friction, **{"tangential": 1e6} if hasattr(friction, "tangential") else {"forces": (1e6,)})
    with pytest.raises(cs.InvalidInput, match="transmits less than"):
        cs.solve(replace(at_approach, friction=too_much).problem(grid, cs.ExactPeriodicity()))


def test_a_force_over_the_load_of_an_approach_is_as_known_as_that_load() -> None:
    at_approach = replace(scene(cs.PartialSlip(0.3, 1.5e4)), load=cs.Approach(2e-6))
    coarse, fine = (
        cs.solve(at_approach, cs.Grid((cells, 1), (4e-4, 1e-3)), cs.ExactPeriodicity()).quantities[
            "traction_coefficient"
        ]
        for cells in (32, 512)
    )
    difference = abs(coarse.value - fine.value)
    assert 1e-6 * fine.value < difference <= coarse.bound + fine.bound


def test_a_load_that_no_pressure_carries_leaves_no_traction() -> None:
    fretting = replace(scene(cs.Fretting(0.3, forces=(1e4,))), hardness=1e3)
    found = cs.solve(fretting, cs.Grid((32, 1), (1e-3, 1e-3)), cs.ExactPeriodicity())
    assert found.status is cs.Status.NO_ADMISSIBLE_PRESSURE
    assert found.quantities["largest_shear"].value == 0


def test_incompressible_coatings_are_dissimilar_whatever_dundurs_constant() -> None:
    rubber = cs.CoatedHalfSpace(cs.HalfSpace(1e6, 0.5), 1e-3, cs.HalfSpace(1e9, 0.5))
    one = scene(cs.Sliding(0.2), solids=(rubber, RIGID), load=cs.LineLoad(1e2))
    assert "dissimilar bodies (Dundurs' beta 0)" in " ".join(cs.plan(one).reasons)


def test_a_body_of_the_users_own_slides_as_the_half_space_of_its_moduli() -> None:
    class Own:
        youngs_modulus, poisson_ratio = STEEL.youngs_modulus, STEEL.poisson_ratio
        compliance, response = STEEL.compliance, STEEL.response

    found, expected = (
        solved(scene(cs.Sliding(0.3), solids=(solid, RIGID)), (64, 1)).pressure for solid in (Own(), STEEL)
    )
    np.testing.assert_array_equal(found, expected)


# Highest von Mises stress over Hertz's pressure under full sliding, nu = 0.3: closed form of the line contact
MISES = ((0.0, 0.55751), (0.2, 0.58999), (0.3, 0.66663), (0.4, 0.81584))


@pytest.mark.parametrize(("coefficient", "wanted"), MISES)
def test_stress_below_sliding_is_as_in_closed_form(coefficient: float, wanted: float) -> None:
    a = scene(None).hertz.half_width
    depths = tuple(a * z for z in (1e-6, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75))
    below = cs.SubsurfaceStress(depths)
    one = scene(cs.Sliding(coefficient), outputs=(below,))
    solution = solved(one, (1201, 1), tolerance=1e-9)
    dataset = solution.to_dataset()
    peak = one.hertz.peak_pressure
    # in cells of a / 460 and between depths 0.05 a apart: the maximum is flat to their square
    assert float(dataset.von_mises.max()) / peak == pytest.approx(wanted, abs=2e-3)
    surface = dataset.stress.sel(component="xx").isel(z=0, y=0) / peak
    x = dataset.x / a
    inside = np.abs(x) < 0.9
    exact = -np.sqrt(1 - x[inside] ** 2) - 2 * coefficient * x[inside]
    np.testing.assert_allclose(surface[inside], exact, atol=2e-3)
    shear = dataset.stress.sel(component="xz").isel(z=0, y=0)[inside] / peak
    np.testing.assert_allclose(shear, -coefficient * np.sqrt(1 - x[inside] ** 2), atol=1e-3)


def test_the_second_body_feels_the_reaction() -> None:
    stresses = []
    for solid in (0, 1):
        below = cs.SubsurfaceStress((2e-5,), body=solid)
        stresses.append(solved(scene(cs.Sliding(0.3), outputs=(below,)), (64, 1)).to_dataset().stress)
    np.testing.assert_allclose(stresses[0].sel(component="xx").values, stresses[1].sel(component="xx").values[:, ::-1])


def test_a_solution_without_friction_has_no_shear() -> None:
    plain = solved(scene(None))
    for name in ("shear", "stick"):
        with pytest.raises(cs.NotDefined, match=r"Scene\.friction"):
            getattr(plain, name)
    assert "shear_x" not in plain.to_dataset()
    labelled = solved(scene(cs.PartialSlip(0.3, 1e4))).to_dataset()
    assert set(labelled.variables) >= {"shear_x", "shear_y", "stick"}


def test_equal_coated_bodies_slide_alike_with_a_hardness_and_roughness() -> None:
    coated = cs.CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 2e-6, STEEL)
    known = replace(coated, coating=replace(coated.coating, yield_stress=1e10))
    assert scene(cs.PartialSlip(0.2, 1e4), solids=(coated, known))  # which changes nothing elastic
    one = scene(cs.Sliding(0.2), solids=(coated, coated), shapes=ROUGH, hardness=3e9)
    sliding, without = solved(one, (64, 32)), solved(replace(one, friction=None), (64, 32))
    np.testing.assert_array_equal(sliding.pressure, without.pressure)


@pytest.mark.parametrize(
    "body",
    [
        cs.ViscoelasticHalfSpace(STEEL.youngs_modulus, STEEL.poisson_ratio),
        cs.ElasticPlasticHalfSpace(STEEL.youngs_modulus, STEEL.poisson_ratio, infinite),
    ],
)
def test_a_body_that_neither_creeps_nor_yields_sticks_as_an_elastic_one(body: object) -> None:
    """Both stop at a residual of 1e-9, whose error is no more than its root."""
    one = scene(cs.TractiveRolling(0.3, longitudinal=1e-3))
    found, elastic = (solved(replace(one, solids=(first, STEEL)), tolerance=1e-9).shear for first in (body, STEEL))
    np.testing.assert_allclose(found, elastic, rtol=0, atol=3e-5 * elastic.max())


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
    stick = cs.solve(one, grid, cs.ExactPeriodicity()).quantities["stick_fraction"]
    assert stick.value == 1
    assert 1 - sqrt(1 - part) <= stick.bound < 0.2
