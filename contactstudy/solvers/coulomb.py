"""Coulomb's law on every cell: full sliding, and the traction of a contact that sticks in part and slips in part.

In full sliding the traction is the coefficient of friction mu times the pressure p. Otherwise Coulomb's law for the
traction q on the first body, with the slip ``s = s0 + D q`` of the first against the second body, is

    ``F(q) = q - Proj(q - rho s) = 0``

with the projection onto the friction set ``|q| <= mu p``, with a given resultant if there is one. Here s0 is the free
slip, that without traction, and D the elastic slip by a unit of traction. The inverse of rho is the slip of a cell
under a unit on it alone. The trial traction is ``q - rho s``. The derivative of F is ``1 - P (1 - rho D)`` with that of
the projection, P: ``rho D`` in cells that stick. Its equations are solved by GMRES. Where no fraction of a Newton step
reduces F, extragradient iterations, of two projections each, are taken before the next one.

Arrays (2, cells) are of the cells in contact alone, with the components along x and y; fields (component, x, y) are of
all cells.

Source: Kalker (1990), ch. 4 (law); semismooth Newton of Alart & Curnier (1991); Saad & Schultz (1986); extragradient of
Korpelevich (1976).
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isnan, sqrt

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.device import Device
from contactstudy.domain.grid import Array
from contactstudy.elasticity.approximate_inverse import at_unpadded_wave_numbers
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.elasticity.transforms import TRANSFORMS
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, Status, TangentialTraction
from contactstudy.solvers.solve import SolveOptions, solve_contact, solve_with_mixing

# Most outer iterations between pressure and tangential traction in full sliding. Even without mixing, each divides the
# error by at least 1.7 where both bodies are elastic and friction is below 1.
MAX_SLIDING_ITERATIONS = 200


@dataclass(frozen=True, eq=False)
class FullSliding:
    """Full sliding along x: the traction ``coefficient * pressure`` on the first body, and its reaction on the second.

    `coupling` maps tangential traction [Pa] to normal displacement [m]; None for elastically similar bodies (Dundurs'
    beta = 0), where traction does not change the pressure.
    """

    coefficient: float
    coupling: GeneralConvolution | None

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the solution of a `problem` under tangential traction, from a pressure `start` (x, y) [Pa] on.

        With a coupling, pressure and traction are solved in turn, until the traction changes the gap by less than the
        tolerance. The coupling is odd, so that it has no place in a symmetric operator: its displacement is added to
        the gap.
        """
        coupling = self.coupling
        if coupling is None:
            solution = solve_contact(problem, options, start, device)
            return replace(solution, traction=self.traction(solution.pressure))
        lagged = solve_with_mixing(
            problem, lambda p: self.coefficient * coupling(p), options, start, device, MAX_SLIDING_ITERATIONS
        )
        solution, applications = lagged.solution_of(problem), lagged.outer_iterations
        return replace(
            solution,
            convolutions=solution.convolutions + applications,
            traction=self.traction(solution.pressure, applications),
        )

    def traction(self, pressure: Array, applications: int = 1) -> TangentialTraction:
        """Return the traction of full sliding under `pressure` (x, y) [Pa], found by `applications` of the coupling."""
        shear = np.stack([self.coefficient * pressure, np.zeros_like(pressure)])
        method = "full sliding" if self.coupling is None else "full sliding, shear lagged"
        return TangentialTraction(shear, np.zeros(pressure.shape, dtype=bool), method, applications)


# Largest number of Newton iterations in a projection with a given resultant, more than were seen on any contact.
MAX_ITERATIONS = 200


