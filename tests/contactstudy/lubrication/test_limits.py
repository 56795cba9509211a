from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, STEEL, by_moes, grid, in_moes_units, with_motion

A = DRY.hertz.half_width

OIL = cs.Lubricant(0.04, 2e-8)


def at(load: float, speed: float) -> cs.Scene:
    motion = cs.Lubrication(OIL, speed, slide_roll_ratio=0.1)
    return cs.Scene(cs.LineLoad(load), (STEEL, STEEL), (cs.Cylinder(0.01),), lubrication=motion)


@pytest.mark.whole
def test_the_lightest_loads_have_the_film_of_martin() -> None:
    contact = cs.solve(by_moes(0.01, 0), error=1e-2)
    # rigid cylinders, an endless inlet: h0 = 2.447484 / M
    bound = contact.error.central_film.total + 0.1 * 0.01
    assert 0.01 * in_moes_units(contact, contact.central_film) == pytest.approx(2.447484, rel=bound)


def test_few_cells_have_no_error_and_say_why() -> None:
    error = cs.solve(at(1e5, 1.0), grid(12, 5.0)).error
    assert error.central_film.total == np.inf
    assert "FILM_BELOW_CELL" in " ".join(error.warnings)


def test_an_error_refines_the_cells_of_a_given_extent() -> None:
    given = grid(48, 12.0)
    contact = cs.solve(by_moes(20, 5), given, error=4e-2)
    assert contact.grid.extent == given.extent
    assert contact.grid.cells[0] > 48
    assert contact.error.central_film.total <= 4e-2
    assert contact.error.minimum_film.total <= 4e-2


def test_an_error_that_the_width_misses_names_the_inlet() -> None:
    narrow = cs.solve(by_moes(5, 0), grid(96, 2.5), error=1e-2)
    assert "not met" in narrow.accuracy
    assert "inlet: give a wider grid" in narrow.accuracy


def test_friction_that_no_lubricant_bears_has_no_bound_and_names_the_limit() -> None:
    """Newtonian steel at 1.4 GPa has a coefficient of 48; a limiting shear stress of 0.07 of the pressure bounds it."""
    newtonian = at(5e5, 1.0)
    limited = with_motion(newtonian, lubricant=replace(OIL, shear=cs.LimitingShear(0.07)))
    without, with_limit = (cs.solve(scene, error=5e-2) for scene in (newtonian, limited))
    assert without.friction > 1
    assert without.quantities["minimum_film"].relative_bound < 5e-2
    # the verdict is on all numbers, and not on the film alone
    assert not without.met
    assert "no bound in the friction; Friction has no bound" in without.accuracy
    assert "LimitingShear" in without.quantities["friction_coefficient"].reason
    assert with_limit.judged["friction_coefficient"].ratio <= 1


@pytest.mark.parametrize(("load", "height", "wavelength"), [(100, 5, A / 4), (30, 2.2, A / 2), (50, 4, A / 2)])
def test_several_films_between_high_ridges_are_reported(load: float, height: float, wavelength: float) -> None:
    """Transverse waves with their rms height over the smooth film, isoviscous."""
    film = solve_lubricated(by_moes(load, 0), grid(256, 1.5)).central_film
    waves = cs.Waviness(np.sqrt(2) * height * film, across=wavelength)
    contact = solve_lubricated(by_moes(load, 0, waves), grid(512, 1.5))
    assert contact.status is cs.Status.SEVERAL_FILMS


def test_a_film_starts_from_one_on_another_grid() -> None:
    waves = by_moes(20, 5, cs.Waviness(2e-8, across=A, along=A))
    for scene, first, second in (
        (by_moes(20, 5), grid(100, 4.5), grid(300, 6.0)),
        (waves, grid(64, 3.0, 8), grid(64, 3.0, 16)),
        (by_moes(20, 5), grid(100, 4.5), grid(100, 4.5)),
    ):
        controls = FilmControls(tolerance=1e-10)
        coarse = solve_lubricated(scene, first, controls=controls)
        cold, warm = (solve_lubricated(scene, second, controls=controls, start=start) for start in (None, coarse))
        assert warm.film == pytest.approx(cold.film, rel=1e-6)
        assert warm.iterations <= (1 if first == second else cold.iterations)


