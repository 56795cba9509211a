"""Heights inside the cells, which a pressure on the grid does not resolve, and their effect on the contact.

1. The gap is sampled at points inside the cells, on lines through their centres along each axis. A cubic through the
   centres is what the cells resolve; what it misses is hidden.
2. Where a shape names no length scales, points between the lines are sampled too, where a feature may hide.
3. Under a pressure, hidden heights count as the pressure that would flatten them; a corner raises the pressure at each
   halving of the cells.

E* is the contact modulus and dx the size of a cell along the axis in question.
"""

from dataclasses import dataclass
from math import log, pi

import numpy as np

from contactstudy.accuracy.discretisation.cells import around_contact, with_ends
from contactstudy.accuracy.discretisation.sampled_heights import (
    SampledHeights,
    cubics,
    extended_by_two,
)
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import BLOCK_CELLS, Array
from contactstudy.domain.grid import Grid, axis_first, on_cells
from contactstudy.elasticity.convolution import Convolution
from contactstudy.problem.problem import Problem, Source

# Steps of a two-dimensional sequence of low discrepancy to which points can be added one by one:
# Roberts (2018), "The unreasonable effectiveness of quasirandom sequences".
STEPS = 0.7548776662466927, 0.5698402909980532


@dataclass(frozen=True)
class SubgridConstants:
    """Constants of the examination of heights inside the cells.

    Attributes
    ----------
    points
        Points in a cell along a line, where all shapes name their length scales.
    points_at_corners
        Points in a cell along a line that may have a corner, where all shapes name their length scales.
    points_without_scales
        Points in a cell along a line, where a shape names no length scales.
    lines
        Least number of lines along an axis that are examined, or all if there are fewer.
    sparse
        Of many lines, one in this many is examined, but at least `lines`.
    points_off_lines
        Points in a cell off the lines, where a shape names no length scales: a feature that covers 3 % of the cell is
        found with a probability of 95 %.
    pressure_rise
        Rise of the pressure where a hidden height h is pressed flat, over ``E* h / dx``. It is pi / 2 and pi for waves
        of two cells and of one, and pi / 2 for a bump ``exp(-r^2 / dx^2)``; a value between is taken.
    resolved_fraction
        Largest interpolation error of a feature that the centres resolve, over the second difference of the heights at
        the centres. An error beyond that belongs to a feature that the centres do not show.
    """

    points: int = 4
    points_at_corners: int = 32
    points_without_scales: int = 48
    lines: int = 64
    sparse: int = 4
    points_off_lines: int = 99
    pressure_rise: float = 2.5
    resolved_fraction: float = 0.5


CONSTANTS = SubgridConstants()


@dataclass(frozen=True)
class SubgridEffect:
    """Effect of the heights inside the cells on a contact.

    Heights that a cubic through the centres misses are hidden. They count by the pressure that would flatten them, at
    most the pressure there. A corner that points out of the body, at which the slope changes by S, raises the pressure
    by ``E* S / (2 pi) ln 2`` each time the cell is halved, and so without limit: the pressure near the apex of a blunt
    wedge is logarithmic (Johnson 1985, sect. 5.2). A kink stands for a height ``|x|^n`` with n between 1 and 2, whose
    rises get smaller at each halving and have a finite sum.

    Attributes
    ----------
    hidden_load
        Fraction of the load whose cells hide heights.
    corner_rise
        Largest rise at a corner in the contact when the cells are halved, over the peak pressure.
    protrudes
        Whether the surface protrudes from a cell so far that it would carry more than the peak pressure.
    peak_rise
        Fraction of the peak pressure by which hidden heights may raise it.
    area_loss
        Fraction of the contact that may open: the hidden pressure over that of each cell, at most 1, in the mean.
    mean_height
        Mean of the heights inside the cells below that at their centres [m].
    kink_rise
        Fraction by which the peak pressure may still rise on finer cells at a kink.
    """

    hidden_load: float
    corner_rise: float
    protrudes: bool
    peak_rise: float = 0.0
    kink_rise: float = 0.0
    area_loss: float = 0.0
    mean_height: float = 0.0


