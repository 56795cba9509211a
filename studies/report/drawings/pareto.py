"""Drawing of the study `pareto`: figures, findings and tables from its stored data."""

from collections.abc import Iterable
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from studies.advice.settings_table import NOISE, STORED_ERRORS, Settings, pareto_front, settings
from studies.advice.verification import verify
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.reference.line_contact import LINE, covers
from studies.report.style import captioned, padding_style, paddings, panels, percent, select_evenly

KNOWN_AXES = ("padding", "images", "period", "grid", "solver_tolerance", "solver")


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw error against runtime with the front at every period, and what each decade costs."""
    return _fronts(dataset), _decades(dataset)


def _fronts(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values)
    rows = {"pressure_error_l1": "L1 error as solved", "corrected_error_l1": "L1 error, corrected"}
    fig, axes = panels(len(rows) * len(periods), columns=len(periods), height=3.0, share="both")
    for ax, (variable, period) in zip(axes, product(rows, periods), strict=True):
        _front(ax, settings(dataset.sel(period=period), variable))
    for top, bottom, period in zip(axes, axes[len(periods) :], periods, strict=False):
        top.set_title(f"period L = {period:g} a")
        bottom.set_xlabel("wall time, set-up and solve [s]")
    for ax, label in zip(axes[:: len(periods)], rows.values(), strict=True):
        ax.set_ylabel(label)
    return captioned(
        "front",
        fig,
        "Accuracy against wall time on one thread, for every mode, n, grid, tolerance and solver. Filled marks: "
        "preconditioned solver; open marks: Polonsky & Keer. The solid black line is the Pareto front of all "
        "settings; the dashed line is the front of settings with cells along the length, for contacts that vary "
        "there. Grey bars extend to the slowest repeat. “line” is exact periodicity with one cell along a "
        "length on which nothing varies. Points far above the others stopped at a tolerance of 1e-4, before "
        "the contact set was found. In the lower row the edge law removes the discretisation error of the "
        "contact edge, for a few operations per cell; the truncation error of a window remains.",
    )


def _front(ax: Axes, every: Settings) -> None:
    for name in dict.fromkeys(every.modes.tolist()):
        for solver in dict.fromkeys(every.axes["solver"].tolist()):
            marks = (every.modes == name) & (every.axes["solver"] == solver)
            is_hollow = solver == "polonsky_keer"
            face = {"markerfacecolor": "none"} if is_hollow else {"label": name}
            ax.loglog(
                every.cost[marks], every.error[marks], linestyle="none", alpha=0.6, markersize=4,
                **padding_style(name) | face,
            )  # fmt: skip
    for chosen, style, label in (
        (every, "-", "front"),
        (every.where(every.modes != LINE), "--", "front, cells along the length"),
    ):
        best = chosen.where(pareto_front(chosen.cost, chosen.error))
        ax.step(best.cost, best.error, f"k{style}", where="post", label=label, linewidth=0.9)
        bars = np.clip([best.cost - best.spread[0], best.spread[1] - best.cost], 0, None)
        ax.errorbar(
            best.cost, best.error, xerr=bars, fmt="none", ecolor="grey", elinewidth=1.5, alpha=0.6,
            zorder=1,
        )  # fmt: skip


def _decades(dataset: xr.Dataset) -> CaptionedFigure:
    periods = select_evenly(dataset["period"].values)
    period = periods[len(periods) // 2]
    fig, axes = panels(len(STORED_ERRORS), share="y")
    words = []
    for ax, (metric, errors) in zip(axes, STORED_ERRORS.items(), strict=True):
        every = settings(dataset.sel(period=period), *errors)
        targets = 10.0 ** np.arange(-1, np.floor(np.log10(every.error.min())) - 1, -0.02)
        for name in paddings(dataset):
            of_mode = every.where(every.modes == name)
            best = [(target, of_mode.cheapest(target)) for target in targets]
            met = [(target, index) for target, index in best if index is not None]
            if met:
                targets_met, chosen = map(list, zip(*met, strict=True))
                style = padding_style(name) | {"markevery": 25}
                ax.loglog(targets_met, of_mode.cost[chosen], label=name, **style)
                ax.fill_between(
                    targets_met, *of_mode.spread[:, chosen], color=style["color"], alpha=0.2, lw=0
                )
        ax.invert_xaxis()
        ax.set(title=f"of the {metric}", xlabel="requested error")
        least = every.where(np.array([int(np.argmin(every.error))]))
        words.append(f"{metric} {percent(least.error[0])} ({least.name(0)})")
    axes[0].set_ylabel("shortest wall time that reaches it [s]")
    return captioned(
        "decades",
        fig,
        f"Cost of each decade of accuracy by mode, at L = {period:g} a: the cheapest stored setting that "
        "reaches the requested error, corrected or not, with the spread of its "
        "repeats. Errors with a sign may cancel by chance. A line ends where no stored setting "
        "of the mode is more accurate: for a truncated window this is its truncation error, for the others the "
        f"error of the finest grid. Smallest errors: {'; '.join(words)}.",
    )


DECADES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
# Errors of the peak and of the half-width have a sign, so that those of images and cells may cancel.
L1 = STORED_ERRORS["pressure in L1"]


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the paddings that are never the cheapest, and the quality of recommendations."""
    if not covers(dataset, {"duplicated", "superposed", "circular", "exact"}):
        return ()
    modes = Finding(*dominated_modes(dataset), "Paddings that never pay")
    if dataset.sizes["period"] < 3:  # times of one are predicted from those of the others
        return (modes,)
    return modes, Finding(*recommendation_check(dataset), "Recommendations")


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """Return the shortest time in which each mode reaches each decade of the L1 error, at every period."""
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
    """Return the least seconds for each of ``DECADES`` of the L1 error, infinite for none, by mode and period."""
    shortest = {}
    for period in dataset["period"].values:
        every = settings(dataset.sel(period=period), *L1)
        for mode in dict.fromkeys(every.modes.tolist()):
            of_mode = every.where(every.modes == mode)
            best = (of_mode.cheapest(target) for target in DECADES)
            seconds = tuple(
                np.inf if setting is None else float(of_mode.cost[setting]) for setting in best
            )
            if np.isfinite(seconds).any():
                shortest[mode, "any" if mode == LINE else f"{period:g} a"] = seconds
    return shortest


