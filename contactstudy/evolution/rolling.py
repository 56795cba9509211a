"""A viscoelastic contact that moves steadily across: Scene -> SteadyRolling."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf, pi

import numpy as np

from contactstudy.accuracy.coarser import halved
from contactstudy.accuracy.estimate import ErrorEstimate, error_estimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings
from contactstudy.elasticity.coefficients import Coefficients, Displacement
from contactstudy.elasticity.convolution import antisymmetric, superposed
from contactstudy.elasticity.viscoelastic import Trailing
from contactstudy.evolution.march import StepSource
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import response, sudden
from contactstudy.scene.inelastic import ViscoelasticHalfSpace
from contactstudy.scene.load import ConstantLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.solvers.lagged import Settled, solve_lagged
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, Solver

# Fine cells in a cell, or as many as give this number, on which the delayed displacement under the pressure is found.
FINE, MOST = 8, 2**17
# Error of the resistance at most: over its change from cells of twice the size, on which passes settle to the last, and
# over the error of the pressure. Measured on smooth, wavy and rough cylinders against cells of an eighth.
CHANGED, LEAST, SETTLED = 2.0, 0.15, 1e-4


@dataclass(frozen=True, eq=False)
class SteadyRolling:
    """What ``settled``: its :attr:`solution`, in the frame of the contact, and what moving it takes.

    ``odd`` are the coefficients [m] and weights [1/Pa] of the displacement that is odd across; ``again`` solves the same
    scene on another grid.
    """

    settled: Settled
    odd: Mapping[Coefficients, float]
    again: "Callable[[Grid], SteadyRolling]"

    @property
    def solution(self) -> Solution:
        """Pressure, gap and status; the gap holds the part of the displacement that is odd across, too."""
        return self.settled.solution

    @property
    def shift(self) -> float:
        """How far the pressure's centroid is ahead of the axis [m]."""
        pressure = self.solution.pressure
        x = self.solution.problem.grid.x
        return float(x @ pressure.sum(axis=1) / pressure.sum())

    @cached_property
    def resistance(self) -> float:
        """Force against the motion over load: the power lost in the bodies over speed and load.

        A pressure that is constant in each cell does the work ``p (u(x + dx / 2) - u(x - dx / 2))`` in a length rolled,
        of which only the displacement that is odd across loses any. It is found on finer cells. The moment of the
        pressure, for a cylinder the shift over its radius, is the same in the limit, and further from it.
        """
        if not self.odd:
            return 0.0
        problem = self.solution.problem
        assert problem.paddings is not None
        (nx, ny), pressure = problem.grid.cells, self.solution.pressure
        times = max(2, min(FINE, MOST // (nx * ny)))
        fine = Grid((times * nx, ny), problem.grid.extent)
        displacement = antisymmetric(self.odd, fine, problem.paddings)(
            np.repeat(pressure, times, axis=0)
        )
        around = np.concatenate((displacement[:1], displacement, displacement[-1:]))
        faces = (around[:-1:times] + around[1::times]) / 2
        work = -(pressure * np.diff(faces, axis=0)).sum() / problem.grid.cell[0]
        return float(work / pressure.sum())

    @cached_property
    def coarse(self) -> "SteadyRolling | None":
        """The same on cells of twice the size, for its difference; None where the scene has no such grid."""
        try:
            return self.again(halved(self.solution.problem.grid))
        except InvalidInput:
            return None

    @property
    def resistance_error(self) -> float:
        """Upper estimate of the relative error of the resistance; infinite without a coarser grid to compare with.

        It is the change from cells of twice the size, and a small share of the pressure's error in L1, since the change
        may be small by chance.
        """
        if self.coarse is None or not np.isfinite(self.settled.change):
            return inf
        if not self.resistance:
            return 0.0
        change = abs(self.coarse.resistance - self.resistance)
        return CHANGED * change / abs(self.resistance) + LEAST * self.error_estimate().l1.total

    def error_estimate(self) -> ErrorEstimate:
        """Estimate the errors of :attr:`solution`, where its own pressure does not tell them from :attr:`coarse`."""
        coarse = None if self.coarse is None else self.coarse.solution
        return error_estimate(self.solution, coarse=coarse)


def solve_rolling(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    tolerance: float = 1e-8,
    change: float = 1e-6,
    max_passes: int = 100,
    max_iterations: int = 2000,
    solver: Solver = PreconditionedCG(),  # noqa: B008 (a frozen value)
    precision: Precision = Precision.DOUBLE,
) -> SteadyRolling:
    """Solve ``scene`` moving at its ``rolling`` speed, in the frame of the contact.

    The delayed displacement is a convolution with coefficients that trail behind the contact, infinitely far: no
    wake is cut off. Their even part is in the operator, their odd part is lagged until the pressure changes by
    less than ``change`` in L1 (see :func:`~contactstudy.solvers.lagged.solve_lagged`).
    Raises :class:`~contactstudy.InvalidInput` for a scene without ``rolling``, or one with a load that
    changes, with wear, or with a fluid.
    """
    if scene.rolling is None:
        raise InvalidInput("Scene.rolling is None: give a Rolling(speed=...).")
    if scene.friction is not None:
        raise InvalidInput("Scene.friction is not known in rolling: leave it out.")
    if scene.wear is not None or not isinstance(scene.load, ConstantLoad):
        field = "Scene.load" if scene.wear is None else "Scene.wear"
        raise InvalidInput(f"{field} changes in time beside Scene.rolling: leave one of them out.")
    still = replace(scene, solids=sudden(scene.solids), rolling=None)
    problem = still.problem(grid, padding)
    datum = problem.scales.length
    even, odd = _trailing(scene, datum)
    weights = Counter(response(still.solids, datum))
    weights.update(even)

    def delayed(problem: Problem) -> Problem:
        return (
            replace(problem, operator=superposed(weights, problem.grid, padding))
            if even
            else problem
        )

    assert problem.source is not None
    problem = replace(
        delayed(problem),
        description=PosedScene(scene, grid, padding),
        source=StepSource(problem.source, delayed),
    )
    settled = solve_lagged(
        problem,
        antisymmetric(odd, grid, padding) if odd else None,
        SolveOptions(tolerance, max_iterations, solver, precision),
        change=change,
        max_passes=max_passes,
    )
    again = partial(
        solve_rolling, scene, padding=padding, tolerance=SETTLED / 10, change=SETTLED, max_passes=max_passes,
        max_iterations=max_iterations, solver=solver, precision=precision,
    )  # fmt: skip
    return SteadyRolling(settled, odd, again)


def _trailing(
    scene: Scene, datum: float
) -> tuple[Mapping[Coefficients, float], Mapping[Coefficients, float]]:
    """The even and odd coefficients of what the bodies delay, with their weights [1/Pa]."""
    assert scene.rolling is not None
    speed = scene.rolling.speed
    even: dict[Coefficients, float] = {}
    odd: dict[Coefficients, float] = {}
    for number, body in enumerate(scene.solids):
        if not isinstance(body, ViscoelasticHalfSpace) or speed == inf:
            continue
        if body.creep.fluidity:
            raise InvalidInput(
                f"Scene.solids[{number}] is a fluid, which a contact that has rolled for ever has pressed "
                "infinitely deep: give an equilibrium modulus above 0 Pa."
            )
        for size, time in body.creep.terms:
            still = Displacement(datum)
            delayed = still if speed == 0 else Trailing(still, speed * time, 1)
            even[delayed] = even.get(delayed, 0.0) + size / pi
            if isinstance(delayed, Trailing):
                opposed = replace(delayed, sign=-1)
                odd[opposed] = odd.get(opposed, 0.0) + size / pi
    return even, odd
