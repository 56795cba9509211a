import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import films_answer
from contactstudy.domain.grid import Array
from contactstudy.evolution.evolve_lubricated import FilmTrajectory, evolve_lubricated
from contactstudy.lubrication.film_equation import FilmEquation
from contactstudy.lubrication.pseudo_time import FilmIteration, iterate
from contactstudy.lubrication.steady_film import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, by_moes, grid, with_motion

A = DRY.hertz.half_width


def rolling(load: float, viscosity: float, *shapes: cs.Shape) -> cs.Scene:
    scene = by_moes(load, viscosity, *shapes)
    return with_motion(scene, slide_roll_ratio=0.0)


def speed_of(scene: cs.Scene) -> float:
    return scene.lubrication.largest_speed


def from_rest(scene: cs.Scene, duration: float, first: float = 1e-3) -> cs.Scene:
    """A fraction of the speed at first, all of it from `duration` on."""
    speed = speed_of(scene)
    history = cs.SpeedHistory((0.0, duration), (first * speed, speed))
    return with_motion(scene, mean_speed=history)


def central_films(evolution: FilmTrajectory) -> Array:
    return np.array([contact.central_film for contact in evolution.contacts])


def test_an_extreme_between_the_instants_is_within_the_bound() -> None:
    """The film lags behind the speed, and is thinnest after the instant at which that is lowest."""
    steady = rolling(20.0, 5.0)
    speed, unit = speed_of(steady), A / speed_of(steady)
    scene = with_motion(steady, mean_speed=cs.SpeedHistory((0.0, unit, 2 * unit), (speed, 0.1 * speed, speed)))
    answers = [
        cs.solve(scene, grid(48, 2.5), times=unit * np.array(times))
        for times in ((0.0, 1.0, 6.0), (0.0, 1.0, 1.5, 2.0, 2.5, 3.0, 6.0))
    ]
    few, many = (answer.quantities["central_film"] for answer in answers)
    assert many.value < 0.7 * few.value
    assert few.value - many.value <= few.bound
    for answer in answers:  # wherever the pressure is highest
        assert answer.error.l1.steps == max(frame.error.l1.steps for frame in answer.frames)


@pytest.mark.whole
def test_a_wave_that_passes_is_reduced_as_known() -> None:
    """At M = 100, L = 10 the central film follows a wave of half a half-width to 0.4398 in pure rolling."""
    cells, smooth = grid(400, 3.0), rolling(100, 10)
    height = 0.1 * solve_lubricated(smooth, cells).central_film
    scene = rolling(100, 10, cs.MovingShape(cs.Waviness(height, across=A / 2, along=np.inf)))
    period = A / 2 / speed_of(scene)
    evolution = evolve_lubricated(scene, cells, times=np.linspace(0, 7 * period, 169), step=period / 48)
    assert {contact.status for contact in evolution.contacts} == {cs.Status.CONVERGED}
    last_wave = [contact.film[199:201].mean() for contact in evolution.contacts[-25:]]
    # two digits: the reference has another grid, whose ratios fall by 2 % with twice the steps
    assert np.ptp(last_wave) / 2 / height == pytest.approx(0.4398, rel=0.02)


@pytest.mark.parametrize("cavitation", [cs.ElrodAdams(), cs.ReynoldsCavitation()])
def test_a_steady_film_stays_as_it_is(cavitation: object) -> None:
    scene = by_moes(20, 5)
    scene = with_motion(scene, cavitation=cavitation)
    times = np.linspace(0, 4 * A / speed_of(scene), 5)
    evolution = evolve_lubricated(scene, grid(100, 4.5), times=times)
    assert central_films(evolution) == pytest.approx(central_films(evolution)[0], rel=1e-6)


def test_a_start_from_rest_and_a_load_that_grows_end_in_the_steady_film() -> None:
    scene, cells = by_moes(20, 5), grid(160, 4.0)
    passage = A / speed_of(scene)
    growing = cs.LoadHistory((0, 2 * passage, 6 * passage, 16 * passage), (1e5, 1e5, 2e5, 2e5))
    times = np.linspace(0, 16 * passage, 9)
    started = central_films(evolve_lubricated(from_rest(scene, 5 * passage), cells, times=times))
    squeezed = central_films(evolve_lubricated(replace(scene, load=growing), cells, times=times))
    light = solve_lubricated(scene, cells).central_film
    heavy = solve_lubricated(replace(scene, load=cs.LineLoad(2e5)), cells).central_film
    assert started[0] < 0.02 * light
    assert (np.diff(started[:4]) > 0).all()
    assert squeezed.max() > 1.01 * squeezed[0]
    assert (started[-1], squeezed[-1]) == pytest.approx((light, heavy), rel=1e-3)


def test_rough_heights_pass_through() -> None:
    smooth = solve_lubricated(by_moes(20, 5), grid(64, 3.0))
    waves = cs.Waviness(0.2 * smooth.central_film, across=A, along=A / 2)
    scene = by_moes(20, 5, cs.MovingShape(waves, body=1))
    times = np.linspace(0, A / speed_of(scene), 3)
    last = evolve_lubricated(scene, grid(64, 3.0, 8), times=times, error=3e-2).contacts[-1]
    assert last.status is not cs.Status.FILM_NOT_CONVERGED
    assert np.ptp(last.film, axis=1).max() > 0


