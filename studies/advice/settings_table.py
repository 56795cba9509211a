"""Stored settings as a table: their Pareto front, the cheapest for an error, and what each mode saves."""

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
    """Return the indices of the points that no other beats in both cost and error, by growing cost.

    Parameters
    ----------
    cost, error
        Flat arrays of one length; points with nan are left out.
    """
    order = np.lexsort((error, cost))
    order = order[np.isfinite(cost[order]) & np.isfinite(error[order])]
    best = np.minimum.accumulate(error[order])
    is_better = np.concatenate(([True], best[1:] < best[:-1]))[: len(order)]
    return order[is_better]


# Quantities whose error can be requested, and their stored errors; the second costs almost nothing more.
STORED_ERRORS: dict[str, tuple[str, ...]] = {
    "peak pressure": ("peak_pressure_error",),
    "pressure in L1": ("pressure_error_l1", "corrected_error_l1"),
    "half-width": ("half_width_error",),
}
# Ratio by which two least times of one computation may differ; less is no saving.
NOISE = 1.1


@dataclass(frozen=True, eq=False)
class Settings:
    """Stored settings at one period, each once, as flat arrays.

    Attributes
    ----------
    cost
        Time of each setting [s].
    spread
        Least and largest time (2, settings) [s].
    error
        Relative error of each setting.
    axes
        Value of each dimension for each setting.
    """

    cost: Array
    spread: Array
    error: Array
    axes: dict[str, np.ndarray]

    @property
    def modes(self) -> np.ndarray:
        """Name of the padding of each setting."""
        return self.axes["padding"]

    def where(self, chosen: np.ndarray) -> "Settings":
        """Return the settings that the boolean or index array `chosen` selects."""
        axes = {name: values[chosen] for name, values in self.axes.items()}
        return Settings(self.cost[chosen], self.spread[:, chosen], self.error[chosen], axes)

    def name(self, index: int) -> str:
        """Return the name of the setting with index `index` in words."""
        axes = {name: values[index] for name, values in self.axes.items()}
        return (
            f"{padding_label(str(axes['padding']), int(axes['images']))}, {int(axes['grid'])} cells"
        )

    def cheapest(self, target: float) -> int | None:
        """Return the index of the cheapest setting whose error is no larger than `target`; None without one."""
        meets = np.flatnonzero(self.error <= target)
        return int(meets[np.argmin(self.cost[meets])]) if meets.size else None

    def savings(self) -> dict[str, tuple[float, float]]:
        """Return for each mode how much it saves at the most, and at which error.

        The saving is the cost of the cheapest setting of another mode that is as accurate as a setting of this mode,
        over the cost of that setting: below 1 where another mode is cheaper, infinite where none is as accurate.
        """
        savings = {}
        for mode in dict.fromkeys(self.modes.tolist()):
            of_mode, of_others = self.where(self.modes == mode), self.where(self.modes != mode)
            best = 0.0, np.nan
            for cost, error in zip(of_mode.cost, of_mode.error, strict=True):
                rival = of_others.cheapest(float(error))
                saved = np.inf if rival is None else float(of_others.cost[rival] / cost)
                best = max(best, (saved, float(error)), key=lambda pair: pair[0])
            savings[mode] = best
        return savings


def settings(dataset: xr.Dataset, *errors: str) -> Settings:
    """Return the settings in `dataset`, which has no period left, with the least of the errors named."""
    error = np.minimum.reduce([abs(dataset[name]) for name in errors])
    cost = total_time(dataset)
    least = most = cost
    if "setup_time_all" in dataset:
        times = dataset["setup_time_all"] + dataset["solve_time_all"]
        least, most = times.min("repeat"), times.max("repeat")
    flat = xr.Dataset({"cost": cost, "least": least, "most": most})
    flat["error"] = cost.dims, error
    stacked = flat.stack(point=cost.dims).reset_index("point")
    axes = {str(name): stacked[name].values for name in cost.dims}
    spread = np.stack([stacked["least"].values, stacked["most"].values])
    all_settings = Settings(stacked["cost"].values, spread, stacked["error"].values, axes)
    # points that share one computation have the same cost and error
    finite = np.flatnonzero(np.isfinite(all_settings.cost) & np.isfinite(all_settings.error))
    pairs = np.stack([all_settings.cost[finite], all_settings.error[finite]])
    return all_settings.where(finite[np.sort(np.unique(pairs, axis=1, return_index=True)[1])])


def stored_timings(dataset: xr.Dataset | None, cpu: str) -> tuple[Timing, ...]:
    """Return the timings of a stored ``pareto`` sweep, if they were taken on the processor `cpu`; else none."""
    if dataset is None or dataset.attrs.get("cpu") != cpu:
        return ()
    columns = dataset[["setup_time", "solve_time", "case_status"]]
    table = columns.sel(solver="preconditioned_cg", drop=True).to_dataframe().reset_index()
    seconds = table[["setup_time", "solve_time"]]
    table = table[(table["case_status"] == CaseStatus.OK) & (seconds > 0).all(axis=1)]
    return tuple(_timing(row) for row in table.itertuples(index=False))


def _timing(row: Any) -> Timing:
    """Return a row of the stored sweep as a timing."""
    is_line = row.padding == LINE
    return Timing(
        cs.Grid((row.grid, 1 if is_line else row.grid), (1.0, row.period)),
        padding_at("exact" if is_line else row.padding, row.images),
        convolutions_to(row.solver_tolerance, SMOOTH_CONVOLUTIONS),
        row.setup_time,
        row.solve_time,
    )
