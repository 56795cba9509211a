"""The conjugate gradient scheme of Polonsky & Keer (1999)."""

from dataclasses import dataclass

from contactstudy.domain.device import arrays
from contactstudy.domain.fields import Array, inner, mean_over
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.solvers.iterate import Iterate, Stall


@dataclass(frozen=True)
class PolonskyKeer:
    """Conjugate gradients on the active set, the cells in contact below an upper limit, restarted when the contact
    gains a cell.

    An iteration takes two convolutions. Source: Polonsky & Keer (1999), Wear 231, sect. 3. Additions: an upper limit of
    the pressure, a prescribed approach, a restart where the direction is not a descent direction, the step of a Winkler
    foundation for a single cell, and a projected gradient step where scaling to the load leaves no descent direction.

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
        """Return the state where ``problem.should_stop`` at this `tolerance`, at `max_iterations` or at a stall."""
        xp, constraint = arrays(), problem.constraint
        initial = problem.uniform() if start is None else xp.asarray(start, copy=True)
        pressure = problem.clip_and_scale(initial)
        direction = xp.zeros_like(pressure)
        # delta is 0 after the contact has gained cells, else 1
        previous_squared_norm, delta = 1.0, 0.0
        stall = Stall(self.patience)
        compliance = problem.operator.self_compliance
        iteration = 0
        while True:
            # 1. the gap, whose mean over the active set is zero under a prescribed load
            displacement = problem.operator(pressure)
            gap = problem.gap(pressure, displacement)
            residual = problem.residual(pressure, gap)
            ended = problem.should_stop(residual, displacement, tolerance, gap.largest_displacement)
            if ended or iteration == max_iterations or stall.stalled(residual):
                convolutions = 2.0 * iteration + 1
                return Iterate(pressure, displacement, gap.approach, residual, iteration, convolutions)
            iteration += 1
            # 2. the conjugate direction on the active set
            active = constraint.active(pressure)
            contact_gap = gap.height * active
            squared_norm = inner(contact_gap, contact_gap)
            beta = delta * squared_norm / previous_squared_norm if previous_squared_norm > 0 else 0.0
            direction = contact_gap + beta * direction * active
            previous_squared_norm = squared_norm
            if inner(contact_gap, direction) <= 0:  # addition: restart
                direction = contact_gap
            # 3. the step length, by the second convolution
            response = problem.operator(direction)
            if problem.control.approach is None and squared_norm > 0:
                response -= mean_over(active, response)
            curvature = inner(response, direction)
            # addition: a single active cell has no curvature, nor has none
            step = inner(contact_gap, direction) / curvature if curvature > 0 else 1 / compliance
            # 4. the step, without tension
            before, pressure = pressure, constraint.clip(pressure - step * direction)
            # 5. cells that overlap enter the contact
            at_limit = 1 - constraint.active(pressure)
            trial = constraint.clip(pressure - step * gap.height * at_limit)
            delta = 1.0 if xp.all(trial == pressure) else 0.0
            # 6. the load
            pressure = problem.clip_and_scale(trial)
            # addition: the projected gradient step where that one is no descent direction
            if inner(gap.height, pressure - before) >= 0:
                delta, pressure = 0.0, problem.project(before - step * gap.height)
