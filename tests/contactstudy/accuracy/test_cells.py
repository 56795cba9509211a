"""Errors due to the cells: edges inside them, areas, and the same contact on larger ones."""

from dataclasses import replace
from math import log
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.coarser import (
    coarse_solution,
    coarser_problem,
    contact_perimeter,
    discretisation_errors,
    edge_error,
    straight_edges,
    unseen_area_error,
)
from contactstudy.accuracy.hidden_heights import HiddenHeights
from contactstudy.io.quantities.quantity import Quantity
from tests.conftest import LineContact

GRID = cs.Grid((4, 5), (4 * 2.0, 5 * 3.0))  # a cell is 2 m across and 3 m along
EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()


@pytest.mark.parametrize(("cells", "largest"), [(24, 2e-3), (96, 1e-4)])
def test_the_half_width_lies_inside_its_cells_wherever_the_edge_does(
    cells: int, largest: float, line_contact: LineContact
) -> None:
    """Widths that move the edge through a cell and more."""
    true = line_contact.hertz.half_width
    for width in 2.4 + 6.4 / cells * np.linspace(0, 1, 9):
        found = cs.solve(line_contact.scene, line_contact.grid((cells, 1), 2.4, width), EXACT).quantities["half_width"]
        assert abs(found.value - true) <= found.bound
        assert abs(found.value / true - 1) < largest
        assert found.relative_bound < 5 * largest


def test_edges_of_few_or_separate_cells_are_not_known() -> None:
    gap = np.ones((40, 3))
    gap[[0, 20, -1]] = 0.0
    for pressure in (np.pad(np.ones((2, 1)), ((3, 3), (0, 0))), gap, np.ones((40, 3))):
        assert straight_edges(pressure) is None


@pytest.mark.parametrize(
    ("flat", "rounding", "cells"), [(1e-4, 3e-3, 20), (1e-4, 1e-3, 36), (1e-4, 1e-3, 24), (8e-5, 1e-3, 20)]
)
def test_area_and_peak_of_a_flat_with_rounded_edges_are_bounded_where_the_pressure_rises_up_to_them(
    flat: float, rounding: float, cells: int
) -> None:
    x = np.r_[0, np.linspace(flat, 2e-4, 60)]
    profile = cs.ProfilePoints(tuple(x), tuple(np.maximum(x - flat, 0) ** 2 / 2 / rounding), axis="across")
    steel = cs.HalfSpace(210e9, 0.3)
    scene = cs.Scene(cs.LineLoad(3e4), (steel, steel), (profile,))
    found, fine = (cs.solve(scene, cs.Grid((n, 1), (4e-4, 4e-4)), EXACT).quantities for n in (cells, 16 * cells))
    for name in ("contact_area", "peak_pressure"):
        assert abs(found[name].value - fine[name].value) <= found[name].bound


def test_the_half_width_is_bounded_where_an_outer_island_lies_between_the_cells() -> None:
    shapes = cs.Cylinder(0.054), cs.Texture(cs.Groove(2e-6, 0.317e-3, "parabolic"), (0.841e-3, np.inf))
    scene = cs.Scene(cs.LineLoad(1.7e6), (cs.HalfSpace(125e9, 0.35), cs.HalfSpace(np.inf, 0.3)), shapes)
    found, fine = (cs.solve(scene, cs.Grid((n, 1), (3.44e-3, 1e-3)), EXACT).quantities["half_width"] for n in (38, 608))
    assert fine.value / found.value > 1.2
    assert fine.value - found.value <= found.bound


def test_the_edge_error_is_the_largest_of_edges_nearby(line_contact: LineContact) -> None:
    """The law holds to the order of cell over half-width, 1 / 100; its leap makes it larger, not smaller."""
    hertz, found = line_contact.hertz, []
    for width in np.linspace(2.4, 2.45, 40):
        grid = line_contact.grid((256, 1), 1.0, width)
        pressure = cs.solve(line_contact.scene.problem(grid, EXACT), tolerance=1e-11).pressure
        touching = np.flatnonzero(pressure[:, 0])
        beside = pressure[touching[-1] - np.arange(16), 0]
        true = hertz.pressure(grid.x[touching[-1] - np.arange(16)])
        found.append(edge_error(beside[:1], beside[1:2])[0] / np.abs(beside - true).sum())
    assert min(found) > 0.98
    assert np.median(found) < 1.5


