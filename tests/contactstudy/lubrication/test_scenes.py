"""Scenes with a lubricant: what is refused, in one sentence, and what an empty slot costs."""

from dataclasses import replace

import pytest

import contactstudy as cs
from contactstudy.lubrication.solve_lubricated import film_grid, solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, by_moes, grid

OIL = cs.Lubricant(0.04, 2e-8)
MOTION = cs.Lubrication(OIL, 1.0)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"rolling": cs.Rolling(1.0)}, "Scene.rolling is not supported"),
        ({"friction": cs.Sliding(0.1)}, "Scene.friction is not supported"),
        ({"hardness": 2e9}, "Scene.hardness is not supported"),
        ({"lubrication": OIL}, "give a Lubrication, or None"),
    ],
)  # fmt: skip
def test_an_effect_that_is_not_known_with_a_film_is_refused(
    changed: dict[str, object], message: str
) -> None:
    with pytest.raises(cs.InvalidInput, match=message):
        replace(DRY, **{"lubrication": MOTION, **changed})  # type: ignore[arg-type]


def test_a_dry_scene_is_sent_to_the_dry_solver_and_a_lubricated_one_to_this() -> None:
    with pytest.raises(cs.InvalidInput, match=r"or call contactstudy\.solve"):
        solve_lubricated(DRY)
    with pytest.raises(cs.InvalidInput, match=r"call contactstudy\.solve"):
        by_moes(20, 5).problem(grid(100, 4.5), cs.ExactPeriodicity())


def test_a_flat_contact_has_no_inlet() -> None:
    with pytest.raises(cs.NotDefined, match="no inlet draws lubricant in"):
        solve_lubricated(replace(DRY, shapes=(), lubrication=MOTION), grid(100, 4.5))


def test_a_padding_that_ends_along_the_length_is_refused() -> None:
    with pytest.raises(cs.InvalidInput, match="periodic along the length"):
        solve_lubricated(by_moes(20, 5), grid(32, 4.5, 4), cs.ZeroPadding())


def test_sliding_speed_is_the_ratio_times_the_mean_speed() -> None:
    contact = solve_lubricated(by_moes(20, 5), grid(64, 4.5))
    assert contact.sliding_speed == pytest.approx(0.1 * contact.mean_speed)


def test_limiting_shear_bounds_the_stress_by_a_share_of_the_pressure() -> None:
    law = cs.LimitingShear(0.05)
    scene = by_moes(20, 10, shear=law)
    contact = solve_lubricated(scene, grid(200, 4.5))
    assert (contact.shear <= 0.05 * contact.pressure).all()
    assert 0.02 < contact.friction < 0.05


@pytest.mark.parametrize("error", [0, -1, float("nan"), "a"])
def test_a_grid_for_an_error_that_is_none_is_refused(error: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"film_grid\.error is .*: give one above 0"):
        film_grid(by_moes(20, 5), error)


def test_cells_wider_than_the_contact_are_refused() -> None:
    with pytest.raises(cs.InvalidInput, match="wider than half the contact: give 18"):
        solve_lubricated(by_moes(20, 5), grid(12, 9.0))
