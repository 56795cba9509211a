"""Preconditioned conjugate gradients with a trial step and a start from coarser grids."""

from dataclasses import dataclass
from math import prod

from numpy.typing import DTypeLike

from contactstudy.domain.device import Precision, arrays, fused
from contactstudy.domain.fields import Array, compiled, in_blocks, inner, total
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.constraint import Gap
from contactstudy.problem.operator import ApproximateInverse
from contactstudy.solvers.iterate import Iterate, Stall
from contactstudy.solvers.polonsky_keer import PolonskyKeer

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


def slope_to(trial: Array, pressure: Array, gap: Gap) -> float:
    """How fast the energy grows along the step to ``trial``."""
    kernels, height = fused(), gap.height
    if kernels is not None:
        return float(compiled(kernels.slope, trial, pressure, height, results=1).sum())
    return sum(
        in_blocks(
            lambda rows: inner(height[rows, :], trial[rows, :] - pressure[rows, :]), trial.shape
        )
    )


def curvature_to(trial: Array, pressure: Array, ahead: Array, moved: Array) -> float:
    """The work of the step to ``trial`` on the change of displacement that it makes."""
    kernels = fused()
    if kernels is not None:
        return float(compiled(kernels.curvature, trial, pressure, ahead, moved, results=1).sum())

    def some(rows: slice) -> float:
        return inner(trial[rows, :] - pressure[rows, :], ahead[rows, :] - moved[rows, :])

    return sum(in_blocks(some, trial.shape))


def meets_a_limit(problem: BareProblem, trial: Array, pressure: Array, factor: float) -> bool:
    """Whether a cell is beyond a limit so many steps ahead."""
    kernels, most = fused(), problem.constraint.capacity(1)
    if kernels is not None:
        return bool(compiled(kernels.beyond, trial, pressure, factor, most, results=1).any())

    def some(rows: slice) -> bool:
        step = trial[rows, :] - pressure[rows, :]
        return problem.constraint.cuts(pressure[rows, :] + factor * step)

    return any(in_blocks(some, pressure.shape))


def advance(
    problem: BareProblem, trial: Array, pressure: Array, ahead: Array, moved: Array, taken: float
) -> None:
    """So much of a step: pressure and displacement in place of those ahead, their changes in place of those before."""
    kernels, most = fused(), problem.constraint.capacity(1)
    if kernels is not None:
        compiled(kernels.advance, trial, pressure, ahead, moved, taken, most)
        return

    def some(rows: slice) -> None:
        step, response = trial[rows, :] - pressure[rows, :], ahead[rows, :] - moved[rows, :]
        if taken != 1:
            step *= taken
            response *= taken
            trial[rows, :] = problem.constraint.clip(pressure[rows, :] + step)
            ahead[rows, :] = moved[rows, :] + response
        pressure[rows, :], moved[rows, :] = step, response

    in_blocks(some, trial.shape)


# A trial step that meets a limit is taken whole where that lowers the energy: half the best step is less.
WHOLE = 0.5
# The preconditioner takes a contact to be stiffer than it is, not softer: a step is at most this many
# times as long as it says. Nor shorter than this, or rounding could make it shorter and shorter.
LONGEST, SHORTEST = 1.0, 0.1
# On grids of so few cells an iteration costs the same however few they are: coarser ones save nothing.
SMALL = 1024


