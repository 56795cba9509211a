"""Preconditioned conjugate gradients that look before they step, from coarse grids to fine."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.arrays import Array, inner
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.gap import Gap
from contactstudy.solvers.iterate import Iterate, Stall
from contactstudy.solvers.polonsky_keer import PolonskyKeer

# A trial step is taken whole, zeros and all, from this share of the best step along its line on.
WHOLE = 0.8
# On grids of so few cells an iteration costs the same however few they are: coarser ones save nothing.
SMALL = 1024


@dataclass(frozen=True)
class PreconditionedCG:
    """One convolution and one preconditioning per iteration.

    The direction is the preconditioned gap of the cells in contact, made conjugate to the step before.
    A trial pressure one step ahead is made admissible first: tension is cut off, cells that penetrate
    get ``seed`` of the pressure that would close their gap alone, the load is balanced. Its convolution
    then shows the whole line from here to there, on which the best point is known exactly; so every
    step lowers the energy. Coarser grids give the start, down to ``coarse_tolerance``. Where
    the residual has not halved in ``patience`` iterations, Polonsky & Keer's scheme goes on from there,
    and the solution's note says so.

    Source: preconditioner Vollebregt (2014); conjugacy Hestenes & Stiefel (1952), eq. 3:1; seeding and
    the line search on the admissible step are of this package.
    """

    coarse_tolerance: float = 1e-4
    seed: float = 0.1
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
            return start.copy(), 0.0
        shape = problem.undeformed_gap.shape
        coarse = problem.coarsened() if problem.undeformed_gap.size > SMALL else None
        if coarse is None:
            return problem.uniform(), 0.0
        last = self._descend(coarse, None, max(tolerance, self.coarse_tolerance), self.patience)
        blocks = [n // m for n, m in zip(shape, last.pressure.shape, strict=True)]
        fine = last.pressure.repeat(blocks[0], axis=0).repeat(blocks[1], axis=1)
        return fine, last.convolutions * coarse.operator.work / problem.operator.work

    def _descend(
        self,
        problem: BareProblem,
        start: Array | None,
        tolerance: float,
        max_iterations: int,
    ) -> Iterate:
        operator, constraint = problem.operator, problem.constraint
        precondition, its_work = operator.approximate_inverse()
        pressure, work = self._begin(problem, start, tolerance)
        pressure = problem.admit(pressure)
        moved = operator(pressure)
        work += 1
        gap: Gap | None = None
        last: _Step | None = None
        length = 1.0
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
            trial = _direction(gap, precondition(gap.held), last)
            work += 1 + its_work / operator.work
            trial *= length
            trial += pressure
            cut = constraint.cuts(trial)
            # as if the limits were not there: a yielding cell thus stands above the hardness, and stays
            # there when the rest is scaled down a little
            trial += gap.overlap * (self.seed / own)
            trial = problem.admit(trial)
            step = np.subtract(trial, pressure, out=last.step if last else None)
            slope = gap.slope(step)
            if slope >= 0:
                # balancing the load has turned the step uphill: that to the nearest pressure never is
                cut, length = True, length / 4
                np.subtract(gap.overlap, gap.held, out=trial)
                trial /= own
                trial += pressure
                trial = problem.nearest(trial)
                np.subtract(trial, pressure, out=step)
                slope = gap.slope(step)
            ahead = operator(trial)
            response = np.subtract(ahead, moved, out=last.response if last else None)
            curvature = inner(step, response)
            best = -slope / curvature if curvature > 0 else 0.0
            if cut:
                # zeros are left where tension was; beyond the whole they would turn to tension
                taken = 1.0 if best > WHOLE else best
            else:
                # nor beyond it to just where a cell meets a limit: rounding would say which of many did
                meets = best > 1 and constraint.cuts(_ahead(pressure, step, best, gap.held))
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
            length *= min(max(best, 0.3), 3.0)


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


def _direction(gap: Gap, closing: Array, last: _Step | None) -> Array:
    """Against the preconditioned gap, ``closing``, and conjugate to the last step where that is downhill.

    Zero in cells at a limit, and such that the load stays as it is. All sums are taken first, so that it
    is written once.
    """
    closing *= gap.free
    cells = gap.free.sum()
    level = closing.sum() / cells
    # a trial cut back to where it began has been no step
    if last is not None and last.curvature > 0:
        kept = (
            inner(closing, last.response) - level * inner(gap.free, last.response)
        ) / last.curvature
        if kept * inner(gap.held, last.step) < inner(gap.held, closing):
            level -= kept * inner(gap.free, last.step) / cells
            direction = last.step * kept
            direction -= closing
            direction += level
            direction *= gap.free
            return np.asarray(direction)
    closing -= level
    closing *= -gap.free
    return closing


def _ahead(pressure: Array, step: Array, factor: float, out: Array) -> Array:
    """The pressure so many steps ahead."""
    np.multiply(step, factor, out=out)
    return np.add(pressure, out, out=out)
