"""Preconditioned conjugate gradients that look before they step, from coarse grids to fine."""

from dataclasses import dataclass
from math import prod

from contactstudy.domain.devices.arrays import Array, inner, total
from contactstudy.domain.devices.device import arrays, fused
from contactstudy.domain.devices.rows import in_blocks
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.gap import Gap
from contactstudy.problem.operator import ApproximateInverse
from contactstudy.solvers.iterate import Iterate, Stall
from contactstudy.solvers.polonsky_keer import PolonskyKeer

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
        operator, constraint = problem.operator, problem.constraint
        inverse = operator.approximate_inverse()
        pressure, work = self._begin(problem, start, tolerance)
        pressure = problem.admit(pressure)
        moved = operator(pressure)
        work += 1
        gap: Gap | None = None
        last: _Step | None = None
        length = 1.0
        cut = False
        own = operator.own
        stall = Stall(self.patience)
        iteration = 0
        while True:
            gap = problem.gap(pressure, moved, gap)
            left = problem.residual(pressure, gap)
            done = problem.ends(left, moved, tolerance) or iteration == max_iterations
            if done or stall.sees(left):
                return Iterate(pressure, moved, gap.approach, left, iteration, work)
            iteration += 1
            closing, cells, unlevel, wrong = _closing(problem, inverse, pressure, gap, length)
            same = not cut and not wrong
            direction = _direction(unlevel, closing, cells, last if same else None)
            work += 1 + inverse.work / operator.work
            trial, cut = _trial(problem, pressure, direction, length)
            trial = problem.levelled(trial, cells)
            # or they would stand through the next convolution
            del direction, closing, cells, unlevel
            step, slope = _difference(trial, pressure, gap, last.step if last else None)
            if slope >= 0:
                # balancing the load has turned the step uphill: that to the nearest pressure never is
                cut, length = True, max(length / 4, SHORTEST)
                trial[...] = pressure - gap.height / own
                trial = problem.nearest(trial)
                step, slope = _difference(trial, pressure, gap, step)
            ahead = operator(trial)
            response, curvature = _response(ahead, moved, step, last.response if last else None)
            best = -slope / curvature if curvature > 0 else 0.0
            if cut:
                # zeros are left where tension was; beyond the whole they would turn to tension
                taken = 1.0 if best > WHOLE else best
            else:
                # nor beyond it to just where a cell meets a limit: rounding would say which of many did
                meets = best > 1 and _meets(problem, pressure, step, best)
                taken = 1.0 if meets else best
            last = _Step(step, response, curvature)
            if taken == 1:
                pressure, moved = trial, ahead
            else:
                last.scale(taken)
                pressure += last.step
                moved += last.response
                constraint.clip(pressure)
            del trial, ahead  # or they would stand through the next convolution
            length = min(max(length * min(max(best, 0.3), 3.0), SHORTEST), LONGEST)


@dataclass
class _Step:
    """A step taken, the displacement it made, and their product."""

    step: Array
    response: Array
    curvature: float

    def scale(self, factor: float) -> None:
        """Make it so many times as long."""
        self.step *= factor
        self.response *= factor
        self.curvature *= factor**2


def _direction(gap: Array, closing: Array, cells: Array, last: _Step | None) -> Array:
    """Against the preconditioned ``gap``, ``closing``, and conjugate to the last step where that is downhill.

    Zero outside ``cells``, and such that the load stays as it is. All sums are taken first, so that it
    is written once.
    """
    kernels, conjugate = fused(), last is not None and last.curvature > 0
    if last is None or not conjugate:
        count, closed, share, kept = total(cells), total(closing), 0.0, 0.0
        level = closed / count
    else:
        count, closed, downhill, along, over, ahead, shifted = _products(
            gap, closing, cells, last.step, last.response
        )
        level, kept = closed / count, 0.0
        share = (along - level * over) / last.curvature
        if share * ahead < downhill:
            kept = share
            level -= kept * shifted / count

    def some(rows: slice) -> None:
        direction = closing[rows, :]
        if kernels is not None and last is not None:
            kernels.direction(direction, cells[rows, :], last.step[rows, :], level, kept)
            return
        direction *= -1
        direction += level
        if kept and last is not None:
            direction += kept * last.step[rows, :]
        direction *= cells[rows, :]

    in_blocks(some, closing.shape)
    return closing


def _products(
    gap: Array, closing: Array, cells: Array, step: Array, response: Array
) -> tuple[float, ...]:
    """The sums that make a direction conjugate."""
    kernels = fused()
    if kernels is None:
        pairs = (gap, closing), (closing, response), (cells, response), (gap, step), (cells, step)
        return total(cells), total(closing), *(inner(*pair) for pair in pairs)

    def some(rows: slice) -> tuple[float, ...]:
        fields = gap, closing, cells, step, response
        found: tuple[float, ...] = kernels.products(*(field[rows, :] for field in fields))
        return found

    return tuple(map(sum, zip(*in_blocks(some, gap.shape), strict=True)))


