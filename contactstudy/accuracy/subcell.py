"""What the heights do inside the cells, which a pressure on the grid cannot show."""

from dataclasses import dataclass
from math import ceil, log, pi, prod

import numpy as np

from contactstudy.accuracy.coarser import on_cells
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.problem.problem import Problem

# Points in a cell, along one axis at a time: where the shapes name their scales, and where one does not.
POINTS, DENSE = 4, 48
# Lines that are looked at: all of so many, of more every fourth.
LINES, SPARSE = 64, 4
# A feature over this share of a cell's area is to be found with the confidence asked for.
FEATURE = 0.03
# Steps of the two-dimensional sequence of lowest discrepancy whose points are added one by one:
# Roberts (2018), "The unreasonable effectiveness of quasirandom sequences".
STEPS = 0.7548776662466927, 0.5698402909980532
# A bump ``h exp(-r^2 / s^2)`` pressed flat raises the pressure by ``pi / 2 E* h / s``; a sharper one by twice that.
RISE = 2.0 * pi / 2
# What cubics miss of a feature that the centres show is no more than this share of their second difference.
SHOWN = 0.5
# A corner has so much of the bend of three cells between two neighbouring points; a smooth surface a sixth.
CORNER = 0.7
# Powers n - 1 of a height |x|^n from which a bend counts as smooth, and the least one that is told from a corner.
SMOOTH, FLATTEST = 0.82, 0.1


@dataclass(frozen=True)
class Subcell:
    """``uncertain``: the share of the load whose cells hide heights; ``corner``: how sharp the edges are.

    A cell hides what a cubic through the centres misses, by the pressure that would flatten it, at most
    the highest there. A corner that points out of the body by a slope S raises the pressure by
    ``E* S / (2 pi) ln 2`` each time the cell is halved, and so without limit; ``corner`` is the largest such
    rise in the contact over the peak pressure. ``stands_out``: whether a shape that names no
    scales stands out of a cell so far that it would carry all of the pressure there, and more. ``rise`` is by what
    share of the peak pressure such a shape's features within a cell may raise it, and ``kink`` by what share it may
    still rise on finer cells under a height ``|x|^n`` with n below 2.
    """

    uncertain: float
    corner: float
    stands_out: bool
    rise: float = 0.0
    kink: float = 0.0


def subcell(problem: Problem, pressure: Array, confidence: float) -> Subcell | None:
    """Evaluate the heights inside the cells of ``problem`` where ``pressure`` (x, y) acts, and beside.

    Along lines through the cell centres, and of shapes that name no scales also at points off these lines, as many as
    the ``confidence`` asks for. None where the heights are not known there.
    """
    source, grid = problem.source, problem.grid
    if source is None or problem.paddings is None:
        return None
    beside = _with_neighbours(pressure, problem)
    points_each = POINTS if source.names_scales else DENSE
    hidden, standing = np.zeros_like(pressure), np.zeros_like(pressure)
    corner = kink = 0.0
    for axis, padding in enumerate(problem.paddings):
        if grid.cells[axis] < 4:
            continue
        lines, inside = _lines(grid.cells, axis, 1), _lines(grid.cells, axis, points_each)
        try:
            centres, points = (source.gap(Grid(cells, grid.extent)) for cells in (lines, inside))
        except InvalidInput:
            return None
        if points.shape[axis] == 1:
            continue
        modulus = _modulus(problem, axis)
        missed, stands, edge, bend = (
            np.broadcast_to(np.moveaxis(field, 0, axis), lines)
            for field in _along(
                np.moveaxis(centres, axis, 0),
                np.moveaxis(points, axis, 0),
                grid.cell[axis],
                points_each,
                wraps=padding.wraps,
            )
        )
        if not source.names_scales:
            standing += on_cells(stands * (modulus / grid.cell[axis]), grid.cells)
        hidden += on_cells(missed * (modulus / grid.cell[axis]), grid.cells)
        pressed, halving = on_cells(beside, lines) > 0, modulus * log(2) / (2 * pi)
        corner = max(corner, float(np.where(pressed, edge, 0.0).max()) * halving)
        if not source.names_scales:
            kink = max(kink, float(np.where(pressed, bend, 0.0).max()) * halving)
    rise = 0.0
    if not source.names_scales and min(grid.cells) >= 4:
        try:
            missed, stands, narrow, unseen = _off_lines(problem, confidence)
        except InvalidInput:
            return None
        stiffness = max(_modulus(problem, axis) / grid.cell[axis] for axis in (0, 1))
        hidden = np.maximum(hidden, missed * stiffness)
        standing = np.maximum(standing, stands * stiffness)
        risen = np.where(beside > 0, pressure + RISE * unseen * stiffness / narrow, 0.0)
        rise = max(float(risen.max() / pressure.max()) - 1, 0.0)
    hides = np.minimum(hidden, beside)
    borne = pressure.sum()
    stands_out = bool((standing > beside)[beside > 0].any())
    highest = float(pressure.max())
    return Subcell(float(hides.sum() / borne), corner / highest, stands_out, rise, kink / highest)


