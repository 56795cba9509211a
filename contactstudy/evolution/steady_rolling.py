"""Steady rolling of a contact whose bodies creep or are elastic, in the frame of the contact.

In this frame nothing changes with time. The displacement of a viscoelastic body has an instantaneous part and a retarded
one, which trails behind the pressure. The retarded part is a convolution. Its coefficients that are even in x act as a
compliance and belong to the operator of the contact. Those that are odd in x make the pressure asymmetric and lose
energy; their part is lagged: it follows from the pressure of the iteration before.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf
from typing import Any

import numpy as np

from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.errors import ErrorEstimate
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.elasticity.convolution import Coefficients, by_symmetry, general_convolutions, superposed
from contactstudy.problem.problem import Problem
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.shapes.shape import ShapesSource
from contactstudy.scene.solids.bodies import creeps, instantaneous, response
from contactstudy.scene.solids.inelastic import rolling_bodies
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import LaggedSolution, SolveOptions, solve_contact, solve_with_mixing

# Fine cells per cell across, for the retarded displacement under the pressure, and most fine cells in all, which take
# 0.2 s: beyond these there are fewer per cell, at least 2. With 8 the resistance is right to 5e-4 on 32 cells across, a
# tenth of its change to 128 cells; with 2 it is right to 2e-3 on 32 cells, and to 1e-5 on 512.
REFINEMENT, MAX_FINE_CELLS = 8, 2**17
# A shift of the pressure below this fraction of the grid's width is rounding: some fifty units in the last place.
ROUNDING = 1e-14


@dataclass(frozen=True, eq=False)
class SteadyRolling:
    """A contact that rolls steadily, with its rolling resistance, which leaves out losses by the tangential traction.

    Attributes
    ----------
    lagged
        The contact in its own frame, with the number of outer iterations.
    antisymmetric_weights
        Weights [1/Pa] of the influence coefficients [m] that make the displacement that is odd in x; none of elastic
        bodies.
    solve_on
        Solves the same scene on another grid.
    direction
        1 for a contact that moves to larger x, -1 to smaller x.
    """

    lagged: LaggedSolution
    antisymmetric_weights: Mapping[Coefficients, float]
    solve_on: "Callable[[Grid], SteadyRolling]"
    direction: int = 1

    @property
    def solution(self) -> Solution:
        """Pressure, gap and status; the gap includes the part of the displacement that is odd in x."""
        return self.lagged.solution

    @property
    def shift(self) -> float:
        """Distance [m] of the pressure's centroid in front of x = 0; 0 without pressure, and where it is rounding."""
        pressure, grid = self.solution.pressure, self.solution.problem.grid
        total = pressure.sum()
        shift = float(grid.x @ pressure.sum(axis=1) / total) if total else 0.0
        return self.direction * shift if abs(shift) > ROUNDING * grid.extent[0] else 0.0

    @property
    def loses_energy(self) -> bool:
        """True if bodies creep under some pressure: elastic ones have no resistance."""
        return bool(self.antisymmetric_weights) and bool(self.solution.pressure.any())

    @cached_property
    def resistance_coefficient(self) -> float:
        """Coefficient of rolling resistance: the force against the motion over the load.

        It is the power lost in the bodies over speed and load.

        A pressure that is constant in each cell does the work ``p (u(x + dx / 2) - u(x - dx / 2))`` in a length rolled,
        of which only the displacement that is odd in x loses any. That displacement is computed on finer cells. The
        moment of the pressure (for a cylinder, the shift over its radius) has the same limit and a larger error.
        """
        if not self.loses_energy:
            return 0.0
        problem = self.solution.problem
        assert problem.paddings is not None
        (nx, ny), pressure = problem.grid.cells, self.solution.pressure
        times = max(2, min(REFINEMENT, MAX_FINE_CELLS // (nx * ny)))
        fine = Grid((times * nx, ny), problem.grid.extent)
        (convolution,) = general_convolutions([self.antisymmetric_weights], fine, problem.paddings)
        displacement = convolution(np.repeat(pressure, times, axis=0))
        # at a face of cells, the mean of the fine cells on both sides; at an end of the grid, that of the last fine cell
        padded = np.concatenate((displacement[:1], displacement, displacement[-1:]))
        faces = (padded[:-1:times] + padded[1::times]) / 2
        work = -(pressure * np.diff(faces, axis=0)).sum() / problem.grid.cell_size[0]
        return self.direction * float(work / pressure.sum())

    def error_estimate(self, coarse: Solution | None = None) -> ErrorEstimate:
        """Return the estimated errors of the contact.

        `coarse` is its solution on cells of twice the size, if it is at hand; else the contact is solved there. The
        change of the pressure in the last outer iteration adds to the residual, which is infinite where the
        iterations did not converge.
        """
        estimate, status = error_estimate(self.solution, coarse=coarse), self.solution.status
        change, reason = self.lagged.change, ""
        if status is Status.NOT_CONVERGED:
            change, reason = inf, f"No bound: {status}"
        parts: dict[str, Any] = {
            name: replace(part, residual=(part.residual or 0.0) + change, reason=part.reason or reason)
            for name, part in estimate
        }
        warnings = (*filter(None, (reason,)), *estimate.warnings)
        return replace(estimate, **parts, warnings=warnings)


def solve_rolling(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    progress: Callable[[float, float], object] | None = None,
) -> SteadyRolling:
    """Solve `scene` moving at its speed of rolling or tractive rolling, in the frame of the contact.

    The retarded displacement is a convolution with coefficients that extend infinitely far behind the contact, so that
    no wake is cut off. Their symmetric part is in the operator, their antisymmetric part is lagged.

    Parameters
    ----------
    scene
        The scene, with a ``rolling_speed`` and a constant load. Elastic bodies in tractive rolling have none.
    grid, padding
        Cells and boundary conditions, as for :func:`~contactstudy.solve`.
    options
        Method and tolerance, see :func:`~contactstudy.solvers.solve.solve_with_mixing`.
    progress
        Called after each outer iteration with the change of the gap in it, and with the tolerance.

    Returns
    -------
    SteadyRolling
        The contact and its rolling resistance.

    Raises
    ------
    InvalidInput
        If the scene has a load that changes, or a viscoelastic body without an equilibrium modulus, which flows.
    """
    speed = scene.rolling_speed
    assert speed is not None
    elastic = replace(scene, solids=instantaneous(scene.solids), rolling=None)
    problem = elastic.problem(grid, padding)
    weights = response(rolling_bodies(scene.solids, scene.contact_speeds), scene.datum(grid))
    symmetric_weights, antisymmetric_weights = by_symmetry(weights)

    def rolling(problem: Problem) -> Problem:
        """Return an elastic `problem` with the even part of the retarded displacement, and the friction of the scene."""
        friction, paddings = scene.friction, problem.paddings
        assert paddings is not None
        return replace(
            problem,
            operator=superposed(symmetric_weights, problem.grid, padding),
            friction=None
            if friction is None
            else friction.solver(scene, problem.grid, paddings, scene.datum(problem.grid)),
        )

    source = problem.source
    assert isinstance(source, ShapesSource)
    problem = replace(problem, description=PosedScene(scene, grid, padding))
    if any(map(creeps, scene.solids)):
        problem = replace(rolling(problem), source=source.with_problem_step(rolling))
    # the traction changes the pressure between dissimilar bodies; else it is solved once, under the last pressure
    friction_solver = problem.friction
    is_coupled = getattr(friction_solver, "coupling", None) is not None
    odd = [antisymmetric_weights] if antisymmetric_weights else []
    lagged = solve_with_mixing(
        problem if is_coupled else replace(problem, friction=None),
        next(iter(general_convolutions(odd, grid, padding)), None),
        options,
        progress=progress,
    )
    if friction_solver is not None and not is_coupled:
        last = lagged.solution  # its problem has the lagged displacement in the undeformed gap
        with_shear = replace(last.problem, friction=friction_solver)
        sheared = solve_contact(with_shear, options, last.pressure)
        assert sheared.traction is not None
        both = sheared.with_traction(sheared.traction, last.status, last.residual, last.iterations, last.convolutions)
        lagged = replace(lagged, solution=both, outer_iterations=lagged.outer_iterations + 1)
    solve_on = partial(solve_rolling, scene, padding=padding, options=options)
    return SteadyRolling(lagged, antisymmetric_weights, solve_on, -1 if speed < 0 else 1)
