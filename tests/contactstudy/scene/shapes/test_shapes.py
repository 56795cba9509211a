from dataclasses import replace
from math import inf, pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.shapes.shape import LengthScales
from tests.conftest import STEEL, LineContact


def measured(shape: Any, grid: cs.Grid) -> tuple[float, float]:
    """The highest above the mean, and the rms slope, of heights (a gap counts the other way)."""
    heights = -np.broadcast_to(shape.gap(grid), grid.cells)
    slopes = [
        (np.roll(heights, -1, axis) - heights) / step if count > 1 else np.zeros(1)
        for axis, (count, step) in enumerate(zip(grid.cells, grid.cell_size, strict=True))
    ]
    rms = np.sqrt(sum((one**2).mean() for one in slopes))
    return float(heights.max() - heights.mean()), float(rms)


FINE = cs.Grid((512, 512), (2.0, 3.0))


@pytest.mark.parametrize(("across", "along"), [(0.5, inf), (inf, 0.75), (0.5, 0.75), (2.0, 0.3)])
def test_a_wave_has_its_lengths_its_amplitude_and_its_slope(across: float, along: float) -> None:
    wave = cs.Waviness(0.01, across=across, along=along, phase=0.3)
    height, slope = measured(wave, FINE)
    scales = wave.length_scales
    assert scales.shortest_wavelengths == (across, along)
    assert scales.period == (along if along < inf else 0.0)
    # a difference over a step is less than a slope by (2 pi step / length)^2 / 24
    assert scales.height == pytest.approx(height, rel=1e-3)
    assert scales.slope == pytest.approx(slope, rel=2e-3)
    assert (scales.longest_wavelength, scales.roller, scales.known_width) == (0.0, 0.0, inf)
    assert cs.Waviness(0.0, across=across).length_scales == LengthScales()


def test_a_wave_s_heights_are_those_of_its_cosine() -> None:
    grid = cs.Grid((7, 6), (2.0, 3.0))
    wave = cs.Waviness(0.01, across=0.9, along=1.5, phase=0.4)
    x, y = grid.x[:, None], grid.y
    wanted = -0.01 * np.cos(2 * pi * (x / 0.9 + y / 1.5) + 0.4)
    np.testing.assert_allclose(wave.gap(grid), wanted, atol=1e-15)


@pytest.mark.parametrize(
    ("feature", "pitch", "finest", "slope"),
    [
        # lands of a fifth between dimples of 0.3, on which pi 0.15^2 of 0.5 x 0.75 is textured
        (
            cs.Dimple(0.01, 0.3), (0.5, 0.75), (0.2, 0.3),
            2 * 0.01 / 0.3 * (pi * 0.15**2 / (0.5 * 0.75)) ** 0.5,
        ),
        (cs.Groove(0.01, 0.3), (0.5, inf), (0.2, inf), 2 * 0.01 / 0.3 * 0.6**0.5),
        (cs.Groove(0.02, 0.1), (inf, 0.75), (inf, 0.1), 2 * 0.02 / 0.1 * (0.1 / 0.75) ** 0.5),
    ],
)  # fmt: skip
def test_a_texture_is_as_fine_as_its_features_and_lands(
    feature: Any, pitch: tuple[float, float], finest: tuple[float, float], slope: float
) -> None:
    scales = cs.Texture(feature, pitch).length_scales
    assert scales.shortest_wavelengths == pytest.approx(finest)
    assert scales.period == (pitch[1] if pitch[1] < inf else 0.0)
    assert scales.slope == pytest.approx(slope)
    assert (scales.height, scales.roller) == (0.0, 0.0)


@pytest.mark.parametrize("peklenik", [0.5, 1.0, 2.0])
def test_a_rough_surface_has_its_waves_by_its_lay_and_its_slope(peklenik: float) -> None:
    shape = cs.Roughness(0.01, hurst=0.7, roll_off=0.5, cut_off=0.05, seed=3, peklenik=peklenik, extent=(2.0, 3.0))
    scales = shape.length_scales
    wide, long = max(peklenik, 1), max(1 / peklenik, 1)
    assert scales.shortest_wavelengths == pytest.approx((0.05 * wide, 0.05 * long))
    assert (scales.period, scales.longest_wavelength) == pytest.approx((3.0, 0.5 * long))
    # four times the rms height, of some hundred waves a side
    height, slope = measured(shape, FINE)
    assert scales.height == pytest.approx(0.04)
    assert 0.5 * scales.height < height < 1.25 * scales.height
    # one sample, of which a difference over a tenth of the finest wave sees all but a few hundredths
    assert scales.slope == pytest.approx(slope, rel=0.1)
    by_slope = cs.Roughness(
        cs.RmsSlope(scales.slope), hurst=0.7, roll_off=0.5, cut_off=0.05, seed=3, peklenik=peklenik
    ).length_scales
    assert by_slope.height == pytest.approx(0.04)
    assert by_slope.period == 0
    assert cs.Roughness(0.0, hurst=0.7, roll_off=0.5, cut_off=0.05, seed=3).length_scales == LengthScales()


