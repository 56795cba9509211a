from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, by_moes, grid

A = DRY.hertz.half_width
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
    found, known = (solve_lubricated(between(b, b), grid(240, 6.0)) for b in (body, elastic))
    assert found.status is cs.Status.CONVERGED
    assert np.abs(found.pressure - known.pressure).max() < 1e-6 * known.peak_pressure
    assert found.film == pytest.approx(known.film, rel=1e-6)


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
    found, known = (solve_lubricated(scene, grid(240, 6.0)) for scene in (sliding, one_relaxed))
    assert np.abs(found.pressure - known.pressure).max() < 1e-6 * known.peak_pressure
