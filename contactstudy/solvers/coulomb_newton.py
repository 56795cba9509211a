"""Newton's method on Coulomb's projection: the shear of steady rolling on one grid.

With the slip ``s = s0 + D q``, ``(D q)(x) = [(A q)(x) - (A q)(x + dx)] / dx``, Coulomb's law is

    ``F(q) = q - Proj(q - rho s) = 0``

with the projection onto the disks ``|q| <= mu p`` and the inverse rho of a cell's own slip. A cell sticks where
``z = q - rho s`` is within its disk. There the derivative of F is ``rho D``; elsewhere, with ``n = z / |z|`` and
``g = mu p / |z|``, it is ``1 - g (1 - n n^T) (1 - rho D)``. Its equations are solved by GMRES. Where Newton's steps no
longer reduce F, two projections an iteration do, more slowly.

Source: semismooth Newton of Alart & Curnier (1991); Saad & Schultz (1986); extragradient of Korpelevich (1976).
"""

from collections.abc import Callable
from math import sqrt

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.elasticity.transforms import TRANSFORMS

# Share of F that one Newton step leaves.
FORCING = 0.1
NEWTON, KRYLOV, HALVINGS = 60, 200, 10


class Rolled:
    """Newton's method, and its fallback, for the shear (2, cells) of the cells in contact on one grid.

    Parameters
    ----------
    response
        Displacement under shear, A.
    limit
        Largest shear (x, y) [Pa], the coefficient of friction times the pressure.
    step
        Width of a cell [m], negative where the contact moves to smaller x.
    """

    def __init__(self, response: ShearResponse, limit: Array, step: float) -> None:
        self._shape, self._cells = limit.shape, np.flatnonzero(limit)
        self._radius = limit.ravel()[self._cells]
        self.capacity = float(self._radius.sum())
        self._ahead = 1 if step > 0 else -1
        padded = response.xx.padded
        waves = np.exp(2j * np.pi * self._ahead / padded[0] * np.arange(padded[0]))
        change = (1 - waves)[:, None] / abs(step)
        self._slip = response.times(change)
        own = TRANSFORMS.backward(self._slip.xx.spectrum.copy(), limit.shape, padded)[0, 0]
        self._rho = 1 / float(own)
        self._stiffness = tuple(
            _inverted(part.spectrum.real) for part in (response.xx, response.yy)
        )
        self._padded, self._scale = padded, abs(step) / self._rho
        self.applications = 0

    @property
    def saturation(self) -> float:
        """Creepage [1] of the order of that at which all cells slide."""
        return float(self._radius.max()) / self._rho

    def slip(self, shear: Array) -> Array:
        """Return the slip (2, cells) by elastic deformation under `shear` (2, cells)."""
        self.applications += 1
        return self.gathered(self._slip(self.field(shear)))

    def slip_field(self, shear: Array) -> Array:
        """Return the slip (component, x, y) of all cells by elastic deformation under `shear` (2, cells)."""
        self.applications += 1
        return self._slip(self.field(shear))

    def field(self, values: Array) -> Array:
        """Return `values` (2, cells) as a field (component, x, y), zero outside the contact."""
        whole = np.zeros((2, *self._shape))
        whole.reshape(2, -1)[:, self._cells] = values
        return whole

    def gathered(self, whole: Array) -> Array:
        """Return a field (component, x, y) in the cells in contact (2, cells)."""
        gathered: Array = whole.reshape(2, -1)[:, self._cells]
        return gathered

    def projected(self, trial: Array) -> Array:
        """Return the nearest shear (2, cells) to a `trial` one that friction bears."""
        return trial * (self._radius / np.maximum(np.hypot(*trial), self._radius))

    def residual(self, shear: Array, slip: Array) -> tuple[Array, float]:
        """Return F (2, cells), and its root mean square over the largest shear."""
        nearest = self.projected(shear - self._rho * slip)
        error = shear - nearest
        mean = float(np.einsum("cn,cn->", error, error)) / self._radius.size
        largest = float(np.hypot(*nearest).max())
        return error, sqrt(mean) / largest if largest else 0.0

    def preconditioned(self, values: Array, sticks: Array) -> Array:
        """Return the approximate inverse of `rho D` on the cells that stick, the identity on the others.

        ``D = (I - S) A / dx`` with the shift S by one cell. The sum from the leading edge undoes ``I - S``, the division
        by the spectrum undoes A.
        """
        whole = self.field(np.where(sticks, values, 0))[:, :: -self._ahead]
        summed = np.cumsum(whole, axis=1)[:, :: -self._ahead]
        for component, inverse in zip(summed, self._stiffness, strict=True):
            waves = TRANSFORMS.forward(component, self._padded)
            waves *= inverse
            component[:] = TRANSFORMS.backward(waves, self._shape, self._padded)
        return np.where(sticks, self._scale * self.gathered(summed), values)

    def solved(
        self, rigid: Array, shear: Array, tolerance: float, most: int
    ) -> tuple[Array, Array, float]:
        """Return shear and slip (2, cells) from a first `shear`, and the residual; at most `most` applications.

        `rigid` (component, x, y) is the slip without shear.
        """
        free, most = self.gathered(rigid), most + self.applications
        shear = self.projected(shear)
        slip = free + self.slip(shear)
        error, size = self.residual(shear, slip)
        for _ in range(NEWTON):
            if size <= tolerance or self.applications >= most:
                return shear, slip, size
            change, slip_change = self._newton_step(
                shear, slip, error, _forcing(tolerance, size), most
            )
            # slip is linear in the shear: shorter steps cost nothing
            for halving in range(HALVINGS):
                part = 0.5**halving
                trial = shear + part * change, slip + part * slip_change
                trial_error, trial_size = self.residual(*trial)
                if trial_size <= (1 - 0.1 * part) * size:
                    break
            else:
                break
            (shear, slip), error, size = trial, trial_error, trial_size
        return self._extragradient(free, shear, slip, tolerance, most)

    def _newton_step(
        self, shear: Array, slip: Array, error: Array, forcing: float, most: int
    ) -> tuple[Array, Array]:
        """Return the changes of shear and slip (2, cells) that reduce the linearised F to the share `forcing`."""
        trial = shear - self._rho * slip
        distance = np.hypot(*trial)
        sticks = distance <= self._radius
        direction = trial / np.maximum(distance, np.finfo(float).tiny)
        cut = self._radius / np.maximum(distance, self._radius)
        steps: list[tuple[Array, Array]] = []

        def derivative(values: Array) -> Array:
            change = self.preconditioned(values, sticks)
            moved = self.slip(change)
            steps.append((change, moved))
            across = change - self._rho * moved
            across -= direction * np.einsum("cn,cn->n", direction, across)
            return np.where(sticks, self._rho * moved, change - cut * across)

        weights = gmres(derivative, -error, forcing, min(KRYLOV, most - self.applications))
        change, slip_change = np.zeros_like(shear), np.zeros_like(slip)
        for weight, (one, its_slip) in zip(weights, steps, strict=True):
            change += weight * one
            slip_change += weight * its_slip
        return change, slip_change

    def _extragradient(
        self, free: Array, shear: Array, slip: Array, tolerance: float, most: int
    ) -> tuple[Array, Array, float]:
        """Return shear, slip and residual by two projections an iteration, whose step is shortened as needed."""
        step = self._rho
        size = self.residual(shear, slip)[1]
        while size > tolerance and self.applications < most:
            while True:
                half = self.projected(shear - step * slip)
                half_slip = free + self.slip(half)
                moved, felt = np.linalg.norm(half - shear), np.linalg.norm(half_slip - slip)
                if step * felt <= 0.9 * moved or self.applications >= most:
                    break
                step *= 0.7
            shear = self.projected(shear - step * half_slip)
            slip = free + self.slip(shear)
            size = self.residual(shear, slip)[1]
        return shear, slip, size


