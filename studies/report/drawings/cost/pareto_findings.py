"""Findings of the study `pareto`: which modes are worth using, and the cost of each decade of accuracy."""

from collections.abc import Iterable

import numpy as np
import xarray as xr

from studies.advice.settings_table import NOISE, STORED_ERRORS, settings
from studies.advice.verification import verify
from studies.model.drawing import Finding, Table
from studies.reference.line_contact import LINE, covers
from studies.report.formatting import paddings, percent

DECADES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
# A peak's or a half-width's error has a sign: that of the images may by chance undo that of the cells.
L1 = STORED_ERRORS["pressure in L1"]


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Which modes are never worth using, and how good the recommendations are."""
    if not covers(dataset, {"duplicated", "superposed", "circular", "exact"}):
        return ()
    return (
        Finding(*dominated_modes(dataset), "Which paddings are never worth using?"),
        Finding(*recommendation_check(dataset), "How reliable is a recommendation?"),
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """The shortest time in which each mode reaches each decade of the L1 error, at every period."""
    rows = []
    for (mode, period), seconds in decades(dataset).items():
        times = (f"{second:.2g}" if np.isfinite(second) else "none" for second in seconds)
        rows.append((mode, period, *times))
    table = Table(
        "Cost of each decade: the shortest time [s] on one thread in which each mode reaches an L1 error of the "
        "pressure, with or without edge correction, over all n, grids, tolerances and solvers of the study. "
        "“line” is exact periodicity with one cell along a length on which nothing varies.",
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
            took = f"takes {1 / least:.2g} times as long as" if slower else "is no faster than"
            said.append(
                f"{mode} padding, at its best, {took} another mode of the same accuracy (at an error of "
                f"{percent(error)})"
            )
        elif np.isfinite(most[mode]):
            least = min(error for _, error in paying.values())
            said.append(
                f"{mode} saves up to a factor of {most[mode]:.2g}, at L = {_join_periods(paying)} a, for errors of "
                f"{percent(least)} and above"
            )
        else:
            only = [period for period, best in places.items() if not np.isfinite(best[0])]
            said.append(
                f"{mode} is the only one at the smallest errors at L = {_join_periods(only)} a"
            )
    claim = (
        f"Never worth using: {_join_and(never)}."
        if never
        else "Every mode is worth using somewhere."
    )
    lined = settings(dataset.isel(period=-1), *L1)
    if LINE in paddings(dataset):
        line, others = (lined.where((lined.modes == LINE) == is_line) for is_line in (True, False))
        target = max(float(line.error.min()), float(others.error.min()))
        own, same = line.cheapest(target), others.cheapest(target)
        assert own is not None
        assert same is not None
        said.append(
            "if nothing varies along the length, one cell along it is "
            f"{float(others.cost[same] / line.cost[own]):.0f} times faster, for an error of {percent(target)}"
        )
    return claim, (
        "Over every n, grid, tolerance and solver, wall time against the L1 error of the "
        "pressure, corrected or not: "
        + "; ".join(said)
        + ". At large errors the grid is coarse, a solve takes "
        "milliseconds and the set-up dominates, so a sum of two images is cheap."
        + " A window centred on the domain needs twice the transform and also errs along the length."
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
        f"A recommended setting met the requested error in {percent(met)} of {len(found.error)} cases.",
        "For every target, metric and period in turn, the times of one period were predicted from those of the "
        f"others. In {percent(near)} of the cases no stored setting whose estimated error meets the target is "
        f"more than 1.3 times faster than the recommended one; the worst factor is "
        f"{float(np.max(found.slower)):.2g}. If settings count that met the target only because their contact "
        f"edge fell favourably within its cell, the share is {percent(lucky)} and the median factor "
        f"{float(np.nanmedian(found.slower_than_luck)):.2g}: this is the price of a reliable estimate.",
    )


def _join_periods(periods: Iterable[float]) -> str:
    return ", ".join(f"{period:g}" for period in periods)


def _join_and(names: list[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
