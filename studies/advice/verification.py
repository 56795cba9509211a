"""Verification of recommendations on stored settings."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from contactstudy.accuracy.expected_error import Edges, Metric
from contactstudy.domain.fields import Array
from contactstudy.planning.cost import CostModel
from studies.advice.recommendation import Limits, Setting, SmoothContact, candidates, choose
from studies.advice.settings_table import STORED_ERRORS, Settings, settings, stored_timings
from studies.reference.line_contact import COUNTS_IMAGES, HERTZ, LINE

TARGETS = 10.0 ** np.arange(-1, -6.1, -0.5)
WHAT = {
    Metric.PEAK_PRESSURE: "peak pressure",
    Metric.L1: "pressure in L1",
    Metric.HALF_WIDTH: "half-width",
}


@dataclass(frozen=True, eq=False)
class Verification:
    """Recommendations among stored settings, one for each target, metric, period and choice of modes.

    Attributes
    ----------
    error
        Stored error over the requested error.
    slower
        Stored time over that of the quickest setting that is expected to meet the error.
    slower_than_luck
        Stored time over that of the quickest setting that meets it, also by chance, where the edge of the contact falls
        well in its cell.
    """

    error: Array
    slower: Array
    slower_than_luck: Array


def verify(dataset: xr.Dataset) -> Verification:
    """Recommend settings from a stored ``pareto`` sweep, at each period by the times of the other periods alone."""
    rows = []
    for period in dataset["period"].values.tolist():
        other_periods = dataset.drop_sel(period=period) if dataset.sizes["period"] > 1 else dataset
        costs = CostModel(stored_timings(other_periods, str(dataset.attrs.get("cpu"))))
        modes = tuple(str(name) for name in dataset["padding"].values)
        for chosen_modes in (modes, tuple(name for name in modes if name != LINE)):
            contact = SmoothContact(
                HERTZ.half_width,
                period * HERTZ.half_width,
                chosen_modes,
                tuple(dataset["grid"].values.tolist()),
                tuple(dataset["images"].values.tolist()),
                tuple(sorted(dataset["solver_tolerance"].values.tolist(), reverse=True)),
            )
            at_period = dataset.sel(period=period, padding=list(chosen_modes))
            for metric in Metric:
                names = STORED_ERRORS[WHAT[metric]]
                stored = settings(at_period, *names)
                error_names = {Edges.AS_SOLVED: names[0], Edges.CORRECTED: names[-1]}
                by_edges = {edges: settings(at_period, name) for edges, name in error_names.items()}
                for target in TARGETS.tolist():
                    limits = Limits(target, metric)
                    settings_found = list(candidates(contact, limits, costs))
                    recommended = choose(settings_found, limits)
                    if recommended.meets:
                        best = recommended.best
                        expected = [
                            setting for setting in settings_found if setting.error.total <= target
                        ]
                        error = float(
                            by_edges[best.edges].error[_places(by_edges[best.edges], best)][0]
                        )
                        rows.append((error / target, *_slower(stored, best, expected, target)))
    errors, slower, by_luck = np.array(rows).reshape(-1, 3).T
    return Verification(errors, slower, by_luck)


def _slower(
    stored: Settings, best: Setting, expected: list[Setting], target: float
) -> tuple[float, float]:
    """Return the time of `best` over that of the quickest expected setting, and over that of the quickest of all."""
    cost = float(stored.cost[_places(stored, best)][0])
    quickest = min(stored.cost[_places(stored, setting)].min() for setting in expected)
    by_luck = stored.cheapest(target)
    return cost / float(quickest), np.nan if by_luck is None else cost / float(stored.cost[by_luck])


def _places(stored: Settings, setting: Setting) -> np.ndarray:
    """Return the indices of a setting among those stored."""
    axes = stored.axes
    matches = (axes["padding"] == setting.mode) & (axes["grid"] == setting.grid.cells[0])
    matches &= (axes["solver"] == "preconditioned_cg") & (
        axes["solver_tolerance"] == setting.tolerance
    )
    if setting.mode in COUNTS_IMAGES:
        matches &= axes["images"] == getattr(setting.padding, "images", 0)
    return np.flatnonzero(matches)
