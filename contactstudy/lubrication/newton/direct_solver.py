"""Linear system of a step in plane strain, solved directly: by elasticity all cells act on each other."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from contactstudy.domain.grid import Array
from contactstudy.lubrication.film_equation import Bands, Film, FilmEquation, Linearised
from contactstudy.lubrication.newton.pseudo_time import ActiveSets, FilmCorrection


@dataclass(frozen=True, eq=False)
class DirectSolver:
    """Gaussian elimination; ``influence`` (i, j) is the deflection of cell i under a unit pressure on cell j.

    ``last`` are the coefficients of the last linearisation, for further active sets.
    """

    influence: Array
    last: "DenseCoefficients | None" = None

    @classmethod
    def for_equation(cls, equation: FilmEquation) -> "DirectSolver":
        """Return the solver for ``equation`` in plane strain, whose deflection is a convolution."""
        first = np.zeros(equation.gap.shape)
        first[0] = 1
        downstream, upstream = (equation.deflection(end)[:, 0] for end in (first, first[::-1]))
        index = np.arange(len(downstream))
        return cls(np.concatenate((upstream[:-1], downstream))[len(downstream) - 1 + index[:, None] - index])

    def step(self, linear: Linearised, film: Film, active: ActiveSets, load_residual: float) -> FilmCorrection:
        """Return the step for given ``active`` sets.

        The unknowns are the pressure or the void fraction of each cell, the asperity pressure of each touching cell, and
        the separation; the rows are the flow balance of each cell, the thickness of each touching cell, and the load.
        """
        if self.last is None or self.last.linear is not linear:
            fresh = replace(self, last=DenseCoefficients(linear, self.influence))
            return fresh.step(linear, film, active, load_residual)
        equation, width = linear.equation, linear.equation.cell[0]
        n, fixed, cavitated = len(film.thickness), equation.fixed[:, 0], active.cavitated[:, 0]
        full_film = ~(cavitated | fixed)
        # prescribed changes: pressures and voids that vanish
        pressure = np.where(cavitated, -film.pressure[:, 0], 0.0)
        void = np.where(cavitated, 0.0, -film.void[:, 0])
        change = linear.change_with(pressure[:, None], void[:, None], equation.deflection(pressure[:, None]))
        balance = -(linear.residual + change)[:, 0]
        load_residual -= width * pressure.sum()
        touching_cells = np.flatnonzero(active.touching)
        asperity_pressure = np.where(active.touching, 0.0, -film.asperity_pressure)[:, 0]
        balance -= self.last.by_deflection @ asperity_pressure
        load_residual -= width * asperity_pressure.sum()
        balance[fixed] = 0

        size = n + len(touching_cells) + 1
        system = np.zeros((size, size))
        system[:n, :n] = self.last.by_pressure
        system[:n, :n][:, cavitated] = self.last.by_void[:, cavitated]
        system[:n, -1] = self.last.by_separation
        system[-1, :n] = width * full_film
        rhs = np.zeros(size)
        rhs[:n], rhs[-1] = balance, load_residual
        if len(touching_cells):
            system[:n, n:-1] = self.last.by_deflection[:, touching_cells]
            system[n:-1, :n] = self.influence[touching_cells] * full_film
            system[n:-1, n:-1] = self.influence[np.ix_(touching_cells, touching_cells)]
            system[n:-1, -1] = 1
            system[-1, n:-1] = width
            distance = equation.boundary_film - film.thickness[:, 0] - self.influence @ (pressure + asperity_pressure)
            rhs[n:-1] = distance[touching_cells]
        system[:n][fixed] = np.eye(n, size)[fixed]
        scale = np.abs(system).max(axis=1)
        system /= scale[:, None]
        try:
            solution = np.linalg.solve(system, rhs / scale)
        except np.linalg.LinAlgError:
            unchanged = film.pressure, film.asperity_pressure, film.void, 0.0
            return FilmCorrection(*unchanged, self, solved=False)
        unknown, asperity_pressure[touching_cells] = solution[:n], solution[n:-1]
        return FilmCorrection(
            np.where(cavitated, pressure, unknown)[:, None],
            asperity_pressure[:, None],
            np.where(cavitated, unknown, void)[:, None],
            float(solution[-1]),
            self,
        )


@dataclass(frozen=True, eq=False)
class DenseCoefficients:
    """Derivatives (n, n) of the flow balance of each cell by the unknowns of each cell."""

    linear: Linearised
    influence: Array

    @cached_property
    def by_pressure(self) -> Array:
        """Derivatives by pressures of the lubricant."""
        return self.by_deflection + _matrix(self.linear.pressure, len(self.influence))

    @cached_property
    def by_deflection(self) -> Array:
        """Derivatives by asperity pressures, which only deflect the surfaces."""
        n = len(self.influence)
        matrix = np.zeros((n, n))
        for (offset, _), coefficient in self.linear.thickness.items():
            first, end = max(0, -offset), min(n, n - offset)
            # a diagonal times the influence is the influence with its rows shifted
            matrix[first:end] += coefficient[first:end] * self.influence[first + offset : end + offset]
        return matrix

    @cached_property
    def by_void(self) -> Array:
        """Derivatives by void fractions."""
        return _matrix(self.linear.void, len(self.influence))

    @cached_property
    def by_separation(self) -> Array:
        """Derivatives (n,) by the separation."""
        return np.asarray(sum(self.linear.thickness.values())).ravel()


def _matrix(bands: Bands, n: int) -> Array:
    """Return the matrix (n, n) of bands in plane strain."""
    matrix = np.zeros((n, n))
    for (offset, _), coefficient in bands.items():
        index = np.arange(max(0, -offset), min(n, n - offset))
        matrix[index, index + offset] = coefficient[index, 0]
    return matrix
