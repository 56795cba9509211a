from collections.abc import Callable
from dataclasses import replace
from math import inf

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.coarser import touching_fraction
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.hidden_heights import HiddenHeights
from contactstudy.elasticity.convolution import Convolution, weighted_sum
from tests.conftest import LineContact
from tests.contactstudy.scene.shapes.test_shapes import Own

Pair = tuple[float, float]


def spike(place: float, width: float) -> Own:
    """One narrow peak between two cell centres."""
    return Own(lambda grid: -3e-7 * np.exp(-(((grid.x - place) / width) ** 2))[:, None])


def estimate_of(scene: cs.Scene, grid: cs.Grid) -> cs.ErrorEstimate:
    return error_estimate(cs.solve(scene.problem(grid, cs.ExactPeriodicity())))


@pytest.mark.parametrize(("cells", "land"), [(96, 0.07), (160, 0.01)])
def test_lands_narrower_than_a_cell_leave_no_bound(cells: int, land: float, line_contact: LineContact) -> None:
    pitch = line_contact.hertz.half_width / 4
    groove = cs.Groove(2e-6, (1 - land) * pitch, "flat")
    scene = line_contact.with_shapes(cs.Texture(groove, (pitch, inf)))
    estimate = estimate_of(scene, line_contact.grid((cells, 1), 1.0, width=3.0))
    assert estimate.l1.total == estimate.peak_pressure.total == inf
    assert "do not resolve lengths" in estimate.warnings[0]


@pytest.mark.parametrize("moving", [lambda shape: shape, cs.MovingShape], ids=["at rest", "moving"])
def test_one_hidden_peak_is_enough(moving: Callable[[cs.Shape], cs.Shape], line_contact: LineContact) -> None:
    grid = line_contact.grid((96, 1), 1.0, width=3.0)
    hidden = moving(spike(0.1 * grid.cell_size[0], 0.02 * grid.cell_size[0]))
    assert estimate_of(line_contact.with_shapes(hidden), grid).l1.total == inf


def test_a_smooth_unknown_shape_keeps_its_bound(line_contact: LineContact) -> None:
    scene = line_contact.with_shapes(spike(0.0, line_contact.hertz.half_width))
    estimate = estimate_of(scene, line_contact.grid((192, 1), 1.0, width=3.0))
    assert estimate.l1.total < 0.01
    assert not estimate.warnings


def test_the_peak_pressure_at_a_sharp_end_has_no_bound(line_contact: LineContact) -> None:
    """Lundberg's profile has a finite drop: pressure there grows without limit on finer cells."""
    length = 4 * line_contact.hertz.half_width
    profile = cs.LundbergProfile.for_load(
        1e5, contact_modulus=line_contact.scene.contact_modulus, radius=0.01, length=length
    )
    scene = line_contact.with_shapes(profile)
    grid = line_contact.grid((36, 60), 4.0, width=2.6)
    estimate = error_estimate(cs.solve(scene.problem(grid, (cs.ZeroPadding(), cs.ZeroPadding()))))
    assert estimate.peak_pressure.total == inf
    assert "sharp end" in " ".join(estimate.warnings)
    assert estimate.l1.total < 0.02


def bumps(height: float, width: float, place: Pair, cell: Pair) -> Own:
    """Bumps at one place of every fourth cell along either axis, in fractions of a cell."""

    def heights(grid: cs.Grid) -> np.ndarray:
        across, along = (
            ((points / step - at + 2) % 4 - 2) / width
            for points, step, at in zip((grid.x, grid.y), cell, place, strict=True)
        )
        return -height * np.exp(-(across[:, None] ** 2) - along**2)

    return Own(heights)


@pytest.mark.parametrize(("width", "place"), [(0.15, (0.0, 0.0)), (0.3, (0.31, -0.22)), (1.0, (0.05, 0.0))])
def test_bumps_between_the_lines_of_an_unknown_shape_leave_no_bound(
    width: float, place: tuple[float, float], line_contact: LineContact
) -> None:
    """With even counts of cells the place 0 is the corner of four of them."""
    hertz = line_contact.hertz
    grid = line_contact.grid((48, 40), 1.3, width=3.2)
    height = 0.4 * hertz.half_width**2 / hertz.radius
    scene = line_contact.with_shapes(bumps(height, width, place, grid.cell_size))
    estimate = estimate_of(scene, grid)
    assert estimate.l1.total == estimate.peak_pressure.total == inf
    assert "protrudes" in estimate.warnings[0]


def test_low_bumps_between_the_lines_count_by_what_they_hide(line_contact: LineContact) -> None:
    hertz, grid = line_contact.hertz, line_contact.grid((48, 40), 1.3, width=3.2)
    height = 1e-3 * hertz.half_width**2 / hertz.radius
    scene = line_contact.scene
    bumpy = replace(scene, shapes=(*scene.shapes, bumps(height, 0.3, (0.0, 0.0), grid.cell_size)))
    coarse = cs.solve(bumpy.problem(grid, cs.ExactPeriodicity()))
    fine_grid = cs.Grid((8 * 48, 8 * 40), grid.extent)
    fine = cs.solve(bumpy.problem(fine_grid, cs.ExactPeriodicity()), tolerance=1e-5)
    means = fine.pressure.reshape(48, 8, 40, 8).mean(axis=(1, 3))
    error = float(np.abs(coarse.pressure - means).sum() / means.sum())
    peak = fine.pressure.max() / coarse.pressure.max() - 1
    estimate = error_estimate(coarse)
    assert error <= estimate.l1.total < inf
    assert peak <= estimate.peak_pressure.total < inf
    # without them the peak would be known far better
    assert peak > 3 * estimate_of(scene, grid).peak_pressure.total