def _closing(
    problem: BareProblem, inverse: ApproximateInverse, pressure: Array, gap: Gap, length: float
) -> tuple[Array, Array, Array, bool]:
    """The pressure that would close the gap of the cells that will bear, and what :func:`_bearing` says of them."""
    cells, unlevel = _contact(problem, pressure, gap)
    extension = inverse.extension(cells)
    whole = extension(unlevel)
    wrong = _bearing(problem, pressure, gap, whole, length, cells, unlevel)
    if wrong:
        del extension, whole  # or they would stand beside those of more cells
        extension = inverse.extension(cells)
        whole = extension(unlevel)
    waves = inverse.waves(whole)
    del whole  # or it would stand beside what comes back
    return extension.transposed(inverse.pressure(waves)), cells, unlevel, wrong


def _contact(problem: BareProblem, pressure: Array, gap: Gap) -> tuple[Array, Array]:
    """Cells that bear pressure (1, others 0) and are at no limit, and their gap."""
    xp, kernels, most = arrays(), fused(), problem.constraint.capacity(1)
    cells, unlevel = xp.empty_like(pressure), xp.empty_like(pressure)

    def some(rows: slice) -> None:
        if kernels is not None:
            fields = pressure, gap.height, cells, unlevel
            kernels.contact(*(field[rows, :] for field in fields), most)
            return
        free = problem.constraint.free(pressure[rows, :])
        cells[rows, :] = free
        unlevel[rows, :] = gap.height[rows, :] * free

    in_blocks(some, pressure.shape)
    return cells, unlevel


def _bearing(
    problem: BareProblem,
    pressure: Array,
    gap: Gap,
    closing: Array,
    length: float,
    cells: Array,
    unlevel: Array,
) -> bool:
    """To ``cells``, those that will bear pressure (1, others 0), and their gap; whether any of them does not yet.

    Those that bear pressure do, and those that would penetrate after a step that closes the gap of the contact
    and takes its surroundings along: by so much of ``closing``, the gap extended to all cells, as the
    step is long. By the penetration as it is, a contact that is a little too high over a wide region would
    gather all cells there whose gap is small.
    """
    xp, kernels, most = arrays(), fused(), problem.constraint.capacity(1)

    def some(rows: slice) -> bool:
        if kernels is not None:
            fields = pressure, gap.height, closing, cells, unlevel
            return bool(kernels.bearing(*(field[rows, :] for field in fields), length, most))
        height = gap.height[rows, :]
        wrong = problem.constraint.wrong(pressure[rows, :], height - length * closing[rows, :])
        own = cells[rows, :]
        own += wrong
        unlevel[rows, :] = height * own
        return bool(xp.any(wrong > 0))

    return any(in_blocks(some, pressure.shape))


def _trial(
    problem: BareProblem, pressure: Array, direction: Array, length: float
) -> tuple[Array, bool]:
    """The pressure one step ahead, in place of the ``direction``, and whether a limit cuts it."""

    kernels, most = fused(), problem.constraint.capacity(1)

    def some(rows: slice) -> bool:
        ahead = direction[rows, :]
        if kernels is not None:
            return bool(kernels.trial(pressure[rows, :], ahead, length, most))
        ahead *= length
        ahead += pressure[rows, :]
        return problem.constraint.cuts(ahead)

    return direction, any(in_blocks(some, pressure.shape))


def _difference(trial: Array, pressure: Array, gap: Gap, out: Array | None) -> tuple[Array, float]:
    """The step to ``trial``, and how fast the energy grows along it."""
    return _changed(trial, pressure, gap.height, out)


def _response(ahead: Array, moved: Array, step: Array, out: Array | None) -> tuple[Array, float]:
    """The change of displacement along a ``step``, and its work on it."""
    return _changed(ahead, moved, step, out)


def _changed(one: Array, other: Array, weight: Array, out: Array | None) -> tuple[Array, float]:
    """``one - other``, and the sum of its product with ``weight``."""
    kernels = fused()
    change = arrays().empty_like(one) if out is None else out

    def some(rows: slice) -> float:
        if kernels is not None:
            fields = one, other, weight, change
            return float(kernels.difference(*(field[rows, :] for field in fields)))
        change[rows, :] = own = one[rows, :] - other[rows, :]
        return inner(weight[rows, :], own)

    return change, sum(in_blocks(some, one.shape))


def _meets(problem: BareProblem, pressure: Array, step: Array, factor: float) -> bool:
    """Whether a cell is beyond a limit so many steps ahead."""

    def some(rows: slice) -> bool:
        return problem.constraint.cuts(pressure[rows, :] + factor * step[rows, :])

    return any(in_blocks(some, pressure.shape))
