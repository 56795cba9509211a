"""How an estimate is put together of what the solution, the heights in its cells and a coarser solution show.

The numbers of its parts are written here, so that each of its factors is one of a product or a sum by hand.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, pi
from types import SimpleNamespace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy import estimate
from contactstudy.accuracy.coarser import Change
from contactstudy.accuracy.estimate import _has_isolated_cells, _spot_width
from contactstudy.accuracy.subcell import HeightsInside, Subcell
from tests.conftest import STEEL, LineContact

# By smooth edges: of the peak pressure, in L1, of the area; and by images left out.
PEAK, L1, AREA, PEAK_CUT, L1_CUT = 0.02, 0.01, 0.05, 0.001, 0.003
# Of the mean gap, by heights sampled at the centres.
SAMPLED = 1e-4


@dataclass(frozen=True)
class Estimated:
    """A solution, and the estimate of it from what was seen."""

    solution: cs.Solution
    show: Callable[..., cs.ErrorEstimate]


@pytest.fixture
def estimated(line_contact: LineContact, monkeypatch: pytest.MonkeyPatch) -> Estimated:
    problem = line_contact.scene.problem(line_contact.grid((24, 1), 1.0), cs.ExactPeriodicity())
    solution = cs.solve(problem)
    monkeypatch.setattr(estimate, "discretisation", lambda *_: (PEAK, L1))
    monkeypatch.setattr(estimate, "contact_area", lambda *_: AREA)
    monkeypatch.setattr(estimate, "truncation", lambda *_: (PEAK_CUT, L1_CUT))
    monkeypatch.setattr(estimate, "_sampling_error", lambda *_: SAMPLED)

    def show(
        uncertain: float,
        seen: Change | None = None,
        corner: float = 0.0,
        of: cs.Solution = solution,
    ) -> cs.ErrorEstimate:
        monkeypatch.setattr(
            HeightsInside,
            "from_problem",
            lambda *_: SimpleNamespace(
                under=lambda *_: Subcell(uncertain, corner, stands_out=False)
            ),
        )
        monkeypatch.setattr(estimate, "change", lambda *_: seen)
        # without a change nothing coarser may be asked for
        monkeypatch.setattr(estimate, "coarse_solution", lambda *_: 1 / 0 if seen is None else of)
        return cs.error_estimate(of)

    return Estimated(solution, show)


def of_cells(found: cs.ErrorEstimate) -> tuple[float, float, float, float]:
    parts = (found.peak_pressure, found.l1, found.contact_area, found.mean_gap)
    first, second, third, fourth = (part.discretisation for part in parts)
    return first, second, third, fourth


def gap_of_edges(solution: cs.Solution) -> float:
    """Return 0.15 of the error in L1 times flattened depth over mean gap, plus the error of sampling."""
    inside = np.abs(solution.problem.grid.x[solution.pressure[:, 0] > 0])
    depth = (inside.max() ** 2 - inside.min() ** 2) / (2 * 0.01)
    return float(0.15 * L1 * depth / solution.gap.mean() + SAMPLED)


def test_images_left_out_count_eightfold_for_the_gap(estimated: Estimated) -> None:
    found = estimated.show(0.0)
    assert found.peak_pressure.truncation == PEAK_CUT
    assert found.l1.truncation == found.contact_area.truncation == L1_CUT
    assert found.mean_gap.truncation == pytest.approx(8 * L1_CUT)
    assert found.peak_pressure.total == pytest.approx(
        PEAK_CUT + PEAK + found.peak_pressure.residual
    )


@pytest.mark.parametrize("hides", [0.0, 0.2, 0.25])
def test_smooth_edges_that_hide_little_need_no_coarser_solution(
    hides: float, estimated: Estimated
) -> None:
    found = estimated.show(hides * L1, corner=0.01)
    # twice what is hidden counts for the peak
    gap = gap_of_edges(estimated.solution)
    assert of_cells(found) == pytest.approx((PEAK * (1 + 2 * hides), L1, AREA, gap))
    assert not found.warnings


SEEN = Change(l1=0.3, peak_pressure=0.1, contact_area=0.2, mean_gap=0.3)


@pytest.mark.parametrize(
    ("uncertain", "seen", "wanted"),
    [
        # hides as much as the edges' error: 1.6 times that in L1, and 1 + 2 times the peak's. The area may have
        # lost 1.25 of the 20 % seen, the gap is three times its change
        (L1, SEEN, (0.06, 0.016, 1 / 3, 0.9)),
        # less than that was seen
        (L1, Change(0.008, 0.004, 0.02, 0.0005), (PEAK, 0.0112, AREA, 0.3 * L1)),
        # half as much again: the peak by 2.5 of its rise, or 1.5 of its fall
        (1.5 * L1, SEEN, (0.25, 0.016, 1 / 3, 0.9)),
        (1.5 * L1, replace(SEEN, peak_pressure=-0.1), (0.15, 0.016, 1 / 3, 0.9)),
        (2 * L1, SEEN, (0.25, 0.016, 1 / 3, 0.9)),
        # thrice as much: 1.4 of the change in L1
        (3 * L1, SEEN, (0.25, 0.42, 1 / 3, 0.9)),
        # half of the load whose cells hide heights, a quarter of it for the area
        (0.9, Change(0.1, 0.1, 0.02, 0.3), (0.25, 0.45, 0.225, 0.9)),
    ],
)
def test_what_cells_hide_or_a_coarser_solution_shows_counts_by_the_more(
    uncertain: float,
    seen: Change,
    wanted: tuple[float, float, float, float],
    estimated: Estimated,
) -> None:
    found = estimated.show(uncertain, seen)
    assert of_cells(found) == pytest.approx(wanted)
    assert not found.warnings


def test_a_corner_counts_by_the_change_and_a_sharp_one_has_no_peak_pressure(
    estimated: Estimated,
) -> None:
    blunt = estimated.show(L1, SEEN, corner=0.01)
    assert of_cells(blunt)[:2] == pytest.approx((0.06, 0.016))
    sharp = estimated.show(0.0, SEEN, corner=0.0101)
    assert of_cells(sharp) == pytest.approx((inf, 0.42, 1 / 3, 0.9))
    assert "a sharp edge or corner" in sharp.warnings[0]


@pytest.mark.parametrize(
    ("uncertain", "seen", "said"),
    [
        (1.5 * L1, replace(SEEN, peak_pressure=0.2), "it grew by 20%"),
        (3 * L1, replace(SEEN, l1=0.5 / 1.4), "hardly shows the surface"),
        (1.0, replace(SEEN, l1=0.1), "hardly shows the surface"),
    ],
)
def test_a_peak_that_grows_by_a_fifth_or_a_load_half_astray_has_no_bound(
    uncertain: float, seen: Change, said: str, estimated: Estimated
) -> None:
    found = estimated.show(uncertain, seen)
    assert found.peak_pressure.total == inf
    assert found.l1.total < 1
    [warning] = found.warnings
    assert warning.startswith("No bound for the peak pressure:")
    assert said in warning
    # a little less is bounded
    less = Change(*(0.99 * part for part in (seen.l1, seen.peak_pressure, 0.2, 0.3)))
    assert estimated.show(0.99 * uncertain, less).peak_pressure.total < inf


def test_the_pressure_in_l1_is_at_most_two_astray_and_a_lost_area_has_no_bound(
    estimated: Estimated,
) -> None:
    found = estimated.show(3 * L1, Change(1.9, 0.1, 0.8, 0.3))
    assert of_cells(found) == pytest.approx((inf, 2.0, inf, 0.9))
    assert found.warnings[0].startswith("No bound for the peak pressure: the grid hardly shows")
    assert found.warnings[1].startswith("No bound for the contact area")


def test_pressure_at_the_hardness_is_known(estimated: Estimated, line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, hardness=0.8 * line_contact.hertz.peak_pressure)
    problem = scene.problem(line_contact.grid((24, 1), 1.0, width=3.6), cs.ExactPeriodicity())
    found = estimated.show(0.0, SEEN, of=cs.solve(problem))
    assert of_cells(found) == pytest.approx((0.0, 0.42, 1 / 3, 0.9))


@pytest.mark.parametrize(
    ("stiffer", "cells", "times"), [(2.1, 7.9, 3.5), (2.1, 8.1, 1.0), (1.9, 7.9, 1.0)]
)
def test_a_stiff_coat_of_less_than_eight_cells_makes_bounds_three_and_a_half_times_as_large(
    stiffer: float,
    cells: float,
    times: float,
    estimated: Estimated,
    line_contact: LineContact,
) -> None:
    grid = line_contact.grid((24, 1), 1.0)
    coat = replace(STEEL, youngs_modulus=stiffer * STEEL.youngs_modulus)
    coated = cs.CoatedHalfSpace(coat, cells * grid.cell[0], STEEL)
    scene = replace(line_contact.scene, solids=(coated, STEEL))
    solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
    found = estimated.show(0.0, of=solution)
    gap = gap_of_edges(solution)
    assert of_cells(found) == pytest.approx((times * PEAK, times * L1, AREA, gap))
    assert bool(found.warnings) == (times > 1)


def test_sampled_heights_change_the_mean_gap_by_no_more_than_from_cells_of_twice_the_size(
    line_contact: LineContact,
) -> None:
    """The mean of ``x^2`` at n centres is ``W^2 / 12 (1 - 1 / n^2)``."""
    grid = line_contact.grid((24, 1), 1.0, width=3.0)
    solution = cs.solve(line_contact.scene.problem(grid, cs.ExactPeriodicity()))
    change = grid.extent[0] ** 2 / 12 * (4 - 1) / 24**2 / (2 * 0.01)
    found = estimate._sampling_error(solution) * solution.gap.mean()
    assert found == pytest.approx(change, rel=1e-9)
    unknown = replace(solution, problem=replace(solution.problem, source=None))
    assert estimate._sampling_error(unknown) == 0.0


def test_the_residual_is_twice_the_pressure_that_closes_the_gap_left() -> None:
    """A wave of the gap over a body in full contact: E* k / 2 times it is the pressure that flattens it."""
    length, modulus = 1e-3, cs.Scene(cs.LineLoad(1.0), (STEEL, STEEL)).contact_modulus
    grid = cs.Grid((64, 1), (length, length))
    wave = 1e-6 * np.cos(2 * pi * grid.x / length)[:, None]
    closing = pi * modulus * 1e-6 / length
    mean = 4 * closing
    exact = cs.ExactPeriodicity()
    problem = cs.Scene(
        cs.LineLoad(mean * length), (STEEL, STEEL), (cs.Waviness(1e-6, across=length),)
    ).problem(grid, (exact, exact))
    solved = cs.solve(problem, tolerance=1e-10)
    assert solved.pressure.min() > 0
    left = replace(solved, gap=solved.gap + 0.1 * wave)
    found = cs.error_estimate(left)
    # a cell of constant pressure: its own compliance differs from the wave's by (pi / 64)² / 6
    share = 0.1 * closing / mean
    assert found.l1.residual == pytest.approx(2 * 2 / pi * share, rel=0.05)
    rise = (solved.pressure + 2 * 0.1 * closing * np.abs(wave) / 1e-6).max()
    assert found.peak_pressure.residual == pytest.approx(
        max(rise / solved.pressure.max() - 1, 2 * 2 / pi * share), rel=0.05
    )
    assert found.contact_area.residual == found.mean_gap.residual == found.l1.residual


def test_the_spot_of_the_peak_pressure_is_counted_along_the_shorter_axis() -> None:
    pressure = np.zeros((7, 6))
    pressure[1:5, 2] = 1, 2, 5, 1
    pressure[3, 2:5] = 5, 1, 1
    assert _spot_width(pressure, (False, False)) == 3
    pressure[3, 1:6] = 1, 5, 1, 1, 1
    assert _spot_width(pressure, (False, False)) == 4
    # over the seam of an axis that goes on, and up to the ends of one that does not
    along = np.array([[3.0, 1, 0, 0, 1, 1, 1]])
    assert _spot_width(along, (False, True)) == 5
    assert _spot_width(along, (False, False)) == 2
    assert _spot_width(along[:, ::-1], (False, False)) == 2
    # where all of it touches it has no end
    assert _spot_width(np.ones((1, 6)), (False, True)) == 6


def test_cells_without_a_neighbour_along_an_axis_are_alone() -> None:
    assert _has_isolated_cells(np.array([[1.0], [0.0], [1.0]]))
    assert not _has_isolated_cells(np.array([[1.0], [1.0], [0.0]]))
    # neighbours along one axis, none along the other
    assert _has_isolated_cells(np.array([[1.0, 1.0], [0.0, 0.0], [1.0, 1.0]]))
    assert not _has_isolated_cells(np.array([[1.0, 1.0], [1.0, 0.0]]))
