"""Pressure and plastic strain at the end of a step in load, together: a semismooth Newton method."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array, inner, total
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.operator import Extension
from contactstudy.problem.problem import Scales
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.yielding_bodies import ROOT, Return, YieldingBodies


def conjugate_gradients(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    inner: Callable[[Array, Array], float],
    right_side: Array,
    share: float,
    max_products: int,
) -> Array:
    """Return an approximate x with ``product(x) = right_side``.

    Conjugate gradients for a map that is symmetric and not negative in the inner product `inner`. They stop when the
    residual has fallen to a `share` of the first, in the norm of the preconditioner, after `max_products` products, or
    at a direction without curvature. Source: Hestenes & Stiefel (1952), eq. 3:1.
    """
    solution, residual = np.zeros_like(right_side), right_side
    closing = precondition(residual)
    direction, size = closing, inner(residual, closing)
    target = share**2 * size
    for _ in range(max_products):
        if not size > target:
            break
        response = product(direction)
        curvature = inner(direction, response)
        if not curvature > 0:
            break
        length = size / curvature
        solution = solution + length * direction
        residual = residual - length * response
        closing = precondition(residual)
        last, size = size, inner(residual, closing)
        direction = closing + (size / last) * direction
    return solution


# A loose answer takes Newton's method no more iterations than an exact one.
TOLERANCE = 1e-2
LONGEST = 200


@dataclass(frozen=True, eq=False)
class ContactTangent:
    """Derivative ``-dp/dgap`` of the pressure under a fixed load, on the cells that bear.

    It is ``Pi = K^-1 - K^-1 1 1^T K^-1 / (1^T K^-1 1)``, applied by conjugate gradients that are preconditioned as the
    contact is. `cells` (x, y) is 1 for cells that bear and 0 for the others.
    """

    bare: BareProblem
    scales: Scales
    cells: Array

    @classmethod
    def from_solution(cls, solution: Solution, precision: Precision) -> "ContactTangent":
        """Return the tangent for the cells that bear in `solution`, in this `precision`."""
        problem = solution.problem
        cells = (solution.pressure > 0).astype(precision.real)
        return cls(problem.bare(precision), problem.scales, cells)

    def __call__(self, gap: Array) -> Array:
        """Return the fall of the pressure ``Pi gap`` (x, y) [Pa] by a change of the gap (x, y) [m]."""
        count = total(self.cells)
        if count < 2:
            return np.zeros_like(gap)
        real = self.bare.undeformed_gap.dtype
        level_gap = self._level(((gap / self.scales.gap) * self.cells).astype(real), count)
        pressure = conjugate_gradients(
            lambda field: self._level(self.bare.operator(field) * self.cells, count),
            lambda field: self._closing(field, count),
            inner,
            level_gap,
            TOLERANCE,
            LONGEST,
        )
        return np.asarray(pressure * self.scales.pressure, dtype=np.float64)

    def _closing(self, residual: Array, count: float) -> Array:
        """Return the pressure that would close the gap `residual`, by the preconditioner."""
        return self._level(self._extension.closing(self._extension(residual)), count)

    def _level(self, field: Array, count: float) -> Array:
        """Return `field` less its mean over the `count` cells that bear, and zero elsewhere."""
        return np.asarray((field - total(field) / count) * self.cells)

    @cached_property
    def _extension(self) -> Extension:
        """Preconditioner of the cells that bear."""
        return self.bare.operator.approximate_inverse().extension(self.cells)


# Map from a change of the gap (x, y) [m] to the fall of the pressure (x, y) [Pa].
Tangent = Callable[[Array], Array]
# Newton iterations of a step; up to 15 were seen for a load of 5 times that of first yield in one step.
ITERATIONS = 40
# Conjugate gradients: most iterations for a linear system, and the range of its relative residual.
PRODUCTS = 400
LOOSE, TIGHT = 0.1, 1e-6
# Smallest share of a Newton step that is tried before a step of plain return is taken.
SMALLEST = 1e-3
# A residual not halved in this number of iterations has met the noise of the contact.
PATIENCE = 12


@dataclass(frozen=True, eq=False)
class Settled:
    """State at the end of a step in load.

    Parameters
    ----------
    solution
        The last solution of the contact.
    strain
        Plastic strain (C, cells).
    flow
        Growth of the equivalent plastic strain in the step (cells,).
    residual
        Largest error of plastic strain, in units of yield stress over Young's modulus.
    iterations
        Number of Newton's iterations.
    contacts
        All solutions of the contact on the way, in order.
    """

    solution: Solution
    strain: Array
    flow: Array
    residual: float
    iterations: int
    contacts: tuple[Solution, ...]


@dataclass(frozen=True, eq=False)
class _Point:
    """A plastic strain, the contact under it, and the return to the yield surface that its stress asks for."""

    strain: Array
    solution: Solution
    returned: Return
    residual: Array
    error: float
    energy: float


def settle(
    bodies: YieldingBodies,
    contact: Callable[[Array], Solution],
    tangent: Callable[[Solution], Tangent | None],
    before: Array,
    equivalent: Array,
    tolerance: float,
    around: Array | None = None,
) -> Settled:
    """Return pressure and plastic strain at the end of a step in load.

    Backward Euler in load: the minimum of a convex energy, by a semismooth Newton method with conjugate gradients. A
    step that neither lowers the energy (forward-backward envelope) nor halves the residual is shortened.

    Parameters
    ----------
    bodies
        Operators and yield laws of the bodies that yield.
    contact
        Solves for the pressure over a surface that is lowered by a field (x, y) [m].
    tangent
        Linearisation of `contact` at a solution; None for a given pressure.
    before
        Plastic strain (C, cells) at the end of the last step.
    equivalent
        Equivalent plastic strain (cells,) at the end of the last step.
    tolerance
        Largest error of plastic strain, in units of yield stress over Young's modulus.
    around
        Stress (C, cells) [Pa] by plastic strain outside the volume.

    Returns
    -------
    Settled
        The last state, also where the tolerance was not reached.
    """
    contacts: list[Solution] = []
    outer = np.zeros_like(before) if around is None else around

    def evaluate(strain: Array) -> _Point:
        solution = contact(bodies.lift(strain))
        contacts.append(solution)
        relaxed = bodies.stress_of_strain(strain)
        stress = bodies.stress_of_pressure(solution.pressure) + outer - relaxed
        returned = bodies.law.returned(stress, strain, before, equivalent)
        residual = strain - returned.strain
        error = float((np.abs(residual) / bodies.unit).max(initial=0.0))
        elastic = bodies.inner(strain, relaxed / 2 - outer) - _energy(solution, bodies.cell_area)
        squared = np.einsum("ck,ck->k", residual, residual)
        cost = bodies.law.dissipation(returned.strain, before, equivalent)
        density = bodies.law.twice_shear / 2 * squared + cost
        energy = elastic + bodies.inner(stress, residual) + float((density * bodies.volumes).sum())
        return _Point(strain, solution, returned, residual, error, energy)

    point = evaluate(before)
    best, idle = point.error, 0
    iterations = 0
    while tolerance < point.error and iterations < ITERATIONS and idle < PATIENCE:
        iterations += 1
        step = _newton_step(bodies, tangent(point.solution), point)
        share = 1.0
        while True:
            trial = evaluate(point.strain + share * step)
            if trial.energy < point.energy or trial.error < point.error / 2:
                break
            share /= 2
            if share < SMALLEST:
                trial = evaluate(point.returned.strain)
                break
        point = trial
        best, idle = (point.error, 0) if point.error < best / 2 else (best, idle + 1)
    flow = ROOT * point.returned.amount
    return Settled(
        point.solution, point.returned.strain, flow, point.error, iterations, tuple(contacts)
    )


def _energy(solution: Solution, cell_area: float) -> float:
    """Return the energy of the contact [J], ``1/2 p K p + p gap``."""
    heights = solution.problem.undeformed_gap + solution.displacement / 2
    return float(np.einsum("xy,xy->", solution.pressure, heights)) * cell_area


def _newton_step(bodies: YieldingBodies, tangent: Tangent | None, point: _Point) -> Array:
    """Return the step of the plastic strain (C, cells) that solves the linearised return.

    Cells that do not flow take their whole residual at once.
    """
    returned, residual = point.returned, point.residual
    flows = returned.flows
    step = np.where(flows, 0.0, -residual)
    if not flows.any():
        return step
    stiffness = returned.stiffness
    right_side = -returned.inverse_tangent(residual)
    if step.any():
        right_side -= _relaxed(bodies, tangent, step)
    right_side *= flows
    inverse = np.linalg.inv(stiffness + bodies.self_blocks(flows))

    def precondition(residual: Array) -> Array:
        strain = np.zeros_like(residual)
        strain[:, flows] = np.einsum("kij,jk->ik", inverse, residual[:, flows])
        return strain

    def product(strain: Array) -> Array:
        stress = _relaxed(bodies, tangent, strain) * flows
        stress[:, flows] += np.einsum("kij,jk->ik", stiffness, strain[:, flows])
        return stress

    forcing = max(min(LOOSE, point.error**0.5), TIGHT)
    return step + conjugate_gradients(
        product, precondition, bodies.inner, right_side, forcing, PRODUCTS
    )


def _relaxed(bodies: YieldingBodies, tangent: Tangent | None, strain: Array) -> Array:
    """Return the stress (C, cells) [Pa] that `strain` relaxes, with the change of the pressure: ``(B + S Pi S^T) e``."""
    if tangent is None:
        return bodies.stress_of_strain(strain)
    change = tangent(bodies.lift(strain))
    return bodies.stress_of_strain(strain) + bodies.stress_of_pressure(change)
