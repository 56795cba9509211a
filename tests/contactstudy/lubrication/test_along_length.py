from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.lubrication import linear_solvers
from contactstudy.lubrication.film_equation import neighbour
from contactstudy.lubrication.posed_film import pose
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import continued, solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, STEEL, by_moes, grid, with_motion

A = DRY.hertz.half_width


def crossed(amplitude: float) -> cs.Waviness:
    """Crossed waves, a half-width long along and two thirds of one across."""
    return cs.Waviness(amplitude, across=2 * A / 3, along=A / 2)


def film_scale(scene: cs.Scene) -> float:
    return solve_lubricated(scene, grid(128, 4.0)).central_film


@pytest.mark.parametrize(("load", "viscosity", "cells"), [(100, 10, (128, 16)), (20, 5, (96, 32))])
def test_a_film_that_varies_along_the_length_converges_carries_its_load_and_loses_no_lubricant(
    load: float, viscosity: float, cells: tuple[int, int]
) -> None:
    """Waves between steel, and random heights on a coating."""
    height = 0.4 * film_scale(by_moes(load, viscosity))
    rough = cs.Roughness(0.3 * height, hurst=0.8, roll_off=A, cut_off=A / 2, seed=1)
    scene = by_moes(load, viscosity, crossed(height) if load > 20 else rough)
    if load == 20:
        scene = replace(scene, solids=(cs.CoatedHalfSpace(cs.HalfSpace(20e9, 0.3), 2e-5, STEEL), STEEL))
    contact = solve_lubricated(scene, grid(cells[0], 4.0, cells[1]))
    assert contact.status is not cs.Status.FILM_NOT_CONVERGED
    assert contact.flux_spread < 1e-6
    assert (contact.film > 0).all()
    assert np.ptp(contact.film[cells[0] // 2]) > 0
    assert contact.load_per_length == pytest.approx(1e5, rel=1e-7)


def test_the_balance_of_the_film_changes_by_its_derivatives() -> None:
    """By central differences: pressure at a constant film, film, and void fraction of each cell."""
    posed = pose(by_moes(20, 5, crossed(2e-8)), grid(96, 4.0, 8), cs.ExactPeriodicity())
    equation, chance = posed.equation, np.random.default_rng(1)
    film = continued(posed, FilmControls(tolerance=1e-6)).film
    linear, step = equation.linearise(film), 1e-6
    for name, bands in (("pressure", linear.pressure), ("thickness", linear.thickness)):
        field = getattr(film, name)
        change = field * chance.uniform(0.5, 1, field.shape)
        before, after = (
            equation.linearise(replace(film, **{name: field + sign * step * change})).residual for sign in (-1, 1)
        )
        wanted = sum(band * neighbour(change, offset) for offset, band in bands.items())
        # of a sum that cancels, and the rounding of the difference
        scale = np.abs(linear.flux).max()
        np.testing.assert_allclose((after - before) / (2 * step), wanted, atol=1e-5 * scale)


@pytest.mark.parametrize(("along", "period"), [(15, 1.0), (16, 4.0)])
def test_the_local_stage_changes_the_way_to_a_film_and_not_the_film(
    along: int, period: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Lines across short and long cells, and factors."""
    scene = by_moes(20, 5, crossed(0.3 * film_scale(by_moes(20, 5))))
    by_lines = solve_lubricated(scene, grid(64, 4.0, along, period))
    monkeypatch.setattr(linear_solvers, "_by_lines", linear_solvers._by_factors)
    by_factors = solve_lubricated(scene, grid(64, 4.0, along, period))
    assert by_lines.film == pytest.approx(by_factors.film, rel=1e-6)
    assert by_lines.linear_iterations < 2 * by_factors.linear_iterations


def test_a_film_of_a_short_contact_is_as_wide_as_the_dry_contact() -> None:
    """2.2 half-widths of the mean load, which is 2.8 times the mean in the middle."""
    crowned, cells = by_moes(20, 2, cs.Crown(0.01, 20 * A)), grid(96, 6.0, 16, period=20.0)
    contact = solve_lubricated(crowned, cells)
    assert contact.status is not cs.Status.FILM_NOT_CONVERGED
    dry = cs.solve(replace(crowned, lubrication=None), cells, cs.ExactPeriodicity())
    assert dry.pressure[cells.x > 2 * A].any()
    assert contact.peak_pressure == pytest.approx(dry.pressure.max(), rel=0.02)
    with pytest.raises(cs.InvalidInput, match="too narrow for a film that carries load over"):
        solve_lubricated(crowned, grid(48, 2.0, 16, period=20.0))


@pytest.mark.parametrize("shapes", [(), (cs.Crown(0.01),)])
def test_a_film_that_ends_at_a_sharp_end_is_refused_also_where_it_is_thick(shapes: tuple[cs.Shape, ...]) -> None:
    fast = by_moes(1.0, 2, cs.FiniteLength(2 * A), *shapes)
    with pytest.raises(cs.InvalidInput, match="sharp end"):
        solve_lubricated(fast, grid(64, 8.0, 16, period=4.0))


def test_a_film_between_rollers_is_solved_along_them_with_its_least_towards_an_end() -> None:
    plain = by_moes(20, 5)
    width = plain.hertz.half_width
    length = 20 * width
    profile = cs.LundbergProfile.iso_16281(2 * plain.radius, length)
    scene = replace(plain, shapes=(*plain.shapes, profile))
    film = cs.solve(scene, error="10 %")
    least, middle = film.quantities["minimum_film"], film.quantities["central_film"]
    assert film.grid.cells[1] >= 48
    assert length / 4 < abs(least.position["y"]) < length / 2
    assert least.value < 0.9 * cs.solve(plain, error="10 %").quantities["minimum_film"].value
    at_middle = film.film[:, film.grid.cells[1] // 2]
    assert middle.value == pytest.approx(film.central_weights @ at_middle, rel=0.01)
    with pytest.raises(cs.InvalidInput, match="along the length with the LundbergProfile"):
        cs.solve(scene, cs.Grid((96, 1), film.grid.extent))


def test_the_largest_stress_below_a_film_is_among_its_numbers() -> None:
    scene = replace(by_moes(20, 5), outputs=(cs.SubsurfaceStress(),))
    film = cs.solve(scene, grid(100, 4.5), cs.ExactPeriodicity())
    stress = film.quantities["largest_von_mises"]
    assert stress.value == pytest.approx(0.56 * scene.hertz.peak_pressure, rel=0.1)


def test_stress_below_the_surface_takes_pressure_and_friction() -> None:
    stress = cs.SubsurfaceStress(depths=(2e-5,))
    scene = replace(by_moes(20, 5, shear=cs.LimitingShear(0.1)), outputs=(stress,))
    still = with_motion(scene, slide_roll_ratio=0.0)
    dragged, plain = (film_answer(solve_lubricated(moving, grid(100, 4.5))).to_dataset() for moving in (scene, still))
    assert dragged["von_mises"].dims == ("z", "x", "y")
    change = float((dragged["stress"] - plain["stress"]).sel(component="xz").sum())
    # shear that enters at the surface passes through every depth of a wide strip; z points into the body, and the stress
    # on a surface that faces -z is that on the film, against the body's motion
    assert change == pytest.approx(float(dragged["shear"].sum()), rel=0.1)