@dataclass(frozen=True)
class PreconditionedCG:
    """One convolution and one preconditioning per iteration.

    The direction is the preconditioned gap of the cells that bear pressure or will, those that are
    expected to penetrate once the contact's own gap is closed; where the same cells bear as before, it is made
    conjugate to the last step. A trial pressure one step ahead is made admissible first: tension is cut off,
    and these cells are shifted to carry the load. Its convolution then shows the whole line from here to
    there, on which the best point is known exactly; so every step lowers the energy. Coarser grids give the start,
    down to ``coarse_tolerance``. Where the residual has not halved in ``patience`` iterations, Polonsky & Keer's
    scheme goes on from there, and the solution's note says so.

    Source: active sets Hintermueller, Ito & Kunisch (2002), here with one step of the inner iteration to
    each set; preconditioner Vollebregt (2014); conjugacy Hestenes & Stiefel (1952), eq. 3:1.
    """

    coarse_tolerance: float = 1e-3
    patience: int = 40

    def iterate(
        self,
        problem: BareProblem,
        *,
        tolerance: float,
        max_iterations: int,
        start: Array | None = None,
    ) -> Iterate:
        """Iterate until ``problem.residual(pressure, gap) <= tolerance``."""
        last = self._descend(problem, start, tolerance, max_iterations)
        ended = problem.ends(last.residual, last.displacement, tolerance)
        if ended or last.iterations == max_iterations:
            return last
        rest = PolonskyKeer().iterate(
            problem,
            tolerance=tolerance,
            max_iterations=max_iterations - last.iterations,
            start=last.pressure,
        )
        better = min(last, rest, key=lambda iterate: iterate.residual)
        return Iterate(
            better.pressure,
            better.displacement,
            better.approach,
            better.residual,
            last.iterations + rest.iterations,
            last.convolutions + rest.convolutions,
            f"Preconditioned conjugate gradients stalled at a residual of {last.residual:.1e} after "
            f"{last.iterations} iterations; Polonsky & Keer's scheme went on from there.",
        )

    def _begin(
        self, problem: BareProblem, start: Array | None, tolerance: float
    ) -> tuple[Array, float]:
        """A pressure to begin with, the caller's own, and what it cost."""
        if start is not None:
            return arrays().asarray(start, copy=True), 0.0
        shape = problem.undeformed_gap.shape
        coarse = problem.coarsened() if prod(shape) > SMALL else None
        if coarse is None:
            return problem.uniform(), 0.0
        last = self._descend(coarse, None, max(tolerance, self.coarse_tolerance), self.patience)
        blocks = [n // m for n, m in zip(shape, last.pressure.shape, strict=True)]
        xp = arrays()
        fine = xp.repeat(xp.repeat(last.pressure, blocks[0], axis=0), blocks[1], axis=1)
        return fine, last.convolutions * coarse.operator.work / problem.operator.work

    def _descend(
        self,
        problem: BareProblem,
        start: Array | None,
        tolerance: float,
        max_iterations: int,
    ) -> Iterate:
        operator = problem.operator
        inverse = operator.approximate_inverse(preconditioning(problem))
        pressure, work = self._begin(problem, start, tolerance)
        pressure = problem.admit(pressure)
        moved = operator(pressure)
        work += 1
        gap: Gap | None = None
        last: Step | None = None
        length = 1.0
        cut = False
        own = operator.own
        stall = Stall(self.patience)
        iteration = 0
        while True:
            gap = problem.gap(pressure, moved, gap)
            left = problem.residual(pressure, gap)
            done = problem.ends(left, moved, tolerance, gap.farthest) or iteration == max_iterations
            if done or stall.sees(left):
                return Iterate(pressure, moved, gap.approach, left, iteration, work)
            iteration += 1
            closing, cells, wrong = closing_pressure(problem, inverse, pressure, gap, length)
            same = last if not (cut or wrong) else None
            trial, cut = trial_along(problem, pressure, gap, closing, cells, last, same, length)
            work += 1 + inverse.work / operator.work
            trial = problem.levelled(trial, cells)
            # or they would stand through the next convolution
            del closing, cells, same
            last = None
            slope = slope_to(trial, pressure, gap)
            if slope >= 0:
                # balancing the load has turned the step uphill: that to the nearest pressure never is
                cut, length = True, max(length / 4, SHORTEST)
                trial[...] = pressure - gap.height / own
                trial = problem.nearest(trial)
                slope = slope_to(trial, pressure, gap)
            ahead = operator(trial)
            curvature = curvature_to(trial, pressure, ahead, moved)
            best = -slope / curvature if curvature > 0 else 0.0
            if cut:
                # zeros are left where tension was; beyond the whole they would turn to tension
                taken = 1.0 if best > WHOLE else best
            else:
                # nor beyond it to just where a cell meets a limit: rounding would say which of many did
                meets = best > 1 and meets_a_limit(problem, trial, pressure, best)
                taken = 1.0 if meets else best
            advance(problem, trial, pressure, ahead, moved, taken)
            last = Step(pressure, moved, curvature * taken**2)
            pressure, moved = trial, ahead
            del trial, ahead  # or they would stand beside the next ones
            length = min(max(length * min(max(best, 0.3), 3.0), SHORTEST), LONGEST)
