"""Newton's method on Coulomb's projection: the tangential traction of a contact that sticks in part and slips in part.

With the slip ``s = s0 + D q`` of the first against the second body, Coulomb's law is

    ``F(q) = q - Proj(q - rho s) = 0``

with the projection onto the friction set ``|q| <= mu p``, with a given resultant if there is one; rho is the inverse of
the self-compliance of a cell. The derivative of F is ``1 - P (1 - rho D)`` with that of the projection, P: ``rho D`` in
cells that stick. Its equations are solved by GMRES. Where no fraction of a Newton step reduces F, extragradient
iterations, of two projections each, are taken before the next one.

Source: semismooth Newton of Alart & Curnier (1991); Saad & Schultz (1986); extragradient of Korpelevich (1976).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isnan, sqrt

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.grid import Array
from contactstudy.solvers.friction.coulomb import ElasticSlip, FrictionSet, Projection
from contactstudy.solvers.solution import Status

# Largest fraction of F that the linear equations of a step may leave: 0.1 takes fewer steps and more applications.
FORCING = 0.3
# That fraction over the square root of the residual: 3 takes two thirds of the steps of a constant fraction, and 0.95 of
# the applications.
FORCING_BY_RESIDUAL = 3.0
# Vectors of one GMRES: ten times what was seen on any contact.
MAX_VECTORS = 200
# Halvings of a step that does not reduce F before the extragradient iteration takes over.
MAX_HALVINGS = 10
# Fraction of the largest traction at the start below which it is not resolved in proportion: where a force returns to
# zero, what is left may be rounding.
LEAST_SHEAR = 1e-4
# Fraction of the largest limit by which the trial traction of a cell that sticks is below its own limit.
STICKING = 1e-6
# Extragradient iterations after a step that failed, before the next Newton step; doubled each time. Newton steps fail
# only far from the solution, where a few of them find most of the cells that stick.
FIRST_EXTRAGRADIENT = 4


def shear_status(residual: float, applications: int, tolerance: float, max_applications: int) -> Status:
    """Return the status of a tangential traction with this `residual`, after so many `applications` of its response."""
    if residual <= tolerance:
        return Status.CONVERGED
    if isnan(residual):
        return Status.NOT_FINITE
    return Status.ITERATION_LIMIT if applications >= max_applications else Status.STALLED


@dataclass(frozen=True, eq=False)
class _State:
    """Tangential traction `shear` and `slip` (2, cells), and what follows from them.

    `projection` is that of the trial traction, `residual` is F (2, cells), and `relative_residual` its size.
    """

    shear: Array
    slip: Array
    projection: Projection
    residual: Array
    relative_residual: float


class CoulombNewton:
    """Newton's method, and its fallback, for the tangential traction (2, cells) of the cells in contact on one grid.

    Parameters
    ----------
    slip
        Slip under traction, D.
    limit
        Largest traction (x, y) [Pa], the coefficient of friction times the pressure.
    total
        Sum of the traction over all cells (2,) [Pa], nan for a component whose rigid displacement, or
        creepage, is given; None where both are.
    """

    def __init__(self, slip: ElasticSlip, limit: Array, total: Array | None = None) -> None:
        self._operator, self._shape, self._cells = slip, limit.shape, np.flatnonzero(limit)
        self._set = FrictionSet(limit.ravel()[self._cells], total)
        self._rho = 1 / slip.self_compliance
        self.applications, self._least = 0, 0.0

    def slip(self, shear: Array) -> Array:
        """Return the slip (2, cells) by elastic deformation under `shear` (2, cells)."""
        return self.gathered(self.slip_field(shear))

    def slip_field(self, shear: Array) -> Array:
        """Return the slip (component, x, y) of all cells by elastic deformation under `shear` (2, cells)."""
        self.applications += 1
        return self._operator(self.field(shear))

    def field(self, values: Array) -> Array:
        """Return `values` (2, cells) as a field (component, x, y), zero outside the contact."""
        full = np.zeros((2, *self._shape))
        full.reshape(2, -1)[:, self._cells] = values
        return full

    def gathered(self, whole: Array) -> Array:
        """Return a field (component, x, y) in the cells in contact (2, cells)."""
        gathered: Array = whole.reshape(2, -1)[:, self._cells]
        return gathered

    def project(self, shear: Array) -> Array:
        """Return the nearest traction (2, cells) that friction can transmit, with the given sum if there is one."""
        return self._set.project(shear).traction

    def sticks(self, shear: Array, slip: Array) -> NDArray[np.bool_]:
        """Return which cells (x, y) stick under `shear` and `slip` (2, cells): whose trial traction is below its limit.

        The trial traction decides and not the traction itself, which rounding may leave just inside the disk of a
        slipping cell.
        """
        radius, stick = self._set.radius, np.zeros(self._shape, dtype=bool)
        trial = np.hypot(*(shear - self._rho * slip))
        stick.ravel()[self._cells] = trial < radius - STICKING * radius.max()
        return stick

    def solve(
        self, free_slip: Array, shear: Array, tolerance: float, max_applications: int
    ) -> tuple[Array, Array, Array, float]:
        """Return traction [Pa] and slip (2, cells), the multiplier of the given sum (2,), and the relative residual.

        The iteration begins with a first `shear` (2, cells), and ends at a relative residual of `tolerance` or after
        `max_applications` of the slip operator. `free_slip` (component, x, y) is the slip without traction. The
        multiplier is the rigid displacement, or creepage, that the given sum asks for; the slip is without it. The
        relative residual is the root mean square of F over the largest traction, or over a ten-thousandth of that at the
        start (of its limit where that is zero) if that is more.
        """
        free, max_total = self.gathered(free_slip), max_applications + self.applications
        projected = self.project(shear)
        first = max(float(np.hypot(*each).max()) for each in (shear, projected))
        self._least = LEAST_SHEAR * (first or float(self._set.radius.max()))
        state = self._state(projected, free + self.slip(projected))
        length, extragradient_iterations = self._rho, FIRST_EXTRAGRADIENT
        while state.relative_residual > tolerance and self.applications < max_total:
            forcing = _forcing(tolerance, state.relative_residual)
            change, slip_change = self._newton_step(state, forcing, max_total)
            # slip is linear in the tangential traction: shorter steps cost nothing
            for halving in range(MAX_HALVINGS):
                part = 0.5**halving
                trial = self._state(state.shear + part * change, state.slip + part * slip_change)
                if trial.relative_residual <= (1 - 0.1 * part) * state.relative_residual:
                    state = trial
                    break
            else:
                for _ in range(extragradient_iterations):
                    shear, slip, length = self._extragradient(free, state.shear, state.slip, length)
                    state = self._state(shear, slip)
                    if state.relative_residual <= tolerance or self.applications >= max_total:
                        break
                extragradient_iterations *= 2
        multiplier = state.projection.multiplier / self._rho
        return state.shear, state.slip, multiplier, state.relative_residual

    def _state(self, shear: Array, slip: Array) -> "_State":
        """Return the state of this `shear` and `slip` (2, cells)."""
        projection = self._set.project(shear - self._rho * slip)
        projected = projection.traction
        residual = shear - projected
        mean = norm(residual) / sqrt(self._cells.size)
        relative_residual = mean / max(float(np.hypot(*projected).max()), self._least)
        return _State(shear, slip, projection, residual, relative_residual)

    def _newton_step(self, state: "_State", forcing: float, max_total: int) -> tuple[Array, Array]:
        """Return the changes of traction and slip (2, cells) that leave the fraction `forcing` of the linearised F."""
        projection = state.projection.derivative()
        steps: list[tuple[Array, Array]] = []

        def derivative(values: Array) -> Array:
            change = self._preconditioned(values, projection)
            slip_change = self.slip(change)
            steps.append((change, slip_change))
            return change - projection(change - self._rho * slip_change)

        max_vectors = min(MAX_VECTORS, max_total - self.applications)
        weights = gmres(derivative, -state.residual, forcing, max_vectors)
        change, slip_change = np.zeros_like(state.shear), np.zeros_like(state.slip)
        for weight, (shear_step, its_slip) in zip(weights, steps, strict=True):
            change += weight * shear_step
            slip_change += weight * its_slip
        return change, slip_change

    def _preconditioned(self, values: Array, projection: Callable[[Array], Array]) -> Array:
        """Return ``(1 - P + P (rho D)^-1 P) values`` for the derivative P of the `projection`, D inverted roughly.

        It is the inverse where P is 0 or 1, and about that of the cells that slip, whose P is between.
        """
        projected = projection(values)
        inverse = self._operator.approximate_inverse(self.field(projected))
        return values - projected + projection(self.gathered(inverse) / self._rho)

    def _extragradient(self, free: Array, shear: Array, slip: Array, length: float) -> tuple[Array, Array, float]:
        """Return traction and slip after two projections, and their step length, which is shortened as needed."""
        while True:
            half = self.project(shear - length * slip)
            half_slip = free + self.slip(half)
            shear_change, slip_change = norm(half - shear), norm(half_slip - slip)
            if length * slip_change <= 0.9 * shear_change:
                break
            length *= 0.7
        shear = self.project(shear - length * half_slip)
        return shear, free + self.slip(shear), length


def _forcing(tolerance: float, residual: float) -> float:
    """Return the fraction of F that a Newton step may leave.

    It is less where few cells change between stick and slip, as in inexact Newton methods (Eisenstat & Walker 1996); the
    last steps end at the tolerance, not far below it.
    """
    forcing = min(FORCING, FORCING_BY_RESIDUAL * sqrt(residual))
    last = 0.5 * tolerance / residual
    return last if last > 0.2 * forcing else forcing


def norm(values: Array) -> float:
    """Return the Euclidean norm of `values` (2, cells); BLAS waits for a core where all are busy."""
    return sqrt(float(np.einsum("cn,cn->", values, values)))


def gmres(apply: Callable[[Array], Array], rhs: Array, tolerance: float, max_vectors: int) -> Array:
    """Return the weights of the Krylov vectors that minimise the residual of ``apply(x) = rhs``: GMRES.

    Vector i is the i-th argument of `apply`. The residual is at most `tolerance` times the norm of `rhs`, unless
    `max_vectors` do not suffice. Every vector is orthogonal to those before it, so that a caller who keeps what it made
    of them needs no further application. Source: Saad & Schultz (1986).
    """
    size, most = norm(rhs), max(max_vectors, 1)
    basis, hessenberg = [rhs / size], np.zeros((most + 1, most))
    target = np.zeros(most + 1)
    target[0] = size
    for count in range(1, most + 1):
        vector = apply(basis[-1])
        for row, basis_vector in enumerate(basis):
            hessenberg[row, count - 1] = np.einsum("cn,cn->", basis_vector, vector)
            vector = vector - hessenberg[row, count - 1] * basis_vector
        length = hessenberg[count, count - 1] = norm(vector)
        basis.append(vector / (length or 1.0))
        reduced = hessenberg[: count + 1, :count]
        weights = np.linalg.lstsq(reduced, target[: count + 1], rcond=None)[0]
        if np.linalg.norm(target[: count + 1] - reduced @ weights) <= tolerance * size:
            break
    return weights