class FrictionSet:
    """Convex set of tractions (2, cells) with ``|q| <= radius`` in each cell, and with a given sum if there is one.

    Parameters
    ----------
    radius
        Largest traction of each cell (cells,), above 0.
    total
        Sum of the tractions (2,), nan for a component whose sum may be any; None where both may.
    """

    def __init__(self, radius: Array, total: Array | None = None) -> None:
        self.radius, self.total = radius, total
        self._shift: Array | None = None

    def project(self, trial: Array) -> "Projection":
        """Return the projection of a `trial` traction (2, cells), with the traction of this set that is nearest to it.

        The trial is shifted by one vector, which meets the sum, and cut off at the radius.
        """
        if self.total is not None:
            self._shift = self._shift_to(self.total, trial)
        shift = np.zeros(2) if self._shift is None else self._shift
        return Projection(self.radius, self.total, trial + shift[:, None], shift)

    def _shift_to(self, total: Array, trial: Array) -> Array:
        """Return the shift (2,) of a `trial` (2, cells) that gives its projection the sum `total`.

        It is found by Newton's method, damped: the residual, what the sum lacks, is the gradient of a convex function of
        the shift. The method begins with the shift found before.
        """
        r, (x, y), prescribed = self.radius, trial, ~np.isnan(total)
        shift, guessed = self._shift, self._shift is not None
        if shift is None:
            shift = np.where(prescribed, total - np.array([x.sum(), y.sum()]), 0) / r.size
        # the ridge keeps the derivative regular where all cells slip; a hundred times as much may not converge
        size, ridge = float(r.sum()), 1e-12 * r.size
        # of the first step: factors of 1 to 8 take the same iterations
        max_step = 4 * float(max(r.max(), np.abs(x).max(initial=0.0), np.abs(y).max(initial=0.0)))
        origin, step, slope = shift, np.zeros(2), 0.0
        error = worst = np.inf
        for _ in range(MAX_ITERATIONS):
            u, v = x + shift[0], y + shift[1]
            distance = np.sqrt(u * u + v * v)
            farther = np.maximum(distance, r)
            cut = r / farther
            resultant = np.array([np.einsum("i,i->", cut, u), np.einsum("i,i->", cut, v)])
            residual = np.where(prescribed, total - resultant, 0)
            worst = float(np.abs(residual).max())
            if float(residual @ step) < -0.5 * slope:
                # beyond the minimum of the convex function, which is nearly linear where all cells slip
                step, slope = step / 2, slope / 2
                max_step = float(np.abs(step).max())
                shift = origin + step
                continue
            # at rounding, or where rounding keeps it from falling further
            if worst <= 1e-14 * size or (worst >= error * (1 - 1e-3) and worst <= 1e-10 * size):
                break
            error = worst
            # derivative of a cell: the identity within, cut (1 - e e^T) where it slips, e = (u, v) / distance
            slipping = (distance > r) * cut / farther**2
            diagonal, across = float(cut.sum()) + ridge, slipping * u
            xx, xy = (diagonal - float(np.einsum("i,i->", across, u)), -float(np.einsum("i,i->", across, v)))
            yy = diagonal - float(np.einsum("i,i->", slipping * v, v))
            matrix = np.where(np.outer(prescribed, prescribed), [[xx, xy], [xy, yy]], np.eye(2))
            direction = np.linalg.solve(matrix, residual)
            longest = float(np.abs(direction).max())
            step = (min(1.0, max_step / longest) if longest else 1.0) * direction
            origin, slope = shift, float(residual @ step)
            shift = origin + step
            max_step *= 2
        if guessed and not worst <= 1e-9 * size:
            # a shift that made all cells slip leaves Newton's method without a slope
            self._shift = None
            return self._shift_to(total, trial)
        return shift


