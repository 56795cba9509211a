"""Quantities of a contact with adhesion."""

from dataclasses import replace
from math import inf

import numpy as np

from contactstudy.accuracy.range_errors import NO_LIMIT
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.io.quantities.quantity import Quantity, per_length, with_bound
from contactstudy.solvers.solution import AdhesiveTraction, Solution


def adhesion_quantities(
    solution: Solution, adhesion: AdhesiveTraction, estimate: ErrorEstimate, length: float | None
) -> dict[str, Quantity]:
    """Return quantities of the attraction, by name; with the pull-off load of bodies that are pulled apart.

    In contact the repulsive part of the pressure is the strength above the net one, whose peak has the same error. Loads
    are per `length` [m] of a roller, or of the grid if that is None.
    """
    grid = solution.problem.grid
    on_length = grid.length / (length or grid.length)
    touching, total = bool(solution.pressure.any()), float(adhesion.attraction.sum())
    attraction = float(adhesion.attraction.sum() * grid.cell_area / grid.length) * on_length
    peak = Quantity(solution.peak_pressure, "Pa", "peak of the repulsive part")
    peak = with_bound(peak, estimate.peak_pressure, estimate.warnings)
    repulsive = replace(peak, value=float(solution.pressure.max()))
    error = estimate.load or estimate.l1
    if adhesion.regularised:
        error = ErrorParts(range=inf, reason=NO_LIMIT)
        repulsive = replace(repulsive, bound=inf, reason=NO_LIMIT)
    elif touching and total:
        moved = moved_force(solution, estimate) / total
        error = ErrorParts(discretisation=moved, reason=estimate.l1.reason)
    quantities = {
        "peak_repulsive_pressure": repulsive,
        "attraction": with_bound(
            Quantity(attraction, "N m-1", "adhesive force per length"), error, estimate.warnings
        ),
        "energy": per_length(adhesion.energy, "J", "energy", length, grid.length),
        "attraction_range": Quantity(adhesion.range, "m", "range of the attraction", 0.0, ""),
        "cells_in_zone": Quantity(adhesion.cells_in_zone, "1", "cells in the cohesive zone", 0.0, ""),
        "detached": Quantity(float(not touching), "1", "1 if the bodies do not touch", 0.0, ""),
    }  # fmt: skip
    if adhesion.tabor is not None:
        quantities["tabor_parameter"] = Quantity(adhesion.tabor, "1", "Tabor parameter", 0.0, "")
    if adhesion.first_unstable_load is not None:
        pull_off = Quantity(-solution.load_per_length * on_length, "N m-1", "pull-off load")
        quantities = {"pull_off": with_bound(pull_off, estimate.pull_off, estimate.warnings)} | quantities
    return quantities


def moved_force(solution: Solution, estimate: ErrorEstimate) -> float:
    """Return the error [Pa] of two sums over cells: of the attraction, and of the net pressure where bodies touch.

    It is the error of the net pressure in L1, and the largest attraction in the cells by which the contact may be larger
    or smaller.
    """
    norm, touching = float(np.abs(solution.net_pressure).sum()), np.count_nonzero(solution.pressure)
    assert solution.adhesion is not None
    area = inf if estimate.contact_area is None else estimate.contact_area.total
    return estimate.l1.total * norm + area * touching * float(solution.adhesion.attraction.max())
