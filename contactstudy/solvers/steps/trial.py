"""A pressure one step ahead, conjugate to the last step where that is downhill."""

from dataclasses import dataclass

from contactstudy.domain.devices.arrays import Array, inner, total
from contactstudy.domain.devices.device import arrays, fused
from contactstudy.domain.devices.rows import compiled, in_blocks
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.gap import Gap


@dataclass(frozen=True)
class Step:
    """A step taken, the displacement it made, and their product."""

    step: Array
    response: Array
    curvature: float


def trial_along(
    problem: BareProblem,
    pressure: Array,
    gap: Gap,
    closing: Array,
    cells: Array,
    last: Step | None,
    same: Step | None,
    length: float,
) -> tuple[Array, bool]:
    """The pressure one step ahead, in place of the ``last`` one, and whether a limit cuts it.

    The direction is against ``closing`` and conjugate to a step of the ``same`` cells where that is downhill. It is
    zero outside ``cells``, and such that the load stays as it is.
    """
    kernels, most = fused(), problem.constraint.capacity(1)
    gap_level, kept = _direction(gap.height, closing, cells, same)
    trial = arrays().empty_like(pressure) if last is None else last.step
    if kernels is not None:
        fields = pressure, closing, cells, gap_level, kept, length, most, trial
        return trial, bool(compiled(kernels.trial, *fields, results=1).any())

    def some(rows: slice) -> bool:
        way = gap_level - closing[rows, :]
        if kept:
            way += kept * trial[rows, :]
        way *= cells[rows, :]
        way *= length
        way += pressure[rows, :]
        trial[rows, :] = way
        return problem.constraint.cuts(way)

    return trial, any(in_blocks(some, pressure.shape))


def _direction(gap: Array, closing: Array, cells: Array, last: Step | None) -> tuple[float, float]:
    """What to add to the direction against ``closing``: a level, and so much of the last step."""
    if last is None or last.curvature <= 0:
        count, closed = _totals(cells, closing)
        return closed / count, 0.0
    count, closed, downhill, along, over, ahead, shifted = _products(gap, closing, cells, last)
    level = closed / count
    kept = (along - level * over) / last.curvature
    return (level - kept * shifted / count, kept) if kept * ahead < downhill else (level, 0.0)


def _totals(cells: Array, closing: Array) -> tuple[float, ...]:
    """The number of cells, and the pressure that would close them."""
    kernels = fused()
    if kernels is None:
        return total(cells), total(closing)
    return tuple(compiled(kernels.totals, cells, closing, results=2).sum(axis=1).tolist())


def _products(gap: Array, closing: Array, cells: Array, last: Step) -> tuple[float, ...]:
    """The sums that make a direction conjugate."""
    kernels, fields = fused(), (gap, closing, cells, last.step, last.response)
    if kernels is not None:
        return tuple(compiled(kernels.products, *fields, results=7).sum(axis=1).tolist())

    def some(rows: slice) -> tuple[float, ...]:
        height, own, chosen, step, response = (field[rows, :] for field in fields)
        pairs = (height, own), (own, response), (chosen, response), (height * chosen, step)
        return total(chosen), total(own), *(inner(*pair) for pair in pairs), inner(chosen, step)

    return tuple(map(sum, zip(*in_blocks(some, gap.shape), strict=True)))