@dataclass(frozen=True, eq=False)
class SubgridHeights:
    """Heights inside the cells of a grid, which are the same under any pressure.

    Attributes
    ----------
    along
        Heights on lines along each axis.
    between_lines
        Heights off these lines, see :func:`_between_lines`, if a shape names no length scales.
    """

    along: "tuple[_HiddenHeights, ...]"
    between_lines: tuple[Array, Array, Array, Array] | None

    @classmethod
    def from_problem(cls, problem: Problem) -> "SubgridHeights | None":
        """Return the heights inside the cells of `problem`, or None where they are not known.

        They are evaluated along lines through the cell centres, and for shapes that name no scales also at points off
        these lines.
        """
        source, grid = problem.source, problem.grid
        if source is None or problem.paddings is None:
            return None
        try:
            points = (
                CONSTANTS.points if source.has_length_scales else CONSTANTS.points_without_scales
            )
            parts = (
                _hidden_heights(problem, axis, points) for axis in (0, 1) if grid.cells[axis] > 1
            )
            along = tuple(part for part in parts if part is not None)
            examined = not source.has_length_scales and min(grid.cells) > 1
            return cls(along, _between_lines(problem) if examined else None)
        except InvalidInput:
            return None

    def effect_under(self, problem: Problem, pressure: Array) -> SubgridEffect:
        """Return the effect of the heights where `pressure` (x, y) [Pa] acts, and in the neighbouring cells."""
        rows = around_contact(pressure)
        loaded = pressure[rows]
        beside = _with_neighbours(loaded, problem)
        hidden, protrusion = np.zeros_like(loaded), np.zeros_like(loaded)
        corner = kink = mean = 0.0
        for part in self.along:
            modulus = _modulus(problem, part.axis)
            stiffness = modulus / problem.grid.cell_size[part.axis]
            halving = modulus * log(2) / (2 * pi)
            hidden += part.in_rows(part.missed, rows, pressure.shape) * stiffness
            protrusion += part.in_rows(part.protrusion, rows, pressure.shape) * stiffness
            corner = max(corner, part.largest(part.corner, beside, rows, pressure.shape) * halving)
            if part.kink is not None:
                kink = max(kink, part.largest(part.kink, beside, rows, pressure.shape) * halving)
            mean += abs(part.mean)
        peak = float(loaded.max())
        risen = loaded + CONSTANTS.pressure_rise * hidden
        if self.between_lines is not None:
            missed, protrusion_there, width, unresolved = (
                field[rows] for field in self.between_lines
            )
            stiffness = max(
                _modulus(problem, axis) / problem.grid.cell_size[axis] for axis in (0, 1)
            )
            hidden = np.maximum(hidden, missed * stiffness)
            protrusion = np.maximum(protrusion, protrusion_there * stiffness)
            risen = np.maximum(
                risen, loaded + CONSTANTS.pressure_rise * unresolved * stiffness / width
            )
        rise = float(risen[beside > 0].max(initial=peak)) / peak - 1
        protrudes = bool((protrusion[beside > 0] > peak).any())
        touching = loaded > 0
        area_loss = float((np.minimum(hidden, loaded)[touching] / loaded[touching]).mean())
        hides = float(np.minimum(hidden, beside, out=hidden).sum() / loaded.sum())
        return SubgridEffect(hides, corner / peak, protrudes, rise, kink / peak, area_loss, mean)


@dataclass(frozen=True, eq=False)
class _HiddenHeights:
    """Heights hidden inside the cells along one `axis`, examined on some lines (across, along).

    `missed` is the interpolation error of cubics through the centres and `protrusion` the height above all centres about
    a cell, both [m]; `corner` and `kink` are the changes of slope there; `mean` is the mean height of the points below
    that of the centres [m]. The `kink` is None for shapes that name their length scales.
    """

    axis: int
    mean: float
    missed: Array
    corner: Array
    protrusion: Array
    kink: Array | None = None

    def in_rows(self, heights: Array, rows: slice, cells: tuple[int, ...]) -> Array:
        """Return `heights` of the lines in some `rows` of all `cells` (across, along)."""
        if self.axis == 0:
            return on_cells(heights[rows], (len(range(cells[0])[rows]), cells[1]))
        return on_cells(heights, (cells[0], cells[1]))[rows]

    def largest(self, slopes: Array, pressure: Array, rows: slice, cells: tuple[int, ...]) -> float:
        """Return the largest of the `slopes` on the lines where a `pressure` acts, which is zero but in some `rows`."""
        if not slopes.any():
            return 0.0
        everywhere = np.zeros(cells)
        everywhere[rows] = pressure
        lines = slopes.shape[0], slopes.shape[1]
        return float(np.where(on_cells(everywhere, lines) > 0, slopes, 0.0).max())


