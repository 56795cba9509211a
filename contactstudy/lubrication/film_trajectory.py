"""Films at instants, and estimates of their errors by the steps in time."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.solvers.solution import Status, worst

# Error by the steps over the largest difference to an evolution with steps twice as long.
ERROR_OVER_DIFFERENCE = 1.5
# Numbers of a film whose errors by the steps are estimated; the peak pressure is the last.
NUMBERS = ("central_film", "minimum_film", "friction", "peak_pressure")


@dataclass(frozen=True, eq=False)
class FilmTrajectory:
    """Lubricated contacts at ``times`` [s], and the steps, iterations and the largest error of a step that they took.

    ``step_error`` is that of the film in the Hertzian zone, in L1 over its mean, of one step. ``errors_by_steps``
    (time,) are estimates of the relative errors of quantities by all steps, from a second evolution with steps twice as
    long; infinite if one of the two failed.
    """

    times: tuple[float, ...]
    contacts: tuple[FilmSolution, ...]
    steps: int
    iterations: int
    linear_iterations: int
    step_error: float
    errors_by_steps: Mapping[str, Array] = field(default_factory=dict)

    @property
    def status(self) -> Status:
        """Gravest outcome of the recorded contacts."""
        return worst([contact.status for contact in self.contacts])

    @property
    def central_film(self) -> Array:
        """Central film (time,) [m]."""
        return np.array([contact.central_film for contact in self.contacts])

    @property
    def minimum_film(self) -> Array:
        """Smallest film (time,) [m]."""
        return np.array([contact.minimum_film for contact in self.contacts])


@dataclass(frozen=True)
class Difference:
    """Values of `NUMBERS` in a film at a time [s], and their differences to a film after longer steps."""

    time: float
    values: Array
    differences: Array

    @classmethod
    def of(cls, time: float, fine: FilmSolution, coarse: FilmSolution) -> "Difference":
        """Compare two films; the differences are infinite if one has not converged.

        That of the peak pressure is the largest of any cell, as a peak that moves may keep its height by chance.
        """
        values = _values(fine)
        if Status.FILM_NOT_CONVERGED in (fine.status, coarse.status):
            return cls(time, values, np.full(len(NUMBERS), inf))
        differences = np.abs(values - _values(coarse))
        differences[-1] = np.abs(fine.pressure - coarse.pressure).max()
        return cls(time, values, differences)


def _values(film: FilmSolution) -> Array:
    return np.array([getattr(film, name) for name in NUMBERS], dtype=float)


def errors_by_steps(films: FilmTrajectory, compared: list[Difference]) -> Mapping[str, Array]:
    """Return estimates (time,) of relative errors from differences at ascending times.

    They are infinite without any, and where a film has not converged.
    The error at an instant is estimated by the largest difference until then, as one alone may vanish by chance: by the
    absolute or by the relative one, whichever is less, since a number may grow or fall by orders of magnitude.
    """
    if not compared:
        return {name: np.full(len(films.times), inf) for name in NUMBERS}
    until = np.searchsorted([film.time for film in compared], films.times)
    until = np.minimum(until, len(compared) - 1)
    differences = np.array([film.differences for film in compared])
    relative = differences / _not_zero([film.values for film in compared])
    absolute = np.maximum.accumulate(differences)[until]
    errors = np.minimum(
        absolute / _not_zero([_values(film) for film in films.contacts]),
        np.maximum.accumulate(relative)[until],
    )
    errors[[film.status is Status.FILM_NOT_CONVERGED for film in films.contacts]] = inf
    return dict(zip(NUMBERS, ERROR_OVER_DIFFERENCE * errors.T, strict=True))


def _not_zero(values: list[Array]) -> Array:
    sizes = np.abs(values)
    return np.where(sizes == 0, 1, sizes)


def errors_beside(films: FilmTrajectory, coarse: tuple[FilmSolution, ...]) -> Mapping[str, Array]:
    """Return estimates (time,) of relative errors from films after longer steps, one an instant or fewer."""
    pairs = zip(films.times, films.contacts, coarse, strict=False)
    return errors_by_steps(films, [Difference.of(*pair) for pair in pairs])
