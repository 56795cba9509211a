"""Scenes with a lubricant: what is refused, in one sentence, and what an empty slot costs."""

import pytest

import contactstudy as cs
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from tests.contactstudy.lubrication.scenes import by_moes, grid


def test_a_lubricated_scene_is_sent_to_the_solver_of_films() -> None:
    with pytest.raises(cs.InvalidInput, match=r"call contactstudy\.solve"):
        by_moes(20, 5).problem(grid(100, 4.5), cs.ExactPeriodicity())


def test_sliding_speed_is_the_ratio_times_the_mean_speed() -> None:
    contact = solve_lubricated(by_moes(20, 5), grid(64, 4.5))
    assert contact.sliding_speed == pytest.approx(0.1 * contact.mean_speed)


def test_limiting_shear_bounds_the_stress_by_a_share_of_the_pressure() -> None:
    law = cs.LimitingShear(0.05)
    scene = by_moes(20, 10, shear=law)
    contact = solve_lubricated(scene, grid(200, 4.5))
    assert (contact.shear <= 0.05 * contact.pressure).all()
    assert 0.02 < contact.friction < 0.05
