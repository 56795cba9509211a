from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, by_moes, with_motion

A = DRY.hertz.half_width
UNIT = A**2 / DRY.hertz.radius


def ridges(height: float) -> tuple[cs.Waviness, ...]:
    """Three transverse waves of a ``height`` over a^2 / R."""
    waves = ((0.5, 0.5, 0.3), (0.3, 0.31, 1.1), (0.2, 0.17, 2.0))
    return tuple(cs.Waviness(height * fraction * UNIT, across=wave * A, phase=phase) for fraction, wave, phase in waves)


def mixed(height: float, speed: float, boundary: float | None = 0.004, viscosity: float = 5) -> cs.Scene:
    """Ridges at M = 20, L = ``viscosity`` and a fraction of that ``speed``, on a ``boundary`` film over a^2 / R."""
    scene = by_moes(20, viscosity, *ridges(height), shear=cs.Eyring(5e6))
    layer = None if boundary is None else cs.Boundary(boundary * UNIT, 0.12)
    speed *= scene.lubrication.largest_speed
    return with_motion(scene, mean_speed=speed, boundary=layer)


def grid(cells: int) -> cs.Grid:
    return cs.Grid((cells, 1), (6 * A, 1e-3))


# height, speed: fraction of asperities, mean film in the contact and flow over 1e-3 a^2 / R, friction, from another
# program of the same scheme; all digits
ROWS = (
    (0.06, 0.2, 0.0, 13.362, 11.907, 0.02548),
    (0.06, 0.06, 0.00961, 6.054, 4.700, 0.02495),
    (0.06, 0.02, 0.91651, 5.575, 4.024, 0.10999),
    (0.03, 0.01, 0.97431, 4.018, 4.013, 0.11692),
    (0.06, 0.003, 0.99029, 5.354, 4.028, 0.11884),
)


@pytest.mark.parametrize(("height", "speed", "fraction", "film", "flow", "friction"), ROWS)
def test_load_share_film_flow_and_friction_are_those_of_the_reference(
    height: float, speed: float, fraction: float, film: float, flow: float, friction: float
) -> None:
    contact = solve_lubricated(mixed(height, speed), grid(400))
    inside = np.abs(contact.grid.x) < A
    assert contact.status is cs.Status.CONVERGED
    assert contact.contact_load_fraction == pytest.approx(fraction, abs=1e-5)
    assert contact.film[inside].mean() / UNIT == pytest.approx(1e-3 * film, rel=1e-3)
    assert contact.flow / contact.mean_speed / UNIT == pytest.approx(1e-3 * flow, rel=1e-3)
    # the reference has bodies that do not shear, which here take up a part of the slip
    assert contact.friction == pytest.approx(friction, rel=3e-3)


def test_two_films_on_which_asperities_touch_are_reported_from_either_start() -> None:
    """Another film than from a cold start where the speed falls step by step from 3.3 times this one."""
    slowed = None
    for speed in (0.2, 0.07, 0.06):
        scene = mixed(0.03, speed, viscosity=0)
        slowed = solve_lubricated(scene, grid(400), start=slowed)
    cold = solve_lubricated(scene, grid(400))
    assert slowed.contact_load_fraction > 1.3 * cold.contact_load_fraction
    assert {cold.status, slowed.status} == {cs.Status.SEVERAL_FILMS}


def test_asperities_bear_only_where_the_film_is_the_boundary_film() -> None:
    contact = solve_lubricated(mixed(0.06, 0.06), grid(400))
    touching = contact.contact_pressure > 0
    assert touching.any()
    assert (contact.lubricant_pressure >= 0).all()
    assert contact.film[touching] == pytest.approx(0.004 * UNIT, rel=1e-7)
    assert contact.film.min() >= 0.004 * UNIT * (1 - 1e-7)
    assert contact.minimum_film >= 0.004 * UNIT
    assert contact.flow >= 0.004 * UNIT * contact.mean_speed
    assert contact.load_per_length == pytest.approx(1e5, rel=1e-7)


def test_slower_films_become_the_dry_contact_to_first_order_in_speed() -> None:
    cells, smooth = grid(400), replace(mixed(0.06, 1.0), lubrication=None)
    dry = cs.solve(smooth, cells, cs.ExactPeriodicity(), tolerance=1e-10)
    distances, fractions = [], []
    for speed in (1e-2, 1e-4, 1e-6):
        contact = solve_lubricated(mixed(0.06, speed), cells)
        distances.append(float(np.abs(contact.pressure - dry.pressure).sum() / dry.pressure.sum()))
        fractions.append(1 - contact.contact_load_fraction)
    assert distances == pytest.approx([5.1e-3, 4.7e-5, 4.7e-7], rel=0.02)
    assert fractions[1] / fractions[2] == pytest.approx(100, rel=0.01)


def test_without_contact_the_film_is_that_without_a_boundary_film() -> None:
    both, film = (solve_lubricated(mixed(0.06, 0.2, boundary), grid(400)) for boundary in (0.004, None))
    assert both.contact_load_fraction == 0
    assert film.contact_pressure is None
    assert np.abs(both.pressure - film.pressure).max() <= 1e-10 * film.peak_pressure
    assert both.friction == pytest.approx(film.friction, rel=1e-10)


def test_asperities_that_do_not_touch_have_a_bound_where_the_film_is_clear_of_them() -> None:
    """A boundary film of a fraction of the minimum film, which is known to a few percent."""
    scene, cells = by_moes(20, 5), cs.Grid((200, 1), (9 * A, 1e-3))
    lowest = solve_lubricated(scene, cells).minimum_film
    for fraction, bound in ((0.5, 0.0), (0.97, np.inf)):
        contact = solve_lubricated(with_motion(scene, boundary=cs.Boundary(fraction * lowest)), cells)
        assert contact.contact_load_fraction == 0
        assert film_answer(contact).quantities["contact_load_fraction"].bound == bound


def test_a_slow_rough_film_becomes_the_dry_contact_along_the_length() -> None:
    rough = cs.Roughness(0.03 * UNIT, hurst=0.8, roll_off=A, cut_off=A / 4, seed=1)
    scene, cells = replace(mixed(0.06, 1.0), shapes=(DRY.shapes[0], rough)), cs.Grid((64, 16), (6 * A, 2 * A))
    dry = cs.solve(replace(scene, lubrication=None), cells, tolerance=1e-10)
    slower = with_motion(scene, mean_speed=1e-3 * scene.lubrication.largest_speed)
    contact = solve_lubricated(slower, cells, controls=FilmControls(tolerance=1e-7))
    assert contact.status is not cs.Status.FILM_NOT_CONVERGED
    assert contact.film[contact.contact_pressure > 0] == pytest.approx(0.004 * UNIT, rel=1e-6)
    assert np.abs(contact.pressure - dry.pressure).sum() < 1e-3 * dry.pressure.sum()
