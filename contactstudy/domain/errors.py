"""Estimated errors of an answer by quantity and by cause, the constants of their bounds, and what a notebook shows.

All errors are relative. Those of a pressure are in L1: the sum over the cells of its absolute error, over that of the
pressure. A number without a law of its error is bounded by its changes between grids. The same contact is solved on a
half, a third and a quarter of the cells along each axis. The changes of the number are extrapolated with the power of
the cell size with which errors fall. These bounds are computed in the package `answers`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from enum import Enum
from html import escape
from textwrap import shorten
from typing import Any

import numpy as np

from contactstudy.domain.validation import is_default

# Beginnings of the reasons why a peak pressure, and for the same reason a largest stress, has no bound.
NO_PEAK, NO_STRESS = "No bound for the peak pressure: ", "No bound for the largest stress: "
# Most letters of a value in a row of a notebook: with the name before them they fit into a line of 120.
VALUE_LETTERS = 90


class InNotebook:
    """Value that a notebook shows as a few rows, by default the fields of a dataclass that are not at their default."""

    def _rows(self) -> str:
        """Return the name of the class, and below it a line for each row."""
        entries = list(_entries(self))
        width = max((len(name) for name, _ in entries), default=0)
        rows = (
            f"  {name:<{width}}  {shorten(_text(entry), VALUE_LETTERS, placeholder=' ...')}" for name, entry in entries
        )
        return "\n".join((type(self).__name__, *rows))

    def _repr_html_(self) -> str:
        """Return the rows as HTML, for which IPython asks by this name."""
        return f"<pre style='font-family: monospace'>{escape(self._rows())}</pre>"


def _given(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield names and values of the fields of a dataclass that are not functions and not at their default."""
    for member in fields(value):
        entry = getattr(value, member.name)
        if member.repr and not callable(entry) and not is_default(member, entry):
            yield member.name, entry


def _entries(value: Any) -> Iterator[tuple[str, Any]]:
    """Yield name and value of each row of a dataclass.

    A tuple has a row for each of its entries, unless all are numbers; a field that is an :class:`InNotebook` itself has
    its own rows in place of one.
    """
    for name, entry in _given(value):
        if isinstance(entry, InNotebook):
            yield from _entries(entry)
        elif isinstance(entry, tuple) and not all(isinstance(part, int | float) for part in entry):
            yield from ((f"{name}[{n}]", part) for n, part in enumerate(entry))
        else:
            yield name, entry


def _text(value: object) -> str:
    """Return a value in short: fields that differ from their defaults, arrays by their shapes."""
    if is_dataclass(value) and not isinstance(value, type):
        given = (f"{name}={_text(entry)}" for name, entry in _given(value))
        return f"{type(value).__name__}({', '.join(given)})"
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, np.ndarray):
        return f"array {' x '.join(map(str, value.shape))}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_text, value))})"
    return str(value)


# A requested relative error: of every number, or of the numbers that are its keys.
Request = float | Mapping[str, float]
# Key of a request for the error of the pressure in L1.
PRESSURE = "pressure"
# Relative error that is requested where neither an error nor a grid is given: loads and shapes of machine elements are
# seldom known better than to a per cent.
DEFAULT_ERROR = 1e-2

# Grids with which an answer is compared: those with 1 / k of its cells along each axis.
COARSER = 2, 3, 4
# Bound over the error that the largest change of a number between grids shows: set on 760 static contacts of 60 kinds,
# where the largest change was at least 0.7 of the error in 98.5 %.
MARGIN = 1.5
# Power of the cell size with which errors of a static contact fall, where no body ends nor attracts another: that of a
# pressure that falls to zero at its edge like the square root of the distance.
STATIC_ORDER = 1.5
# Largest power for a number that is read at an edge, as the highest residual stress: halved cells left 0.65 to 0.75 of
# its error, an order of 0.4 to 0.6; `MARGIN` covers what falls more slowly than the order here.
EDGE_ORDER = 0.7
# Least relative change of a largest stress, and of the depth at which it lies, that a bound counts: both lie between the
# depths that the program has chosen. They are about the least that suffice. Of 588 largest stresses of cylinders in
# plane strain on 20 to 138 cells, 3 were beyond their bounds, by up to 1.1 times, and of their depths none. With half of
# both there were 34, by up to 2.0 times, and no depth; with neither 36, by up to 3.0 times, and 129 depths. Where depths
# are given, the first is left out: of 120 largest stresses none had an error above half of its bound.
STRESS_FLOOR, DEPTH_FLOOR = 5e-4, 6e-3
# Least change of a number that a bound counts, over the L1 error of the pressure, since all changes may be small by
# chance. It limits the worst misses. Of 9260 numbers of smooth and wavy cylinders on 32 to 78 by 16 to 38 cells 27 were
# beyond their bounds, by up to 2.7 times; without a least change 33, by up to 4.8 times. With twice this one there were
# 24, by up to 2.1 times, and the median bound was 1.3 times as wide.
FLOOR = 0.1
# Least change of an area, of a rolling resistance or of a number left by a plastic zone, over the fraction of its cells
# that lie at its edge: the edge passes anywhere through such a cell, so that half of the cell is wrong in the mean.
AREA_FLOOR = 0.5
# Bound of the error by the inlet of a film, over the change of a number on a grid of twice the width. The error of a
# film thickness falls with the inlet's length^-2, and is 4/3 of that change; the error of a rolling resistance falls
# with length^-1, and is twice the change. On 97 in 100 of 750 random films of all kinds they were up to 1.4 and 1.7.
INLET = 1.75