@dataclass(frozen=True, eq=False)
class Projection:
    """Projection of a trial traction onto a friction set.

    `shifted` (2, cells) is the trial plus the `multiplier` (2,) of the given sum, which is zero where none is given.
    """

    radius: Array
    total: Array | None
    shifted: Array
    multiplier: Array

    @property
    def traction(self) -> Array:
        """Nearest traction (2, cells) of the set."""
        shifted, radius = self.shifted, self.radius
        return np.asarray(shifted * (radius / np.maximum(np.hypot(*shifted), radius)))

    def derivative(self) -> Callable[[Array], Array]:
        """Return the derivative of the projection as a map of (2, cells).

        With ``n = z / |z|`` at the shifted trial z it is ``G = (radius / |z|) (1 - n n^T)`` in the cells whose limit
        cuts z off, and 1 in those that stick. A given sum takes ``G 1 (1^T G 1)^-1 1^T G`` from G.
        """
        shifted, length = self.shifted, np.hypot(*self.shifted)
        stick = length <= self.radius
        normal = np.where(stick, 0, shifted / np.maximum(length, np.finfo(float).tiny))
        cut = self.radius / np.maximum(length, self.radius)

        def of_cells(change: Array) -> Array:
            along = np.einsum("cn,cn->n", normal, change)
            return np.asarray(cut * (change - normal * along))

        if self.total is None:
            return of_cells
        prescribed = ~np.isnan(self.total)
        rigid = np.stack([of_cells(np.repeat(axis[:, None], cut.size, axis=1)) for axis in np.eye(2)[prescribed]])
        inverse = np.linalg.pinv(rigid.sum(axis=2)[:, prescribed], rcond=1e-12)

        def balanced(change: Array) -> Array:
            shear_change = of_cells(change)
            shift = inverse @ shear_change.sum(axis=1)[prescribed]
            return np.asarray(shear_change - np.einsum("g,gcn->cn", shift, rigid))

        return balanced


class ElasticSlip:
    """Map D from traction to elastic slip, both (component, x, y), whose symmetric part is positive definite.

    With A, the displacement under traction, it is A itself for a contact at rest that begins without traction, and in
    steady rolling the slip per distance rolled, ``(D q)(x) = [(A q)(x) - (A q)(x + step)] / |step|``. `self_compliance`
    is the slip of a cell under a unit traction along x on it alone. At rest it is less the mean slip of all cells,
    which depends on the datum of the displacement.

    Parameters
    ----------
    response
        Displacement under tangential traction, A.
    step
        Width of a cell [m], negative where the contact rolls to smaller x; 0 at rest.
    """

    def __init__(self, response: ShearResponse, step: float = 0.0) -> None:
        self._step, self._slip, self._inverse = step, response, _inverses(response)
        if step:
            rows = response.xx.padded[0]
            # phase factors of a shift by one cell
            shift = np.exp(2j * np.pi * np.sign(step) / rows * np.arange(rows))
            self._slip = response.scaled((1 - shift)[:, None] / abs(step))
        part = self._slip.xx  # whose inverse transform is the slip by a unit in the first cell
        direct = TRANSFORMS.backward(part.spectrum.copy(), part.cells, part.padded)
        self.self_compliance = float(direct[0, 0] - (0 if step else direct.mean()))

    def __call__(self, shear: Array) -> Array:
        """Return the slip under `shear`, both (component, x, y)."""
        return self._slip(shear)

    def approximate_inverse(self, slip: Array) -> Array:
        """Return an approximation to the traction (component, x, y) of a `slip` of some cells, which is zero elsewhere.

        It is divided by the spectra of A on the unpadded, periodic grid, a circulant preconditioner; in rolling, after
        a sum from the leading edge, which undoes the difference.
        """
        if self._step:
            back = -1 if self._step > 0 else 1
            slip = abs(self._step) * np.cumsum(slip[:, ::back], axis=1)[:, ::back]
        pairs = zip(slip, self._inverse, strict=True)
        return np.stack([TRANSFORMS.filtered(component, factors, None) for component, factors in pairs])


def _inverses(response: ShearResponse) -> list[Array]:
    """Return the inverse spectra of A along x and along y, on the unpadded grid.

    The zero wave number, of a mean traction, takes the largest compliance of the others.
    """
    inverses = []
    for part in (response.xx, response.yy):
        sizes = at_unpadded_wave_numbers(np.abs(part.spectrum.real), part.cells, part.padded)
        sizes[0, 0] = 0
        sizes[0, 0] = largest = sizes.max()
        inverses.append(1 / np.maximum(sizes, 1e-9 * largest))
    return inverses


