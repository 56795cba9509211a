import math
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.scene import ShapesSource, ends_along, sized
from tests.conftest import STEEL, LineContact


@pytest.mark.parametrize("radius", [-0.01, 0.0, math.nan, math.inf, "10 mm", None])
def test_a_bad_radius_is_refused_by_name_and_value(radius: object) -> None:
    with pytest.raises(
        cs.InvalidInput, match=r"^Cylinder\.radius is .*: give a radius above 0 m\.$"
    ):
        cs.Cylinder(radius=radius)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("modulus", "ratio"), [(0.0, 0.3), (-1.0, 0.3), (1e9, 0.51), (1e9, -1.0), (1e9, math.nan)]
)
def test_a_solid_that_cannot_exist_is_refused(modulus: float, ratio: float) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^HalfSpace\."):
        cs.HalfSpace(youngs_modulus=modulus, poisson_ratio=ratio)


def test_two_rigid_bodies_are_refused() -> None:
    rigid = cs.HalfSpace(youngs_modulus=math.inf, poisson_ratio=0.3)
    with pytest.raises(cs.InvalidInput, match="all rigid"):
        cs.Scene(load=cs.LineLoad(1.0), solids=(rigid, rigid))


@pytest.mark.parametrize("solids", [(STEEL,), STEEL, (STEEL, 210e9), ()])
def test_solids_that_are_not_two_bodies_are_refused(solids: object) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.solids"):
        cs.Scene(load=cs.LineLoad(1.0), solids=solids)  # type: ignore[arg-type]


def test_a_rigid_body_adds_no_compliance() -> None:
    rigid = cs.HalfSpace(youngs_modulus=math.inf, poisson_ratio=0.0)
    scene = cs.Scene(load=cs.LineLoad(1.0), solids=(STEEL, rigid))
    assert scene.contact_modulus == pytest.approx(210e9 / (1 - 0.09), rel=1e-15)


def test_shapes_add_up(line_contact: LineContact) -> None:
    halves = replace(line_contact.scene, shapes=(cs.Cylinder(0.02), cs.Cylinder(0.02)))
    grid = line_contact.grid((16, 4), 1.0)
    whole = line_contact.scene.problem(grid, cs.ExactPeriodicity())
    split = halves.problem(grid, cs.ExactPeriodicity())
    np.testing.assert_allclose(split.undeformed_gap, whole.undeformed_gap, rtol=4e-16)
    assert split.scales.length == pytest.approx(whole.scales.length, rel=1e-15)


@pytest.mark.parametrize("kind", [np.int16, np.int64, np.float16, np.float32, int])
def test_numbers_of_any_kind_are_kept_as_floats(kind: type) -> None:
    """Else an int16 would overflow in a formula, and a float32 round it."""
    load = cs.LineLoad(kind(10_000))
    assert type(load.per_length) is float
    assert load.per_length == 10_000.0
    assert type(cs.Cylinder(kind(2)).radius) is float
    assert type(cs.Superposition(np.uint8(3)).images) is int
    hertz = cs.analytic.HertzLine(kind(100), kind(1), kind(1000))
    assert hertz == cs.analytic.HertzLine(100.0, 1.0, 1000.0)


def test_a_number_beyond_floats_is_refused() -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Cylinder\.radius is 1000"):
        cs.Cylinder(10**400)


@pytest.mark.parametrize("shape", [0.01, cs.Cylinder, None])
def test_what_is_no_shape_is_refused(shape: object) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.shapes\[0\] is .*: give a shape"):
        cs.Scene(load=cs.LineLoad(1.0), solids=(STEEL, STEEL), shapes=(shape,))  # type: ignore[arg-type]


def test_what_is_no_grid_is_refused(line_contact: LineContact) -> None:
    with pytest.raises(cs.InvalidInput, match=r"^grid is \(8, 8\): give a Grid\.$"):
        line_contact.scene.problem((8, 8), cs.ExactPeriodicity())  # type: ignore[arg-type]


