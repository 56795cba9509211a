"""Films at instants, and estimates of their time-discretisation errors."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.evolution.march import Record
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.solvers.solution import Counts, Status

# Time-discretisation error over the largest difference to an evolution with steps twice as long.
ERROR_OVER_DIFFERENCE = 1.5
# Numbers of a film whose time-discretisation errors are estimated.
NUMBERS = ("central_film", "minimum_film", "friction")
# Names of the errors of its pressure: the largest of any cell, and in L1.
OF_PRESSURE = ("peak_pressure", "pressure")
# Statuses of a film whose errors are infinite.
FAILED = (Status.FILM_NOT_CONVERGED, Status.NOT_CONVERGED)


@dataclass(frozen=True, eq=False)
class FilmTrajectory:
    """Lubricated contacts at instants.

    Attributes
    ----------
    times
        Time [s] of each contact.
    contacts
        The contacts.
    steps, iterations, linear_iterations
        Number of steps in time, and of iterations of the film and of its linear systems, those of rejected steps and of
        steps twice as long too.
    time_discretisation_errors
        Estimates (time,) of the relative time-discretisation errors of :data:`NUMBERS`, of the peak pressure and of the
        pressure in L1, of all steps together, from a second evolution with steps twice as long; infinite if one of the
        two failed.
    """

    times: tuple[float, ...]
    contacts: tuple[FilmSolution, ...]
    steps: int
    iterations: int
    linear_iterations: int
    time_discretisation_errors: Mapping[str, Array]

    @property
    def counts(self) -> Counts:
        """Number of instants, and of steps and iterations."""
        return {
            "instants": (len(self.contacts), "instants recorded"),
            "steps": (self.steps, "steps in time"),
            "iterations": (self.iterations, "iterations of all steps"),
            "linear_iterations": (self.linear_iterations, "iterations of linear systems"),
        }


@dataclass(frozen=True)
class Difference:
    """Values of `NUMBERS` and of the pressure in a film at a `time` [s], and differences to a film after longer steps.

    The values of the pressure are its peak and its sum over the cells [Pa].
    """

    time: float
    values: Array
    differences: Array

    @classmethod
    def of(cls, time: float, fine: FilmSolution, coarse: FilmSolution) -> "Difference":
        """Compare two films; the differences are infinite if one has not converged.

        That of the peak pressure is the largest of any cell, as a peak that moves may keep its height by chance; that of
        the sum of the pressure is the sum of the differences.
        """
        values = _values(fine)
        if fine.status in FAILED or coarse.status in FAILED:
            return cls(time, values, np.full(len(values), inf))
        differences = np.abs(values - _values(coarse))
        changed = np.abs(fine.pressure - coarse.pressure)
        differences[len(NUMBERS) :] = changed.max(), changed.sum()
        return cls(time, values, differences)


def _values(film: FilmSolution) -> Array:
    """Return `NUMBERS` of a film, its peak pressure and the sum of its pressure (number,)."""
    numbers = [getattr(film, name) for name in NUMBERS]
    return np.array([*numbers, film.pressure.max(), film.pressure.sum()], dtype=float)


def time_discretisation_errors(
    times: Sequence[float], films: Sequence[FilmSolution], compared: Sequence[Difference]
) -> Mapping[str, Array]:
    """Return estimates (time,) of relative errors of films at `times` [s] by name, from differences at ascending times.

    They are infinite without any difference, and where a film has not converged. The error at an instant is estimated
    by the largest difference until then, or of all where none is later, as one alone may vanish by chance: by the
    absolute or by the relative one, whichever is less, since a number may grow or fall by orders of magnitude.
    """
    names = NUMBERS + OF_PRESSURE
    if not compared:
        return {name: np.full(len(times), inf) for name in names}
    until = np.searchsorted([film.time for film in compared], times)
    until = np.minimum(until, len(compared) - 1)
    differences = np.array([film.differences for film in compared])
    relative = differences / _not_zero([film.values for film in compared])
    absolute = np.maximum.accumulate(differences)[until]
    absolute /= _not_zero([_values(film) for film in films])
    errors = np.minimum(absolute, np.maximum.accumulate(relative)[until])
    errors[[film.status in FAILED for film in films]] = inf
    return dict(zip(names, ERROR_OVER_DIFFERENCE * errors.T, strict=True))


def _not_zero(values: Sequence[Array]) -> Array:
    """Return the absolute `values`, by which differences are divided; 1 in place of 0."""
    sizes = np.abs(values)
    return np.where(sizes == 0, 1, sizes)


def film_trajectory(
    records: Sequence[Record[Any]], films: Sequence[FilmSolution], compared: Sequence[Difference]
) -> FilmTrajectory:
    """Return the films that a march recorded, with errors estimated from differences to films after longer steps."""
    work = sum((record.work for record in records), Counter())
    times = tuple(record.state.time for record in records)
    return FilmTrajectory(
        times,
        tuple(films),
        work["steps"],
        work["iterations"],
        work["linear_iterations"],
        time_discretisation_errors(times, films, compared),
    )