def _inverted(spectrum: Array) -> Array:
    """Return the inverse of a `spectrum` whose first entry, the rigid shift, is set to the largest."""
    sizes = np.abs(spectrum)
    sizes[0, 0] = 0
    sizes[0, 0] = largest = sizes.max()
    return np.asarray(1 / np.maximum(sizes, 1e-9 * largest))


def _forcing(tolerance: float, size: float) -> float:
    """Return the share of F that a Newton step may leave; the last steps end at the tolerance, not far below it."""
    last = 0.5 * tolerance / size
    return last if last > 0.2 * FORCING else FORCING


def gmres(
    apply: Callable[[Array], Array], target: Array, tolerance: float, most: int
) -> list[float]:
    """Return weights of the vectors that `apply` was given, whose images add up to `target` but for a small rest.

    The rest is at most `tolerance` of the target, or what it is after `most` applications. Every vector is orthogonal to
    those before it, so that a caller who keeps what it made of them needs no further application. Source: Saad & Schultz
    (1986).
    """
    size = float(np.linalg.norm(target))
    basis = [target / size]
    columns: list[Array] = []
    rotations: list[tuple[float, float]] = []
    reduced = [size]
    while len(columns) < max(most, 1) and abs(reduced[-1]) > tolerance * size:
        vector = apply(basis[-1])
        entries = np.empty(len(basis) + 1)
        for row, other in enumerate(basis):
            entries[row] = np.einsum("cn,cn->", other, vector)
            vector = vector - entries[row] * other
        entries[-1] = np.linalg.norm(vector)
        basis.append(vector / (entries[-1] or 1.0))
        for row, (cosine, sine) in enumerate(rotations):
            above, below = entries[row : row + 2]
            entries[row : row + 2] = cosine * above + sine * below, cosine * below - sine * above
        above, below = entries[-2:]
        length = float(np.hypot(above, below)) or np.finfo(float).tiny
        cosine, sine = above / length, below / length
        rotations.append((cosine, sine))
        columns.append(np.append(entries[:-2], length))
        reduced[-1:] = [cosine * reduced[-1], -sine * reduced[-1]]
    weights = [0.0] * len(columns)
    for row in range(len(columns) - 1, -1, -1):
        rest = sum(columns[n][row] * weights[n] for n in range(row + 1, len(columns)))
        weights[row] = float((reduced[row] - rest) / columns[row][row])
    return weights