@dataclass(frozen=True)
class _Beside(Grid):
    """Points that lie ``aside`` of the centres of a grid's cells, by shares of a cell along each axis."""

    aside: tuple[float, float]

    @property
    def x(self) -> Array:
        return super().x + self.aside[0] * self.cell[0]

    @property
    def y(self) -> Array:
        return super().y + self.aside[1] * self.cell[1]


def _off_lines(problem: Problem, confidence: float) -> tuple[Array, Array, Array, Array]:
    """Return what cubics through the centres miss off their lines [m], what stands out [m], its width and height.

    The width is that of a round bump ``exp(-r^2 / s^2)`` with as large a mean square in the cell, s in cells; the height
    [m] leaves out what the centres show.

    None of k random points in a cell hits a feature over the share q of it with the probability ``(1 - q)^k``; points of
    low discrepancy leave smaller holes. Each point is looked at in all cells at once.
    """
    from scipy import ndimage  # as heavy as all else together

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
    if heights(grid).shape[1] == 1:  # one profile, which lines across have shown
        return missed, missed, np.ones(grid.cells), missed
    wraps = [padding.wraps for padding in problem.paddings]
    beside = _extended(centres, wraps=wraps[0])
    count = ceil(log(1 - confidence) / log(1 - FEATURE))
    for number in range(count):
        across, along = ((0.5 + number * step) % 1 - 0.5 for step in STEPS)
        points = np.broadcast_to(
            heights(_Beside(grid.cells, grid.extent, (across, along))), grid.cells
        )
        smooth = _cubic(_extended(_cubic(beside, across).T, wraps=wraps[1]), along).T
        np.maximum(missed, np.abs(points - smooth), out=missed)
        squares += (points - smooth) ** 2
        np.minimum(lowest, points, out=lowest)
    # above all centres about a cell: a step between two of them hides no height
    mode = tuple("wrap" if closed else "nearest" for closed in wraps)
    stands = np.maximum(ndimage.minimum_filter(centres, 3, mode=mode) - lowest, 0)
    most = count * missed**2
    share = np.divide(squares, most, out=np.ones(grid.cells), where=most > 0)
    shown = np.zeros(grid.cells)
    for axis, closed in enumerate(wraps):
        padded = _extended(np.moveaxis(centres, axis, 0), wraps=closed)[1:-1]
        np.maximum(shown, np.moveaxis(np.abs(np.diff(padded, n=2, axis=0)), 0, axis), out=shown)
    return missed, stands, np.sqrt(2 * share / pi), np.maximum(missed - SHOWN * shown, 0)


def _cubic(extended: Array, place: float) -> Array:
    """Return the cubics through four neighbouring centres, at a ``place`` in cells beside each of the inner ones.

    ``extended`` (n + 4, ...) are the centres with two more at either end.
    """
    count = len(extended) - 4
    nodes = range(-1, 3) if place > 0 else range(-2, 2)
    total = np.zeros((count, *extended.shape[1:]))
    for node in nodes:
        weight = prod((place - other) / (node - other) for other in nodes if other != node)
        total += weight * extended[2 + node : 2 + node + count]
    return total


def _extended(centres: Array, *, wraps: bool) -> Array:
    """Return ``centres`` (n, ...) with two more at either end: a closed axis goes on, else the last cubic does."""
    ends = ((2, 2), *(((0, 0),) * (centres.ndim - 1)))
    padded = np.pad(centres, ends, mode="wrap" if wraps else "edge")
    if not wraps:
        for ghost in (1, 0):
            for side in (padded, padded[::-1]):
                first, second, third, fourth = side[ghost + 1 : ghost + 5]
                side[ghost] = 4 * first - 6 * second + 4 * third - fourth
    return padded


