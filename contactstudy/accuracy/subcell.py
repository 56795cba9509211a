"""Heights inside the cells, which a pressure on the grid does not resolve, and their effect on the contact."""

from dataclasses import dataclass
from functools import cache, cached_property
from math import ceil, log, pi, prod

import numpy as np

from contactstudy.accuracy.discretisation import around_contact, with_ends
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import BLOCK_CELLS, Array, product
from contactstudy.domain.grid import Grid, axis_first, on_cells
from contactstudy.elasticity.convolution import Convolution
from contactstudy.problem.problem import Problem, Source

# Default probability with which a feature is found.
CONFIDENCE = 0.95
# Steps of a two-dimensional sequence of low discrepancy to which points can be added one by one:
# Roberts (2018), "The unreasonable effectiveness of quasirandom sequences".
STEPS = 0.7548776662466927, 0.5698402909980532
# The cubic through the last four points of a row, at the second and the first place beyond them.
BEYOND = np.array([[10.0, -20.0, 15.0, -4.0], [4.0, -6.0, 4.0, -1.0]])


@dataclass(frozen=True)
class SubgridConstants:
    """Constants of the examination of heights inside the cells.

    Attributes
    ----------
    points
        Points in a cell along a line, where all shapes name their length scales.
    points_at_corners
        The same on lines that may have a corner.
    points_without_scales
        The same where a shape names no length scales.
    lines
        Number of lines up to which all are examined.
    sparse
        Of more lines, one in this many is examined.
    feature_area
        Fraction of a cell's area above which a feature is found with the requested confidence.
    pressure_rise
        Rise of the pressure where a hidden height h is pressed flat, over ``E* h / dx``: pi / 2 and pi for waves of two
        cells and of one, and pi / 2 for a bump ``exp(-r^2 / dx^2)``.
    resolved_fraction
        Largest interpolation error of a feature that the centres resolve, over their second difference.
    corner_fraction
        Fraction of the slope change between two neighbouring points that their neighbours do not have, from which it
        is a corner.
    smooth_power
        Power n - 1 of a height ``|x|^n`` from which a bend counts as smooth.
    min_power
        Least such power that is not a corner.
    """

    points: int = 4
    points_at_corners: int = 32
    points_without_scales: int = 48
    lines: int = 64
    sparse: int = 4
    feature_area: float = 0.03
    pressure_rise: float = 2.5
    resolved_fraction: float = 0.5
    corner_fraction: float = 0.7
    smooth_power: float = 0.95
    min_power: float = 0.1


CONSTANTS = SubgridConstants()


@dataclass(frozen=True)
class SubgridEffect:
    """Effect of the heights inside the cells on a contact.

    A cell hides the heights beyond a cubic through the centres, as the pressure that would flatten them, at most the
    pressure there. A corner that points out of the body by a slope S raises the pressure by
    ``E* S / (2 pi) ln 2`` each time the cell is halved, and so without limit.

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
        Fraction by which the peak pressure may still rise on finer cells under a height ``|x|^n`` with n below 2.
    """

    hidden_load: float
    corner_rise: float
    protrudes: bool
    peak_rise: float = 0.0
    kink_rise: float = 0.0
    area_loss: float = 0.0
    mean_height: float = 0.0


