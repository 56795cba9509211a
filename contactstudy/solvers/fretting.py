"""Fretting: shear under a tangential force that swings, each step from the shear before it.

A step from the shear r to q slips by ``s = A (q - r) - d``, with the displacement ``A q`` under shear and a rigid one
d. Coulomb's law, ``|q| <= mu p`` with s opposed to q on the rim and 0 inside, makes q the shear of least energy
``1/2 (q - r) A (q - r)`` among those with the resultant that is asked for. Under a constant pressure a step from one
reversal to the next is exact in plane strain, as slip does not turn back in it.

Source: Mindlin & Deresiewicz (1953); Kalker (1990), ch. 4; Beck & Teboulle (2009) with restart.
"""

from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.fields import Array
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.problem.problem import Problem
from contactstudy.solvers.fretting_traction import FrettingTraction
from contactstudy.solvers.friction import Disks
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# A cell sticks whose shear is below the limit by more than this share of the largest.
STICKING = 1e-6
# Iterations without a fall of the residual by a third after which a step ends.
STALLED = 400


@dataclass(frozen=True, eq=False)
class SwingingShear:
    """Shear under tangential forces that follow one another, added to the pressure of a frictionless contact.

    Parameters
    ----------
    coefficient
        Coefficient of friction mu.
    shares
        Tangential forces along x over mu P, each between -1 and 1, from none on.
    response
        Displacement under shear, A.
    """

    coefficient: float
    shares: tuple[float, ...]
    response: ShearResponse

    def solved(
        self, problem: Problem, options: SolveOptions, start: Array | None, on: Device
    ) -> Solution:
        """Return the normal contact with the shear after the last force, and what all of them did."""
        normal = options.solved(problem, start, on)
        radius = self.coefficient * normal.pressure
        shear = np.zeros((2, *radius.shape))
        iterations, residual, stalled = 0, 0.0, False
        sliding: list[Array] = []
        moved = [0.0]
        shears = []
        # forces cannot act where nothing presses
        shares = self.shares if radius.any() else ()
        scale = self.coefficient * problem.scales.gap
        for share in shares:
            disks = Disks(radius, np.array([share * radius.sum(), 0.0]))
            step = _least_energy(self.response, disks, shear, scale, options)
            sliding.append(np.where(radius > 0, np.hypot(*step.slip), 0))
            moved.append(moved[-1] + step.rigid)
            shear = step.shear
            shears.append(shear)
            iterations += step.iterations
            residual = max(residual, step.residual)
            stalled |= step.iterations < options.max_iterations
        status = normal.status
        if status is Status.CONVERGED and residual > options.tolerance:
            status = Status.STALLED if stalled else Status.ITERATION_LIMIT
        first = _cycle(self.shares)
        slid = sum(sliding[first:], start=np.zeros_like(radius))
        traction = FrettingTraction(
            shear=shear,
            stick=(radius > 0) & (np.hypot(*shear) < radius - STICKING * radius.max()),
            method="fretting, Coulomb disks",
            passes=iterations,
            forces=np.array([0.0, *shares]) * radius.sum() * problem.grid.cell_area,
            rigid=np.array(moved),
            shears=np.array(shears),
            slip_distance=slid,
            energy=radius * slid,
            cycle_from=first,
        )
        return replace(
            normal,
            status=status,
            residual=max(normal.residual, residual),
            iterations=normal.iterations + iterations,
            convolutions=normal.convolutions + 2.0 * iterations,
            traction=traction,
        )


def _cycle(shares: tuple[float, ...]) -> int:
    """Return the step after the last time that the last force acted before: the first of the last cycle, else 0."""
    earlier = [number for number, share in enumerate(shares[:-1]) if share == shares[-1]]
    return earlier[-1] + 1 if earlier else 0


@dataclass(frozen=True, eq=False)
class _Step:
    """Shear and slip (component, x, y) of one step, its rigid displacement along x [m], and what it took."""

    shear: Array
    slip: Array
    rigid: float
    iterations: int
    residual: float


def _least_energy(
    response: ShearResponse, disks: Disks, before: Array, scale: float, options: SolveOptions
) -> _Step:
    """Return the shear of least energy of a step from the shear `before`, in `disks`, by accelerated projections.

    The residual is the change by one projection, as a displacement over `scale`.
    """
    shear = disks.nearest(before)
    extrapolated, inertia, length = shear, 1.0, 1 / response.largest
    residual, best, last_improvement, iteration = np.inf, np.inf, 0, 0
    while True:
        trial = disks.nearest(extrapolated - length * response(extrapolated - before))
        # where a cell sticks its displacement is the rigid one
        rigid = disks.shift / length
        iteration += 1
        size = np.abs(trial)
        change = float(np.abs(trial - extrapolated).sum())
        moved = max(float(size.sum()), change) * length * scale
        residual = change * float(size.max()) / moved if moved else 0.0
        if residual < 0.7 * best:
            best, last_improvement = residual, iteration
        limited = iteration >= options.max_iterations or iteration - last_improvement > STALLED
        if residual <= options.tolerance or limited:
            break
        step = trial - shear
        if np.einsum("cxy,cxy->", extrapolated - trial, step) > 0:
            inertia = 1.0
        following = (1 + np.sqrt(1 + 4 * inertia**2)) / 2
        extrapolated = trial + (inertia - 1) / following * step
        shear, inertia = trial, following
    slip = response(trial - before) - rigid[:, None, None]
    return _Step(trial, slip, float(rigid[0]), iteration + 1, residual)