def _hidden_heights(problem: Problem, axis: int, points_each: int) -> _HiddenHeights | None:
    """Return the heights hidden inside the cells along an `axis`, or None where they do not vary along it.

    Lines with bends like those of a corner are examined again at more points.
    """
    source, grid, paddings = problem.source, problem.grid, problem.paddings
    assert source is not None
    assert paddings is not None
    lines, inside = _lines(grid.cells, axis, 1), _lines(grid.cells, axis, points_each)
    points = axis_first(source.gap(Grid(inside, grid.extent)), axis)
    coarser = grid if lines == grid.cells else Grid(lines, grid.extent)
    centres = axis_first(source.gap(coarser), axis)
    if len(points) == len(centres) == 1:
        return None
    # a shape may vary along an axis at the points alone, or at the centres alone
    width, examined = max(points.shape[1], centres.shape[1]), []
    points = np.broadcast_to(points, (inside[axis], width))
    centres = np.broadcast_to(centres, (lines[axis], width))
    # some lines at a time, whose arrays fit into the cache
    together = max(1, BLOCK_CELLS // len(points))
    for begin in range(0, points.shape[1], together):
        beside = slice(begin, begin + together)
        parts = centres[:, beside], points[:, beside]
        heights = SampledHeights.from_heights(
            *parts, grid.cell_size[axis], wraps=paddings[axis].wraps
        )
        of_any = heights.missed, heights.corner(), heights.protrusion
        of_unknown = () if source.has_length_scales else (heights.kink(),)
        examined.append((*of_any, *of_unknown))
    on_lines = [
        np.broadcast_to(axis_first(np.concatenate(fields, axis=1), axis), lines)
        for fields in zip(*examined, strict=True)
    ]
    if axis and problem.covered_fractions is not None:  # an end is no height that is hidden
        at_end = np.convolve(problem.covered_fractions < 1, np.ones(5), mode="same") > 0
        on_lines[::2] = [np.where(at_end, 0.0, fields) for fields in on_lines[::2]]
    inside_mean, mean = (
        mean_height(source, Grid(cells, grid.extent), axis_first(heights, axis))
        for cells, heights in ((inside, points), (lines, centres))
    )
    hidden = _HiddenHeights(axis, inside_mean - mean, *on_lines)
    if points_each < CONSTANTS.points_at_corners and hidden.corner.any():
        return _hidden_heights(problem, axis, CONSTANTS.points_at_corners)
    return hidden


def _between_lines(problem: Problem) -> tuple[Array, Array, Array, Array]:
    """Return (missed [m], protrusion [m], width [cells], unresolved [m]), fields (x, y) of the heights off the lines.

    `missed` is the largest interpolation error of cubics through the centres, and `protrusion` the height above all
    centres about a cell. `width` is the length s of a round bump ``exp(-r^2 / s^2)`` with the same largest and mean
    square error in the cell: the mean square is ``pi s^2 / 2`` of the square of the largest. `unresolved` is the error
    beyond that of a feature which the centres resolve. With the probability ``(1 - q)^k`` none of k random points in a
    cell hits a feature over the fraction q of it; points of low discrepancy leave smaller holes. Each point is examined
    in all cells at once.
    """
    from scipy import ndimage  # imported late, since it is slow

    source, grid = problem.source, problem.grid
    assert source is not None
    assert problem.paddings is not None
    heights = getattr(source, "gap_without_scales", source.gap)
    centres = np.broadcast_to(heights(grid), grid.cells)
    missed, squares = np.zeros(grid.cells), np.zeros(grid.cells)
    lowest = np.full(grid.cells, np.inf)
    if heights(grid).shape[1] == 1:  # a profile, which the lines across have examined
        return missed, missed, np.ones(grid.cells), missed
    wraps = [padding.wraps for padding in problem.paddings]
    beside = extended_by_two(centres, wraps=wraps[0])
    count = CONSTANTS.points_off_lines
    for number in range(count):
        across, along = ((0.5 + number * step) % 1 - 0.5 for step in STEPS)
        points = np.broadcast_to(
            heights(_ShiftedGrid(grid.cells, grid.extent, (across, along))), grid.cells
        )
        smooth = cubics(beside, (across,))[0]
        smooth = cubics(extended_by_two(smooth.T, wraps=wraps[1]), (along,))[0].T
        np.maximum(missed, np.abs(points - smooth), out=missed)
        squares += (points - smooth) ** 2
        np.minimum(lowest, points, out=lowest)
    # above all centres about a cell: a step between two centres hides no height
    mode = tuple("wrap" if is_periodic else "nearest" for is_periodic in wraps)
    protrusion_there = np.maximum(ndimage.minimum_filter(centres, 3, mode=mode) - lowest, 0)
    largest = count * missed**2
    fraction = np.divide(squares, largest, out=np.ones(grid.cells), where=largest > 0)
    # the second difference of the centres, the larger one of both axes
    shown = np.zeros(grid.cells)
    for axis, is_periodic in enumerate(wraps):
        padded = extended_by_two(axis_first(centres, axis), wraps=is_periodic)[1:-1]
        np.maximum(shown, axis_first(np.abs(np.diff(padded, n=2, axis=0)), axis), out=shown)
    return (
        missed,
        protrusion_there,
        np.sqrt(2 * fraction / pi),
        np.maximum(missed - CONSTANTS.resolved_fraction * shown, 0),
    )


@dataclass(frozen=True)
class _ShiftedGrid(Grid):
    """A grid whose points are shifted from the cell centres by fractions of a cell (across, along)."""

    shift: tuple[float, float]

    @property
    def x(self) -> Array:
        return super().x + self.shift[0] * self.cell_size[0]

    @property
    def y(self) -> Array:
        return super().y + self.shift[1] * self.cell_size[1]


def _lines(cells: tuple[int, int], axis: int, points: int) -> tuple[int, int]:
    """Return the shape of a grid with `points` points a cell along `axis`, and fewer lines where there are many."""
    counts = list(cells)
    counts[axis] *= points
    counts[1 - axis] = min(
        cells[1 - axis], max(CONSTANTS.lines, cells[1 - axis] // CONSTANTS.sparse)
    )
    return counts[0], counts[1]


def mean_height(source: Source, grid: Grid, gap: Array) -> float:
    """Return the mean of a `gap` (x, y) [m] on a grid, over the length of the bodies."""
    lengths = getattr(source, "covered_fractions", lambda _: None)(grid)
    means = np.broadcast_to(gap.mean(axis=0), grid.cells[1])
    return float(np.average(means, weights=lengths))


def _with_neighbours(pressure: Array, problem: Problem) -> Array:
    """Return the largest pressure of each cell and its neighbours."""
    assert problem.paddings is not None
    largest = pressure
    for axis, padding in enumerate(problem.paddings):
        along = with_ends(axis_first(largest, axis), 1, wraps=padding.wraps)
        beside = np.maximum(np.maximum(along[:-2], along[1:-1]), along[2:])
        largest = axis_first(beside, axis)
    return largest


def _modulus(problem: Problem, axis: int) -> float:
    """Return E* [Pa] from the displacement under a pressure that alternates from cell to cell along an `axis`.

    A wave of pressure p of the wave number k displaces a half-space by ``2 p / (E* k)``, here with ``k = pi / dx``.
    """
    across, along = (np.ones(count) for count in problem.grid.cells)
    alternating = along if axis else across
    alternating[1::2] = -1
    alternating[len(alternating) // 2 * 2 :] = 0  # the mean of an odd number of cells
    if isinstance(problem.operator, Convolution):
        energy = problem.operator.work_of_product(across, along)
    else:
        wave = across[:, None] * along
        energy = float((problem.operator(wave) * wave).sum())
    loaded = np.count_nonzero(across) * np.count_nonzero(along)
    return 2 * problem.grid.cell_size[axis] * loaded / (pi * energy)