def savings(dataset: xr.Dataset) -> dict[str, dict[float, tuple[float, float]]]:
    """Return the largest saving of each padding at each period, and its L1 error (see ``Settings``).

    Modes with one cell along the length, which are always the cheapest, are left out.
    """
    saved: dict[str, dict[float, tuple[float, float]]] = {}
    for period in dataset["period"].values.tolist():
        every = settings(dataset.sel(period=period), *L1)
        for mode, best in every.where(every.modes != LINE).savings().items():
            saved.setdefault(mode, {})[period] = best
    return saved


def dominated_modes(dataset: xr.Dataset) -> tuple[str, str]:
    """Return the claim about paddings that are never the cheapest, and what was measured."""
    saved = savings(dataset)
    most = {mode: max(best for best, _ in places.values()) for mode, places in saved.items()}
    never = [mode for mode, best in most.items() if best <= NOISE]
    sentences = []
    for mode, places in saved.items():
        paying = {at: best for at, best in places.items() if best[0] > NOISE}
        if mode in never:
            least, error = max(places.values())
            slower = least < 1 / 1.05
            took = f"takes {1 / least:.2g} times as long as" if slower else "is no faster than"
            sentences.append(
                f"{mode} padding, at its best, {took} another mode of the same accuracy (at an error of "
                f"{percent(error)})"
            )
        elif np.isfinite(most[mode]):
            least = min(error for _, error in paying.values())
            sentences.append(
                f"{mode} saves up to a factor of {most[mode]:.2g}, at L = {_join_periods(paying)} a, for errors of "
                f"{percent(least)} and above"
            )
        else:
            only = [period for period, best in places.items() if not np.isfinite(best[0])]
            sentences.append(
                f"{mode} is the only one at the smallest errors at L = {_join_periods(only)} a"
            )
    claim = (
        f"{_join_and(never).capitalize()} padding {'are' if len(never) > 1 else 'is'} never the cheapest."
        if never
        else "Every mode is worth using somewhere."
    )
    lined = settings(dataset.isel(period=-1), *L1)
    if LINE in paddings(dataset):
        line, two_dimensional = (
            lined.where((lined.modes == LINE) == is_line) for is_line in (True, False)
        )
        target = max(float(line.error.min()), float(two_dimensional.error.min()))
        line_setting, other_setting = line.cheapest(target), two_dimensional.cheapest(target)
        assert line_setting is not None
        assert other_setting is not None
        faster = float(two_dimensional.cost[other_setting] / line.cost[line_setting])
        sentences.append(
            f"if nothing varies along the length, one cell along it is {faster:.0f} times faster, for an error of "
            f"{percent(target)}"
        )
    return claim, (
        "Over every n, grid, tolerance and solver, wall time against the L1 error of the "
        "pressure, corrected or not: "
        + "; ".join(sentences)
        + ". At large errors the grid is coarse, a solve takes "
        "milliseconds and the set-up dominates, so a sum of two images is cheap."
        + " A window centred on the domain needs twice the transform and also has an error along the length."
        * ("superposed" in never)
    )


def recommendation_check(dataset: xr.Dataset) -> tuple[str, str]:
    """Return the claim about recommendations, and what was measured."""
    verification = verify(dataset)
    met, near, lucky = (
        np.mean(values <= limit)
        for values, limit in (
            (verification.error, 1.0), (verification.slower, 1.3), (verification.slower_than_luck, 1.3),
        )
    )  # fmt: skip
    return (
        f"A recommended setting met the requested error in {percent(met)} of {len(verification.error)} cases.",
        "For every target, metric and period in turn, the times of one period were predicted from those of the "
        f"others. In {percent(near)} of the cases no stored setting whose estimated error meets the target is "
        f"more than 1.3 times faster than the recommended one; the worst factor is "
        f"{float(np.max(verification.slower)):.2g}. If settings count that met the target only because their contact "
        f"edge fell favourably within its cell, the share is {percent(lucky)} and the median factor "
        f"{float(np.nanmedian(verification.slower_than_luck)):.2g}: this is the price of a reliable estimate.",
    )


def _join_periods(periods: Iterable[float]) -> str:
    """Return periods separated by commas."""
    return ", ".join(f"{period:g}" for period in periods)


def _join_and(names: list[str]) -> str:
    """Return names as a list in a sentence."""
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
