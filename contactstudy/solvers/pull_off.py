"""Pull-off: the load at which a contact with adhesion loses its equilibrium, by a search over loads."""

from dataclasses import dataclass, replace
from math import inf

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.problem.problem import Problem
from contactstudy.solvers.adhesion import AdhesiveSolver
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# Iterations of each load but the first over those of a solve: just beyond the last stable load the bodies detach slowly.
ITERATION_FACTOR = 10
# Step of the load over the sum of the attraction, until a load is unstable.
LOAD_STEP = 0.25


@dataclass(frozen=True, eq=False)
class PullOffSearch:
    """Search for the pull-off load of a contact with adhesion, from the load of its problem on.

    The load is lowered until the bodies detach, and bisected between the last stable load and the first unstable one.
    Each solve begins with the last stable state. A load at which the solve does not converge ends the search.

    Parameters
    ----------
    solver
        Solver of each load.
    error
        Difference of both loads over the first unstable one.
    """

    solver: AdhesiveSolver
    error: float

    def continued(self, attraction: Array) -> "PullOffSearch":
        """Return this search, which begins with the load of its problem in any case."""
        return self

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the last stable state; its part `adhesion` has the first unstable load, None if none was found.

        Where the solve at some load does not converge, the status is that of this load, which the note says.
        """
        assert isinstance(problem.control, PrescribedLoad)
        last_stable = self.solver.solve(problem, options, start, device)
        status, note = last_stable.status, last_stable.note
        iterations, convolutions = last_stable.iterations, last_stable.convolutions
        load, first_unstable = problem.control.total, -inf
        to_load_per_length = problem.grid.cell_area / problem.grid.length
        options = replace(options, max_iterations=ITERATION_FACTOR * options.max_iterations)
        while status.has_converged and (
            first_unstable == -inf or load - first_unstable > self.error * abs(first_unstable)
        ):
            assert last_stable.adhesion is not None
            pull = LOAD_STEP * float(last_stable.adhesion.attraction.sum())
            # bodies that attract each other do not separate under a load of at least 0
            trial = min(load - pull, 0.0) if first_unstable == -inf else (load + first_unstable) / 2
            lowered = replace(problem, control=PrescribedLoad(trial))
            state = self.solver.after(last_stable).solve(lowered, options, last_stable.pressure, device)
            iterations += state.iterations
            convolutions += state.convolutions
            if state.status is Status.DETACHED:
                first_unstable = trial
                continue
            status, note = state.status, state.note
            if status.has_converged:
                load, last_stable = trial, state
            else:
                where = f"{trial * to_load_per_length:.4g} N/m"
                ended = f"The search for the pull-off load ended at {where}, where it did not converge."
                note = f"{note} {ended}".lstrip()
        assert last_stable.adhesion is not None
        part = replace(
            last_stable.adhesion,
            branch=self.solver.branch.value,
            first_unstable_load=first_unstable * to_load_per_length if first_unstable > -inf else None,
        )
        return replace(
            last_stable, status=status, note=note, iterations=iterations, convolutions=convolutions, adhesion=part
        )
