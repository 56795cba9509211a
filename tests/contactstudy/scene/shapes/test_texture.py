import math
from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs

DIMPLE = cs.Dimple(depth=5e-6, diameter=1e-4)
GROOVE = cs.Groove(depth=2e-6, width=4e-5)
DIMPLES = cs.Texture(DIMPLE, pitch=(2e-4, 2.5e-4))


def grid(nx: int, ny: int) -> cs.Grid:
    return cs.Grid(cells=(nx, ny), extent=(4e-4, 5e-4))


def test_dimples_repeat_at_their_pitch_and_are_deepest_in_the_middle() -> None:
    depths = DIMPLES.gap(grid(401, 501))
    assert depths[200, 250] == 5e-6
    assert depths.max() == 5e-6
    assert depths.min() == 0
    even = DIMPLES.gap(grid(80, 100))
    np.testing.assert_allclose(even[40:], even[:40], rtol=0, atol=1e-12 * 5e-6)
    np.testing.assert_allclose(even[:, 50:], even[:, :50], rtol=0, atol=1e-12 * 5e-6)


@pytest.mark.parametrize(
    ("profile", "fraction"),
    [("parabolic", 1 / 2), ("cosine", 1 / 2 - 2 / math.pi**2), ("flat", 1.0)],
    ids=repr,
)
def test_dimples_hold_the_volume_of_their_profile(profile: object, fraction: float) -> None:
    """In closed form; a cell on the rim is in or out, so the error of the sum is a part of theirs."""
    texture = replace(DIMPLES, feature=replace(DIMPLE, profile=profile))
    cells = 800
    rim = math.pi * DIMPLE.diameter * math.hypot(4e-4 / cells, 5e-4 / cells)
    area = math.pi * DIMPLE.diameter**2 / 4
    mean = texture.gap(grid(cells, cells)).mean()
    assert mean == pytest.approx(fraction * texture.area_density * 5e-6, rel=rim / area / 2)


def test_a_texture_is_found_by_its_area_density() -> None:
    dimples = cs.Texture.of_density(DIMPLE, 0.2, along=2.5e-4)
    assert dimples.area_density == pytest.approx(0.2, rel=1e-14)
    assert dimples.pitch[1] == 2.5e-4
    grooves = cs.Texture.of_density(GROOVE, 0.2)
    assert grooves.area_density == pytest.approx(0.2, rel=1e-14)
    assert grooves.pitch == pytest.approx((2e-4, math.inf))


def test_grooves_run_along_or_across_the_length() -> None:
    along = cs.Texture(GROOVE, (1e-4, np.inf))
    across = cs.Texture(GROOVE, (np.inf, 1.25e-4))
    assert along.gap(grid(40, 50)).shape == (40, 1)
    depths = across.gap(grid(40, 50))
    assert depths.shape == (40, 50)
    np.testing.assert_array_equal(depths, np.broadcast_to(depths[:1], depths.shape))
    offset = (grid(40, 50).y + 6.25e-5) % 1.25e-4 - 6.25e-5
    expected = np.where(np.abs(offset) < 2e-5, 1e-6 * (1 + np.cos(2 * np.pi * offset / 4e-5)), 0.0)
    np.testing.assert_allclose(depths[0], expected, rtol=0, atol=1e-18)
