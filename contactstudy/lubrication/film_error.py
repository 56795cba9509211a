"""Errors of a lubricated contact, from further solutions: with half the cells across, and with twice the inlet."""

from dataclasses import dataclass, replace
from math import inf

import numpy as np

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.lubrication.lubricated_contact import (
    FilmStatus,
    LubricatedContact,
    rise_beside_lowest,
)

# The inlet's error falls as its length^-2. A constriction of few cells hides a share of the film's rise beside it.
SHORTER_INLET, HIDDEN = 4 / 3, 0.2
# Of the change from a quarter to half the cells, the share that the next change may have, unless it happens to vanish.
NEXT = 1 / 3
# A second peak of pressure, this much higher than the valley before it [of the highest], is a spike.
SPIKE = 0.02


@dataclass(frozen=True)
class FilmErrorParts:
    """Relative errors by cause.

    ``discretisation`` is that of the cells, ``inlet`` that of a finite inlet, ``residual`` that of the iteration.
    """

    discretisation: float
    inlet: float
    residual: float

    @property
    def total(self) -> float:
        """Sum of the parts."""
        return self.discretisation + self.inlet + self.residual


@dataclass(frozen=True)
class FilmError:
    """Estimated relative errors of a lubricated contact; ``peak_pressure`` is infinite beside a spike.

    ``reason`` says why a part is infinite, and is empty where none is.
    """

    central_film: FilmErrorParts
    minimum_film: FilmErrorParts
    friction: FilmErrorParts
    pressure_l1: FilmErrorParts
    peak_pressure: FilmErrorParts
    reason: str = ""


def film_error(contact: LubricatedContact) -> FilmError:
    """Estimate the errors of ``contact``.

    Three further solutions are made, with half the cells, with a quarter, and with half over twice the inlet. Cells: the
    difference to half as many, since the order observed is 1 to 2.3, no less than a third of that between half and a
    quarter, since the error may change its sign, and of the smallest film no less than a fifth of its rise over the
    next cell. Inlet: 4/3 of the change, as its error falls with the inlet's length squared. Where half
    the cells do not resolve the film no estimate is finite, nor is that of a peak beside a spike, which is as high as
    the cells are fine.
    """
    from contactstudy.lubrication.solve_lubricated import solve_lubricated

    (nx, ny), (width, period) = contact.grid.cells, contact.grid.extent
    half = max(nx // 2, 8)
    x = contact.grid.x
    coarse = solve_lubricated(contact.scene, Grid((half, ny), (width, period)), contact.padding)
    coarsest = solve_lubricated(
        contact.scene, Grid((max(half // 2, 8), ny), (width, period)), contact.padding
    )
    longer = solve_lubricated(
        contact.scene, Grid((2 * half, ny), (2 * width, period)), contact.padding
    )
    unresolved = FilmStatus.NOT_CONVERGED, FilmStatus.FILM_BELOW_CELL
    failed = [one for one in (contact, coarse, longer) if one.status in unresolved]
    residual = inf if failed else contact.residual
    reason = ""
    if failed:
        cells = failed[0].grid.cells[0]
        reason = (
            f"With {cells} cells across a film of the estimate is no answer: {failed[0].status}"
        )

    def parts(name: str) -> FilmErrorParts:
        here, wide, widest, long = (
            float(getattr(one, name)) for one in (contact, coarse, coarsest, longer)
        )
        scale = abs(here) or 1.0
        change = abs(here - wide)
        if coarsest.status not in unresolved:
            change = max(change, NEXT * abs(wide - widest))
        return FilmErrorParts(change / scale, SHORTER_INLET * abs(wide - long) / scale, residual)

    on_coarse, on_longer = (_pressure_at(x, one) for one in (coarse, longer))
    pressure = FilmErrorParts(
        _l1(contact.pressure, on_coarse),
        SHORTER_INLET * _l1(on_coarse, on_longer),
        residual,
    )
    peak = parts("peak_pressure")
    if has_spike(contact.pressure):
        peak = FilmErrorParts(inf, peak.inlet, residual)
        reason = reason or (
            "The peak pressure has no estimate: it may be that of the spike before the outlet, which grows with the "
            "number of cells."
        )
    smallest = parts("minimum_film")
    hidden = HIDDEN * rise_beside_lowest(contact.film)
    smallest = replace(smallest, discretisation=max(smallest.discretisation, hidden))
    return FilmError(parts("central_film"), smallest, parts("friction"), pressure, peak, reason)


def has_spike(pressure: Array) -> bool:
    """Return whether the mean pressure over the length (x, y) has a second peak downstream of a valley."""
    mean = pressure.mean(axis=1)
    falls = np.maximum.accumulate(mean) - mean
    # the deepest valley that pressure rises from again
    rises = np.maximum.accumulate(mean[::-1])[::-1] - mean
    return bool(np.minimum(falls, rises).max() > SPIKE * mean.max())


def _pressure_at(x: Array, contact: LubricatedContact) -> Array:
    """Return the pressure of ``contact`` (x, y) at other places ``x`` across, linear between its cells."""
    return np.stack([np.interp(x, contact.grid.x, column) for column in contact.pressure.T], axis=1)


def _l1(pressure: Array, other: Array) -> float:
    return float(np.abs(pressure - other).sum() / np.abs(pressure).sum())
