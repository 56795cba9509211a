"""Heights inside the cells, which a pressure on the grid does not resolve, and their effect on the contact.

1. The gap is sampled at points inside the cells, on lines through their centres along each axis. Where a shape names no
   length scales (how short its waves are), it is also sampled between the lines.
2. What a cubic through the centres misses is hidden. It counts as the pressure that would flatten it. A corner raises
   the pressure at each halving of the cells.

E* is the contact modulus and dx the size of a cell along the axis in question. Samples along a line are arrays
(n, lines), with the axis that the lines run along first. Heights of the gap grow away from the contact.
"""

from dataclasses import dataclass
from math import log, pi

import numpy as np

from contactstudy.accuracy.coarser import around_contact, with_ends, wraps_of
from contactstudy.domain.grid import BLOCK_CELLS, Array, Grid, axis_first, on_cells
from contactstudy.domain.validation import InvalidInput
from contactstudy.elasticity.convolution import Convolution
from contactstudy.problem.problem import Problem

# Steps of a two-dimensional sequence of low discrepancy to which points can be added one by one: 1 / g and 1 / g^2 with
# g^3 = g + 1 (Roberts 2018, "The unreasonable effectiveness of quasirandom sequences").
STEPS = 0.7548776662466927, 0.5698402909980532
# Weights of four points at the end of a row, the outermost first, in the value of their cubic at the second and at the
# first place beyond them.
BEYOND = np.array([[10.0, -20.0, 15.0, -4.0], [4.0, -6.0, 4.0, -1.0]])


# Points in a cell along a line, where all shapes name their length scales: four show 81 % and more of the largest error
# of the cubics in waves of two cells and longer.
POINTS_PER_CELL = 4
# Points in a cell along a line that may have a corner, where all shapes name their length scales. With these, the bend
# of a smooth surface between two points is a quarter of that at `POINTS_PER_CELL`, and that of a corner the same.
POINTS_AT_CORNERS = 16
# Points in a cell along a line, where a shape names no length scales: features of 2 % of a cell are found.
POINTS_WITHOUT_SCALES = 48
# Points in a cell off the lines, where a shape names no length scales: a feature that covers 3 % of the cell is found
# with a probability of 95 %.
POINTS_OFF_LINES = 99
# Of more than LEAST_LINES lines along an axis about one in LINES_PER_EXAMINED is examined, but at least LEAST_LINES.
# Their number is odd and has no divisor in common with a number of cells that four divides, or lines would keep in step
# with a texture of four cells and pass all its dimples by. On rough surfaces of 512^2 and 1024^2 cells, 1.2 to 5 in the
# shortest wave, the hidden fraction of the load was that by all lines to 1 %, and the rise of the peak 0.8 times that
# and more; on dimples they were 0.9 and 1.2 times and more. Bounds of the peak were twice the errors of 44 surfaces and
# more.
LEAST_LINES, LINES_PER_EXAMINED = 256, 4
# Rise of the pressure where a hidden height h is pressed flat, over ``E* h / dx``. It is pi / 2 and pi for waves of two
# cells and of one, and pi / 2 for a bump ``exp(-r^2 / dx^2)``.
PRESSURE_RISE = pi
# Rise on all finer cells over that rise, where a shape names no length scales: at most 3.2 under heights ``|x|^n`` with
# n from 1.5 on.
FURTHER_RISE = 3.5
# Two neighbouring points are at a corner if their slope changes, less those at the points before and after them, are
# more than this fraction of them: a height ``|x|^n`` with n below 1.5 has more, a smooth one none.
CORNER_FRACTION = 0.55


@dataclass(frozen=True)
class HiddenEffect:
    """Effect of the heights inside the cells on a contact.

    The hidden pressure of a cell is that which would flatten its hidden height.

    Attributes
    ----------
    hidden_load
        Sum over the cells of the hidden pressure, at most that acting in or beside the cell, over the load.
    corner_rise
        Largest rise at a corner in the contact when the cells are halved, over the peak pressure.
    protrudes
        True if the surface protrudes from a cell so far that it would carry more than the peak pressure.
    peak_rise
        Fraction of the peak pressure by which hidden heights may raise it.
    area_loss
        Fraction of the contact that may open: the mean over its cells of hidden over acting pressure, at most 1 in
        each.
    """

    hidden_load: float
    corner_rise: float
    protrudes: bool
    peak_rise: float
    area_loss: float