@dataclass(frozen=True, eq=False)
class _HiddenHeights:
    """Heights hidden inside the cells along one `axis`, examined on some lines (across, along).

    `missed` is the interpolation error of cubics through the centres and `protrusion` the height above all centres about
    a cell, both [m]; `corner` and `kink` are slopes; `mean` is the mean height of the points below that of the centres
    [m]. The `kink` is None for shapes that name their length scales.
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

    along: tuple[_HiddenHeights, ...]
    between_lines: tuple[Array, Array, Array, Array] | None

    @classmethod
    def from_problem(
        cls, problem: Problem, confidence: float = CONFIDENCE
    ) -> "SubgridHeights | None":
        """Return the heights inside the cells of `problem`, or None where they are not known.

        They are evaluated along lines through the cell centres, and for shapes that name no scales also at points off
        these lines.

        Parameters
        ----------
        problem
            The contact.
        confidence
            Probability with which a feature over 3 % of a cell is found, which sets the number of points off the lines.
        """
        source, grid = problem.source, problem.grid
        if source is None or problem.paddings is None:
            return None
        try:
            points = CONSTANTS.points if source.names_scales else CONSTANTS.points_without_scales
            parts = (
                _hidden_heights(problem, axis, points) for axis in (0, 1) if grid.cells[axis] >= 4
            )
            along = tuple(part for part in parts if part is not None)
            examined = not source.names_scales and min(grid.cells) >= 4
            return cls(along, _between_lines(problem, confidence) if examined else None)
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
            stiffness, halving = (
                modulus / problem.grid.cell_size[part.axis],
                modulus * log(2) / (2 * pi),
            )
            hidden += part.in_rows(part.missed, rows, pressure.shape) * stiffness
            protrusion += part.in_rows(part.protrusion, rows, pressure.shape) * stiffness
            corner = max(corner, part.largest(part.corner, beside, rows, pressure.shape) * halving)
            if part.kink is not None:
                kink = max(kink, part.largest(part.kink, beside, rows, pressure.shape) * halving)
            mean += abs(part.mean)
        peak = float(loaded.max())
        risen = loaded + CONSTANTS.pressure_rise * hidden
        if self.between_lines is not None:
            missed, protrusion_there, narrow, unseen = (field[rows] for field in self.between_lines)
            stiffness = max(
                _modulus(problem, axis) / problem.grid.cell_size[axis] for axis in (0, 1)
            )
            hidden = np.maximum(hidden, missed * stiffness)
            protrusion = np.maximum(protrusion, protrusion_there * stiffness)
            risen = np.maximum(
                risen, loaded + CONSTANTS.pressure_rise * unseen * stiffness / narrow
            )
        rise = float(risen[beside > 0].max(initial=peak)) / peak - 1
        protrudes = bool((protrusion[beside > 0] > peak).any())
        touching = loaded > 0
        area_loss = float((np.minimum(hidden, loaded)[touching] / loaded[touching]).mean())
        hides = float(np.minimum(hidden, beside, out=hidden).sum() / loaded.sum())
        return SubgridEffect(hides, corner / peak, protrudes, rise, kink / peak, area_loss, mean)


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
        of_unknown = () if source.names_scales else (heights.kink(),)
        examined.append((*of_any, *of_unknown))
    on_lines = [
        np.broadcast_to(axis_first(np.concatenate(fields, axis=1), axis), lines)
        for fields in zip(*examined, strict=True)
    ]
    inside_mean, mean = (
        mean_height(source, Grid(cells, grid.extent), axis_first(heights, axis))
        for cells, heights in ((inside, points), (lines, centres))
    )
    hidden = _HiddenHeights(axis, inside_mean - mean, *on_lines)
    if points_each < CONSTANTS.points_at_corners and hidden.corner.any():
        return _hidden_heights(problem, axis, CONSTANTS.points_at_corners)
    return hidden


def mean_height(source: Source, grid: Grid, gap: Array) -> float:
    """Return the mean of a `gap` (x, y) [m] on a grid, over the length of the bodies."""
    lengths = getattr(source, "row_lengths", lambda _: None)(grid)
    rows = np.broadcast_to(gap.mean(axis=0), grid.cells[1])
    return float(np.average(rows, weights=lengths))


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


def _between_lines(problem: Problem, confidence: float) -> tuple[Array, Array, Array, Array]:
    """Return interpolation errors of cubics off their lines [m], the protrusion [m], its width in cells, and the
    hidden heights.

    The width is that of a round bump ``exp(-r^2 / s^2)`` with as large a mean square in the cell. With the probability
    ``(1 - q)^k`` none of k random points in a cell hits a feature over the fraction q of it; points of low discrepancy
    leave smaller holes. Each point is examined in all cells at once.
    """
    from scipy import ndimage  # imported late, since it is slow

    source, grid = problem.source, problem.grid
    assert source is not None
    assert problem.paddings is not None
    heights = getattr(source, "gap_without_scales", source.gap)
    centres = np.broadcast_to(heights(grid), grid.cells)
    missed, squares, lowest = (
        np.zeros(grid.cells),
        np.zeros(grid.cells),
        np.full(grid.cells, np.inf),
    )
    if heights(grid).shape[1] == 1:  # a profile, which the lines across have examined
        return missed, missed, np.ones(grid.cells), missed
    wraps = [padding.wraps for padding in problem.paddings]
    beside = _extended(centres, wraps=wraps[0])
    count = ceil(log(1 - confidence) / log(1 - CONSTANTS.feature_area))
    for number in range(count):
        across, along = ((0.5 + number * step) % 1 - 0.5 for step in STEPS)
        points = np.broadcast_to(
            heights(_ShiftedGrid(grid.cells, grid.extent, (across, along))), grid.cells
        )
        smooth = _cubics(beside, (across,))[0]
        smooth = _cubics(_extended(smooth.T, wraps=wraps[1]), (along,))[0].T
        np.maximum(missed, np.abs(points - smooth), out=missed)
        squares += (points - smooth) ** 2
        np.minimum(lowest, points, out=lowest)
    # above all centres about a cell: a step between two centres hides no height
    mode = tuple("wrap" if is_periodic else "nearest" for is_periodic in wraps)
    protrusion_there = np.maximum(ndimage.minimum_filter(centres, 3, mode=mode) - lowest, 0)
    largest = count * missed**2
    fraction = np.divide(squares, largest, out=np.ones(grid.cells), where=largest > 0)
    shown = np.zeros(grid.cells)
    for axis, is_periodic in enumerate(wraps):
        padded = _extended(axis_first(centres, axis), wraps=is_periodic)[1:-1]
        np.maximum(shown, axis_first(np.abs(np.diff(padded, n=2, axis=0)), axis), out=shown)
    return (
        missed,
        protrusion_there,
        np.sqrt(2 * fraction / pi),
        np.maximum(missed - CONSTANTS.resolved_fraction * shown, 0),
    )


def _cubics(extended: Array, positions: tuple[float, ...]) -> Array:
    """Return the cubics through four neighbouring points, at `positions` in cells from each centre (places, n, lines).

    The points (n + 4, lines) are the centres, `extended` by two at either end.
    """
    count = len(extended) - 4
    nodes = np.stack([extended[node : node + count] for node in range(5)])
    weights = np.array([_weights(position) for position in positions])
    return product(weights, nodes.reshape(5, -1)).reshape(len(positions), *nodes.shape[1:])


@cache
def _weights(position: float) -> tuple[float, ...]:
    """Return the weights of a centre and two more on either side in the cubic at a `position`; one of five is zero."""
    nodes = range(-1, 3) if position > 0 else range(-2, 2)
    return tuple(
        prod((position - near) / (node - near) for near in nodes if near != node)
        if node in nodes
        else 0.0
        for node in range(-2, 3)
    )


def _extended(centres: Array, *, wraps: bool) -> Array:
    """Return `centres` (n, lines) with two more at either end: those of a closed axis, or of the last cubic."""
    padded = with_ends(centres, 2, wraps=wraps)
    if not wraps:
        for side in (padded, padded[::-1]):
            side[:2] = product(BEYOND, side[2:6])
    return padded


def _lines(cells: tuple[int, int], axis: int, points: int) -> tuple[int, int]:
    """Return the shape of a grid with `points` points a cell along `axis`, and fewer lines where there are many."""
    counts = list(cells)
    counts[axis] *= points
    counts[1 - axis] = min(
        cells[1 - axis], max(CONSTANTS.lines, cells[1 - axis] // CONSTANTS.sparse)
    )
    return counts[0], counts[1]


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
    """Return E* [Pa] from the displacement under an alternating pressure, ``2 dx / (pi E*)`` for a half-space."""
    across, along = (np.ones(count) for count in problem.grid.cells)
    (along if axis else across)[1::2] = -1
    if isinstance(problem.operator, Convolution):
        energy = problem.operator.energy_of_product(across, along)
    else:
        wave = across[:, None] * along
        energy = float((problem.operator(wave) * wave).sum())
    return 2 * problem.grid.cell_size[axis] * prod(problem.grid.cells) / (pi * energy)


@dataclass(frozen=True)
class SampledHeights:
    """Heights inside the cells along one axis, of shapes (n, ...) for n cells.

    Attributes
    ----------
    missed
        What a cubic through the centres misses in each cell [m].
    slope_changes
        Change of the slope at each point (n points, ...), above zero where it points out of the body.
    wraps
        Whether the axis wraps.
    padded
        Heights at the centres, and at two more at either end (n + 4, ...) [m].
    heights
        Heights inside the cells (n, points, ...) [m].
    """

    missed: Array
    slope_changes: Array
    wraps: bool
    padded: Array
    heights: Array

    @classmethod
    def from_heights(
        cls, centres: Array, inside: Array, step: float, *, wraps: bool
    ) -> "SampledHeights":
        """Return what heights (n, ...) at the centres, and (n points, ...) inside cells of width `step`, show [m]."""
        count = len(centres)
        points = len(inside) // count
        padded = np.ascontiguousarray(_extended(centres, wraps=wraps))
        inside = np.ascontiguousarray(inside)  # along the length they are not, which takes longer
        heights = inside.reshape(count, points, -1)
        missed = _cubics(padded, tuple((point + 0.5) / points - 0.5 for point in range(points)))
        missed -= heights.swapaxes(0, 1)
        missed = np.abs(missed, out=missed).max(axis=0)
        slope_changes = np.diff(with_ends(inside, 1, wraps=wraps), n=2, axis=0)
        rounding = 8 * np.finfo(float).eps * max(inside.max(), -inside.min())
        slope_changes[np.abs(slope_changes) < rounding] = 0.0
        slope_changes *= points / step
        if not wraps:
            slope_changes[[0, -1]] = 0.0
        return cls(missed, slope_changes, wraps, padded, heights)

    @property
    def protrusion(self) -> Array:
        """Heights above the centres of a cell and its neighbours (n, ...) [m]; a step between centres is not hidden."""
        lowest = np.minimum(np.minimum(self.padded[1:-3], self.padded[2:-2]), self.padded[3:-1])
        return np.asarray(np.maximum(lowest - self.heights.min(axis=1), 0))

    @cached_property
    def _outward(self) -> Array:
        """Slope changes that point out of the body (n points, ...); zero elsewhere."""
        return np.maximum(self.slope_changes, 0)

    @cached_property
    def _in_cells(self) -> tuple[Array, Array]:
        """Outward slope changes of pairs of neighbours (n points, ...), and the same by cells (n, points, ...)."""
        slope_changes = self._outward
        pairs = np.empty_like(slope_changes)
        np.add(slope_changes[:-1], slope_changes[1:], out=pairs[:-1])
        np.add(slope_changes[-1], slope_changes[0], out=pairs[-1])
        return pairs, pairs.reshape(len(self.missed), -1, *pairs.shape[1:])

    def corner(self) -> Array:
        """Return the slope of the corner in each cell (n, ...), 0 where its bend is that of a smooth surface.

        A corner bends between two neighbouring points alone, and more than the mean of its cell; a smooth surface bends
        as much on either side.
        """
        all_pairs, pairs = self._in_cells
        slope_changes = np.abs(self.slope_changes)
        slope = all_pairs - np.roll(slope_changes, 1, axis=0) - np.roll(slope_changes, -2, axis=0)
        slope[slope <= CONSTANTS.corner_fraction * all_pairs] = 0.0
        steepest = slope.reshape(pairs.shape).max(axis=1)
        usual = slope_changes.reshape(pairs.shape).mean(axis=1)
        return np.where(steepest > usual, steepest, 0.0)

    def kink(self) -> Array:
        """Return the slope of all rises to come at a height ``|x|^n`` in each cell (n, ...), 0 where there is none.

        It has the fraction ``(w / W)^(n - 1)`` of the slope change over a cell W within w about its apex, which tells
        n. The pressure there rises with the power n - 1 of the cell: all rises to come are that of a corner of the same
        bend in a cell, over ``1 - 2^(1 - n)``.
        """
        from scipy import ndimage  # imported late, since it is slow

        all_pairs, pairs = self._in_cells
        points = pairs.shape[1]
        strongest = pairs.max(axis=1)
        # the bend within half a cell to either side of each pair
        sums = np.cumsum(with_ends(self._outward, points // 2, wraps=self.wraps), axis=0)
        around = np.concatenate([sums[points - 1 : points], sums[points:] - sums[:-points]])
        apex = pairs.argmax(axis=1)[:, None]
        about = np.take_along_axis(around[: len(all_pairs)].reshape(pairs.shape), apex, axis=1)[
            :, 0
        ]
        fraction = np.divide(strongest, about, out=np.ones_like(about), where=about > 0)
        power = np.maximum(
            np.log(np.maximum(fraction, 1 / points)) / log(2 / points), CONSTANTS.min_power
        )
        # an apex bends more than all about it; where a bend begins, half of the window is straight
        highest = ndimage.maximum_filter1d(all_pairs, points + 1, axis=0, mode="nearest")
        window_peak = np.take_along_axis(highest.reshape(pairs.shape), apex, axis=1)[:, 0]
        is_apex = (strongest > 0) & (strongest >= window_peak) & (power < CONSTANTS.smooth_power)
        if not self.wraps:
            is_apex[[0, -1]] = False
        return np.where(is_apex, about / (1 - 2**-power), 0.0)