def test_within_the_contact_a_cell_s_mean_is_a_12th_of_the_second_difference_aside() -> None:
    """Of a wave without an edge: ``2 - 2 cos(2 pi / n)`` of its height, whose mean size is 2 / pi."""
    cells = 64
    wave = 3 + np.cos(2 * np.pi * np.arange(cells) / cells)[:, None]
    _, (l1, along) = discretisation_errors(wave, (True, True))
    assert along == 0
    # the mean over cells is the integral's up to the square of a cell
    bend = 2 - 2 * np.cos(2 * np.pi / cells)
    assert l1 == pytest.approx(bend * 2 / np.pi / 12 / 3, rel=1 / cells)
    assert discretisation_errors(np.ones((6, 5)), (False, True)) == (0.0, (0.0, 0.0))


def test_heights_of_a_problem_are_averaged_over_larger_cells(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((16, 8), 1.2), EXACT)
    added = np.random.default_rng(0).normal(scale=1e-7, size=(16, 8))
    rough = replace(problem, undeformed_gap=problem.undeformed_gap + added)
    smooth, coarse = coarser_problem(problem), coarser_problem(rough)
    means = added.reshape(8, 2, 4, 2).mean(axis=(1, 3))
    assert coarse.undeformed_gap - smooth.undeformed_gap == pytest.approx(means, rel=1e-6)


def test_a_problem_keeps_its_own_limits_and_load_on_larger_cells(line_contact: LineContact) -> None:
    scene, grid = line_contact.scene, line_contact.grid((33, 1), 1.0, width=6.0)
    hardness = line_contact.hertz.peak_pressure
    plain = scene.problem(grid, EXACT)
    changed = replace(plain, control=plain.control.scaled(3), constraint=cs.Constraint(hardness))
    named = replace(scene, load=cs.LineLoad(3e5), hardness=hardness).problem(grid, EXACT)
    ours, theirs = (coarse_solution(problem) for problem in (changed, named))
    np.testing.assert_allclose(ours.pressure, theirs.pressure, rtol=1e-9)


@pytest.mark.parametrize(
    ("paddings", "round_the_ends"), [((FREE, FREE), 0), ((EXACT, FREE), 3), ((FREE, cs.DuplicatedPadding()), 4)]
)
def test_a_perimeter_counts_the_edges_of_cells_round_the_ends_that_repeat(
    paddings: cs.Paddings, round_the_ends: float
) -> None:
    """Two cells in the corner, one behind the other along x, and one alone in the middle."""
    touching = np.zeros(GRID.cells, dtype=bool)
    touching[0, 0] = touching[1, 0] = touching[2, 3] = True
    # along x an edge is 3 m: one behind the two, and two of the one; along y it is 2 m: two and two
    assert contact_perimeter(touching, GRID, paddings) == 3 * 3 + 2 * 4 + round_the_ends


def test_the_area_of_alike_islands_lies_within_its_bound_on_every_grid() -> None:
    """The edges of an egg-box wave are mirrored and repeated, so that their errors are alike."""
    modulus, wavelength, amplitude = 2e11, 1e-4, 1e-7
    wave = cs.Waviness(amplitude, across=wavelength, along=wavelength)
    load = cs.LineLoad(0.2 * np.pi * modulus * amplitude)
    scene = cs.Scene(load, (cs.HalfSpace(modulus, 0.0), cs.HalfSpace(np.inf, 0.0)), (wave,))

    def area(cells: int) -> Quantity:
        grid = cs.Grid((cells, cells), (wavelength, wavelength))
        return cs.solve(scene, grid, (EXACT, EXACT)).quantities["contact_area"]

    # their errors cancel over grids that lie differently
    true = np.mean([area(cells).value for cells in range(111, 132, 5)])
    for found in map(area, range(24, 97, 6)):
        assert abs(found.value - true) < found.bound < found.value


