"""Coulomb's limit on the tangential traction of every cell as a convex set, and the projection onto it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from contactstudy.domain.fields import Array

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
            xx, xy = (
                diagonal - float(np.einsum("i,i->", across, u)),
                -float(np.einsum("i,i->", across, v)),
            )
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
