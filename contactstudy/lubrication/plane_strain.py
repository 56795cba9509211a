"""The linear system of a step in plane strain, solved directly: all cells act on each other through the film."""

from dataclasses import dataclass

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import Bands, Film, FilmEquation, Linearised, Mask
from contactstudy.lubrication.pseudo_time import FilmStep


@dataclass(frozen=True, eq=False)
class DirectStep:
    """Gaussian elimination for one row of cells; ``influence`` (i, j) is the deflection of cell i under cell j."""

    influence: Array

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
        n, fixed, empty = len(film.film), linear.equation.fixed[:, 0], cavitated[:, 0]
        by_pressure = _matrix(linear.pressure, n) + _matrix(linear.film, n) @ self.influence
        by_void = _matrix(linear.void, n)
        by_separation = sum(linear.film.values(), start=np.zeros((n, 1)))
        pressure = np.where(empty, -film.pressure[:, 0], 0.0)
        void = np.where(empty, 0.0, -film.void[:, 0])

        system = np.zeros((n + 1, n + 1))
        system[:n, :n] = np.where(empty, by_void, by_pressure)
        system[:n, n:] = by_separation
        system[n, :n] = np.where(empty | fixed, 0.0, linear.equation.cell[0])
        system[:n][fixed] = np.eye(n, n + 1)[fixed]
        right = np.append(
            -linear.residual[:, 0] - by_pressure @ pressure - by_void @ void,
            load_missing - linear.equation.cell[0] * pressure.sum(),
        )
        right[:n][fixed] = 0
        scale = np.abs(system).max(axis=1)
        try:
            solution = np.linalg.solve(system / scale[:, None], right / scale)
        except np.linalg.LinAlgError:
            return FilmStep(film.pressure, film.void, 0.0, solved=False)
        unknown, separation = solution[:n], float(solution[n])
        return FilmStep(
            np.where(empty, pressure, unknown)[:, None],
            np.where(empty, unknown, void)[:, None],
            separation,
        )


def _matrix(bands: Bands, n: int) -> Array:
    """Return the matrix (n, n) of bands of one row of cells."""
    matrix = np.zeros((n, n))
    for (offset, _), coefficient in bands.items():
        index = np.arange(max(0, -offset), min(n, n - offset))
        matrix[index, index + offset] = coefficient[index, 0]
    return matrix
