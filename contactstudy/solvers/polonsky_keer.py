"""The conjugate gradient scheme of Polonsky & Keer (1999)."""

from dataclasses import dataclass

from contactstudy.domain.device import arrays
from contactstudy.domain.fields import Array, inner, mean_over
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.solvers.iterate import Iterate, Stall


@dataclass(frozen=True)
class PolonskyKeer:
    """Conjugate gradients on the cells in contact, restarted when the contact gains a cell.

    An iteration takes two convolutions. Source: Polonsky & Keer (1999), Wear 231, sect. 3.

    Parameters
    ----------
    patience
        Iterations without a halving of the residual after which the solver stops.
    """

    patience: int = 400

    def iterate(
        self,
        problem: BareProblem,
        *,
        tolerance: float,
        max_iterations: int,
        start: Array | None = None,
    ) -> Iterate:
        """Iterate until ``problem.residual(pressure, gap) <= tolerance``, the limit, or a stall."""
        xp, constraint = arrays(), problem.constraint
        initial = problem.uniform() if start is None else xp.asarray(start, copy=True)
        pressure = problem.make_admissible(initial)
        direction = xp.zeros_like(pressure)
        previous_squared_norm, conjugate = 1.0, 0.0
        stall = Stall(self.patience)
        compliance = problem.operator.self_compliance
        iteration = 0
        while True:
            displacement = problem.operator(pressure)
            gap = problem.gap(pressure, displacement)
            residual = problem.residual(pressure, gap)
            ended = problem.ends(residual, displacement, tolerance, gap.largest_displacement)
            if ended or iteration == max_iterations or stall.stalled(residual):
                work = 2.0 * iteration + 1
                return Iterate(pressure, displacement, gap.approach, residual, iteration, work)
            iteration += 1
            free = constraint.free(pressure)
            contact_gap = gap.height * free
            squared_norm = inner(contact_gap, contact_gap)
            beta = (
                conjugate * squared_norm / previous_squared_norm
                if previous_squared_norm > 0
                else 0.0
            )
            direction = contact_gap + beta * direction * free
            previous_squared_norm = squared_norm
            if inner(contact_gap, direction) <= 0:  # not a descent direction: restart
                direction = contact_gap
            response = problem.operator(direction)
            if problem.resultant.approach is None:
                response -= mean_over(free, response)
            curvature = inner(response, direction)
            # a single cell in contact has no curvature: take the step of a Winkler foundation
            step = inner(contact_gap, direction) / curvature if curvature > 0 else 1 / compliance
            before, pressure = pressure, constraint.clip(pressure - step * direction)
            at_limit = 1 - constraint.free(pressure)
            trial = xp.maximum(pressure - step * gap.height * at_limit, 0)
            conjugate = 1.0 if xp.all(trial == pressure) else 0.0
            pressure = problem.make_admissible(trial)
            # not a descent direction after projection
            if inner(gap.height, pressure - before) >= 0:
                conjugate, pressure = 0.0, problem.project(before - step * gap.height)
