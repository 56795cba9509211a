"""Pressure and plastic strain at the end of a step in load, together: a semismooth Newton method."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array, inner, total
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.operator import ApproximateInverse
from contactstudy.problem.problem import Scales
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.yielding_bodies import ROOT, Return, YieldingBodies


def conjugate_gradients(
    product: Callable[[Array], Array],
    precondition: Callable[[Array], Array],
    inner: Callable[[Array, Array], float],
    wanted: Array,
    share: float,
    most: int,
) -> Array:
    """What ``product`` maps to ``wanted``, in the product ``inner`` in which it is symmetric and not negative.

    The residual falls to a ``share`` of the first, in the norm of the preconditioner, in at ``most`` so many products;
    a direction without curvature ends it before. Source: Hestenes & Stiefel (1952), eq. 3:1.
    """
    found, rest = np.zeros_like(wanted), wanted
    closing = precondition(rest)
    direction, size = closing, inner(rest, closing)
    enough = share**2 * size
    for _ in range(most):
        if not size > enough:
            break
        response = product(direction)
        curvature = inner(direction, response)
        if not curvature > 0:
            break
        length = size / curvature
        found = found + length * direction
        rest = rest - length * response
        closing = precondition(rest)
        last, size = size, inner(rest, closing)
        direction = closing + (size / last) * direction
    return found


# A loose answer takes Newton's method no more iterations than an exact one.
TOLERANCE = 1e-2
LONGEST = 200


@dataclass(frozen=True, eq=False)
class ContactTangent:
    """``-dp/dgap`` under a fixed load: ``Pi = K^-1 - K^-1 1 1^T K^-1 / (1^T K^-1 1)`` on the cells that bear.

    Found by conjugate gradients, preconditioned as the contact is.
    """

    bare: BareProblem
    scales: Scales
    cells: Array

    @classmethod
    def of(cls, solution: Solution, precision: Precision) -> "ContactTangent":
        """For the cells that bear in ``solution``."""
        problem = solution.problem
        cells = (solution.pressure > 0).astype(precision.real)
        return cls(problem.bare(precision), problem.scales, cells)

    def __call__(self, gap: Array) -> Array:
        """``Pi gap`` (x, y) [Pa] of a change of the gap (x, y) [m]."""
        count = total(self.cells)
        if count < 2:
            return np.zeros_like(gap)
        real = self.bare.undeformed_gap.dtype
        rest = self._level(((gap / self.scales.gap) * self.cells).astype(real), count)
        found = conjugate_gradients(
            lambda field: self._level(self.bare.operator(field) * self.cells, count),
            lambda field: self._closing(field, count),
            inner,
            rest,
            TOLERANCE,
            LONGEST,
        )
        return np.asarray(found * self.scales.pressure, dtype=np.float64)

    def _closing(self, rest: Array, count: float) -> Array:
        return self._level(self._precondition(rest, self.cells) * self.cells, count)

    def _level(self, field: Array, count: float) -> Array:
        """Without its mean over the cells that bear."""
        return np.asarray((field - total(field) / count) * self.cells)

    @cached_property
    def _precondition(self) -> ApproximateInverse:
        return self.bare.operator.approximate_inverse()


# How the pressure (x, y) [Pa] falls with a change of the gap (x, y) [m].
Tangent = Callable[[Array], Array]
# Newton iterations of a step; up to 15 were seen for a load of 5 times that of first yield in one step.
ITERATIONS = 40
# Conjugate gradients: of each linear system, and how closely it is solved.
PRODUCTS = 400
LOOSE, TIGHT = 0.1, 1e-6
# Shares of a Newton step that are tried, before a step of plain return is taken.
SMALLEST = 1e-3
# Without halving the residual in so many iterations it has met the noise of the contact.
PATIENCE = 12


@dataclass(frozen=True, eq=False)
class Settled:
    """What a step ends with: the contact's ``solution``, plastic ``strain`` (C, cells), ``flow`` of equivalent strain.

    ``residual`` is the largest error of plastic strain over Y / E; ``iterations`` are Newton's, and ``contacts``
    all solutions of the contact, in order.
    """

    solution: Solution
    strain: Array
    flow: Array
    residual: float
    iterations: int
    contacts: tuple[Solution, ...]


@dataclass(frozen=True, eq=False)
class _Point:
    """A plastic strain, the contact under it, and the return that its stress asks for."""

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
    """From the plastic strain ``before`` (C, cells) and ``equivalent`` (cells,) of the last step.

    ``contact`` solves for the pressure over a surface that is lowered by a field (x, y) [m]; ``tangent`` is its
    linearisation there, None for a given pressure. ``around`` (C, cells) [Pa] is stress by what is outside.
    Backward Euler in load. The minimum of a convex energy, by a semismooth Newton method with conjugate gradients;
    a step that neither lowers the energy (forward-backward envelope) nor halves the residual is shortened.
    """
    contacts: list[Solution] = []
    outer = np.zeros_like(before) if around is None else around

    def at(strain: Array) -> _Point:
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
        rest = bodies.law.twice_shear / 2 * squared + cost
        energy = elastic + bodies.inner(stress, residual) + float((rest * bodies.volumes).sum())
        return _Point(strain, solution, returned, residual, error, energy)

    point = at(before)
    best, since = point.error, 0
    iterations = 0
    while tolerance < point.error and iterations < ITERATIONS and since < PATIENCE:
        iterations += 1
        step = _newton_step(bodies, tangent(point.solution), point)
        share = 1.0
        while True:
            ahead = at(point.strain + share * step)
            if ahead.energy < point.energy or ahead.error < point.error / 2:
                break
            share /= 2
            if share < SMALLEST:
                ahead = at(point.returned.strain)
                break
        point = ahead
        best, since = (point.error, 0) if point.error < best / 2 else (best, since + 1)
    flow = ROOT * point.returned.amount
    found = point.solution, point.returned.strain, flow, point.error
    return Settled(*found, iterations, tuple(contacts))


def _energy(solution: Solution, cell_area: float) -> float:
    """Of the contact [J]: ``1/2 p K p + p gap``."""
    heights = solution.problem.undeformed_gap + solution.displacement / 2
    return float(np.einsum("xy,xy->", solution.pressure, heights)) * cell_area


def _newton_step(bodies: YieldingBodies, tangent: Tangent | None, point: _Point) -> Array:
    """What takes the linearised return to the strain; cells that do not flow go back at once."""
    returned, residual = point.returned, point.residual
    flows = returned.flows
    step = np.where(flows, 0.0, -residual)
    if not flows.any():
        return step
    stiffness = returned.stiffness
    wanted = -returned.inverse_tangent(residual)
    if step.any():
        wanted -= _relaxed(bodies, tangent, step)
    wanted *= flows
    inverse = np.linalg.inv(stiffness + bodies.self_blocks(flows))

    def precondition(rest: Array) -> Array:
        found = np.zeros_like(rest)
        found[:, flows] = np.einsum("kij,jk->ik", inverse, rest[:, flows])
        return found

    def product(strain: Array) -> Array:
        found = _relaxed(bodies, tangent, strain) * flows
        found[:, flows] += np.einsum("kij,jk->ik", stiffness, strain[:, flows])
        return found

    forcing = max(min(LOOSE, point.error**0.5), TIGHT)
    return step + conjugate_gradients(
        product, precondition, bodies.inner, wanted, forcing, PRODUCTS
    )


def _relaxed(bodies: YieldingBodies, tangent: Tangent | None, strain: Array) -> Array:
    """Stress that ``strain`` takes away, with what the pressure changes: ``(B + S Pi S^T) e``."""
    if tangent is None:
        return bodies.stress_of_strain(strain)
    change = tangent(bodies.lift(strain))
    return bodies.stress_of_strain(strain) + bodies.stress_of_pressure(change)
