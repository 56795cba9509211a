"""The answer for a lubricated contact."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

from contactstudy.answers.answer import Answer
from contactstudy.domain.errors import ErrorEstimate, ErrorParts, Request
from contactstudy.domain.imports import needed_for
from contactstudy.io.quantities.film_quantities import film_quantities
from contactstudy.io.quantities.quantity import Quantities
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.problem.problem import Field
from contactstudy.solvers.solution import Counts

if TYPE_CHECKING:
    import xarray as xr

# What a bound is said to be in, by the number of the largest one.
MEASURES = {
    "friction_coefficient": "friction",
    "flash_temperature": "flash temperature",
    "film_temperature": "film temperature",
    "contact_load_fraction": "load fraction of asperities",
}


@dataclass(frozen=True, eq=False, repr=False)
class LubricatedContact(Answer, FilmSolution):
    """Lubricated contact: fields (x, y) of its film thickness, pressure and shear stress.

    Parameters
    ----------
    requested
        Requested relative error of every number, or errors by name.
    time
        Time [s] of a frame of an evolution; None for others.
    """

    requested: Request | None = None
    time: float | None = None

    @cached_property
    def error(self) -> ErrorEstimate:
        """Estimate of the errors, from further solutions where it is not known already."""
        from contactstudy.lubrication.film_error import film_error

        return film_error(self) if self.estimate is None else self.estimate

    @cached_property
    def quantities(self) -> Quantities:
        """Numbers of the film by name, with unit and bound."""
        return film_quantities(self, self.error)

    @property
    def state(self) -> Mapping[str, Field]:
        """Fields that a frame keeps from one instant to the next, such as the wear depth."""
        worn = self.wear_depth
        return {} if worn is None else {"wear_depth": Field(("x", "y"), worn, "m", "wear depth")}

    @property
    def judged_error(self) -> tuple[str, ErrorParts]:
        """The largest bound of the numbers that the scene asks for."""
        errors = self.requested_errors(self.error)
        name = max(errors, key=lambda name: errors[name].total)
        return f"in the {MEASURES.get(name, 'film')}", errors[name]

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


def film_answer(contact: FilmSolution, **further_fields: Any) -> LubricatedContact:
    """Return a film as an answer, with `further_fields` of :class:`LubricatedContact`."""
    values = {field.name: getattr(contact, field.name) for field in fields(FilmSolution)}
    return LubricatedContact(**values, **further_fields)
