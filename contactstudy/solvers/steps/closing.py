"""The pressure that would close the gap of the cells that will bear."""

from numpy.typing import DTypeLike

from contactstudy.domain.devices.arrays import Array
from contactstudy.domain.devices.device import arrays, fused
from contactstudy.domain.devices.rows import compiled, in_blocks
from contactstudy.domain.precision import Precision
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.gap import Gap
from contactstudy.problem.operator import ApproximateInverse

# Heights beyond this are left to double precision: their squares and sums must be numbers in single precision too.
FAR = 1e15


def closing_pressure(
    problem: BareProblem, inverse: ApproximateInverse, pressure: Array, gap: Gap, length: float
) -> tuple[Array, Array, bool]:
    """The pressure that would close the gap of the cells that will bear, these cells, and whether any joined.

    The cells are those that bear pressure, and those that would penetrate after a step that closes their gap and takes
    the surroundings along.
    """
    cells, unlevel = _contact(problem, pressure, gap, inverse.real)
    extension = inverse.extension(cells)
    whole = extension(unlevel)
    del unlevel  # or it would stand beside the waves
    wrong = _join(problem, pressure, gap, length, cells, whole)
    if wrong:
        del extension  # or it would stand beside that of more cells
        extension = inverse.extension(cells)
        whole = extension(_held(gap, cells, whole))
    waves = inverse.waves(whole)
    del whole  # or it would stand beside what comes back
    return extension.transposed(inverse.pressure(waves)), cells, wrong


def preconditioning(problem: BareProblem) -> Precision | None:
    """Of the preconditioner: single where passes are compiled and heights are no strangers to it, else its own.

    It halves the passes' time, not the number of iterations; array operations would have to convert every field.
    """
    if fused() is None or not -FAR < float(arrays().max(problem.undeformed_gap)) < FAR:
        return None
    return Precision.SINGLE


def _contact(
    problem: BareProblem, pressure: Array, gap: Gap, real: DTypeLike
) -> tuple[Array, Array]:
    """Cells that bear pressure (1, others 0) and are at no limit, and their gap, in ``real`` numbers of this type."""
    xp, kernels, most = arrays(), fused(), problem.constraint.capacity(1)
    cells, unlevel = (xp.empty(pressure.shape, dtype=real) for _ in range(2))
    if kernels is not None:
        compiled(kernels.contact, pressure, gap.height, most, cells, unlevel)
        return cells, unlevel

    def some(rows: slice) -> None:
        free = problem.constraint.free(pressure[rows, :])
        cells[rows, :] = free
        unlevel[rows, :] = gap.height[rows, :] * free

    in_blocks(some, pressure.shape)
    return cells, unlevel


def _join(
    problem: BareProblem, pressure: Array, gap: Gap, length: float, cells: Array, whole: Array
) -> bool:
    """To ``cells``, those that will bear pressure (1, others 0); whether any does not yet.

    They are expected to penetrate after a step that changes all heights by so much of ``whole``, the gap of the
    contact extended to all cells, as the step is long. By the penetration as it is, a contact that is a little too
    high over a wide region would gather all cells there whose gap is small.
    """
    xp, kernels, most = arrays(), fused(), problem.constraint.capacity(1)
    if kernels is not None:
        fields = pressure, gap.height, whole, length, most, cells
        return bool(compiled(kernels.joined, *fields, results=1).any())

    def some(rows: slice) -> bool:
        expected = gap.height[rows, :] - length * whole[rows, :]
        wrong = problem.constraint.wrong(pressure[rows, :], expected)
        cells[rows, :] = cells[rows, :] + wrong
        return bool(xp.any(wrong > 0))

    return any(in_blocks(some, pressure.shape))


def _held(gap: Gap, cells: Array, out: Array) -> Array:
    """The gap of ``cells``, which are 1, others 0."""
    kernels = fused()
    if kernels is not None:
        compiled(kernels.product, gap.height, cells, out)
        return out

    def some(rows: slice) -> None:
        out[rows, :] = gap.height[rows, :] * cells[rows, :]

    in_blocks(some, out.shape)
    return out
