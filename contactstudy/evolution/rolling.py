"""Steady rolling of a viscoelastic contact, in the frame of the contact."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, pi

import numpy as np

from contactstudy.accuracy.coarser import halved
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.elasticity.coefficients import Coefficients, Displacement
from contactstudy.elasticity.convolution import antisymmetric, superposed
from contactstudy.elasticity.viscoelastic import RetardedCoefficients
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import instantaneous, response
from contactstudy.scene.inelastic import ViscoelasticHalfSpace
from contactstudy.scene.scene import PosedScene, Scene, ShapesSource
from contactstudy.solvers.lagged import LaggedSolution, solve_lagged
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions

# Fine cells per cell, and the largest number of fine cells, for the delayed displacement under the pressure.
REFINEMENT, MAX_FINE_CELLS = 8, 2**17
# Factors of the upper estimate of the resistance's error: on its change from cells of twice the size, and on the
# pressure's error, measured on smooth, wavy and rough cylinders against cells of an eighth of the size. On coarse cells,
# passes end at the change COARSE_CHANGE.
CHANGE_FACTOR, PRESSURE_FACTOR, COARSE_CHANGE = 2.0, 0.15, 1e-4


@dataclass(frozen=True, eq=False)
class SteadyRolling:
    """A contact that rolls steadily, with its rolling resistance.

    Attributes
    ----------
    lagged
        The contact in its own frame, with the number of passes.
    antisymmetric_weights
        Coefficients [m] and weights [1/Pa] of the displacement that is antisymmetric across.
    solve_on
        Solves the same scene on another grid.
    """

    lagged: LaggedSolution
    antisymmetric_weights: Mapping[Coefficients, float]
    solve_on: "Callable[[Grid], SteadyRolling]"

    @property
    def solution(self) -> Solution:
        """Pressure, gap and status; the gap includes the part of the displacement that is antisymmetric across."""
        return self.lagged.solution

    @property
    def shift(self) -> float:
        """Distance [m] of the pressure's centroid in front of the axis."""
        pressure = self.solution.pressure
        x = self.solution.problem.grid.x
        return float(x @ pressure.sum(axis=1) / pressure.sum())

    @cached_property
    def resistance(self) -> float:
        """Force against the motion over the load, the power lost in the bodies over speed and load.

        A pressure that is constant in each cell does the work ``p (u(x + dx / 2) - u(x - dx / 2))`` in a length rolled,
        of which only the displacement that is antisymmetric across loses any. That displacement is computed on finer
        cells. The moment of the pressure (for a cylinder, the shift over its radius) has the same limit and a larger
        error.
        """
        if not self.antisymmetric_weights:
            return 0.0
        problem = self.solution.problem
        assert problem.paddings is not None
        (nx, ny), pressure = problem.grid.cells, self.solution.pressure
        times = max(2, min(REFINEMENT, MAX_FINE_CELLS // (nx * ny)))
        fine = Grid((times * nx, ny), problem.grid.extent)
        displacement = antisymmetric(self.antisymmetric_weights, fine, problem.paddings)(
            np.repeat(pressure, times, axis=0)
        )
        padded = np.concatenate((displacement[:1], displacement, displacement[-1:]))
        faces = (padded[:-1:times] + padded[1::times]) / 2
        work = -(pressure * np.diff(faces, axis=0)).sum() / problem.grid.cell[0]
        return float(work / pressure.sum())

    @cached_property
    def coarse(self) -> "SteadyRolling | None":
        """This contact on cells of twice the size; None where the scene has no such grid."""
        try:
            return self.solve_on(halved(self.solution.problem.grid))
        except InvalidInput:
            return None

    @property
    def resistance_error(self) -> float:
        """Upper estimate of the relative error of the resistance; infinite without a coarser grid to compare with.

        It is the change from cells of twice the size, and a small fraction of the pressure's L1 error, since the change
        may be small by chance.
        """
        if self.coarse is None or not np.isfinite(self.lagged.change):
            return inf
        if not self.resistance:
            return 0.0
        change = abs(self.coarse.resistance - self.resistance)
        return (
            CHANGE_FACTOR * change / abs(self.resistance)
            + PRESSURE_FACTOR * self._pressure_errors.l1.total
        )

    @cached_property
    def _pressure_errors(self) -> ErrorEstimate:
        """Estimate of the errors, with :attr:`coarse` where the pressure alone does not show them."""
        coarse = None if self.coarse is None else self.coarse.solution
        return error_estimate(self.solution, coarse=coarse)

    def error_estimate(self) -> ErrorEstimate:
        """Return the estimated errors of the contact and of its rolling resistance."""
        resistance = ErrorParts(discretisation=self.resistance_error)
        return replace(self._pressure_errors, rolling_resistance=resistance)


def solve_rolling(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    change: float = 1e-6,
    max_passes: int = 100,
) -> SteadyRolling:
    """Solve `scene` moving at its ``rolling`` speed, in the frame of the contact.

    The delayed displacement is a convolution with coefficients that extend infinitely far behind the contact, so that no
    wake is cut off. Their symmetric part is in the operator, their antisymmetric part is lagged from pass to pass.

    Parameters
    ----------
    scene
        The scene, with a ``rolling`` speed and a constant load.
    grid, padding
        Cells and boundary conditions, as for :func:`~contactstudy.solve`.
    options
        How each pass is solved.
    change
        Relative L1 change of the pressure below which passes end, see :func:`~contactstudy.solvers.lagged.solve_lagged`.
    max_passes
        Largest number of passes.

    Returns
    -------
    SteadyRolling
        The contact and its rolling resistance.

    Raises
    ------
    InvalidInput
        If the scene has no ``rolling``, or has a load that changes, wear or a fluid.
    """
    assert scene.rolling is not None
    if scene.wear is not None:
        raise InvalidInput(
            "Scene.wear changes in time together with Scene.rolling: a body that rolls wears alike all round, leave "
            "rolling out and multiply Wear.coefficient by the contact's width over the circumference."
        )
    elastic = replace(scene, solids=instantaneous(scene.solids), rolling=None)
    problem = elastic.problem(grid, padding)
    datum = problem.scales.length
    symmetric_weights, antisymmetric_weights = _delayed_weights(scene, datum)
    weights = Counter(response(elastic.solids, datum))
    weights.update(symmetric_weights)

    def with_retarded_operator(problem: Problem) -> Problem:
        return (
            replace(problem, operator=superposed(weights, problem.grid, padding))
            if symmetric_weights
            else problem
        )

    assert isinstance(problem.source, ShapesSource)
    problem = replace(
        with_retarded_operator(problem),
        description=PosedScene(scene, grid, padding),
        source=problem.source.with_step(with_retarded_operator),
    )
    lagged = solve_lagged(
        problem,
        antisymmetric(antisymmetric_weights, grid, padding) if antisymmetric_weights else None,
        options,
        change=change,
        max_outer=max_passes,
    )
    coarse = replace(options, tolerance=COARSE_CHANGE / 10)
    solve_on = partial(
        solve_rolling,
        scene,
        padding=padding,
        options=coarse,
        change=COARSE_CHANGE,
        max_passes=max_passes,
    )
    return SteadyRolling(lagged, antisymmetric_weights, solve_on)


def _delayed_weights(
    scene: Scene, datum: float
) -> tuple[Mapping[Coefficients, float], Mapping[Coefficients, float]]:
    """Return coefficients of the bodies' delayed displacements, symmetric and antisymmetric, with weights [1/Pa]."""
    assert scene.rolling is not None
    speed = scene.rolling.speed
    assert speed is not None
    symmetric_weights: dict[Coefficients, float] = {}
    antisymmetric_weights: dict[Coefficients, float] = {}
    for number, body in enumerate(scene.solids):
        if not isinstance(body, ViscoelasticHalfSpace) or speed == inf:
            continue
        if body.creep.fluidity:
            raise InvalidInput(
                f"Scene.solids[{number}] is a fluid (equilibrium modulus 0 Pa), whose indentation in steady rolling is "
                "unbounded: give an equilibrium modulus above 0 Pa."
            )
        for size, time in body.creep.terms:
            still = Displacement(datum)
            delayed = still if speed == 0 else RetardedCoefficients(still, speed * time, 1)
            symmetric_weights[delayed] = symmetric_weights.get(delayed, 0.0) + size / pi
            if isinstance(delayed, RetardedCoefficients):
                opposed = replace(delayed, sign=-1)
                antisymmetric_weights[opposed] = antisymmetric_weights.get(opposed, 0.0) + size / pi
    return symmetric_weights, antisymmetric_weights
