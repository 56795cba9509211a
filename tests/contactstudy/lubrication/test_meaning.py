"""Numbers of a film mean what their names say: where the outlet lies, of which instant, and what is lost."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.evolve_lubricated import evolve_lubricated
from contactstudy.lubrication.posed_film import pose
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import continued, film_solution, solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, STEEL, by_moes, grid, in_moes_units, with_motion

A = DRY.hertz.half_width


@pytest.mark.parametrize("side", [-1, 1])
def test_a_contact_beside_the_axis_has_the_film_of_one_on_it(side: int) -> None:
    """A wave fifty times as long as the contact moves it by 0.9 half-widths, and changes its curvature by a tenth."""
    wave = cs.Waviness(7e-6, across=5e-3, phase=side * np.pi / 2)
    central, shifted = (solve_lubricated(by_moes(20, 5, *shapes), grid(320, 6.0)) for shapes in ((), (wave,)))
    assert shifted.status is cs.Status.CONVERGED
    assert abs(shifted.grid.x @ shifted.pressure[:, 0]) > 0.5 * A * shifted.pressure.sum()
    assert shifted.minimum_film == pytest.approx(central.minimum_film, rel=0.02)
    assert shifted.central_film == pytest.approx(central.central_film, rel=0.02)


def test_an_outlet_that_cuts_the_pressure_off_is_no_answer_and_moves_to_the_end_of_the_grid() -> None:
    scene, cells, controls = by_moes(5, 2), grid(96, 4.0), FilmControls()
    posed = pose(scene, cells, cs.ExactPeriodicity(), outlet=-0.3)
    last = continued(posed, controls)
    cut = film_solution(scene, cells, cs.ExactPeriodicity(), posed, last, controls.tolerance)
    assert cut.status is cs.Status.CONTACT_AT_EDGE
    moved = solve_lubricated(scene, cells, controls=controls, outlet=-0.3)
    assert moved.status is cs.Status.CONVERGED
    assert moved.film == pytest.approx(solve_lubricated(scene, cells).film, rel=1e-6)


def test_the_central_film_is_a_mean_over_the_middle_where_heights_vary_and_on_the_axis_if_smooth() -> None:
    cells = grid(240, 4.0)
    waves, smooth = (
        pose(by_moes(20, 5, cs.Waviness(height, across=0.4 * A)), cells, cs.ExactPeriodicity())
        for height in (2e-8, 0.0)
    )
    mean = waves.central_weights(1e-7)
    assert mean.sum() == pytest.approx(1, rel=1e-12)
    for phase in (0.0, 1.0, 2.0):
        assert abs(mean @ np.cos(2 * np.pi * cells.x / (0.4 * A) + phase)) < 0.03
    on_axis = smooth.central_weights(1e-7)
    assert on_axis @ (1 + cells.x + (cells.x / A) ** 3) == pytest.approx(1, rel=1e-12)


def test_a_frame_has_the_groups_of_its_load_and_speed() -> None:
    """Moes: M grows with W and u^(-1/2), L with u^(1/4)."""
    scene = by_moes(20, 5)
    speed = scene.lubrication.largest_speed
    passage = A / speed
    slow = with_motion(scene, mean_speed=cs.SpeedHistory((0.0, passage), (0.25 * speed, speed)))
    lighter = replace(slow, load=cs.LoadHistory((0.0, passage), (5e4, 1e5)))
    frames = cs.solve(lighter, grid(96, 5.0), times=[0.0, passage], error=0.05).frames
    for frame, viscosity in zip(frames, (5 / 2**0.5, 5), strict=True):
        assert frame.quantities["load_parameter"].value == pytest.approx(20, rel=1e-9)
        assert frame.quantities["viscosity_parameter"].value == pytest.approx(viscosity, rel=1e-9)
    formula = cs.analytic.moes_film(20, 5 / 2**0.5)
    film = in_moes_units(frames[0], frames[0].quantities["moes_film"].value)
    assert film == pytest.approx(formula, rel=1e-9)


def test_at_a_halt_the_formulas_give_no_film() -> None:
    scene = by_moes(20, 0)
    speed = scene.lubrication.largest_speed
    stop = cs.SpeedHistory((0.0, 2 * A / speed), (speed, 0.0))
    halted = cs.solve(with_motion(scene, mean_speed=stop), grid(64, 4.0), times=[0, 2 * A / speed]).frames[-1]
    assert halted.central_film > 0
    assert halted.quantities["load_parameter"].value == np.inf
    for name in ("moes_film", "dowson_higginson_film", "elastic_isoviscous_film"):
        assert halted.quantities[name].value == 0


def test_the_lambda_ratio_is_that_of_the_starved_film() -> None:
    waves = cs.Waviness(1e-8, across=A / 4)
    flooded = cs.solve(by_moes(20, 5, waves), grid(240, 4.0))
    layer = 0.2 * flooded.flow / flooded.mean_speed
    starved = cs.solve(with_motion(flooded.scene, supply=layer), grid(240, 4.0))
    ratios = [film.quantities["lambda_ratio"].value for film in (flooded, starved)]
    assert ratios[1] / ratios[0] == pytest.approx(0.2, rel=0.05)


def test_a_film_under_a_load_that_grows_loses_the_work_of_the_squeeze() -> None:
    scene = by_moes(20, 0)
    passage = A / scene.lubrication.largest_speed
    grown = replace(scene, load=cs.LoadHistory((0.0, passage), (1e5, 3e5)))
    step = passage / 100
    *_, before, last = evolve_lubricated(grown, grid(96, 4.0), times=np.linspace(0, passage, 51), step=step).contacts
    rate = (last.film - before.film) / (2 * step)
    dx = last.grid.cell_size[0]
    rolling = -(last.pressure * np.gradient(last.film, dx, axis=0)).sum() * dx * last.mean_speed
    squeeze = -(last.pressure * rate).sum() * dx
    assert abs(squeeze) > 0.1 * rolling
    assert last.power_loss - last.sliding_loss == pytest.approx(rolling + squeeze, rel=0.02)


@pytest.mark.parametrize("slide", [0.0, 1.0])
def test_a_body_that_creeps_loses_its_own_power_as_when_it_rolls_dry(slide: float) -> None:
    """A thin film over a body that creeps at its own speed; in pure rolling it is the moment of the pressure."""
    body, cells = cs.ViscoelasticHalfSpace(5e8, 0.4, ((1.5e9, 3e-4),)), cs.Grid((160, 1), (3e-3, 1e-3))
    oil = cs.Lubrication(cs.Lubricant(1e-3, 1e-8), 1.0, slide)
    film = cs.Scene(cs.LineLoad(1e4), (body, STEEL), DRY.shapes, lubrication=oil)
    speed = 1.0 + slide / 2
    rolling = replace(film, lubrication=None, rolling=cs.Rolling(speed))
    resistance = cs.solve(rolling, cells, cs.ExactPeriodicity()).quantities["rolling_resistance"].value
    contact = solve_lubricated(film, cells)
    assert contact.creep_loss == pytest.approx(resistance * 1e4 * speed, rel=0.05)
    assert contact.power_loss > contact.creep_loss + contact.sliding_loss
    if not slide:
        moment = -(contact.pressure[:, 0] @ cells.x) * cells.cell_size[0] / (0.01 * 1e4)
        assert contact.rolling_resistance == pytest.approx(moment, rel=0.01)
    swapped = replace(film, solids=(STEEL, body), lubrication=replace(oil, slide_roll_ratio=-slide))
    assert solve_lubricated(swapped, cells).power_loss == pytest.approx(contact.power_loss, rel=1e-6)


def test_the_rolling_loss_has_the_factor_of_the_heated_inlet() -> None:
    scene = with_motion(by_moes(20, 5), slide_roll_ratio=0.0, mean_speed=5.0)
    cold, hot = (solve_lubricated(with_motion(scene, thermal=heat), grid(160, 8.0)) for heat in (None, cs.FilmHeat()))
    assert hot.temperatures.reduction < 0.99
    assert hot.power_loss == pytest.approx(hot.temperatures.reduction * cold.power_loss, rel=1e-9)


@pytest.mark.parametrize("sign", [1, -1])
def test_friction_of_small_slip_is_that_of_bodies_that_stick(sign: int) -> None:
    """Carter (1926): 2 S R / a where all sticks, with a friction mu at most ``mu (1 - (1 - S R / mu a)^2)``."""
    layer, oil = cs.Boundary(5e-9, coefficient=0.12), cs.Lubricant(0.04, 0.0)
    for fraction, expected in ((1e-6, 2e-6), (0.5, 0.75), (1e3, 1.0)):
        slide = sign * fraction * 0.12 * A / DRY.hertz.radius
        motion = cs.Lubrication(oil, 1e-6, slide, boundary=layer)
        contact = solve_lubricated(replace(DRY, lubrication=motion), grid(240, 2.0))
        assert contact.contact_load_fraction > 0.99
        # of a Winkler foundation it is 0.73 in place of 0.75
        assert contact.friction == pytest.approx(sign * 0.12 * expected, rel=0.04)
        assert contact.sliding_loss > 0


FILM = by_moes(20, 5)
SPEED = FILM.lubrication.largest_speed


def creeping(time: float) -> cs.ViscoelasticHalfSpace:
    """Half the modulus of steel after a time [s]."""
    return cs.ViscoelasticHalfSpace(105e9, 0.3, ((105e9, time),))


def between(first: object, second: object, **motion: object) -> cs.Scene:
    lubrication = replace(FILM.lubrication, **motion)
    return replace(FILM, solids=(first, second), lubrication=lubrication)


@pytest.mark.parametrize(("widths", "modulus"), [(1e-9, 105e9), (1e9, 210e9)])
def test_bodies_that_creep_fast_or_slowly_have_the_film_of_elastic_ones(widths: float, modulus: float) -> None:
    body, elastic = creeping(widths * A / SPEED), cs.HalfSpace(modulus, 0.3)
    film, known = (solve_lubricated(between(b, b), grid(240, 6.0)) for b in (body, elastic))
    assert film.status is cs.Status.CONVERGED
    assert np.abs(film.pressure - known.pressure).max() < 1e-6 * known.peak_pressure
    assert film.film == pytest.approx(known.film, rel=1e-6)


def test_a_film_that_vanishes_leaves_the_dry_contact_that_rolls_against_its_surfaces() -> None:
    """Surfaces move to larger x, so that the contact rolls over them to smaller x; to first order in the speed."""
    speed = 1e-5 * SPEED
    body, layer = creeping(A / speed), cs.Boundary(4e-3 * A**2 / DRY.hertz.radius)
    film = between(body, body, mean_speed=speed, slide_roll_ratio=0.0, boundary=layer)
    lubricated = solve_lubricated(film, grid(400, 3.0))
    rolling = replace(film, lubrication=None, rolling=cs.Rolling(speed))
    dry = cs.solve(rolling, grid(400, 3.0), cs.ExactPeriodicity()).pressure[::-1]
    assert np.abs(dry - dry[::-1]).sum() > 0.1 * dry.sum()
    assert np.abs(lubricated.pressure - dry).sum() < 1e-3 * dry.sum()


def test_a_body_that_stands_still_has_crept_and_the_other_creeps_twice_as_fast() -> None:
    body = creeping(A / SPEED)
    sliding = between(body, body, slide_roll_ratio=2.0)
    one_relaxed = between(creeping(2 * A / SPEED), cs.HalfSpace(105e9, 0.3), slide_roll_ratio=0.0)
    film, known = (solve_lubricated(scene, grid(240, 6.0)) for scene in (sliding, one_relaxed))
    assert np.abs(film.pressure - known.pressure).max() < 1e-6 * known.peak_pressure
