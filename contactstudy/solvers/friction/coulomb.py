"""Coulomb's law on every cell: limit of the traction, full sliding, elastic slip, and the stretch by a bulk stress."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from contactstudy.domain.device import Device
from contactstudy.domain.grid import Array, Grid
from contactstudy.elasticity.approximate_inverse import at_unpadded_wave_numbers
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.elasticity.transforms import TRANSFORMS
from contactstudy.problem.problem import Problem
from contactstudy.solvers.solution import Solution, TangentialTraction
from contactstudy.solvers.solve import SolveOptions, solve_contact, solve_with_mixing

# Largest number of Newton iterations in a projection with a given resultant.
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
        """Return the shift of a `trial` (2, cells) that gives its projection the sum `total`.

        Newton's method on two unknowns, damped, whose residual is the gradient of a convex function. It begins with the
        shift found before.
        """
        r, (x, y), prescribed = self.radius, trial, ~np.isnan(total)
        shift, guessed = self._shift, self._shift is not None
        if shift is None:
            shift = np.where(prescribed, total - np.array([x.sum(), y.sum()]), 0) / r.size
        size, ridge = float(r.sum()), 1e-12 * r.size
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


# Outer iterations between pressure and tangential traction: errors fall by a factor of at least 1.7 from one to the
# next where both bodies are elastic and friction is below 1.
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
        """Return the solution under tangential traction.

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
        solution, applications = lagged.of(problem), lagged.outer_iterations
        return replace(
            solution,
            convolutions=solution.convolutions + applications,
            traction=self.traction(solution.pressure, applications),
        )

    def traction(self, pressure: Array, applications: int = 1) -> TangentialTraction:
        """Return the traction of full sliding under `pressure` (x, y) [Pa]."""
        shear = np.stack([self.coefficient * pressure, np.zeros_like(pressure)])
        method = "full sliding" if self.coupling is None else "full sliding, shear lagged"
        return TangentialTraction(shear, np.zeros(pressure.shape, dtype=bool), method, applications)


class ElasticSlip:
    """Map D from traction to elastic slip, both (component, x, y), whose symmetric part is positive definite.

    With A, the displacement under traction, it is A itself for a contact at rest that begins without traction, and in
    steady rolling the slip per distance rolled, ``(D q)(x) = [(A q)(x) - (A q)(x + step)] / |step|``. `self_compliance`
    is the slip of a cell under a unit traction along x on it alone; at rest, less the mean slip of all cells.

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
        direct = _coefficients(self._slip.xx)
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
        return _filtered(slip, self._inverse)


def _coefficients(part: GeneralConvolution) -> Array:
    """Return the convolution (x, y) of a unit in the first cell."""
    return TRANSFORMS.backward(part.spectrum.copy(), part.cells, part.padded)


def _inverses(response: ShearResponse) -> list[Array]:
    """Return the inverse spectra of both components, the zero wave number with the largest compliance of the others."""
    inverses = []
    for part in (response.xx, response.yy):
        sizes = at_unpadded_wave_numbers(np.abs(part.spectrum.real), part.cells, part.padded)
        sizes[0, 0] = 0
        sizes[0, 0] = largest = sizes.max()
        inverses.append(1 / np.maximum(sizes, 1e-9 * largest))
    return inverses


def _filtered(field: Array, factors: list[Array]) -> Array:
    """Return a `field` (component, x, y) with its Fourier coefficients on the unpadded grid times the `factors`."""
    pairs = zip(field, factors, strict=True)
    return np.stack([TRANSFORMS.filtered(component, factor, None) for component, factor in pairs])


@dataclass(frozen=True)
class BulkStress:
    """Stress of a whole body along x, whose strain along y is prevented.

    Parameters
    ----------
    size
        Stress [Pa], tension positive.
    body
        Index of the body.
    compliance
        Strain over stress [1/Pa], ``(1 - nu^2) / E``.
    """

    size: float = 0.0
    body: int = 0
    compliance: float = 0.0

    def stretch(self, grid: Grid, before: float, after: float) -> Array:
        """Return the displacement (x, 1) [m] of the first against the second body, as a stress of `before` changes."""
        strain = (1 - 2 * self.body) * self.compliance * (after - before)
        return strain * grid.x[:, None]

    def of_bodies(self, size: float) -> tuple[float, float]:
        """Return the stress of each body [Pa]."""
        return (0.0, size) if self.body else (size, 0.0)
