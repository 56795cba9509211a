"""A viscoelastic contact that moves steadily across: Scene -> SteadyRolling."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Padding, Paddings
from contactstudy.elasticity.coefficients import Coefficients, Displacement
from contactstudy.elasticity.convolution import antisymmetric, superposed
from contactstudy.elasticity.viscoelastic import Trailing
from contactstudy.scene.bodies import response, sudden
from contactstudy.scene.inelastic import ViscoelasticHalfSpace
from contactstudy.scene.load import ConstantLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.solvers.lagged import Settled, solve_lagged
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, Solver


@dataclass(frozen=True, eq=False)
class SteadyRolling:
    """What ``settled``: its :attr:`solution`, in the frame of the contact, and what moving it takes."""

    settled: Settled
    shapes_gap: Array

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

    @property
    def resistance(self) -> float:
        """Force against the motion over load: the mean slope of the heights under the pressure.

        It is the power lost in the bodies over speed and load. For a cylinder, the shift over its radius.
        """
        pressure = self.solution.pressure
        slope = np.gradient(self.shapes_gap, self.solution.problem.grid.cell[0], axis=0)
        return float((slope * pressure).sum() / pressure.sum())


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
    problem = replace(problem, description=PosedScene(scene, grid, padding), source=None)
    if even:
        weights = Counter(response(still.solids, datum))
        weights.update(even)
        problem = replace(problem, operator=superposed(weights, grid, padding))
    settled = solve_lagged(
        problem,
        antisymmetric(odd, grid, padding) if odd else None,
        SolveOptions(tolerance, max_iterations, solver, precision),
        change=change,
        max_passes=max_passes,
    )
    return SteadyRolling(settled, problem.undeformed_gap)


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
