"""One computation: what to solve, and how exactly."""

from dataclasses import dataclass, field

from contactstudy import Grid, Padding, PolonskyKeer, Problem, Scene, Solution, Solver, solve


@dataclass(frozen=True)
class Case:
    """A scene on a grid with a padding, and the solver's settings.

    A case is a value: points of a study that come to the same case are computed once.
    """

    scene: Scene
    grid: Grid
    padding: Padding
    tolerance: float = 1e-8
    max_iterations: int = 2000
    solver: Solver = field(default_factory=PolonskyKeer)

    def problem(self) -> Problem:
        """The set-up: influence coefficients, transforms, gap."""
        return self.scene.problem(self.grid, self.padding)

    def solve(self, problem: Problem) -> Solution:
        """The solve proper."""
        return solve(
            problem,
            tolerance=self.tolerance,
            max_iterations=self.max_iterations,
            solver=self.solver,
        )
