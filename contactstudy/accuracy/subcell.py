"""What the heights do inside the cells, which a pressure on the grid cannot show."""

from dataclasses import dataclass
from math import log, pi

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
# A corner has so much of the bend of three cells between two neighbouring points; a smooth surface a sixth.
CORNER = 0.7


@dataclass(frozen=True)
class Subcell:
    """``uncertain``: the share of the load whose cells hide heights; ``corner``: how sharp the edges are.

    A cell hides what a cubic through the centres misses, by the pressure that would flatten it, at most
    the highest there. A corner that points out of the body by a slope S raises the pressure by
    ``E* S / (2 pi) ln 2`` each time the cell is halved, and so without limit; ``corner`` is the largest such
    rise in the contact over the peak pressure. ``stands_out``: whether a shape that names no
    scales stands out of a cell so far that it would carry all of the pressure there, and more.
    """

    uncertain: float
    corner: float
    stands_out: bool


def subcell(problem: Problem, pressure: Array) -> Subcell | None:
    """Evaluate the heights inside the cells of ``problem`` where ``pressure`` (x, y) acts, and beside.

    None where they are not known there.
    """
    source, grid = problem.source, problem.grid
    if source is None or problem.paddings is None:
        return None
    beside = _with_neighbours(pressure, problem)
    points_each = POINTS if source.names_scales else DENSE
    hidden, standing, corner = np.zeros_like(pressure), np.zeros_like(pressure), 0.0
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
        missed, stands, edge = (
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
        sharp = np.where(on_cells(beside, lines) > 0, edge, 0.0)
        corner = max(corner, float(sharp.max()) * modulus * log(2) / (2 * pi))
    hides = np.minimum(hidden, beside)
    borne = pressure.sum()
    stands_out = bool((standing > beside)[beside > 0].any())
    return Subcell(float(hides.sum() / borne), corner / float(pressure.max()), stands_out)


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
) -> tuple[Array, Array, Array]:
    """What a cubic through the ``centres`` misses in each cell [m], that which stands out, and the sharpest corner.

    The corner is given by its slope.
    """
    count = len(centres)
    mode = "wrap" if wraps else "edge"
    padded = np.pad(centres, ((2, 2), (0, 0)), mode=mode)  # type: ignore[call-overload]
    if not wraps:
        for ghost in (1, 0):  # the cubic through the last four goes on
            for ends in (padded, padded[::-1]):
                ends[ghost] = np.tensordot([4, -6, 4, -1], ends[ghost + 1 : ghost + 5], 1)
    heights = inside.reshape(count, points, -1)
    missed = np.zeros_like(heights[:, 0])
    # above the centres of a cell and of both beside it: a step between two of them hides no height
    highest = np.minimum.reduce(
        [padded[1 : 1 + count], padded[2 : 2 + count], padded[3 : 3 + count]]
    )
    stands = np.maximum(highest - heights.min(axis=1), 0)
    for point in range(points):
        place = (point + 0.5) / points - 0.5
        nodes = range(-1, 3) if place > 0 else range(-2, 2)
        cubic = sum(
            np.prod([(place - other) / (node - other) for other in nodes if other != node])
            * padded[2 + node : 2 + node + count]
            for node in nodes
        )
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
    return missed, stands, np.where(strongest > CORNER * three, strongest - smooth, 0.0)
