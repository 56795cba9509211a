"""Preconditioned conjugate gradients that look before they step, from coarse grids to fine."""

from dataclasses import dataclass

import numpy as np

from contactstudy.arrays import Array, inner
from contactstudy.iterate import Iterate, Stall
from contactstudy.polonsky_keer import PolonskyKeer
from contactstudy.pressures import AdmissiblePressures
from contactstudy.problem import BareProblem

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
        """Iterate until ``problem.pressures.residual(pressure, gap) <= tolerance``."""
        work = 0.0
        if start is None:
            start, work = self._from_coarser(problem, max(tolerance, self.coarse_tolerance))
        last = self._descend(problem, start, tolerance, max_iterations, work)
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

    def _from_coarser(self, problem: BareProblem, tolerance: float) -> tuple[Array, float]:
        """A start, and what it cost."""
        small = problem.undeformed_gap.size <= SMALL
        coarse = None if small else problem.coarsened()
        if coarse is None:
            return problem.uniform(), 0.0
        start, work = self._from_coarser(coarse, tolerance)
        last = self._descend(coarse, start, tolerance, self.patience, work)
        ratio = coarse.displacement.work / problem.displacement.work
        blocks = [
            n // m for n, m in zip(problem.undeformed_gap.shape, last.pressure.shape, strict=True)
        ]
        fine = last.pressure.repeat(blocks[0], axis=0).repeat(blocks[1], axis=1)
        return fine, last.convolutions * ratio

    def _descend(
        self,
        problem: BareProblem,
        pressure: Array,
        tolerance: float,
        max_iterations: int,
        work: float,
    ) -> Iterate:
        operator, pressures = problem.displacement, problem.pressures
        precondition, its_work = operator.approximate_inverse()
        pressure = pressures.admit(pressure.copy())
        moved = operator(pressure)
        work += 1
        step = response = None
        length = curvature = 1.0
        own = operator.own
        stall = Stall(self.patience)
        iteration = 0
        while True:
            contact = pressures.free(pressure)
            gap = problem.undeformed_gap + moved
            approach = pressures.approach(pressure, gap, contact)
            gap -= approach
            left = pressures.residual(pressure, gap)
            done = problem.ends(left, moved, tolerance) or iteration == max_iterations
            if done or stall.sees(left):
                return Iterate(pressure, moved, approach, left, iteration, work)
            iteration += 1
            inside = contact.astype(gap.dtype)
            direction = _within(inside, np.negative(precondition(gap * inside)))
            work += 1 + its_work / operator.work
            # a trial cut back to where it began has been no step
            if step is not None and response is not None and curvature > 0:
                conjugate = inner(direction, response) / curvature
                tried = _within(inside, direction - conjugate * step)
                if inner(gap, tried) < 0:
                    direction = tried
            trial = pressure + length * direction
            cut = pressures.cuts(trial)
            pressures.release(trial, pressure, gap, own / self.seed)
            trial = pressures.admit(trial)
            step = trial - pressure
            if inner(gap, step) >= 0:
                # balancing the load has turned the step uphill: that to the nearest pressure never is
                cut, length = True, length / 4
                trial = pressures.nearest(pressure - gap / own)
                step = trial - pressure
            ahead = operator(trial)
            response = ahead - moved
            curvature = inner(step, response)
            best = -inner(gap, step) / curvature if curvature > 0 else 0.0
            taken = (
                _whole_or_best(best) if cut else _to_first_limit(pressures, pressure, step, best)
            )
            if taken == 1:
                pressure, moved = trial, ahead
            else:
                pressure = pressures.clip(pressure + taken * step)
                moved = moved + taken * response
            length *= min(max(best, 0.3), 3.0)


def _whole_or_best(best: float) -> float:
    """How much of a step to take that has cut off tension, ``best`` being the lowest point of its line.

    The whole of it leaves zeros where tension was; beyond it they would turn to tension.
    """
    return 1.0 if best > WHOLE else best


def _to_first_limit(
    pressures: AdmissiblePressures, pressure: Array, step: Array, best: float
) -> float:
    """How much of a step to take that has cut off nothing: up to where a cell would meet a limit."""
    return best if best <= 1 else min(best, max(1.0, pressures.room(pressure, step)))


def _within(inside: Array, direction: Array) -> Array:
    """``direction`` where ``inside`` is 1 and not 0, and such that the load stays as it is, in place.

    Products, for a masked choice costs ten times as much where the mask is rough.
    """
    direction -= inner(direction, inside) / inside.sum()
    direction *= inside
    return direction