@pytest.mark.parametrize(("cells", "load"), [(24, 0.9975), (30, 0.9778), (32, 0.99837), (64, 0.99837)])
def test_the_area_of_a_wave_nearly_in_full_contact_is_known_to_its_narrow_openings(cells: int, load: float) -> None:
    """Westergaard: the contact covers 2 / pi asin(sqrt(p / p*)) of a wave."""
    modulus, wavelength, amplitude = 2e11, 1e-4, 1e-8
    pressed = cs.LineLoad(load * np.pi * modulus * amplitude)
    wave = cs.Waviness(amplitude, across=wavelength)
    scene = cs.Scene(pressed, (cs.HalfSpace(modulus, 0.0), cs.HalfSpace(np.inf, 0.0)), (wave,))
    found = cs.solve(scene, cs.Grid((cells, 1), (wavelength, 1e-4)), (EXACT, EXACT)).quantities["contact_fraction"]
    assert abs(found.value - 2 / np.pi * np.arcsin(load**0.5)) < found.bound < 0.15


def test_edges_beside_a_layer_of_few_cells_are_known_less_than_those_of_a_half_space() -> None:
    """Places by two pairs of cells agree by chance where a hard coat is 0.16 cells thick."""
    coated = cs.CoatedHalfSpace(cs.HalfSpace(2.424e12, 0.4749), 4.934e-7, cs.HalfSpace(276.6e9, 0.2145))
    scene = cs.Scene(cs.LineLoad(155458.0), (coated, cs.HalfSpace(np.inf, 0.3)), (cs.Cylinder(4.6924e-3),))
    coarse, fine = (cs.solve(scene, cs.Grid((n, 1), (1.44248e-4, 1e-4)), EXACT).quantities for n in (48, 768))
    for name in ("contact_area", "half_width"):
        assert abs(coarse[name].value - fine[name].value) < coarse[name].bound < 0.1 * coarse[name].value


def test_a_corner_raises_pressure_by_its_slope_at_each_halving(line_contact: LineContact) -> None:
    """By ``E* / (2 pi) slope ln 2`` of cells, whose waves of alternating pressure are stiffer than E* by pi / (4 G).

    These are waves of 4 / (pi n), n odd, each with a compliance of 2 dx / (pi n E*): G is Catalan's 1 - 1/9 + 1/25 ...
    """
    problem = line_contact.scene.problem(line_contact.grid((16, 1), 1.0), (EXACT, EXACT))
    pressure = np.zeros((16, 1))
    pressure[6:10] = 1e9

    def corner_rise(place: float) -> float:
        """Under two flanks of a slope of 1e-3 that meet at a `place` [m]."""
        kink: Any = SimpleNamespace(gap=lambda grid: 1e-3 * np.abs(grid.x - place)[:, None], has_length_scales=True)
        posed = replace(problem, source=kink)
        return HiddenHeights.from_problem(posed).effect_under(posed, pressure).corner_rise

    rise = line_contact.scene.contact_modulus / (8 * 0.915965594177219) * 2e-3 * log(2)
    assert corner_rise(0.0) == pytest.approx(rise / 1e9, rel=1e-6)
    # where nothing bears it does not count
    assert corner_rise(5 * problem.grid.cell_size[0]) == 0


def test_edges_that_change_cells_together_are_as_uncertain_as_one_of_them() -> None:
    """Edges in line are off by half a cell in every row; of those that lie anywhere most errors cancel."""
    x = np.arange(64)[:, None]

    def error(bend: float, length: int) -> float:
        half = 20.2 + bend * np.abs(np.arange(length) - length / 2)
        return unseen_area_error(np.where(np.abs(x - 31.5) < half, 1.0, 0.0), (False, True), None)

    assert error(0.0, 60) == pytest.approx(error(0.0, 6)) == pytest.approx(0.5 * 2**0.5 / 40, rel=0.05)
    assert error(0.3, 60) < 0.4 * error(0.3, 6)