def pressure_request(request: Request) -> float:
    """Return the relative L1 error of the pressure with which a request begins.

    If the keys of the request lack :data:`PRESSURE`, it is the smallest error of the request, but at least
    :data:`DEFAULT_ERROR`: for smaller errors of numbers the cells are refined from there.
    """
    if not isinstance(request, Mapping):
        return request
    return request.get(PRESSURE, max(DEFAULT_ERROR, min(request.values())))


@dataclass(frozen=True)
class ErrorParts:
    """Estimated bounds of a relative error by cause; a part is None where its cause does not apply.

    Attributes
    ----------
    images
        Error due to images that the padding leaves out.
    discretisation
        Error due to the cells.
    residual
        Error due to the solver's remaining residual.
    steps
        Error due to the steps in time.
    inlet
        Error due to the finite inlet of a film.
    range
        Error due to a range of the attraction that is chosen for the grid, in place of the JKR limit of short ranges.
    reason
        Sentence on why a part is infinite; empty where none is.
    """

    images: float | None = None
    discretisation: float | None = None
    residual: float | None = None
    steps: float | None = None
    inlet: float | None = None
    range: float | None = None
    reason: str = ""

    @property
    def by_cause(self) -> dict[str, float]:
        """Parts that apply, by their causes."""
        causes = [member.name for member in fields(self) if member.name != "reason"]
        return {cause: part for cause in causes if (part := getattr(self, cause)) is not None}

    @property
    def total(self) -> float:
        """Sum of the parts, which is the error where all causes act in the same direction."""
        return sum(self.by_cause.values())

    def scaled(self, factor: float) -> "ErrorParts":
        """Return all parts times a factor."""
        parts = {cause: factor * part for cause, part in self.by_cause.items()}
        return replace(self, **parts)  # type: ignore[arg-type]


@dataclass(frozen=True)
class ErrorEstimate(InNotebook):
    """Relative errors of an answer, as estimated bounds by quantity and cause.

    The L1 error of the pressure is against the cell means of the true pressure, relative to its L1 norm: the pressure of
    a cell is such a mean.

    Attributes
    ----------
    l1
        Error of the pressure in L1.
    peak_pressure, contact_area, mean_gap, approach
        Errors of the numbers of a contact; None where the answer does not have the number.
    by_grids
        Names of the errors above that are only a part of a bound, which adds the changes of the number between grids.
    stress
        Part of the error of largest stresses that changes between grids do not show; None where no stress is computed.
    central_film, minimum_film, friction_coefficient
        Errors of the numbers of a film; None for a dry contact.
    contact_load_fraction, contact_area_ratio
        Errors of the fractions of load and of area that asperity contacts in a film have; None without a boundary film.
    flash_temperature, film_temperature
        Errors of the rises of the temperature of a film; None for a film of one temperature.
    load, pull_off
        Errors of the load at a given approach, and of the pull-off load; None where they are not sought.
    warnings
        A sentence for each bound that is infinite, or on what to change.
    slip_reason
        Why slip, stick, force and power of tractive rolling have no bound; empty where they have one.
    """

    l1: ErrorParts
    peak_pressure: ErrorParts | None = None
    contact_area: ErrorParts | None = None
    mean_gap: ErrorParts | None = None
    approach: ErrorParts | None = None
    stress: ErrorParts | None = None
    central_film: ErrorParts | None = None
    minimum_film: ErrorParts | None = None
    friction_coefficient: ErrorParts | None = None
    contact_load_fraction: ErrorParts | None = None
    contact_area_ratio: ErrorParts | None = None
    flash_temperature: ErrorParts | None = None
    film_temperature: ErrorParts | None = None
    load: ErrorParts | None = None
    pull_off: ErrorParts | None = None
    warnings: tuple[str, ...] = ()
    slip_reason: str = ""
    by_grids: Sequence[str] = ()

    def __iter__(self) -> Iterator[tuple[str, ErrorParts]]:
        """Yield name and error of each quantity that has one."""
        for member in fields(self):
            parts = getattr(self, member.name)
            if isinstance(parts, ErrorParts):
                yield member.name, parts

    def _rows(self) -> str:
        """Return a line for each quantity: its error, and the parts by cause or why it has no bound."""
        errors = {name: parts for name, parts in self if parts.by_cause}
        rows = [
            f"  {name:<24}{100 * parts.total:8.2g} %  "
            + (parts.reason or ", ".join(f"{cause} {100 * part:.2g} %" for cause, part in parts.by_cause.items()))
            for name, parts in errors.items()
        ]
        return "\n".join(("bounds of relative errors", *rows, *self.warnings))