def _lines(cells: tuple[int, int], axis: int, points: int) -> tuple[int, int]:
    """So many points in a cell along an axis; fewer lines beside each other where there are many."""
    counts = list(cells)
    counts[axis] *= points
    counts[1 - axis] = min(cells[1 - axis], max(LINES, cells[1 - axis] // SPARSE))
    return counts[0], counts[1]


def _with_neighbours(pressure: Array, problem: Problem) -> Array:
    """The peak pressure of each cell and those beside it."""
    assert problem.paddings is not None
    highest = pressure
    for axis, padding in enumerate(problem.paddings):
        ends = [(0, 0), (0, 0)]
        ends[axis] = (1, 1)
        around = np.pad(highest, ends, mode="wrap" if padding.wraps else "edge")
        parts = (np.take(around, range(k, k + pressure.shape[axis]), axis) for k in range(3))
        highest = np.maximum.reduce(list(parts))
    return highest


def _modulus(problem: Problem, axis: int) -> float:
    """E* [Pa], from the displacement under a pressure that alternates: ``2 dx / (pi E*)`` of a half-space."""
    nx, ny = problem.grid.cells
    signs = (-1.0) ** np.arange((nx, ny)[axis])
    wave = np.ascontiguousarray(np.broadcast_to(signs[:, None] if axis == 0 else signs, (nx, ny)))
    moved = float((problem.operator(wave) * wave).mean())
    return 2 * problem.grid.cell[axis] / (pi * moved)


def _along(
    centres: Array, inside: Array, step: float, points: int, *, wraps: bool
) -> tuple[Array, Array, Array, Array]:
    """Return what a cubic through ``centres`` misses in each cell [m], what stands out [m], its corner and its kink.

    A height ``|x|^n`` has the share ``(w / W)^(n - 1)`` of the bend over a cell W within w about its apex, which tells
    n. The pressure there rises with the power n - 1 of the cell: all rises to come are that of a corner of the same bend
    in a cell, over ``1 - 2^(1 - n)``. Both are given by their slopes.
    """
    count = len(centres)
    mode = "wrap" if wraps else "edge"
    padded = _extended(centres, wraps=wraps)
    heights = inside.reshape(count, points, -1)
    missed = np.zeros_like(heights[:, 0])
    # above the centres of a cell and of both beside it: a step between two of them hides no height
    highest = np.minimum.reduce(
        [padded[1 : 1 + count], padded[2 : 2 + count], padded[3 : 3 + count]]
    )
    stands = np.maximum(highest - heights.min(axis=1), 0)
    for point in range(points):
        place = (point + 0.5) / points - 0.5
        cubic = _cubic(padded, place)
        np.maximum(missed, np.abs(heights[:, point] - cubic), out=missed)
    beyond = ((1, 1), (0, 0))
    slopes = np.diff(np.pad(inside, beyond, mode=mode), axis=0) * (points / step)  # type: ignore[call-overload]
    bends = np.maximum(np.diff(slopes, axis=0), 0)
    if not wraps:
        bends[[0, -1]] = 0.0
    pairs = bends + np.roll(bends, -1, axis=0)
    own = bends.reshape(count, points, -1).sum(axis=1)
    three = own + np.roll(own, 1, axis=0) + np.roll(own, -1, axis=0)
    strongest = pairs.reshape(count, points, -1).max(axis=1)
    # what a smooth bend of these cells has between two points
    smooth = (three - strongest) * (2 / (3 * points - 2))
    corner = np.where(strongest > CORNER * three, strongest - smooth, 0.0)
    # the bend within half a cell to either side of each pair
    half = points // 2
    sums = np.cumsum(np.pad(bends, ((half, half), (0, 0)), mode=mode), axis=0)  # type: ignore[call-overload]
    around = np.concatenate([sums[points - 1 : points], sums[points:] - sums[:-points]])[
        : len(bends)
    ]
    apex = pairs.reshape(count, points, -1).argmax(axis=1)[:, None]
    about = np.take_along_axis(around.reshape(count, points, -1), apex, axis=1)[:, 0]
    share = np.divide(strongest, about, out=np.ones_like(about), where=about > 0)
    power = np.maximum(np.log(np.maximum(share, 1 / points)) / log(2 / points), FLATTEST)
    from scipy import ndimage  # as heavy as all else together

    # an apex bends more than all about it; where a bend begins, half of the window is straight
    highest_pair = ndimage.maximum_filter1d(pairs, points + 1, axis=0, mode="nearest")
    here = np.take_along_axis(highest_pair.reshape(count, points, -1), apex, axis=1)[:, 0]
    is_apex = (strongest > 0) & (strongest >= here) & (power < SMOOTH)
    if not wraps:
        is_apex[[0, -1]] = False
    kink = np.where(is_apex, about / (1 - 2**-power), 0.0)
    return missed, stands, corner, kink
