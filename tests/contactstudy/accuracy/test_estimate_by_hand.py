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
from contactstudy.accuracy.estimate import _has_isolated_cells, _spot_width, error_estimate
from contactstudy.accuracy.subcell import HeightsInside, Subcell
from tests.conftest import STEEL, LineContact

# By smooth edges: of the peak pressure, in L1, of the area; and by images left out.
PEAK, L1, AREA, PEAK_CUT, L1_CUT = 0.02, 0.01, 0.05, 0.001, 0.003
# Mean of the heights inside the cells below that at the centres [m].
SAMPLED = 1e-10


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

    def show(
        uncertain: float,
        seen: Change | None = None,
        corner: float = 0.0,
        of: cs.Solution = solution,
        **more: float,
    ) -> cs.ErrorEstimate:
        monkeypatch.setattr(
            HeightsInside,
            "from_problem",
            lambda *_: SimpleNamespace(
                under=lambda *_: Subcell(uncertain, corner, stands_out=False, mean=SAMPLED, **more)
            ),
        )
        monkeypatch.setattr(estimate, "change", lambda *_: seen)
        # without a change nothing coarser may be asked for
        monkeypatch.setattr(estimate, "coarse_solution", lambda *_: 1 / 0 if seen is None else of)
        return error_estimate(of)

    return Estimated(solution, show)


def of_cells(found: cs.ErrorEstimate) -> tuple[float, float, float, float]:
    parts = (found.peak_pressure, found.l1, found.contact_area, found.mean_gap)
    first, second, third, fourth = (part.discretisation for part in parts)
    return first, second, third, fourth


def gap_of(solution: cs.Solution, l1: float, change: float = 0.0) -> float:
    """Return the change, or 0.12 of the error in L1 times the variation of the displacement, plus what is sampled."""
    moved = 0.12 * l1 * max(solution.displacement.std() / solution.mean_gap, 1)
    return float(max(change, moved) + SAMPLED / solution.mean_gap)


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
    found = estimated.show(hides * L1)
    assert of_cells(found) == pytest.approx((PEAK, L1, AREA, gap_of(estimated.solution, L1)))
    assert not found.warnings


SEEN = Change(l1=0.3, peak_pressure=0.1, contact_area=0.2, mean_gap=0.3)


@pytest.mark.parametrize(
    ("hidden", "seen", "wanted"),
    [
        ({"uncertain": L1}, SEEN, (0.1, 0.3, 0.2, 0.3)),
        # a fall of the peak counts as a rise
        ({"uncertain": L1}, replace(SEEN, peak_pressure=-0.1), (0.1, 0.3, 0.2, 0.3)),
        # less than the law of the edges says was seen by chance
        ({"uncertain": L1}, Change(0.008, 0.004, 0.02, 0.0005), (PEAK, L1, AREA, 0.0005)),
        # 0.8 of the load whose cells hide heights, and of the area that may open: 0.4 of 1 is 2/3 of 0.6
        (
            {"uncertain": 0.9, "rise": 0.25, "opens": 0.5},
            Change(0.1, 0.1, 0.02, 0.3),
            (0.25, 0.72, 2 / 3, 0.3),
        ),
        ({"uncertain": L1, "rise": 0.25, "kink": 0.07}, SEEN, (0.32, 0.3, 0.2, 0.3)),
        # two pressures of one load differ by two at most
        ({"uncertain": L1}, replace(SEEN, l1=2.3), (0.1, 2.0, 0.2, 0.3)),
    ],
)
def test_law_change_and_what_cells_hide_count_by_the_most(
    hidden: dict[str, float],
    seen: Change,
    wanted: tuple[float, float, float, float],
    estimated: Estimated,
) -> None:
    found = estimated.show(seen=seen, **hidden)
    gap = gap_of(estimated.solution, wanted[1], wanted[3])
    assert of_cells(found) == pytest.approx((*wanted[:3], gap))
    assert not found.warnings


def test_a_corner_leaves_the_peak_pressure_alone_without_a_bound(estimated: Estimated) -> None:
    assert estimated.show(L1, SEEN, corner=1e-3).peak_pressure.total < inf
    sharp = estimated.show(0.0, SEEN, corner=1.01e-3)
    gap = gap_of(estimated.solution, 0.3, 0.3)
    assert of_cells(sharp) == pytest.approx((inf, 0.3, 0.2, gap))
    assert "a sharp edge or corner" in sharp.warnings[0]


def test_an_area_that_may_open_everywhere_has_no_bound(estimated: Estimated) -> None:
    found = estimated.show(3 * L1, SEEN, opens=1.25)
    assert found.contact_area.total == inf
    assert found.warnings[0].startswith("No bound for the contact area")


def test_a_mean_gap_that_is_left_by_the_iteration_has_no_bound(estimated: Estimated) -> None:
    """In full contact all of it is."""
    scene = cs.Scene(cs.LineLoad(1e6), (STEEL, STEEL), (cs.Waviness(1e-8, across=1e-3),))
    exact = cs.ExactPeriodicity()
    grid = cs.Grid((32, 1), (1e-3, 1e-3))
    closed = cs.solve(scene.problem(grid, (exact, exact)))
    assert closed.pressure.min() > 0
    found = estimated.show(0.0, SEEN, of=closed)
    assert found.mean_gap.total == inf
    assert "touch everywhere" in " ".join(found.warnings)


def test_pressure_at_the_hardness_is_known(estimated: Estimated, line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, hardness=0.8 * line_contact.hertz.peak_pressure)
    problem = scene.problem(line_contact.grid((24, 1), 1.0, width=3.6), cs.ExactPeriodicity())
    found = estimated.show(0.0, SEEN, of=cs.solve(problem))
    assert of_cells(found)[:3] == pytest.approx((0.0, 0.3, 0.2))


@pytest.mark.parametrize(
    ("stiffer", "cells", "shown"), [(2.1, 1.9, False), (2.1, 2.1, True), (1.9, 1.9, True)]
)
def test_a_stiff_coat_of_less_than_two_cells_may_hide_spikes_at_the_edges(
    stiffer: float,
    cells: float,
    shown: bool,  # noqa: FBT001
    estimated: Estimated,
    line_contact: LineContact,
) -> None:
    grid = line_contact.grid((24, 1), 1.0)
    coat = replace(STEEL, youngs_modulus=stiffer * STEEL.youngs_modulus)
    coated = cs.CoatedHalfSpace(coat, cells * grid.cell[0], STEEL)
    scene = replace(line_contact.scene, solids=(coated, STEEL))
    solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
    found = estimated.show(0.0, of=solution)
    # the plane modulus of the coat bent over 10 mm, each spike as wide as the coat is thick
    spike = (
        2 / 3 * coat.youngs_modulus / (1 - 0.3**2) * coated.thickness / 0.01 / stiffer ** (1 / 3)
    )
    share = 0.0 if shown else 2 * spike * coated.thickness / 1e5
    peak = PEAK if shown else max(PEAK, spike / solution.pressure.max() - 1)
    assert of_cells(found)[:2] == pytest.approx((peak, L1 + share))
    assert bool(found.warnings) != shown


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
    found = error_estimate(left)
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
