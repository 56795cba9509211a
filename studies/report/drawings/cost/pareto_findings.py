"""Which modes pay, where, and what each decade of accuracy costs: what a stored ``pareto`` says."""

from collections.abc import Iterable

import numpy as np
import xarray as xr

from studies.advice.settings_table import METRICS, NOISE, settings
from studies.advice.verification import verify
from studies.model.finding import Finding, Table
from studies.reference.line_contact import LINE, covers
from studies.report.formatting import paddings, percent

DECADES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
# A peak's or a half-width's error has a sign: that of the images may by chance undo that of the cells.
L1 = METRICS["pressure in L1"]


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Which modes are never worth using, and whether recommendations keep what they promise."""
    if not covers(dataset, {"duplicated", "superposed", "circular", "exact"}):
        return ()
    return (
        Finding(*dominated_modes(dataset), "What is never worth using?"),
        Finding(*recommendation_check(dataset), "Can a recommendation be trusted?"),
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """The least time in which each mode meets each decade of the L1 error, at every period."""
    rows = []
    for (mode, period), seconds in decades(dataset).items():
        times = (f"{second:.2g}" if np.isfinite(second) else "none" for second in seconds)
        rows.append((mode, period, *times))
    table = Table(
        "What each decade costs: the least time [s] on one thread in which each mode meets an L1 error of the "
        "pressure, its edges corrected or not, over all n, grids, tolerances and solvers of the study. "
        "“line” is exact periodicity with one cell along a length where nothing varies.",
        ("padding", "period", *(f"error {target:.0e}" for target in DECADES)),
        tuple(rows),
    )
    return (table,)


def decades(dataset: xr.Dataset) -> dict[tuple[str, str], tuple[float, ...]]:
    """Least seconds for each of ``DECADES`` of the L1 error, infinite for none, by mode and period."""
    found = {}
    for period in dataset["period"].values:
        every = settings(dataset.sel(period=period), *L1)
        for mode in dict.fromkeys(every.modes.tolist()):
            own = every.where(every.modes == mode)
            best = (own.cheapest(target) for target in DECADES)
            seconds = tuple(np.inf if one is None else float(own.cost[one]) for one in best)
            if np.isfinite(seconds).any():
                found[mode, "any" if mode == LINE else f"{period:g} a"] = seconds
    return found


def savings(dataset: xr.Dataset) -> dict[str, dict[float, tuple[float, float]]]:
    """For each mode, the most it saves at each period, and at which L1 error (see ``Settings``).

    Among the modes that have cells along the length: with one cell alone nothing else would ever pay.
    """
    found: dict[str, dict[float, tuple[float, float]]] = {}
    for period in dataset["period"].values.tolist():
        every = settings(dataset.sel(period=period), *L1)
        for mode, best in every.where(every.modes != LINE).savings().items():
            found.setdefault(mode, {})[period] = best
    return found


def dominated_modes(dataset: xr.Dataset) -> tuple[str, str]:
    """The claim about modes that are never worth using, and what was measured."""
    saved = savings(dataset)
    most = {mode: max(best for best, _ in places.values()) for mode, places in saved.items()}
    never = [mode for mode, best in most.items() if best <= NOISE]
    said = []
    for mode, places in saved.items():
        paying = {at: best for at, best in places.items() if best[0] > NOISE}
        if mode in never:
            least, error = max(places.values())
            slower = least < 1 / 1.05
            took = f"takes {1 / least:.2g} times as long as" if slower else "is no quicker than"
            said.append(
                f"{mode} padding at its best {took} another mode that is as accurate (at an error of "
                f"{percent(error)})"
            )
        elif np.isfinite(most[mode]):
            least = min(error for _, error in paying.values())
            said.append(
                f"{mode} saves up to a factor of {most[mode]:.2g}, at L = {_join_periods(paying)} a, with errors from "
                f"{percent(least)} on"
            )
        else:
            only = [period for period, best in places.items() if not np.isfinite(best[0])]
            said.append(
                f"{mode} is the only one at the smallest errors at L = {_join_periods(only)} a"
            )
    claim = f"Never worth using: {_join_and(never)}." if never else "Every mode pays somewhere."
    lined = settings(dataset.isel(period=-1), *L1)
    if LINE in paddings(dataset):
        line, others = (lined.where((lined.modes == LINE) == is_line) for is_line in (True, False))
        target = max(float(line.error.min()), float(others.error.min()))
        own, same = line.cheapest(target), others.cheapest(target)
        assert own is not None
        assert same is not None
        said.append(
            "where nothing varies along the length one cell there is "
            f"{float(others.cost[same] / line.cost[own]):.0f} times faster, for an error of {percent(target)}"
        )
    return claim, (
        "Over every n, grid, tolerance and solver, by wall time against the L1 error of the "
        "pressure, corrected or not: " + "; ".join(said) + ". The set-up decides at loose errors, "
        "where a grid is coarse and a solve takes milliseconds: two images are soon summed."
        + " A window centred on the domain needs twice the transform and errs along the length as well."
        * ("superposed" in never)
    )


def recommendation_check(dataset: xr.Dataset) -> tuple[str, str]:
    """The claim about recommendations, and what was measured."""
    found = verify(dataset)
    met, near, lucky = (
        np.mean(values <= limit)
        for values, limit in (
            (found.error, 1.0), (found.slower, 1.3), (found.slower_than_luck, 1.3),
        )
    )  # fmt: skip
    return (
        f"A recommended setting met the error asked for in {percent(met)} of {len(found.error)} cases.",
        "Targets, metrics and periods by turns, the times of each period predicted from those of the "
        f"others. In {percent(near)} of the cases no stored setting whose error could be foreseen to "
        f"meet the target is over 1.3 times faster than the recommended; the worst is "
        f"{float(np.max(found.slower)):.2g}. Counting those that met it because their contact edge "
        f"happened to fall well in its cell, it is {percent(lucky)}, and the median "
        f"{float(np.nanmedian(found.slower_than_luck)):.2g}: that is what certainty costs.",
    )


def _join_periods(periods: Iterable[float]) -> str:
    return ", ".join(f"{period:g}" for period in periods)


def _join_and(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