@dataclass(frozen=True, eq=False)
class HiddenHeights:
    """Heights inside the cells of a grid, which are the same at any instant, as pressures (x, y) [Pa].

    A corner that points out of the body, at which the slope changes by S, raises the pressure by ``E* S / (2 pi) ln 2``
    each time the cell is halved, and so without limit. The pressure near the apex of a blunt wedge is logarithmic
    (Johnson 1985, sect. 5.2).

    Attributes
    ----------
    missed
        Pressure that would flatten the heights which cubics through the centres miss.
    protrusion
        Pressure that would flatten the heights above the centres of a cell and its neighbours.
    rise
        Rise of the pressure by the missed heights.
    corner
        Rise of the pressure at a corner when the cells are halved.
    moduli
        E* [Pa] along each axis of several cells, by which heights became pressures.
    """

    missed: Array
    protrusion: Array
    rise: Array
    corner: Array
    moduli: tuple[float, ...]

    @classmethod
    def from_problem(cls, problem: Problem) -> "HiddenHeights | None":
        """Return the heights inside the cells of `problem`; None where no source samples them."""
        source, grid = problem.source, problem.grid
        if source is None or problem.paddings is None:
            return None
        missed, protrusion, corner = np.zeros((3, 1, 1))
        points = POINTS_PER_CELL if source.has_length_scales else POINTS_WITHOUT_SCALES
        axes = [axis for axis in (0, 1) if grid.cells[axis] > 1]
        moduli = _moduli(problem)
        stiffness = [modulus / grid.cell_size[axis] for axis, modulus in zip(axes, moduli, strict=True)]
        try:
            for axis, modulus, stiff in zip(axes, moduli, stiffness, strict=True):
                if (fields := _on_lines(problem, axis, points)) is None:
                    continue
                missed_here, protruding, slope_change = fields
                missed, protrusion = missed + missed_here * stiff, protrusion + protruding * stiff
                corner = np.maximum(corner, slope_change * modulus * log(2) / (2 * pi))
            # the pressure below a height ``|x|^n`` goes on rising on finer cells
            rise = PRESSURE_RISE * missed * (1 if source.has_length_scales else FURTHER_RISE)
            if not source.has_length_scales and len(axes) == 2:
                missed_there, protrusion_there, rise_there = _off_lines(problem)
                missed = np.maximum(missed, missed_there * max(stiffness))
                protrusion = np.maximum(protrusion, protrusion_there * max(stiffness))
                rise = np.maximum(rise, rise_there * max(stiffness))
        except InvalidInput:  # a shape refuses so many points
            return None
        missed, protrusion, rise, corner = (
            np.broadcast_to(field, grid.cells) for field in (missed, protrusion, rise, corner)
        )
        return cls(missed, protrusion, rise, corner, moduli)

    def effect_under(self, problem: Problem, pressure: Array) -> HiddenEffect:
        """Return the effect of the heights where `pressure` (x, y) [Pa] acts, and in the neighbouring cells.

        In a step in time in which the bodies creep or wear, `problem` is softer than that of the heights, and less
        pressure flattens them.
        """
        from scipy.ndimage import maximum_filter  # imported late, since it is slow

        rows = around_contact(pressure)
        loaded = pressure[rows]
        modes = tuple("wrap" if wraps else "nearest" for wraps in wraps_of(problem))
        beside = maximum_filter(loaded, 3, mode=modes)
        near, touching, peak = beside > 0, loaded > 0, float(loaded.max())
        pairs = zip(_moduli(problem), self.moduli, strict=True)
        softer = max((now / first for now, first in pairs), default=1.0)

        def largest(field: Array) -> float:
            """Return the largest value near the contact of a `field` of pressures, over the peak pressure."""
            return softer * float(np.where(near, field[rows], 0.0).max()) / peak

        hidden = softer * self.missed[rows]
        opens = np.minimum(hidden, loaded) / np.where(touching, loaded, 1.0)
        return HiddenEffect(
            float(np.minimum(hidden, beside).sum() / loaded.sum()),
            largest(self.corner),
            largest(self.protrusion) > 1,
            float(np.where(near, loaded + softer * self.rise[rows], peak).max()) / peak - 1,
            float(opens.sum()) / np.count_nonzero(touching),
        )


