"""Contacts of an evolution, each solved from the pressure of the one before, and bodies without load."""

from dataclasses import dataclass, replace

from contactstudy.domain.fields import Array
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, unloaded
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Factor on the tolerance of a contact that is solved together with a state variable, into which its error goes.
COUPLED_TOLERANCE_FACTOR = 0.01


def solved_or_unloaded(options: SolveOptions, problem: Problem, start: Array | None = None) -> Solution:
    """Return the solution of `problem`; without load, the undeformed bodies that just touch.

    Parameters
    ----------
    options
        How the problem is solved.
    problem
        The contact.
    start
        Pressure (x, y) [Pa] to begin with; None or zero begins on coarser grids.
    """
    if problem.adhesion is None and problem.control.uniform(1) == 0:
        return unloaded(problem)
    begin = start if start is not None and start.any() else None
    return solve_contact(problem, options, begin)


@dataclass(eq=False)
class WarmStartedContact:
    """The contact of `problem` with a field added to its gap, each time solved from the `last` pressure (x, y) [Pa].

    Its tolerance is that of `options` times `COUPLED_TOLERANCE_FACTOR`.
    """

    problem: Problem
    options: SolveOptions
    last: Array

    def __call__(self, added_gap: Array) -> Solution:
        """Return the contact with `added_gap` (x, y) [m] added to its gap."""
        tolerance = COUPLED_TOLERANCE_FACTOR * self.options.tolerance
        options = replace(self.options, tolerance=tolerance)
        solution = solved_or_unloaded(options, with_added_gap(self.problem, added_gap), self.last)
        self.last = solution.pressure
        return solution


def with_added_gap(problem: Problem, added_gap: Array) -> Problem:
    """Return `problem` with `added_gap` (x, y) [m] added to its undeformed gap."""
    return replace(problem, undeformed_gap=problem.undeformed_gap + added_gap)
