"""Heights of round bodies, waves, textures and a user's own shapes, and the scales that a grid has to resolve."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import hypot, inf, nan, pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.shapes.shape import LengthScales, MovingShape, left_out
from tests.conftest import STEEL

FINE = cs.Grid((512, 512), (2.0, 3.0))
DIMPLE = cs.Dimple(depth=5e-6, diameter=1e-4)
GROOVE = cs.Groove(depth=2e-6, width=4e-5)
DIMPLES = cs.Texture(DIMPLE, pitch=(2e-4, 2.5e-4))


def height_and_slope(shape: Any) -> tuple[float, float]:
    """The highest above the mean, and the rms slope, of heights (a gap counts the other way)."""
    heights = -np.broadcast_to(shape.gap(FINE), FINE.cells)
    slopes = [(np.roll(heights, -1, axis) - heights) / step for axis, step in enumerate(FINE.cell_size)]
    return float(heights.max() - heights.mean()), float(np.sqrt(sum((slope**2).mean() for slope in slopes)))


def test_round_bodies_have_their_heights_and_curvatures_across_add() -> None:
    grid, x, y = cs.Grid((4, 3), (4.0, 6.0)), np.array([-1.5, -0.5, 0.5, 1.5])[:, None], np.array([-2.0, 0.0, 2.0])
    assert cs.Cylinder(5.0).gap(grid) == pytest.approx(x**2 / 10)
    assert cs.Sphere(5.0).gap(grid) == pytest.approx((x**2 + y**2) / 10)
    straight = (cs.Sphere(5.0), cs.Crown(5.0), cs.Tilt(0.01), cs.Roughness(1e-7, 0.8, 1e-4, 3e-5))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(5.0), cs.Cylinder(-10.0), *straight))
    assert scene.radius == pytest.approx(10.0)


@pytest.mark.parametrize("waves", [1, 8, 16, 64])
def test_one_row_of_cells_is_warned_of_waves_along_the_length(waves: int) -> None:
    row = cs.Grid((4, 1), (4.0, 6.0))
    assert len(list(left_out([cs.Waviness(0.01, along=6.0 / waves)], row))) == 1
    assert not list(left_out([cs.Waviness(0.01, across=1.0)], row))


@pytest.mark.parametrize(("across", "along"), [(0.5, inf), (inf, 0.75), (2.0, 0.3)])
def test_a_wave_is_a_cosine_with_its_lengths_and_its_amplitude(across: float, along: float) -> None:
    wave = cs.Waviness(0.01, across=across, along=along, phase=0.3)
    expected = -0.01 * np.cos(2 * pi * (FINE.x[:, None] / across + FINE.y / along) + 0.3)
    np.testing.assert_allclose(np.broadcast_to(wave.gap(FINE), FINE.cells), expected, atol=1e-15)
    scales = wave.length_scales
    assert scales.shortest_wavelengths == (across, along)
    assert scales.period == (along if along < inf else 0.0)
    assert scales.height == pytest.approx(-expected.min(), rel=2e-3)


@pytest.mark.parametrize("peklenik", [0.5, 2.0])
def test_a_rough_surface_has_its_waves_by_its_lay_and_its_slope(peklenik: float) -> None:
    shape = cs.Roughness(0.01, hurst=0.7, roll_off=0.5, cut_off=0.05, seed=3, peklenik=peklenik, extent=(2.0, 3.0))
    scales = shape.length_scales
    wide, long = max(peklenik, 1), max(1 / peklenik, 1)
    assert scales.shortest_wavelengths == pytest.approx((0.05 * wide, 0.05 * long))
    assert (scales.period, scales.longest_wavelength) == pytest.approx((3.0, 0.5 * long))
    # four times the rms height, of some hundred waves a side
    height, slope = height_and_slope(shape)
    assert scales.height == pytest.approx(0.04)
    assert 0.5 * scales.height < height < 1.25 * scales.height
    # one sample, of which a difference over a tenth of the finest wave sees all but a few hundredths
    assert replace(shape, rms=cs.RmsSlope(slope)).length_scales.height == pytest.approx(0.04, rel=0.1)


def test_a_measured_surface_is_as_fine_as_two_points_and_as_wide_as_it_is() -> None:
    heights = np.random.default_rng(0).standard_normal((8, 6))
    scales = cs.MeasuredSurface(heights, extent=(4.0, 1.5), seam=cs.Mirrored()).length_scales
    assert scales.shortest_wavelengths == (1.0, 0.5)
    assert (scales.period, scales.known_width) == (3.0, 4.0)
    assert scales.height == pytest.approx(heights.max() - heights.mean())
    assert cs.MeasuredSurface(heights).length_scales == LengthScales(height=scales.height)
    profile = cs.MeasuredSurface(heights[:, :1], extent=(4.0, 1.5)).length_scales
    assert (profile.shortest_wavelengths, profile.period) == ((1.0, inf), 0.0)


def test_a_texture_is_as_fine_as_its_features_and_lands() -> None:
    scales = cs.Texture(cs.Dimple(0.01, 0.3), (0.5, 0.75)).length_scales  # lands of a fifth between
    assert scales.shortest_wavelengths == pytest.approx((0.2, 0.3))
    assert scales.period == 0.75
    assert cs.Texture(cs.Groove(0.02, 0.1), (inf, 0.75)).length_scales.shortest_wavelengths == (inf, 0.1)


@pytest.mark.parametrize(
    ("profile", "fraction"), [("parabolic", 1 / 2), ("cosine", 1 / 2 - 2 / pi**2), ("flat", 1.0)], ids=repr
)
def test_dimples_repeat_and_hold_the_volume_of_their_profile(profile: object, fraction: float) -> None:
    """In closed form; a cell on the rim is in or out, so the error of the sum is a part of theirs."""
    texture, cells = replace(DIMPLES, feature=replace(DIMPLE, profile=profile)), 800
    depths = texture.gap(cs.Grid((cells, cells), (4e-4, 5e-4)))
    rim = pi * DIMPLE.diameter * hypot(4e-4 / cells, 5e-4 / cells)
    area = pi * DIMPLE.diameter**2 / 4
    assert depths.mean() == pytest.approx(fraction * texture.area_density * 5e-6, rel=rim / area / 2)
    assert depths[400, 400] == pytest.approx(5e-6, rel=1e-3)
    np.testing.assert_allclose(depths, np.roll(depths, 400, (0, 1)), rtol=0, atol=1e-12 * 5e-6)


def test_grooves_run_along_or_across_the_length() -> None:
    grid = cs.Grid((40, 50), (4e-4, 5e-4))
    assert cs.Texture(GROOVE, (1e-4, inf)).gap(grid).shape == (40, 1)
    depths = cs.Texture(GROOVE, (inf, 1.25e-4)).gap(grid)
    offset = (grid.y + 6.25e-5) % 1.25e-4 - 6.25e-5
    expected = np.where(np.abs(offset) < 2e-5, 1e-6 * (1 + np.cos(2 * pi * offset / 4e-5)), 0.0)
    np.testing.assert_allclose(depths, np.broadcast_to(expected, grid.cells), rtol=0, atol=1e-18)


def test_measured_heights_move_to_larger_x_and_are_cubic_splines_between_cells() -> None:
    """B-splines at integers and half-way between them, of a wave with the angle t from cell to cell."""
    grid, t = cs.Grid((16, 3), (4.0, 3.0)), 2 * np.pi * 3 / 16
    heights, step = np.random.default_rng(5).standard_normal(grid.cells), grid.cell_size[0]
    moved = MovingShape(cs.MeasuredSurface(heights)).gap_after(grid, 2 * step)
    np.testing.assert_allclose(moved, np.roll(-heights, 2, axis=0), rtol=0, atol=1e-13)
    wave = np.cos(t * np.arange(16))[:, None] * np.ones(3)
    moved = MovingShape(cs.MeasuredSurface(-wave)).gap_after(grid, step / 2)
    factor = (23 * np.cos(t / 2) + np.cos(3 * t / 2)) / 24 / ((2 + np.cos(t)) / 3)
    expected = factor * np.cos(t * (np.arange(16) - 0.5))
    assert moved == pytest.approx(expected[:, None] * np.ones(3), abs=1e-13)


@dataclass(frozen=True)
class Own:
    """A shape of the user's own."""

    heights: Callable[[cs.Grid], Any]
    curvature: Any = 0.0

    def gap(self, grid: cs.Grid) -> Any:
        return self.heights(grid)


def solved(own: Own) -> cs.Solution:
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), own))
    return cs.solve(scene.problem(cs.Grid((48, 12), (3e-4, 1e-4)), cs.ExactPeriodicity()))


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("own", "message"),
    [
        (Own(lambda grid: np.zeros(grid.cells).T), r"Own\.gap has the shape \(12, 48\) and .*: return real heights"),
        (Own(lambda grid: np.ma.masked_less(grid.x, 0)[:, None]), r"is not finite at 24 points"),
        (Own(lambda grid: np.zeros(grid.cells), nan), r"^Scene\.shapes\[1\]\.curvature is "),
    ],
)
def test_what_is_no_height_or_no_curvature_is_refused(own: Own, message: str) -> None:
    with pytest.raises(cs.InvalidInput, match=message):
        solved(own)
