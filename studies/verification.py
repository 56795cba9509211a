"""Whether recommendations keep what they promise, on stored settings alone."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from contactstudy.arrays import Array
from contactstudy.expected_error import Edges, Metric
from studies.cost_model import cost_model
from studies.line_contact import HERTZ, LINE
from studies.price import METRICS, settings
from studies.recommendation import Limits, Setting, SmoothContact, candidates, recommend

TARGETS = 10.0 ** np.arange(-1, -6.1, -0.5)
WHAT = {
    Metric.PEAK_PRESSURE: "highest pressure",
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
        costs = cost_model(others, str(dataset.attrs.get("cpu")))
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
                for target in TARGETS.tolist():
                    limits = Limits(target, metric)
                    found = recommend(contact, limits, costs)
                    meeting = [
                        setting
                        for setting in candidates(contact, limits, costs)
                        if setting.error.total <= target
                    ]
                    if found.meets:
                        rows.append(_row(here, metric, target, found.best, meeting))
    error, slower, lucky = np.array(rows).reshape(-1, 3).T
    return Verification(error, slower, lucky)


def _row(
    here: xr.Dataset, metric: Metric, target: float, best: Setting, meeting: list[Setting]
) -> tuple[float, float, float]:
    names = METRICS[WHAT[metric]]
    variable = names[-1] if best.edges is Edges.CORRECTED else names[0]
    cost = _cost(here, best)
    every = settings(here, *names)
    lucky = every.cheapest(target)
    return (
        abs(float(_stored(here, best)[variable])) / target,
        cost / min(_cost(here, setting) for setting in meeting),
        cost / float(every.cost[lucky]) if lucky is not None else np.nan,
    )


def _stored(here: xr.Dataset, setting: Setting) -> xr.Dataset:
    at: dict[str, object] = {
        "padding": setting.mode,
        "grid": setting.grid.cells[0],
        "solver_tolerance": setting.tolerance,
        "solver": "preconditioned_cg",
        "images": getattr(setting.padding, "images", int(here["images"][0])),
    }
    return here.sel(at)


def _cost(here: xr.Dataset, setting: Setting) -> float:
    one = _stored(here, setting)
    return float(one["setup_time"] + one["solve_time"])