# Constants of Newton's method, judged by the applications of the response in 14 contacts, smooth and rough, that slip in
# part, fret and roll.
# Largest fraction of F that the linear equations of a step may leave: 0.1 takes 5 % more, 0.6 takes 3 % fewer and more
# steps.
FORCING = 0.3
# That fraction over the square root of the residual: 1 and 6 take 1 % more or fewer, and a constant fraction 7 % more.
FORCING_BY_RESIDUAL = 3.0
# Vectors of one GMRES: ten times what was seen on any contact.
MAX_VECTORS = 200
# Halvings of a step that does not reduce F before the extragradient iteration takes over; 5 and 20 make no difference.
MAX_HALVINGS = 10
# Fraction of the largest traction at the start below which it is not resolved in proportion: where a force returns to
# zero, what is left may be rounding. A tenth and ten times it make no difference elsewhere.
LEAST_SHEAR = 1e-4
# A cell sticks if its trial traction is below its own limit by this fraction of the largest limit. That is above the
# rounding of a traction, and the error that a tolerance of 1e-8 leaves.
STICKING = 1e-6
# Extragradient iterations after a step that failed, before the next Newton step; doubled each time. Newton steps fail
# only far from the solution, where a few of them find most of the cells that stick: 1 and 8 make no difference.
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
    """Tangential traction `shear` and `slip` (2, cells) of an iteration, and what follows from them.

    `projection` is that of the trial traction, `residual` is F (2, cells), and `relative_residual` its root mean square
    over the largest traction.
    """

    shear: Array
    slip: Array
    projection: Projection
    residual: Array
    relative_residual: float