@dataclass(frozen=True)
class Dent:
    """A dent on the axis at first, without length scales."""

    start: float
    curvature: float = 0.0

    def gap(self, grid: cs.Grid) -> Array:
        return 2e-7 * np.exp(-(((grid.x - self.start) / (0.3 * A)) ** 2))[:, None]


def test_what_comes_after_a_long_steady_film_is_followed() -> None:
    dent = by_moes(20, 5, cs.MovingShape(Dent(-32 * A)))
    passage = A / speed_of(dent)
    constant = cs.SpeedHistory((0.0, 40 * passage), (speed_of(dent), speed_of(dent)))
    times = np.linspace(0, 40 * passage, 161)
    evolution = evolve_lubricated(with_motion(dent, mean_speed=constant), grid(64, 4.0), times=times, error=1e-2)
    films = central_films(evolution) / central_films(evolution)[0]
    assert np.ptp(films) > 0.2
    assert films[-1] == pytest.approx(1, rel=1e-2)
    bounds = evolution.time_discretisation_errors
    assert bounds[np.searchsorted(evolution.times, 32 * passage)] > 1e-3


def test_a_film_is_that_before_a_jump_of_the_load_until_the_next_step() -> None:
    scene = by_moes(20, 5)
    passage = A / speed_of(scene)
    times = tuple(n * passage for n in (0, 3, 3, 6))
    jump = replace(scene, load=cs.LoadHistory(times, (1e5, 1e5, 1.5e5, 1.5e5)))
    evolution = evolve_lubricated(jump, grid(64, 4.0), times=np.arange(7) * passage, error=1e-2)
    loads = [contact.load_per_length for contact in evolution.contacts]
    after = [1e5 if time <= times[1] else 1.5e5 for time in evolution.times]
    np.testing.assert_allclose(loads, after, rtol=1e-5)


def test_friction_is_that_of_the_instant() -> None:
    scene = by_moes(20, 0)
    passage = A / speed_of(scene)
    evolution = evolve_lubricated(from_rest(scene, 2 * passage), grid(100, 4.0), times=[0, 2 * passage])
    first = evolution.contacts[0]
    assert first.mean_speed == pytest.approx(1e-3 * speed_of(scene))
    rate = first.sliding_speed * first.film_fraction / first.film
    drag = (0.04 * rate).sum() * first.grid.cell_size[0]
    assert first.friction == pytest.approx(drag / 1e5, rel=1e-6)


def test_a_step_that_fails_ends_the_evolution_at_its_own_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """A load that grows by half until one passage: no film converges from a quarter on."""

    def diverging(equation: FilmEquation, *args: Any, **named: Any) -> FilmIteration:
        last = iterate(equation, *args, **named)
        return replace(last, residual=np.inf) if equation.load > np.pi / 2 / 1.2 else last

    monkeypatch.setattr(sys.modules[evolve_lubricated.__module__], "iterate", diverging)
    passage = A / speed_of(by_moes(20, 5))
    growing = replace(by_moes(20, 5), load=cs.LoadHistory((0, passage), (1e5, 1.5e5)))
    evolution = evolve_lubricated(growing, grid(64, 4.0), times=[0, passage])
    last = evolution.contacts[-1]
    assert last.status is cs.Status.FILM_NOT_CONVERGED
    assert last.load_per_length == pytest.approx(growing.load.at(evolution.times[-1]), rel=1e-4)


def test_the_error_by_the_steps_does_not_depend_on_the_instants_recorded() -> None:
    scene = by_moes(20, 5)
    end = A / speed_of(scene)
    starting = from_rest(scene, end, 0.1)
    exact = evolve_lubricated(starting, grid(96, 3.0), times=[0.0, end], error=1e-5, tolerance=1e-8)
    for times in ([0.0, end], np.linspace(0.0, end, 9)):
        evolution = evolve_lubricated(starting, grid(96, 3.0), times=times, error=1e-2)
        value, reference = (films.contacts[-1].pressure for films in (evolution, exact))
        error = np.abs(value - reference).sum() / reference.sum()
        assert 0 < error < evolution.time_discretisation_errors[-1] + exact.time_discretisation_errors[-1]


def test_films_end_where_a_coating_is_worn_through_with_as_many_errors() -> None:
    coat = cs.CoatedHalfSpace(cs.HalfSpace(600e9, 0.2), 1e-6, cs.HalfSpace(210e9, 0.3))
    scene = by_moes(20, 5)
    film = solve_lubricated(scene, grid(64, 4.0), cs.ExactPeriodicity())
    film = replace(film, scene=replace(scene, solids=(coat, scene.solids[1])))
    films = tuple(replace(film, wear_depth=np.full(film.pressure.shape, depth)) for depth in (0.0, 2e-6, 3e-6))
    found = films_answer(FilmTrajectory((0.0, 1.0, 2.0), films, {}, np.zeros(3)))
    assert found.status is cs.Status.WORN_THROUGH
    assert found.films is not None
    assert len(found.frames) == len(found.films.times) == len(found.films.time_discretisation_errors) == 2
