"""The error estimate of a solution, as measures that any study may add to its own."""

from collections.abc import Mapping
from dataclasses import asdict

import xarray as xr

import contactstudy as cs
from studies.model.case import number


def error_estimates(solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """``<metric>_estimate`` and its parts ``<metric>_estimate_<cause>``, for the highest pressure and L1."""
    estimate = cs.error_estimate(solution)
    metrics = {
        "highest_pressure": ("highest pressure", estimate.peak_pressure),
        "pressure_l1": ("pressure in L1", estimate.l1),
    }
    measured: dict[str, xr.Variable] = {}
    for name, (what, parts) in metrics.items():
        said = f"estimated relative error of the {what}"
        measured[f"{name}_estimate"] = number(parts.total, said)
        for cause, part in asdict(parts).items():
            measured[f"{name}_estimate_{cause}"] = number(part, f"{said}, by {cause}")
    return measured
