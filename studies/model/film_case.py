"""Lubricated contacts of a sweep, and the quantities recorded of them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import nan
from time import perf_counter

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.reuse import reusing
from contactstudy.io.dataset import flags
from contactstudy.io.summary import film_quantities
from studies.model.case import Case, number


@dataclass(frozen=True, eq=False)
class SolvedFilm:
    """A lubricated contact, and the wall time [s] of its solution."""

    contact: cs.LubricatedContact
    seconds: float


@dataclass(frozen=True)
class FilmCase(Case):
    """A lubricated contact to solve."""

    def prepare(self) -> None:  # type: ignore[override]
        """Do nothing: a film sets up its nested grids itself."""

    def run(self, prepared: object = None) -> SolvedFilm:  # type: ignore[override]
        """Solve the film, and time it alone: it sets up its own coefficients."""
        with reusing(None):
            start = perf_counter()
            contact = cs.solve_lubricated(
                self.scene, self.grid, self.padding, tolerance=self.options.tolerance
            )
            return SolvedFilm(contact, perf_counter() - start)

    def record(self, result: SolvedFilm) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """Return the numbers of the iteration, and its status as CF flags."""
        contact = result.contact
        return {
            "solver_status": film_status(contact.status),
            "iterations": number(contact.iterations, "steps of the finest grid"),
            "linear_iterations": number(
                contact.linear_iterations, "iterations of linear systems on the finest grid"
            ),
            "residual": number(contact.residual, "residual of the solver"),
        }

    def fields(self, result: SolvedFilm) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """Return pressure, film and film fraction over the grid."""
        dataset = result.contact.to_dataset()
        shown = "x", "y", "pressure", "film", "film_fraction"
        return {name: dataset[name].variable for name in shown}


def film_status(status: cs.FilmStatus) -> xr.Variable:
    """Return the status of a film as a CF flag."""
    statuses = list(cs.FilmStatus)
    meanings = [member.name.lower() for member in statuses]
    return flags((), np.asarray(statuses.index(status)), meanings, "how the solver ended")


def film_measures(case: FilmCase, solved: SolvedFilm) -> Mapping[str, xr.Variable]:
    """Return film, friction, power loss, Moes' parameters, shares of a thin film, wall time and estimated errors."""
    contact = solved.contact
    measured = {
        quantity.name: xr.Variable(
            (), quantity.value, {"units": quantity.units, "long_name": quantity.long_name}
        )
        for quantity in film_quantities(contact)
    }
    scales = contact.scales
    expected = scales.expected_film * scales.film
    area, load = contact.thinner_than(expected / 2)
    thin_film = "film below half of that of Moes' formula"
    measured["moes_film"] = xr.Variable(
        (), expected, {"units": "m", "long_name": "film by the formula of Moes"}
    )
    measured["thin_area"] = number(area, f"share of Hertz's area with a {thin_film}")
    measured["thin_load"] = number(load, f"share of the load on a {thin_film}")
    measured["wall_time"] = xr.Variable(
        (), solved.seconds, {"units": "s", "long_name": "wall time, beside other cases"}
    )
    estimate = asdict(cs.film_error(contact)) if contact.is_smooth else {}
    for metric in ("central_film", "minimum_film", "friction"):
        parts = estimate.get(metric)
        total = sum(parts.values()) if parts else nan
        name = f"estimated relative error of the {metric.replace('_', ' ')}"
        measured[f"{metric}_estimate"] = number(total, name)
    return measured