def _on_lines(problem: Problem, axis: int, points: int) -> list[Array] | None:
    """Return what lines through the centres along an `axis` show, with some `points` in each cell.

    They show missed heights [m], protrusions [m] and slope changes at corners, each a field (x, y), of one cell along
    an axis along which it does not vary. The answer is None where the heights do not vary along `axis`. Where a bend
    may be that of a corner, all lines are examined again at more points.
    """
    source, grid, wraps = problem.source, problem.grid, wraps_of(problem)[axis]
    assert source is not None
    cells = list(grid.cells)
    cells[1 - axis] = min(cells[1 - axis], max(LEAST_LINES, cells[1 - axis] // LINES_PER_EXAMINED) + 1 | 1)
    finer = (points * cells[0], cells[1]) if axis == 0 else (cells[0], points * cells[1])
    sampled = (source.gap(Grid(counts, grid.extent)) for counts in ((cells[0], cells[1]), finer))
    centres, inside = (axis_first(heights, axis) for heights in sampled)
    if len(inside) == len(centres) == 1:
        return None
    # a shape may vary along an axis at the points alone, or at the centres alone
    width = max(inside.shape[1], centres.shape[1])
    centres = np.broadcast_to(centres, (cells[axis], width))
    inside = np.broadcast_to(inside, (points * cells[axis], width))
    examined = []
    # some lines at a time, whose arrays fit into the cache
    together = max(1, BLOCK_CELLS // len(inside))
    for begin in range(0, width, together):
        lines = slice(begin, begin + together)
        bends = _slope_changes(inside[:, lines], grid.cell_size[axis] / points, wraps=wraps)
        shown = _shown(centres[:, lines], inside[:, lines], wraps=wraps)
        examined.append((*shown, _corners(bends, points)))
    on_lines = [np.concatenate(fields, axis=1) for fields in zip(*examined, strict=True)]
    if points < POINTS_AT_CORNERS and on_lines[2].any():
        return _on_lines(problem, axis, POINTS_AT_CORNERS)
    if axis and problem.covered_fractions is not None:  # an end is no height that is hidden, up to two cells away
        at_end = np.convolve(problem.covered_fractions < 1, np.ones(5))[2:-2] > 0
        on_lines[:2] = [np.where(at_end[:, None], 0.0, fields) for fields in on_lines[:2]]
    return [_on_grid(axis_first(field, axis), grid) for field in on_lines]


def _shown(centres: Array, inside: Array, *, wraps: bool) -> tuple[Array, Array]:
    """Return the heights (n, lines) [m] that cubics miss and those that protrude, as shown by points inside the cells.

    The cubics go through the `centres` (n, lines) [m], and the heights `inside` (n x points, lines) [m] are compared
    with them. What lies closer than the centres of a cell and of both its neighbours protrudes: a step between two
    centres is not hidden.
    """
    heights = inside.reshape(len(centres), -1, centres.shape[1])
    points, padded = heights.shape[1], _extended(centres, wraps=wraps)
    missed = np.zeros(centres.shape)
    for number in range(points):
        smooth = _cubic(padded, (number + 0.5) / points - 0.5)
        np.maximum(missed, np.abs(smooth - heights[:, number]), out=missed)
    lowest = np.minimum(np.minimum(padded[1:-3], padded[2:-2]), padded[3:-1])
    return missed, np.maximum(lowest - heights.min(axis=1), 0)


def _slope_changes(inside: Array, step: float, *, wraps: bool) -> Array:
    """Return the change of the slope at each point (n, lines), above zero where it points out of the body.

    The points `inside` (n, lines) [m] stand at the distance `step` [m]; changes by rounding are zero.
    """
    changes = np.diff(with_ends(inside, 1, wraps=wraps), n=2, axis=0)
    rounding = 8 * np.finfo(float).eps * max(inside.max(), -inside.min())
    changes[np.abs(changes) < rounding] = 0.0
    if not wraps:
        changes[[0, -1]] = 0.0
    return np.asarray(changes / step)


def _corners(slope_changes: Array, points: int) -> Array:
    """Return the slope change at a corner in each cell (n, lines), 0 where its bend is that of a smooth surface.

    The `slope_changes` (n x points, lines) are those at the points. A corner bends between two neighbouring points
    alone, and more than the mean of its cell; a smooth surface bends as much on either side.
    """
    outward, size = np.maximum(slope_changes, 0), np.abs(slope_changes)
    pairs = outward + np.roll(outward, -1, axis=0)  # of each point and the next one
    slope = pairs - np.roll(size, 1, axis=0) - np.roll(size, -2, axis=0)
    slope[slope <= CORNER_FRACTION * pairs] = 0.0
    steepest, usual = (field.reshape(-1, points, size.shape[1]) for field in (slope, size))
    return np.where(steepest.max(axis=1) > usual.mean(axis=1), steepest.max(axis=1), 0.0)


def _off_lines(problem: Problem) -> tuple[Array, Array, Array]:
    """Return missed heights, protrusions and rises, fields (x, y) [m] of the heights off the lines; 0 for a profile.

    A missed height is the largest interpolation error in the cell of cubics through the centres, and a protrusion lies
    closer than the centres of the cell and all its neighbours. The rise, that of the pressure over ``E* / dx``, is by a
    round bump ``exp(-r^2 / s^2)``, s in cells, with the same largest and mean square error in the cell. Its mean square
    is ``pi s^2 / 2`` times the largest. With the probability ``(1 - q)^k`` none of k random points in a cell hits a
    feature over the fraction q of it; points of low discrepancy leave smaller holes. Each point is examined in all
    cells at once.
    """
    from scipy.ndimage import minimum_filter  # imported late, since it is slow

    source, grid = problem.source, problem.grid
    assert source is not None
    heights = getattr(source, "gap_without_scales", source.gap)  # the lines show shapes with scales
    missed, squares, lowest = (np.zeros(grid.cells), np.zeros(grid.cells), np.full(grid.cells, np.inf))
    if heights(grid).shape[1] == 1:  # the lines across have examined it
        return missed, missed, missed
    centres = np.broadcast_to(heights(grid), grid.cells)
    across, along = wraps_of(problem)
    beside = _extended(centres, wraps=across)
    for number in range(POINTS_OFF_LINES):
        shift = (0.5 + number * STEPS[0]) % 1 - 0.5, (0.5 + number * STEPS[1]) % 1 - 0.5
        points = np.broadcast_to(heights(_ShiftedGrid(grid.cells, grid.extent, shift)), grid.cells)
        smooth = _cubic(_extended(_cubic(beside, shift[0]).T, wraps=along), shift[1]).T
        np.maximum(missed, np.abs(points - smooth), out=missed)
        squares += (points - smooth) ** 2
        np.minimum(lowest, points, out=lowest)
    # above all centres about a cell: a step between two centres hides no height
    modes = tuple("wrap" if is_periodic else "nearest" for is_periodic in (across, along))
    protrusion = np.maximum(minimum_filter(centres, 3, mode=modes) - lowest, 0)
    largest = POINTS_OFF_LINES * missed**2
    fraction = np.divide(squares, largest, out=np.ones(grid.cells), where=largest > 0)
    return missed, protrusion, PRESSURE_RISE * missed / np.sqrt(2 * fraction / pi)


def _cubic(extended: Array, position: float) -> Array:
    """Return the cubics through four neighbouring points, at a `position` in cells from each centre (n, lines).

    The points (n + 4, lines) are the centres, `extended` by two at either end.
    """
    first, t = (1, position) if position >= 0 else (0, position + 1)
    weights = (
        -t * (t - 1) * (t - 2) / 6,
        (t + 1) * (t - 1) * (t - 2) / 2,
        -(t + 1) * t * (t - 2) / 2,
        (t + 1) * t * (t - 1) / 6,
    )
    count, smooth = len(extended) - 4, np.zeros(())
    for node, weight in enumerate(weights, start=first):
        smooth = smooth + weight * extended[node : node + count]
    return smooth


def _extended(centres: Array, *, wraps: bool) -> Array:
    """Return `centres` (n, lines) with two more at either end: periodic ones where it wraps, else of the last cubic.

    Fewer than four centres have no cubic: the last one is repeated.
    """
    padded = with_ends(centres, 2, wraps=wraps)
    if not wraps and len(centres) >= 4:
        for side in (padded, padded[::-1]):
            side[:2] = BEYOND @ side[2:6]
    return padded


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


def _on_grid(field: Array, grid: Grid) -> Array:
    """Return a `field` of some lines (x, y) on all cells, an axis along which it does not vary as it is."""
    cells = [count if present > 1 else 1 for count, present in zip(grid.cells, field.shape, strict=True)]
    return on_cells(field, (cells[0], cells[1]))


def _moduli(problem: Problem) -> tuple[float, ...]:
    """Return E* [Pa] of the bodies of `problem` along each axis of several cells."""
    return tuple(float(_modulus(problem, axis)) for axis in (0, 1) if problem.grid.cells[axis] > 1)


def _modulus(problem: Problem, axis: int) -> float:
    """Return E* [Pa] of `problem` by the displacement under a pressure that alternates from cell to cell along `axis`.

    A wave of pressure p of the wave number k displaces a half-space by ``2 p / (E* k)``, here with ``k = pi / dx``.
    """
    across, along = (np.ones(count) for count in problem.grid.cells)
    alternating = along if axis else across
    alternating[1::2] = -1
    alternating[len(alternating) // 2 * 2 :] = 0  # so that the mean of an odd number of cells is zero
    if isinstance(problem.operator, Convolution):
        energy = problem.operator.work_of_product(across, along)
    else:
        wave = across[:, None] * along
        energy = float((problem.operator(wave) * wave).sum())
    loaded = np.count_nonzero(across) * np.count_nonzero(along)
    return 2 * problem.grid.cell_size[axis] * loaded / (pi * energy)
