"""A solver that shows how far it is."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields

from contactstudy.domain.devices.arrays import Array
from contactstudy.domain.devices.device import device
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.gap import Gap
from contactstudy.solvers.iterate import Iterate
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solve import Solver

# Takes the residual and the pressure (x, y), dimensionless; the pressure is the solver's own and changes.
See = Callable[[float, Array], object]


@dataclass(frozen=True)
class Watched:
    """``solver``, which calls ``see(residual, pressure)`` in every iteration on the grid itself, not on coarser ones.

    The pressure is in the unit ``problem.scales.pressure``; who keeps it makes a copy.
    """

    see: See = field(compare=False)
    solver: Solver = field(default_factory=PreconditionedCG)

    def iterate(
        self,
        problem: BareProblem,
        *,
        tolerance: float,
        max_iterations: int,
        start: Array | None = None,
    ) -> Iterate:
        """As the solver does."""
        seen = _Seen(
            **{one.name: getattr(problem, one.name) for one in fields(BareProblem)}, see=self.see
        )
        return self.solver.iterate(
            seen, tolerance=tolerance, max_iterations=max_iterations, start=start
        )


@dataclass(frozen=True, eq=False)
class _Seen(BareProblem):
    """A problem that shows each residual."""

    see: See = field(kw_only=True)

    def residual(self, pressure: Array, gap: Gap) -> float:
        """Shown before it is returned."""
        found = super().residual(pressure, gap)
        self.see(found, device().take(pressure))
        return found
