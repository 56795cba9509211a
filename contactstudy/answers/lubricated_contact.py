"""The answer for a lubricated contact: a film with the bounds of its numbers.

A bound is a margin times the largest change of a number between the film and those on a half, a third and a quarter of
the cells along each axis, with the change from half the cells to as large cells over twice the width: that tells the
error by the finite inlet. Numbers with a law of their own are in `LubricatedContact._by_laws_of_films`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy.accuracy.coarser import coarsened
from contactstudy.answers.answer import Answer, by_changes, levels_below, solved_or_none, widened, with_nested_bounds
from contactstudy.domain.errors import INLET, MARGIN, PRESSURE, ErrorEstimate, ErrorParts, Request
from contactstudy.domain.grid import across_and_along
from contactstudy.domain.imports import needed_for
from contactstudy.domain.validation import NotDefined
from contactstudy.io.quantities.film_quantities import BY_SLIDING, ON_ASPERITIES, film_quantities
from contactstudy.io.quantities.quantity import NO_ESTIMATE, Quantities, Quantity
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.posed_film import interpolated
from contactstudy.lubrication.steady_film import solve_lubricated
from contactstudy.problem.problem import Field
from contactstudy.scene.shapes.shape import shortest_wavelengths, unresolved, with_extent_of
from contactstudy.solvers.solution import Counts, Status

if TYPE_CHECKING:
    import xarray as xr

# What a verdict says that the largest bound is in, by the name of the number that has it; "film" for other numbers.
MEASURES = {
    "friction_coefficient": "friction",
    "flash_temperature": "flash temperature",
    "film_temperature": "film temperature",
    "contact_load_fraction": "load fraction of asperities",
}
# Numbers whose errors are told by cause.
BY_CAUSE = "peak_pressure", "central_film", "minimum_film", "contact_area_ratio", *MEASURES
# Outcomes without a film to compare with.
NO_FILM = Status.FILM_NOT_CONVERGED, Status.SEVERAL_FILMS, Status.CONTACT_AT_EDGE
NO_FILM_BELOW = "No bound: there is no film on half the {} cells across to compare with, give more."
OF_IMAGES = (
    "No bound: padding is {!r}, and the error of a film by the images that it leaves out is not estimated, give "
    "ExactPeriodicity()."
)
# A friction that changes by more than this from half the cells, and by more than from a quarter to half, may grow with
# the cells, as that of a Newtonian stress below a spike. Smaller changes are within the bound: of 349 random films 4
# had a friction beyond it.
NOTICEABLE = 0.02
GROWS = (
    "No bound: from half the cells it changes by {:.2g} %, more than from a quarter to half, so that it may grow with "
    "them, as below a spike of the pressure. Give more cells, or a shear law that thins, such as Eyring()."
)
UNTOUCHED = "No bound: no cell touches, and the minimum film is within its error of the boundary film, give more cells."


@dataclass(frozen=True, eq=False, repr=False)
class LubricatedContact(Answer, FilmSolution):
    """Lubricated contact: fields (x, y) of its film thickness, pressure and shear stress.

    Parameters
    ----------
    requested
        Requested relative error of every number, or errors by name.
    time
        Time [s] of a frame of an evolution; None for others.
    estimate
        Errors of a frame of an evolution; None compares with films on fewer cells, and over twice the width.
    """

    requested: Request | None = None
    time: float | None = None
    estimate: ErrorEstimate | None = None

    @cached_property
    def error(self) -> ErrorEstimate:
        """Estimate of the errors, from films on further grids where it is not known already."""
        if self.estimate is not None:
            return self.estimate
        errors: Any = {name: self.error_of(name) for name in BY_CAUSE if name in self.quantities}
        reasons = (parts.reason for parts in (self._l1, *errors.values()))
        return ErrorEstimate(self._l1, **errors, warnings=tuple(dict.fromkeys(filter(None, reasons))))

    def error_of(self, name: str) -> ErrorParts:
        """Return the error of a number by cells, inlet and residual: relative, of a fraction as it is."""
        number = self.quantities[name]
        if not number.bound:
            return ErrorParts()
        if not isfinite(number.bound):
            return ErrorParts(discretisation=inf, inlet=inf, residual=inf, reason=number.reason)
        assert self._wider is not None
        size = 1.0 if number.is_fraction else abs(number.value)
        inlet = INLET * abs(self._below[2].quantities[name].value - self._wider.quantities[name].value) / size
        cells = max(number.bound / size - inlet - self.residual, 0.0)
        return ErrorParts(discretisation=cells, inlet=inlet, residual=self.residual)

    @cached_property
    def requested_errors(self) -> dict[str, ErrorParts]:
        """Error of each number that the scene asks for, of the film and of what its motion adds."""
        motion = self.scales.lubrication
        names = ["central_film", "minimum_film"]
        if motion.slide_roll_ratio:
            names.append("friction_coefficient")
            if motion.thermal is not None:
                names += ["flash_temperature", "film_temperature"]
        if motion.boundary is not None:
            names.append("contact_load_fraction")
        return {name: self.error_of(name) for name in names}

    @cached_property
    def quantities(self) -> Quantities:
        """Numbers of the film by name, with unit and bound."""
        if self.estimate is not None:
            return film_quantities(self, self.estimate.l1)
        found = film_quantities(self, self._l1)
        if self._l1.reason or self._wider is None:
            return found
        below = {k: film.quantities for k, film in self._below.items()}
        replaced = frozenset({NO_ESTIMATE})  # numbers with this reason get a bound
        found = with_nested_bounds(found, below, self._l1, replaced, wider=self._wider.quantities)
        return found | self._by_laws_of_films(found)

    def _by_laws_of_films(self, found: Quantities) -> dict[str, Quantity]:
        """Return those quantities of ``found`` whose bounds are not by their changes between grids alone.

        They are the power loss, the meniscus, numbers by sliding whose friction may grow with the cells, and numbers of
        asperities that do not touch.
        """
        power, sliding, rolling = (found[name] for name in ("power_loss", "sliding_loss", "rolling_resistance"))
        # the bound of the power loss is at least that of its parts, which may change against each other
        of_parts = sliding.bound + rolling.bound * self.load_per_length * self.mean_speed
        changed = {"power_loss": replace(power, bound=max(power.bound, of_parts))}
        if "meniscus" in found:  # a meniscus lies between two cells
            meniscus = found["meniscus"]
            changed["meniscus"] = replace(meniscus, bound=meniscus.bound + self.grid.cell_size[0])
        # on all, half and a quarter of the cells
        frictions = [film.friction for k, film in self._below.items() if k != 3]
        changes = [abs(fine / coarse - 1) if coarse else 0.0 for fine, coarse in pairwise((self.friction, *frictions))]
        if changes[0] > max(NOTICEABLE, changes[-1]):
            reason = GROWS.format(100 * changes[0])
            bounded = [name for name in BY_SLIDING if isfinite(found[name].bound)]
            changed |= {name: replace(found[name], bound=inf, reason=reason) for name in bounded}
        boundary = self.scales.lubrication.boundary
        if self.contact_pressure is not None and boundary is not None and not self.contact_pressure.any():
            lowest = found["minimum_film"]
            is_clear = lowest.value - lowest.bound > boundary.film
            bound, reason = (0.0, "") if is_clear else (inf, UNTOUCHED)
            changed |= {name: replace(found[name], bound=bound, reason=reason) for name in ON_ASPERITIES}
        return changed

    @cached_property
    def _l1(self) -> ErrorParts:
        """Error of the pressure in L1 by cells, inlet and residual; infinite with a reason."""
        reason = unresolved(shortest_wavelengths(self.scene.shapes), self.grid)
        if across_and_along(self.padding)[1].window is not None:
            reason = OF_IMAGES.format(self.padding)
        elif self.status in (*NO_FILM, Status.FILM_BELOW_CELL):
            reason = f"No bound: {self.status}"
        elif not reason and (2 not in self._below or self._wider is None):
            reason = NO_FILM_BELOW.format(self.grid.cells[0])
        if reason or self._wider is None:
            return ErrorParts(discretisation=inf, inlet=inf, residual=inf, reason=reason)
        return l1_of_films({1: self} | self._below, self._wider, ErrorParts(residual=self.residual))

    def _on_coarser_cells(self, factor: int, widening: int = 1) -> "LubricatedContact":
        """Return the film on 1 / `factor` of the cells along each axis, over a multiple of the width."""
        scene = replace(self.scene, shapes=with_extent_of(self.scene.shapes, self.grid))
        grid = widened(coarsened(self.grid, factor), widening)
        solution = solve_lubricated(scene, grid, self.padding, start=self)
        film = film_answer(solution, estimate=ErrorEstimate(ErrorParts()))
        if film.status in NO_FILM:
            raise NotDefined(str(film.status))
        return film

    @cached_property
    def _below(self) -> "dict[int, LubricatedContact]":
        """The film on 1 / k of the cells along each axis by k, as far as there is one."""
        return levels_below(self._on_coarser_cells)  # type: ignore[return-value]

    @cached_property
    def _wider(self) -> "LubricatedContact | None":
        """The film on half the cells over twice the width, which tells the error by the inlet; None without one."""
        return solved_or_none(self._on_coarser_cells, 2, 2)  # type: ignore[return-value]

    @property
    def state(self) -> Mapping[str, Field]:
        """Fields that a frame keeps from one instant to the next, such as the wear depth."""
        worn = self.wear_depth
        return {} if worn is None else {"wear_depth": Field(("x", "y"), worn, "m", "wear depth")}

    @property
    def judged_error(self) -> tuple[str, ErrorParts]:
        """The largest bound of the numbers that the scene asks for."""
        errors = self.requested_errors
        name = max(errors, key=lambda name: errors[name].total)
        return f"in the {MEASURES.get(name, 'film')}", errors[name]

    @property
    def _main_cause(self) -> str:
        """Cause of the largest part of the error that exceeds the request by the largest factor."""
        ratios = {name: number.ratio for name, number in self.judged.items() if 1 < number.ratio < inf}
        ratios.pop(PRESSURE, None)
        if not ratios:
            return super()._main_cause
        parts = self.error_of(max(ratios, key=ratios.__getitem__)).by_cause
        return max(parts, key=parts.__getitem__)

    @property
    def counts(self) -> Counts:
        """Iterations of the film and of its linear systems, the residual, and the imbalance of the flow."""
        return {
            "iterations": (self.iterations, "steps on the finest grid"),
            "linear_iterations": (self.linear_iterations, "iterations of linear systems"),
            "residual": (self.residual, "residual of the film"),
            "flux_spread": (self.flux_spread, "relative imbalance of the mass flow"),
        }

    def to_dataset(self) -> "xr.Dataset":
        """Return fields (x, y) and quantities with units, long names, bounds, errors by cause and the scene."""
        with needed_for("LubricatedContact.to_dataset"):
            from contactstudy.io.dataset import film_dataset

        dataset = film_dataset(self, self.error, self.quantities)
        return dataset if self.time is not None else dataset.assign_attrs(accuracy=self.accuracy)


def l1_of_films(films: Mapping[int, FilmSolution], wider: FilmSolution, known: ErrorParts) -> ErrorParts:
    """Return the L1 error of the pressure of a film, with a `known` error by other causes.

    Parameters
    ----------
    films
        The film on 1 / k of the cells along each axis, by k; that of k = 1 is the one judged.
    wider
        The film on half the cells over twice the width.
    known
        Errors by other causes.
    """
    grid = films[1].grid
    total = float(films[1].pressure.sum())

    def distance(film: FilmSolution, other: FilmSolution) -> float:
        on_grid = (interpolated(each.pressure, each.grid, grid.x, grid.y) for each in (film, other))
        return float(np.abs(np.subtract(*on_grid)).sum()) / total

    # a change shows the larger error the lower the order: the first, where errors fall with the first or second
    cells, inlet = MARGIN * by_changes(films, order=1.0, distance=distance), INLET * distance(films[2], wider)
    return replace(known, discretisation=cells, inlet=inlet, reason="")


def film_answer(contact: FilmSolution, **further_fields: Any) -> LubricatedContact:
    """Return a film as an answer, with `further_fields` of :class:`LubricatedContact`."""
    values = {field.name: getattr(contact, field.name) for field in fields(FilmSolution)}
    return LubricatedContact(**values, **further_fields)