def test_waves_must_fit_the_period(line_contact: LineContact) -> None:
    grid = cs.Grid(cells=(8, 8), extent=(1e-3, 1e-3))
    wave = cs.Waviness(amplitude=1e-6, across=3e-4, along=2.5e-4, phase=0.3)
    x, y = grid.x[:, None], grid.y
    expected = -1e-6 * np.cos(2 * np.pi * (x / 3e-4 + y / 2.5e-4) + 0.3)
    np.testing.assert_allclose(wave.gap(grid), expected, rtol=0, atol=1e-20)
    with pytest.raises(cs.InvalidInput, match=r"^Waviness\.along is 0\.0003: give a length"):
        replace(wave, along=3e-4).gap(grid)


GRID = cs.Grid((8, 6), (2.0, 3.0))
WAVE, LONG = cs.Waviness(1e-6, across=0.5), cs.Waviness(2e-6, across=0.9, along=1.5)


class Unknown:
    """A shape that names no scales."""

    curvature = 0.0

    def gap(self, grid: cs.Grid) -> np.ndarray:
        return 0 * grid.x[:, None] + 3.0


def source(*shapes: Any) -> ShapesSource:
    return ShapesSource(shapes, ends_along=False, make=lambda grid: grid)  # type: ignore[arg-type,return-value]


def test_the_finest_of_all_counts_and_heights_add_up() -> None:
    both = source(WAVE, LONG)
    assert both.finest == (0.5, 1.5)
    assert both.names_scales
    np.testing.assert_allclose(both.gap(GRID), WAVE.gap(GRID) + LONG.gap(GRID))
    mixed = source(WAVE, Unknown())
    assert mixed.finest == (0.5, inf)
    assert not mixed.names_scales
    # no larger than it must be
    assert mixed.gap(GRID).shape == (8, 1)
    assert source().finest == (inf, inf)
    assert source().gap(GRID).tolist() == [[0.0]] * 8
    assert both.problem(GRID) is GRID


def test_the_heights_of_a_problem_are_not_sampled_again() -> None:
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01), LONG))
    problem = scene.problem(GRID, cs.ExactPeriodicity())
    assert problem.source is not None
    assert problem.source.gap(GRID) is problem.undeformed_gap
    finer = cs.Grid((16, 12), GRID.extent)
    expected = sum(shape.gap(finer) for shape in scene.shapes)
    np.testing.assert_array_equal(problem.source.gap(finer), expected)


@pytest.mark.parametrize(
    ("length", "ends"), [(2.9, True), (3.0, True), (3.0 * (1 + 1e-10), True), (3.01, False)]
)
def test_a_roller_ends_in_the_period_that_holds_it(length: float, ends: bool) -> None:  # noqa: FBT001
    assert ends_along((WAVE, cs.FiniteLength(length)), GRID) == ends
    assert not ends_along((WAVE, Unknown()), GRID)  # type: ignore[arg-type]


def test_heights_given_cell_for_cell_get_the_grid_s_extent() -> None:
    surface = cs.MeasuredSurface(np.eye(8, 6))
    first, second = sized((surface, WAVE), GRID)
    assert first.extent == (2.0, 3.0)  # type: ignore[attr-defined]
    assert second is WAVE


def test_without_a_curved_shape_the_scales_are_the_width_and_the_mean_pressure() -> None:
    """2e5 N/m over 1 mm are 2e8 Pa, of which 2**28 is the nearest power of two."""
    scene = cs.Scene(load=cs.LineLoad(2e5), solids=(STEEL, STEEL))
    scales = scene.scales(cs.Grid((4, 2), (1e-3, 5e-3)))
    assert (scales.length, scales.pressure) == (1e-3, 2.0**28)
    assert scales.gap == pytest.approx(2e8 * 1e-3 / scene.contact_modulus, rel=1e-15)