def test_a_measured_surface_is_as_fine_as_two_points_and_as_wide_as_it_is() -> None:
    heights = np.random.default_rng(0).standard_normal((8, 6))
    surface = cs.MeasuredSurface(heights, extent=(4.0, 1.5), seam=cs.Mirrored())
    scales = surface.length_scales
    assert scales.shortest_wavelengths == (1.0, 0.5)
    assert (scales.period, scales.known_width) == (3.0, 4.0)
    assert scales.height == pytest.approx(heights.max() - heights.mean())
    across, along = np.diff(heights, axis=0) / 0.5, np.diff(heights, axis=1) / 0.25
    assert scales.slope == pytest.approx(np.sqrt((across**2).mean() + (along**2).mean()))
    bare = cs.MeasuredSurface(heights).length_scales
    assert bare == LengthScales(height=scales.height)
    profile = cs.MeasuredSurface(heights[:, :1], extent=(4.0, 1.5)).length_scales
    assert (profile.shortest_wavelengths, profile.period) == ((1.0, inf), 0.0)


def test_rollers_say_their_length() -> None:
    assert cs.FiniteLength(2.0).length_scales == LengthScales(roller=2.0)
    assert cs.Crown(5.0).length_scales == LengthScales(roller=inf)
    assert cs.Crown(5.0, 0.01).length_scales == LengthScales(roller=0.01)
    assert cs.Tilt(1e-3).length_scales == LengthScales(roller=inf)
    assert cs.Tilt(0.0).length_scales == LengthScales()
    assert cs.Crown(inf).length_scales == LengthScales()
    for straight in (cs.Crown(length=0.01), cs.Crown.of_drop(0.0, 0.01)):
        assert straight.length_scales == LengthScales(roller=0.01)
    assert cs.Sphere(1.0).length_scales == LengthScales(roller=inf)
    assert cs.LundbergProfile(1e-6, 1e-5, 2.0).length_scales == LengthScales(roller=2.0)


def test_round_bodies_and_ends_have_their_heights() -> None:
    grid = cs.Grid((4, 3), (4.0, 6.0))
    x, y = np.array([-1.5, -0.5, 0.5, 1.5]), np.array([-2.0, 0.0, 2.0])
    assert cs.Cylinder(5.0).gap(grid) == pytest.approx((x**2 / 10)[:, None])
    assert cs.Sphere(5.0).gap(grid) == pytest.approx((x[:, None] ** 2 + y**2) / 10)
    assert cs.Crown(5.0).gap(grid) == pytest.approx((y**2 / 10)[None])
    # 4 m long: the middle cell and those whose centres lie on the ends
    assert cs.FiniteLength(4.0).gap(grid).tolist() == [[0.0]] * 4
    assert cs.FiniteLength(3.9).gap(grid).tolist() == [[3.9, 0.0, 3.9]]
    # cells of 2 m, of which 0.95 m lie on the roller: the cell in the middle stands for them
    assert cs.FiniteLength(3.9).covered_fractions(grid) == pytest.approx([0.0, 1.95, 0.0])
    assert cs.FiniteLength(4.4).covered_fractions(grid) == pytest.approx([0.6, 1.0, 0.6])
    assert cs.FiniteLength(6.0).covered_fractions(grid).tolist() == [1.0] * 3


def test_a_cylinder_alone_is_curved_across_as_a_line_contact() -> None:
    assert cs.Cylinder(5.0).curvature == 0.2
    straight = (cs.Sphere(5.0), cs.Crown(5.0), cs.Tilt(0.01), cs.Roughness(1e-7, 0.8, 1e-4, 3e-5))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(5.0), *straight))
    assert scene.radius == 5.0


FREE = (cs.ZeroPadding(), cs.ZeroPadding())


def solved(contact: LineContact, cells: int, period: float, *more: cs.Shape) -> cs.Solution:
    """A roller 8 half-widths long under a load that is the same in all."""
    scene = replace(contact.scene, shapes=contact.scene.shapes + more)
    grid = contact.grid((32, cells), period, width=3.0)
    return cs.solve(scene.problem(grid, FREE), tolerance=1e-9)


def test_a_roller_longer_than_the_grid_has_no_end(line_contact: LineContact) -> None:
    length = 8 * line_contact.hertz.half_width
    ended = solved(line_contact, 64, 8.0, cs.FiniteLength(length))
    np.testing.assert_array_equal(ended.pressure, solved(line_contact, 64, 8.0).pressure)


def test_a_roller_ends_within_a_grid_as_at_the_end_of_one(line_contact: LineContact) -> None:
    """Both stop at a residual of 1e-9, whose error is no more than its root."""
    length = 8 * line_contact.hertz.half_width
    own = solved(line_contact, 64, 8.0)
    longer = solved(line_contact, 96, 12.0, cs.FiniteLength(length))
    assert longer.status is cs.Status.CONVERGED
    assert not longer.pressure[:, :16].any()
    assert not longer.pressure[:, -16:].any()
    np.testing.assert_allclose(longer.pressure[:, 16:-16], own.pressure, rtol=0, atol=3e-5 * own.pressure.max())


def test_the_mean_gap_is_that_of_the_roller_and_not_of_the_grid_beyond_its_ends(
    line_contact: LineContact,
) -> None:
    """Also where the ends lie inside cells: the grid of 12 half-widths has cells of 0.125 and 0.1263 half-widths."""
    length = 8 * line_contact.hertz.half_width
    own = solved(line_contact, 64, 8.0).mean_gap
    assert solved(line_contact, 96, 12.0, cs.FiniteLength(length)).mean_gap == pytest.approx(own, rel=1e-4)
    divided = solved(line_contact, 95, 12.0, cs.FiniteLength(length))
    assert divided.problem.covered_fractions.sum() * 12 / 95 == pytest.approx(8)
    # the pressure ends at the border of a cell, up to half a cell from the end
    assert divided.mean_gap == pytest.approx(own, rel=0.126 / 8)
    # the rows beyond the ends are recessed by the roller's length
    assert divided.gap.mean() > 100 * own