@dataclass(frozen=True, eq=False)
class SlipStep:
    """Tangential traction that fulfils Coulomb's law, and the slip under it.

    Parameters
    ----------
    shear
        Traction (component, x, y) [Pa] on the first body.
    slip
        Slip (component, x, y) of the first against the second body, zero outside the contact: in a step [m], or per
        distance rolled.
    rigid
        Rigid displacement (2,) [m] of the second against the first body in the step, or its creepage, that was found for
        a given resultant; a positive one makes a positive traction.
    stick
        Cells (x, y) in contact that stick.
    residual
        Root mean square of the change by one projection onto Coulomb's disks, over the largest traction, at the least
        `LEAST_SHEAR` times that before the step.
    applications
        Number of applications of the response to traction.
    """

    shear: Array
    slip: Array
    rigid: Array
    stick: NDArray[np.bool_]
    residual: float
    applications: int


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

    def solve(self, free_slip: Array, shear: Array, tolerance: float, max_applications: int) -> SlipStep:
        """Return the traction, and the slip less the rigid displacement or creepage that a given sum asks for.

        The iteration begins with a first `shear` (component, x, y) [Pa], and ends at a residual of `tolerance`, or
        after `max_applications` of the slip operator. `free_slip` (component, x, y) is the slip without traction. The
        residual is the root mean square of F over the largest traction, at the least `LEAST_SHEAR` times that at the
        start or, without one, times the largest limit.
        """
        free, shear = self._gathered(free_slip), self._gathered(shear)
        projected = self._project(shear)
        first = max(float(np.hypot(*each).max()) for each in (shear, projected))
        self._least = LEAST_SHEAR * (first or float(self._set.radius.max()))
        state = self._state(projected, free + self._slip(projected))
        length, extragradient_iterations = self._rho, FIRST_EXTRAGRADIENT
        while state.relative_residual > tolerance and self.applications < max_applications:
            # less where few cells change between stick and slip (Eisenstat & Walker 1996); the last step ends at the
            # tolerance, not far below it
            forcing = min(FORCING, FORCING_BY_RESIDUAL * sqrt(state.relative_residual))
            forcing = max(forcing, 0.5 * tolerance / state.relative_residual)
            change, slip_change = self._newton_step(state, forcing, max_applications)
            # slip is linear in the tangential traction: shorter steps cost nothing
            for halving in range(MAX_HALVINGS):
                part = 0.5**halving  # accepted where F falls by a tenth of what it would if it were linear
                trial = self._state(state.shear + part * change, state.slip + part * slip_change)
                if trial.relative_residual <= (1 - 0.1 * part) * state.relative_residual:
                    state = trial
                    break
            else:
                for _ in range(extragradient_iterations):
                    shear, slip, length = self._extragradient(free, state.shear, state.slip, length)
                    state = self._state(shear, slip)
                    if state.relative_residual <= tolerance or self.applications >= max_applications:
                        break
                extragradient_iterations *= 2
        rigid = state.projection.multiplier / self._rho
        # the solved traction may exceed its limit by the residual
        shear, slip, radius = self._project(state.shear), state.slip - rigid[:, None], self._set.radius
        # the trial traction decides on stick: rounding may leave the traction just inside the disk of a slipping cell
        stick = np.zeros(self._shape, dtype=bool)
        stick.ravel()[self._cells] = np.hypot(*(shear - self._rho * slip)) < radius - STICKING * radius.max()
        fields = self._field(shear), self._field(slip)
        return SlipStep(*fields, rigid, stick, state.relative_residual, self.applications)

    def _slip(self, shear: Array) -> Array:
        """Return the slip (2, cells) by elastic deformation under `shear` (2, cells)."""
        self.applications += 1
        return self._gathered(self._operator(self._field(shear)))

    def _field(self, values: Array) -> Array:
        """Return `values` (2, cells) as a field (component, x, y), zero outside the contact."""
        full = np.zeros((2, *self._shape))
        full.reshape(2, -1)[:, self._cells] = values
        return full

    def _gathered(self, field: Array) -> Array:
        """Return a `field` (component, x, y) in the cells in contact (2, cells)."""
        gathered: Array = field.reshape(2, -1)[:, self._cells]
        return gathered

    def _project(self, shear: Array) -> Array:
        """Return the nearest traction (2, cells) that friction can transmit, with the given sum if there is one."""
        return self._set.project(shear).traction

    def _state(self, shear: Array, slip: Array) -> "_State":
        """Return the state of this `shear` and `slip` (2, cells)."""
        projection = self._set.project(shear - self._rho * slip)
        projected = projection.traction
        residual = shear - projected
        mean = norm(residual) / sqrt(self._cells.size)
        relative_residual = mean / max(float(np.hypot(*projected).max()), self._least)
        return _State(shear, slip, projection, residual, relative_residual)

    def _newton_step(self, state: "_State", forcing: float, max_applications: int) -> tuple[Array, Array]:
        """Return the changes of traction and slip (2, cells) that leave the fraction `forcing` of the linearised F.

        They take what is left of `max_applications` at most.
        """
        projection = state.projection.derivative()
        steps: list[tuple[Array, Array]] = []

        def derivative(values: Array) -> Array:
            change = self._preconditioned(values, projection)
            slip_change = self._slip(change)
            steps.append((change, slip_change))
            return change - projection(change - self._rho * slip_change)

        max_vectors = min(MAX_VECTORS, max_applications - self.applications)
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
        inverse = self._operator.approximate_inverse(self._field(projected))
        return values - projected + projection(self._gathered(inverse) / self._rho)

    def _extragradient(self, free: Array, shear: Array, slip: Array, length: float) -> tuple[Array, Array, float]:
        """Return traction and slip (2, cells) after two projections, and their step length, shortened as needed.

        `free` is the slip without traction, and `length` the last step length, in place of rho. A step is shortened
        until the slip changes by less than the traction over the length (Khobotov 1987).
        """
        while True:
            half = self._project(shear - length * slip)
            half_slip = free + self._slip(half)
            shear_change, slip_change = norm(half - shear), norm(half_slip - slip)
            if length * slip_change <= 0.9 * shear_change:
                break
            length *= 0.7
        shear = self._project(shear - length * half_slip)
        return shear, free + self._slip(shear), length


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