LOADS = cs.LineLoad(1e5), cs.Approach(1.5e-6)


@pytest.mark.parametrize("load", LOADS, ids=str)
@pytest.mark.parametrize(("cells", "height"), [(1.0, 1e-9), (1.4, 3e-8), (2.0, 1e-8), (2.7, 1e-8)])
def test_a_wave_of_few_cells_is_seen_between_the_centres(
    cells: float, height: float, load: cs.LineLoad | cs.Approach, line_contact: LineContact
) -> None:
    grid = line_contact.grid((100, 1), 1.0, width=3.2)
    wave = cs.Waviness(height, across=cells * grid.cell_size[0])
    scene = replace(line_contact.scene, load=load, shapes=(*line_contact.scene.shapes, wave))
    coarse = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
    fine_grid = cs.Grid((3200, 1), grid.extent)
    fine = cs.solve(scene.problem(fine_grid, cs.ExactPeriodicity()), tolerance=1e-6)
    means = fine.pressure.reshape(100, 32).mean(axis=1)[:, None]
    estimate = error_estimate(coarse)
    assert np.abs(coarse.pressure - means).sum() <= estimate.l1.total * means.sum()
    peak = abs(coarse.pressure.max() / fine.pressure.max() - 1)
    assert peak <= estimate.peak_pressure.total
    area = touching_fraction(coarse) / touching_fraction(fine)
    assert abs(area - 1) <= estimate.contact_area.total
    if estimate.load is not None:
        assert abs(fine.load_per_length / coarse.load_per_length - 1) <= estimate.load.total


# Two flanks that meet at an edge.
WEDGE = Own(lambda grid: 0.02 * np.abs(grid.x)[:, None])


@pytest.mark.parametrize("adhesion", [None, cs.Adhesion(1e-3, range=2e-7)], ids=["dry", "adhesive"])
@pytest.mark.parametrize("load", LOADS, ids=str)
def test_an_edge_and_waves_within_cells_leave_no_bound_whatever_is_given(
    load: cs.LineLoad | cs.Approach, adhesion: cs.Adhesion | None, line_contact: LineContact
) -> None:
    grid = line_contact.grid((97, 1), 1.0, width=6.0)
    waves = bumps(2e-7, 0.3, (0.5, 0.0), (grid.cell_size[0] / 4, inf))
    for shapes, reason in (((WEDGE,), "a sharp edge"), ((cs.Cylinder(0.01), waves), "protrudes")):
        scene = replace(line_contact.scene, load=load, shapes=shapes, adhesion=adhesion)
        estimate = estimate_of(scene, grid)
        assert estimate.peak_pressure.total == inf
        assert any(reason in said for said in estimate.warnings)


@pytest.mark.parametrize(("cells", "height", "place"), [(65, 5e-7, 0.13), (48, 2e-6, 0.13), (64, 2e-6, 0.4)])
def test_the_peak_at_an_apex_is_bounded_by_all_rises_to_come(
    cells: int, height: float, place: float, line_contact: LineContact
) -> None:
    """It bends without limit, so that pressure rises with the power 0.6 of the cell: by 49 ** -0.6 below the finest."""
    a = line_contact.hertz.half_width
    apex = Own(lambda grid: height * np.abs(grid.x / a - place)[:, None] ** 1.6)
    scene = line_contact.with_shapes(apex)
    coarse, fine, finest = (
        cs.solve(scene, line_contact.grid((n * cells, 1), 1.0, width=3.0), cs.ExactPeriodicity()) for n in (1, 7, 49)
    )
    peak, *peaks = (one.pressure.max() for one in (coarse, fine, finest))
    limit = peaks[1] + (peaks[1] - peaks[0]) / (7**0.6 - 1)
    assert limit / peak - 1 <= error_estimate(coarse).peak_pressure.total < 0.6


def test_hidden_heights_weigh_less_where_a_step_of_wear_softens_the_contact(line_contact: LineContact) -> None:
    """Bodies wear under a pressure as if each cell had a soft layer, under which waves are flat at less pressure."""
    grid = line_contact.grid((96, 1), 1.0, width=3.0)
    wave = cs.Waviness(1e-8, across=4 * grid.cell_size[0])
    problem = line_contact.with_shapes(wave).problem(grid, cs.ExactPeriodicity())
    assert isinstance(problem.operator, Convolution)
    layer = 2 * grid.cell_size[0] / line_contact.scene.contact_modulus
    worn = replace(problem, operator=weighted_sum([(1.0, problem.operator)], layer))
    pressure = cs.solve(problem).pressure
    heights, of_worn = (HiddenHeights.from_problem(one) for one in (problem, worn))
    assert heights is not None
    assert of_worn is not None
    found, expected = (one.effect_under(worn, pressure) for one in (heights, of_worn))
    assert found.hidden_load == pytest.approx(expected.hidden_load)
    assert found.peak_rise == pytest.approx(expected.peak_rise)
    assert 0 < found.hidden_load < heights.effect_under(problem, pressure).hidden_load


def test_lines_do_not_keep_in_step_with_a_texture(line_contact: LineContact) -> None:
    """Dimples at every fourth cell show at least as much on 264 lines, not all examined, as on 40, of which all are."""

    def missed(count: int) -> float:
        grid = line_contact.grid((count, count), count / 160, width=count / 160)
        pitch = 4 * grid.cell_size[0]
        scene = line_contact.with_shapes(cs.Texture(cs.Dimple(1e-7, pitch / 2, "cosine"), (pitch, pitch)))
        return float(HiddenHeights.from_problem(scene.problem(grid, cs.ExactPeriodicity())).missed.max())

    assert missed(264) > 0.95 * missed(40) > 0
