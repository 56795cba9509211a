"""The linear system of a step in plane strain, solved directly: all cells act on each other through the film."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Bands, Film, FilmEquation, Linearised, Mask
from contactstudy.lubrication.pseudo_time import FilmStep


@dataclass(frozen=True, eq=False)
class DirectStep:
    """Gaussian elimination for one row of cells; ``influence`` (i, j) is the deflection of cell i under cell j.

    ``last`` are the coefficients of the last linearisation, for further sets of cavitated cells.
    """

    influence: Array
    last: "DenseCoefficients | None" = None

    @classmethod
    def for_equation(cls, equation: FilmEquation) -> "DirectStep":
        """Return the solver for ``equation``, whose deflection depends on the distance of cells only."""
        first = np.zeros(equation.gap.shape)
        first[0] = 1
        column = equation.deflection(first)[:, 0]
        index = np.arange(len(column))
        return cls(column[np.abs(index[:, None] - index)])

    def step(
        self, linear: Linearised, film: Film, cavitated: Mask, load_missing: float
    ) -> FilmStep:
        """Return the step for a given set of ``cavitated`` cells."""
        if self.last is None or self.last.linear is not linear:
            fresh = replace(self, last=DenseCoefficients(linear, self.influence))
            return fresh.step(linear, film, cavitated, load_missing)
        by_pressure, by_void = self.last.by_pressure, self.last.by_void
        n, fixed, empty = len(film.film), linear.equation.fixed[:, 0], cavitated[:, 0]
        pressure = np.where(empty, -film.pressure[:, 0], 0.0)
        void = np.where(empty, 0.0, -film.void[:, 0])

        system = np.empty((n + 1, n + 1))
        system[:n, :n] = by_pressure
        system[:n, :n][:, empty] = by_void[:, empty]
        system[:n, n] = self.last.by_separation
        system[n] = np.append(np.where(empty | fixed, 0.0, linear.equation.cell[0]), 0.0)
        system[:n][fixed] = np.eye(n, n + 1)[fixed]
        change = linear.change(pressure[:, None], void[:, None], 0.0)
        right = np.append(
            -(linear.residual + change),
            load_missing - linear.equation.cell[0] * pressure.sum(),
        )
        right[:n][fixed] = 0
        scale = np.abs(system).max(axis=1)
        system /= scale[:, None]
        try:
            solution = np.linalg.solve(system, right / scale)
        except np.linalg.LinAlgError:
            return FilmStep(film.pressure, film.void, 0.0, self, solved=False)
        unknown, separation = solution[:n], float(solution[n])
        return FilmStep(
            np.where(empty, pressure, unknown)[:, None],
            np.where(empty, unknown, void)[:, None],
            separation,
            self,
        )


@dataclass(frozen=True, eq=False)
class DenseCoefficients:
    """Changes (n, n) of the balance of one row of cells with the pressure and the void fraction of each cell."""

    linear: Linearised
    influence: Array

    @cached_property
    def by_pressure(self) -> Array:
        """Coefficients of the pressures of the lubricant."""
        return self.by_film + _matrix(self.linear.pressure, len(self.influence))

    @cached_property
    def by_film(self) -> Array:
        """Coefficients of pressures that only bend the film: a band times the influence is its rows, shifted."""
        n = len(self.influence)
        matrix = np.zeros((n, n))
        for (offset, _), coefficient in self.linear.film.items():
            first, end = max(0, -offset), min(n, n - offset)
            matrix[first:end] += (
                coefficient[first:end] * self.influence[first + offset : end + offset]
            )
        return matrix

    @cached_property
    def by_void(self) -> Array:
        """Coefficients of the void fractions."""
        return _matrix(self.linear.void, len(self.influence))

    @cached_property
    def by_separation(self) -> Array:
        """Coefficients (n,) of the separation."""
        return np.asarray(sum(self.linear.film.values())).ravel()


def _matrix(bands: Bands, n: int) -> Array:
    """Return the matrix (n, n) of bands of one row of cells."""
    matrix = np.zeros((n, n))
    for (offset, _), coefficient in bands.items():
        index = np.arange(max(0, -offset), min(n, n - offset))
        matrix[index, index + offset] = coefficient[index, 0]
    return matrix