def test_a_spike_that_cells_hide_leaves_the_peak_pressure_without_an_error() -> None:
    """Half of it is missing on 96 cells; no cell rises above the one before it and falls again."""
    coarse, fine = (solve_lubricated(by_moes(5.3, 9.2), grid(cells, 4.2)) for cells in (96, 640))
    assert fine.peak_pressure > 1.5 * coarse.peak_pressure
    assert film_answer(coarse).error.peak_pressure.total == np.inf
    isoviscous = cs.solve(by_moes(10, 0), grid(160, 2.3)).error
    assert np.isfinite(isoviscous.peak_pressure.total)


def test_few_cells_along_a_wave_are_within_their_error() -> None:
    height = 0.2 * solve_lubricated(by_moes(20, 5), grid(96, 3.0)).central_film
    scene = by_moes(20, 5, cs.Waviness(height, across=A / 2, along=A / 2))
    few, many = (solve_lubricated(scene, grid(96, 3.0, cells)) for cells in (8, 32))
    error = film_answer(few).error
    for name in ("central_film", "minimum_film", "peak_pressure"):
        bound = getattr(error, name).total
        assert getattr(few, name) == pytest.approx(getattr(many, name), rel=bound), name


def test_friction_that_hangs_on_a_spike_has_no_error_unless_its_stress_is_limited() -> None:
    newtonian, eyring = (
        cs.solve(by_moes(6.5, 7.5, shear=shear), error=2e-2).error for shear in (cs.Newtonian(), cs.Eyring(5e6))
    )
    assert newtonian.friction_coefficient.total == np.inf
    assert "a shear law that thins" in " ".join(newtonian.warnings)
    assert np.isfinite(eyring.friction_coefficient.total)


@pytest.mark.parametrize(("load", "viscosity"), 10 ** np.random.default_rng(7).uniform((0.3, 0.0), (2.0, 1.0), (2, 2)))
def test_errors_are_no_larger_than_their_estimates(load: float, viscosity: float) -> None:
    contact = cs.solve(by_moes(load, viscosity), error=2e-2)
    cells, (width, period) = contact.grid.cells, contact.grid.extent
    # cells of half the width, twice the inlet
    fine = solve_lubricated(by_moes(load, viscosity), cs.Grid((4 * cells[0], 1), (2 * width, period)), start=contact)
    assert fine.status is cs.Status.CONVERGED
    error = contact.error
    assert error.central_film.total + error.minimum_film.total < 4e-2
    numbers = {
        name: getattr(fine, name) for name in ("central_film", "minimum_film", "rolling_resistance", "power_loss")
    }
    for name, value in (numbers | {"friction_coefficient": fine.friction}).items():
        bounded = contact.quantities[name]
        assert bounded.value == pytest.approx(value, rel=0, abs=bounded.bound), name


def test_the_plan_of_a_file_reaches_its_error() -> None:
    described = cs.read_scene(Path(__file__).parents[3] / "examples" / "oil.toml")
    planned = described.plan()
    assert planned.dimension == 1
    assert planned.error == 0.01
    contact = described.solve()
    assert contact.grid.length == planned.grid.length
    assert contact.status is cs.Status.CONVERGED
    assert contact.judged["friction_coefficient"].ratio <= 1
    assert contact.error.minimum_film.total <= 0.01


def test_a_plan_for_an_error_out_of_reach_names_one_within_reach() -> None:
    (warning,) = cs.plan(by_moes(20, 5), error=1e-6).warnings
    reached = float(warning.split("give about ")[1].split(",")[0])
    assert cs.plan(by_moes(20, 5), error=reached).error == reached
    assert cs.plan(by_moes(20, 5), error=0.8 * reached).error == np.inf


def test_a_meniscus_is_within_its_bound_inside_the_grid_and_has_none_beyond() -> None:
    scene, cells = by_moes(20, 5), grid(96, 4.5)
    film = solve_lubricated(scene, cells).central_film
    starved, flooded = (with_motion(scene, supply=fraction * film) for fraction in (0.5, 20))
    meniscus = cs.solve(starved, cells).quantities["meniscus"]
    assert meniscus.value == pytest.approx(solve_lubricated(starved, grid(384, 4.5)).meniscus, abs=meniscus.bound)
    assert "meniscus lies beyond" in cs.solve(flooded, cells).quantities["meniscus"].reason
