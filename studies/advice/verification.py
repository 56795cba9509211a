"""Whether recommendations keep what they promise, on stored settings alone."""

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

    Their stored ``error`` over the error asked for, and their stored time over that of the quickest setting
    that meets it: ``slower`` of those whose error is expected to, ``slower_than_luck`` of all, those whose
    edge happened to fall well in its cell among them.
    """

    error: Array
    slower: Array
    slower_than_luck: Array


def verify(dataset: xr.Dataset) -> Verification:
    """Recommend from a stored ``pareto``, at each period by the times of the other periods alone."""
    rows = []
    for period in dataset["period"].values.tolist():
        others = dataset.drop_sel(period=period) if dataset.sizes["period"] > 1 else dataset
        costs = CostModel(stored_timings(others, str(dataset.attrs.get("cpu"))))
        modes = tuple(str(name) for name in dataset["padding"].values)
        for chosen in (modes, tuple(name for name in modes if name != LINE)):
            contact = SmoothContact(
                HERTZ.half_width,
                period * HERTZ.half_width,
                chosen,
                tuple(dataset["grid"].values.tolist()),
                tuple(dataset["images"].values.tolist()),
                tuple(sorted(dataset["solver_tolerance"].values.tolist(), reverse=True)),
            )
            here = dataset.sel(period=period, padding=list(chosen))
            for metric in Metric:
                names = STORED_ERRORS[WHAT[metric]]
                every = settings(here, *names)
                own = {Edges.AS_SOLVED: names[0], Edges.CORRECTED: names[-1]}
                treated = {edges: settings(here, name) for edges, name in own.items()}
                for target in TARGETS.tolist():
                    limits = Limits(target, metric)
                    found = list(candidates(contact, limits, costs))
                    recommended = choose(found, limits)
                    if recommended.meets:
                        best = recommended.best
                        foreseen = [one for one in found if one.error.total <= target]
                        error = float(
                            treated[best.edges].error[_places(treated[best.edges], best)][0]
                        )
                        rows.append((error / target, *_slower(every, best, foreseen, target)))
    errors, slower, lucky = np.array(rows).reshape(-1, 3).T
    return Verification(errors, slower, lucky)


def _slower(
    every: Settings, best: Setting, foreseen: list[Setting], target: float
) -> tuple[float, float]:
    cost = float(every.cost[_places(every, best)][0])
    quickest = min(every.cost[_places(every, one)].min() for one in foreseen)
    lucky = every.cheapest(target)
    return cost / float(quickest), np.nan if lucky is None else cost / float(every.cost[lucky])


def _places(every: Settings, setting: Setting) -> np.ndarray:
    """Where a setting is among those stored."""
    axes = every.axes
    there = (axes["padding"] == setting.mode) & (axes["grid"] == setting.grid.cells[0])
    there &= (axes["solver"] == "preconditioned_cg") & (
        axes["solver_tolerance"] == setting.tolerance
    )
    if setting.mode in COUNTS_IMAGES:
        there &= axes["images"] == getattr(setting.padding, "images", 0)
    return np.flatnonzero(there)
