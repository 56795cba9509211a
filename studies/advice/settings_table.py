"""The settings that no other beats on both counts."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.planning.cost import SMOOTH_CONVOLUTIONS, Timing, convolutions_to
from studies.model.outcome import CaseStatus
from studies.reference.line_contact import LINE, padding_at, padding_label, total_time


def pareto_front(cost: Array, error: Array) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Indices of the points with no other both cheaper and more accurate, by growing cost.

    ``cost`` and ``error`` are flat and of one length; points with nan are left out.
    """
    order = np.lexsort((error, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(error[order])]
    best = np.minimum.accumulate(error[order])
    is_better = np.concatenate(([True], best[1:] < best[:-1]))[: len(order)]
    return order[is_better]


# What of a contact may be asked to be accurate, and the stored errors of it; the second is nearly free.
STORED_ERRORS: dict[str, tuple[str, ...]] = {
    "peak pressure": ("peak_pressure_error",),
    "pressure in L1": ("pressure_error_l1", "corrected_error_l1"),
    "half-width": ("half_width_error",),
}
# Two least times of one computation may differ by so much; less is no saving.
NOISE = 1.1


@dataclass(frozen=True, eq=False)
class Settings:
    """Every stored setting at one period, one of a kind once: flat arrays over the settings.

    ``cost`` [s] with its ``spread`` (2, settings) from least to most, ``error``, and ``axes``, the value of
    each dimension.
    """

    cost: Array
    spread: Array
    error: Array
    axes: dict[str, np.ndarray]

    @property
    def modes(self) -> np.ndarray:
        """The padding of each."""
        return self.axes["padding"]

    def where(self, chosen: np.ndarray) -> "Settings":
        """Some of them."""
        axes = {name: values[chosen] for name, values in self.axes.items()}
        return Settings(self.cost[chosen], self.spread[:, chosen], self.error[chosen], axes)

    def name(self, index: int) -> str:
        """What setting ``index`` is, in words."""
        axes = {name: values[index] for name, values in self.axes.items()}
        return (
            f"{padding_label(str(axes['padding']), int(axes['images']))}, {int(axes['grid'])} cells"
        )

    def cheapest(self, target: float) -> int | None:
        """The one of least cost whose error is no larger than ``target``."""
        meets = np.flatnonzero(self.error <= target)
        return int(meets[np.argmin(self.cost[meets])]) if meets.size else None

    def savings(self) -> dict[str, tuple[float, float]]:
        """For each mode the most that it saves, and at which error.

        The cost of the cheapest setting of another mode that is as accurate as one of its own, over
        that one's cost: below one where another does as well for less, infinite where none does as well.
        """
        found = {}
        for mode in dict.fromkeys(self.modes.tolist()):
            own, others = self.where(self.modes == mode), self.where(self.modes != mode)
            best = 0.0, np.nan
            for cost, error in zip(own.cost, own.error, strict=True):
                other = others.cheapest(float(error))
                saved = np.inf if other is None else float(others.cost[other] / cost)
                best = max(best, (saved, float(error)), key=lambda pair: pair[0])
            found[mode] = best
        return found


def settings(dataset: xr.Dataset, *errors: str) -> Settings:
    """The settings in ``dataset``, which has no period left, by the least of the ``errors`` named."""
    error = np.minimum.reduce([abs(dataset[name]) for name in errors])
    cost = total_time(dataset)
    least = most = cost
    if "setup_time_all" in dataset:
        every = dataset["setup_time_all"] + dataset["solve_time_all"]
        least, most = every.min("repeat"), every.max("repeat")
    flat = xr.Dataset({"cost": cost, "least": least, "most": most})
    flat["error"] = cost.dims, error
    stacked = flat.stack(point=cost.dims).reset_index("point")
    axes = {str(name): stacked[name].values for name in cost.dims}
    spread = np.stack([stacked["least"].values, stacked["most"].values])
    every_one = Settings(stacked["cost"].values, spread, stacked["error"].values, axes)
    # points of one computation have one cost and one error
    known = np.flatnonzero(np.isfinite(every_one.cost) & np.isfinite(every_one.error))
    pairs = np.stack([every_one.cost[known], every_one.error[known]])
    return every_one.where(known[np.sort(np.unique(pairs, axis=1, return_index=True)[1])])


def stored_timings(dataset: xr.Dataset | None, cpu: str) -> tuple[Timing, ...]:
    """Return what the cases of a stored ``pareto`` took, if they were timed on this ``cpu``; else nothing."""
    if dataset is None or dataset.attrs.get("cpu") != cpu:
        return ()
    columns = dataset[["setup_time", "solve_time", "case_status"]]
    table = columns.sel(solver="preconditioned_cg", drop=True).to_dataframe().reset_index()
    seconds = table[["setup_time", "solve_time"]]
    table = table[(table["case_status"] == CaseStatus.OK) & (seconds > 0).all(axis=1)]
    return tuple(_timing(row) for row in table.itertuples(index=False))


def _timing(row: Any) -> Timing:
    lined = row.padding == LINE
    return Timing(
        cs.Grid((row.grid, 1 if lined else row.grid), (1.0, row.period)),
        padding_at("exact" if lined else row.padding, row.images),
        convolutions_to(row.solver_tolerance, SMOOTH_CONVOLUTIONS),
        row.setup_time,
        row.solve_time,
    )
