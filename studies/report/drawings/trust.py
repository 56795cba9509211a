"""Drawings of the studies of trust: hard cases, bounds beside true errors."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from studies.definitions.accuracy import KINDS, METRICS
from studies.definitions.stability import VERDICTS
from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.reference.hard_case import SOLVERS
from studies.reference.hard_cases import CASES, GROUPS
from studies.report.style import (
    COLORS,
    LAW_STYLE,
    add_legend,
    padding_style,
    paddings,
    panels,
    percent,
)

# Hard cases


RIGHT, EXPLAINED, WRONG, NOT_APPLICABLE = range(len(VERDICTS))
SOLVER_COLORS = dict(zip(SOLVERS, COLORS, strict=False))
SMALLEST_ERROR = 1e-17  # where an error of zero is drawn
MOST_NAMES = 10  # of cases in a list


def _groups(dataset: xr.Dataset) -> dict[str, xr.Dataset]:
    """Return the cases of each group, in the order of the groups."""
    names = [str(name) for name in dataset["case"].values]
    members = {
        group: [name for name in names if name in CASES and CASES[name].group == group]
        for group in GROUPS
    }
    return {group: dataset.sel(case=cases) for group, cases in members.items() if cases}


def _count(dataset: xr.Dataset, verdict: int) -> int:
    return int((dataset["verdict"] == verdict).sum())


def _stability_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    groups = _groups(dataset)
    fig, (ax,) = panels(1, width=8.5, height=1.2 + 0.3 * len(groups))
    for row, cases in enumerate(groups.values()):
        right = cases["verdict"] == RIGHT
        for number, solver in enumerate(map(str, dataset["solver"].values)):
            errors = cases["pressure_error"].where(right).sel(solver=solver).values.ravel()
            ax.plot(
                np.maximum(errors, SMALLEST_ERROR), np.full(errors.size, row + 0.15 * (2 * number - 1)), ".",
                ms=4, color=SOLVER_COLORS[solver], label=f"error, {solver}",
            )  # fmt: skip
        stated = float(cases["stated_error"].where(right).max())
        ax.plot([stated], [row], "|", ms=14, color="black", label="largest error stated")
    ax.set_xscale("log")
    ax.set_yticks(range(len(groups)), list(groups))
    ax.set(ylim=(len(groups) - 0.5, -0.5), xlabel="largest pressure error / peak pressure")
    add_legend(fig)
    return (
        CaptionedFigure(
            "stability",
            fig,
            "Errors of hard cases by what is hard about them. The reference answer comes from a dense matrix, built "
            "pair by pair without transforms, whose contact sets are found by pivoting, or from an equivalent "
            "form of the same contact (other units, shifted, mirrored, over two periods). The stated error is the "
            "remaining violation of the contact conditions times the largest compliance of a wave in "
            "the contact. Errors of exactly zero are drawn at the left end.",
        ),
    )


def _stability_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    if dataset.sizes["case"] != len(CASES):
        return ()
    share = (dataset["pressure_error"] / dataset["stated_error"]).where(dataset["verdict"] == RIGHT)
    claim = "Hard cases end with an error within the stated one, or with a status that explains why there is no answer."
    n_wrong, where = _count(dataset, WRONG), ""
    if n_wrong:
        claim = "Some hard cases end neither within the stated error nor with a status that explains why."
        is_wrong = (dataset["verdict"] == WRONG).any(("padding", "solver"))
        names = [str(name) for name in dataset["case"].values[is_wrong.values]]
        where = f" ({', '.join(names[:MOST_NAMES])}{', ...' * (len(names) > MOST_NAMES)})"
    return (
        Finding(
            claim,
            f"{dataset.sizes['case']} difficult contacts were solved with {dataset.sizes['padding']} paddings and "
            f"{dataset.sizes['solver']} solvers, where the combination applies: {_count(dataset, RIGHT)} solves have an "
            f"error within the one stated for them, {_count(dataset, EXPLAINED)} end with a status that explains why "
            f"there is no answer, and {n_wrong} do neither{where}. The median error is {percent(share.median())} of the "
            f"stated error, the largest {percent(share.max())}.",
            "Is it stable?",
        ),
    )


def _stability_tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    rows = []
    for group, cases in _groups(dataset).items():
        right = cases["verdict"] == RIGHT
        error, stated = (
            f"{float(cases[which].where(right).max()):.0e}" if right.any() else "none"
            for which in ("pressure_error", "stated_error")
        )
        counts = (_count(cases, verdict) for verdict in (RIGHT, EXPLAINED, WRONG))
        rows.append((group, str(cases.sizes["case"]), *map(str, counts), error, stated))
    return (
        Table(
            "Hard cases by what is hard about them, over all paddings and both solvers: solves with an error within the "
            "stated one, with a status that explains why there is no answer, and with neither; the largest error of the "
            "pressure over its maximum, and the largest stated error.",
            (
                "difficulty",
                "cases",
                "within stated",
                "explained",
                "neither",
                "largest error",
                "largest stated",
            ),
            tuple(rows),
        ),
    )


stability = Drawing(
    _stability_figures, _stability_findings, _stability_tables, ("case", "padding", "solver")
)


# accuracy


LABELS = {
    "l1": "pressure in L1",
    "peak_pressure": "peak pressure",
    "contact_area": "contact area",
    "mean_gap": "mean gap",
}
# Those that the promise is about; the mean gap's bound is meant to hold, not to be narrow.
PROMISED = ("l1", "peak_pressure", "contact_area")
SMALLEST = 1e-7  # where errors of nothing are drawn


def _accuracy_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw bounds against true errors, a panel for each quantity and a colour for each kind of surface."""
    fig, axes = panels(len(PROMISED), columns=3, width=3.6, height=3.6)
    kinds = dataset["kind"].values.astype(int)
    for ax, metric in zip(axes, PROMISED, strict=True):
        error, bound = _pairs(dataset, metric)
        for kind in np.unique(kinds):
            marks = (kinds == kind) & np.isfinite(bound) & np.isfinite(error)
            ax.loglog(
                np.maximum(error[marks], SMALLEST), np.maximum(bound[marks], SMALLEST), ls="none", ms=4,
                color=f"C{kind % 10}", marker="ox^sv"[kind // 10 % 5], alpha=0.7, label=KINDS[kind],
            )  # fmt: skip
        span = np.array([SMALLEST, 2.0])
        ax.loglog(span, span, label="bound = error", **LAW_STYLE)
        ax.set(title=LABELS[metric], xlabel="true relative error", ylabel="bound")
    add_legend(fig)
    return (CaptionedFigure("accuracy", fig, _accuracy_caption(dataset)),)


def _accuracy_caption(dataset: xr.Dataset) -> str:
    missing = int((~np.isfinite(dataset["peak_pressure_bound"])).sum())
    return (
        f"Bounds beside true errors of {dataset.sizes['case']} contacts. The truth is a closed form or a grid 4 to 200 "
        "times finer; pressures are compared as cell means. Marks on or above the line are bounded. Not drawn are "
        f"infinite bounds ({missing} of the peak pressure), which come with a reason."
    )


def _accuracy_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the share of bounds that hold, on every kind of surface."""
    parts, lowest = [], 1.0
    for metric in PROMISED:
        share, median, missing = _summary(*_pairs(dataset, metric))
        lowest = min(lowest, share)
        parts.append(
            f"{LABELS[metric]}: {100 * share:.1f} % bounded, in the median {median:.2g} times too large, "
            f"{missing} without a bound"
        )
    silent = int(dataset["silent"].sum())
    return (
        Finding(
            f"The error bound holds in {100 * lowest:.1f} % of {dataset.sizes['case']} contacts of every kind, or says "
            "why there is none.",
            f"{'; '.join(parts)}. {silent} bounds are missing without a reason. A bound is missing where "
            "the pressure at a sharp edge is infinite, and where the grid does not show the surface.",
            "How far to trust an answer?",
        ),
    )


def _accuracy_tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """Return bounds by kind of surface, and the worst errors beyond their bound."""
    kinds = dataset["kind"].values.astype(int)
    rows, misses = [], []
    for kind in np.unique(kinds):
        row = [KINDS[kind], str(int((kinds == kind).sum()))]
        for metric in PROMISED:
            error, bound = _pairs(dataset, metric)
            share, median, missing = _summary(error[kinds == kind], bound[kinds == kind])
            row += [f"{100 * share:.1f} %", f"{median:.2g}", str(missing)]
        rows.append(tuple(row))
    for metric in METRICS:
        error, bound = _pairs(dataset, metric)
        misses += [
            (
                true / limit if limit else np.inf,
                (str(name), LABELS[metric], f"{true:.2g}", f"{limit:.2g}"),
            )
            for name, true, limit in zip(dataset["case"].values, error, bound, strict=True)
            if limit < true
        ]
    misses.sort(key=lambda miss: -miss[0])
    heads = [
        f"{LABELS[metric]}: {what}"
        for metric in PROMISED
        for what in ("bounded", "median ratio", "no bound")
    ]
    return (
        Table(
            "Bounds by kind of surface: the share of cases whose bound is no smaller than the error, how many times "
            "larger it is in the median where it is finite, and how many cases have no bound and say why.",
            ("surface", "cases", *heads),
            tuple(rows),
        ),
        Table(
            f"Errors larger than their bound: the worst of {len(misses)}.",
            ("case", "quantity", "true error", "bound"),
            tuple(row for _, row in misses[:MOST_NAMES]),
        ),
    )


def _pairs(dataset: xr.Dataset, metric: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the true errors, nan where they are not known, and the bounds."""
    error = dataset[f"{metric}_error"].values.astype(float)
    return np.where(error < 0, np.nan, error), dataset[f"{metric}_bound"].values.astype(float)


def _summary(error: np.ndarray, bound: np.ndarray) -> tuple[float, float, int]:
    """Return the share that is bounded, the median of bound over error, and how many have no bound."""
    is_known = ~np.isnan(error)
    error, bound = error[is_known], bound[is_known]
    finite = np.isfinite(bound) & (error > 0)
    share = float((bound >= error).mean()) if error.size else 1.0
    median = float(np.median(bound[finite] / error[finite])) if finite.any() else np.inf
    return share, median, int((~np.isfinite(bound)).sum())


accuracy = Drawing(_accuracy_figures, _accuracy_findings, _accuracy_tables, axes=("case",))


# Error estimates of all sweeps

# estimate, error, and the name of what both are of
ESTIMATES = {
    "peak_pressure_estimate": ("peak_pressure_error", "peak pressure"),
    "pressure_l1_estimate": ("pressure_error_l1", "pressure in L1"),
}
CAUSES = "truncation", "discretisation", "residual"
LARGE = 5  # times the true error: limit for the median estimate


def sweeps_with_estimates(stored: Mapping[str, xr.Dataset]) -> Mapping[str, xr.Dataset]:
    """Return the sweeps that hold both an estimate and a true error, by name."""
    needed = {"padding"} | set(ESTIMATES) | {error for error, _ in ESTIMATES.values()}
    return {name: dataset for name, dataset in stored.items() if needed <= set(dataset.variables)}


def estimated_cases(stored: Mapping[str, xr.Dataset], estimate: str) -> xr.Dataset:
    """Return every distinct case as a flat list of ``error``, ``estimate``, its parts and ``padding``."""
    error, _ = ESTIMATES[estimate]
    parts = [f"{estimate}_{cause}" for cause in CAUSES]
    rows: dict[tuple[object, ...], None] = {}  # a set that keeps its order
    for dataset in stored.values():
        for name in paddings(dataset):
            part = dataset.sel(padding=name)
            columns = [part[variable].values.ravel() for variable in (error, estimate, *parts)]
            rows.update({(name, *map(float, row)): None for row in zip(*columns, strict=True)})
    names, numbers = [row[0] for row in rows], np.array([row[1:] for row in rows], dtype=float)
    numbers = np.abs(numbers)  # an error has a sign
    is_complete = np.isfinite(numbers).all(axis=1) & (numbers[:, 0] > 0)
    labels = ("error", "estimate", *CAUSES)
    flat = {
        label: ("case", column[is_complete])
        for label, column in zip(labels, numbers.T, strict=True)
    }
    return xr.Dataset(flat | {"padding": ("case", np.array(names)[is_complete])})


def estimates_figure(stored: Mapping[str, xr.Dataset]) -> CaptionedFigure:
    """Draw estimates against true errors, a panel for each metric."""
    fig, axes = panels(len(ESTIMATES), width=4.4, height=3.8)
    for ax, (estimate, (_, label)) in zip(axes, ESTIMATES.items(), strict=True):
        flat = estimated_cases(stored, estimate)
        for name in dict.fromkeys(flat["padding"].values.tolist()):
            of_padding = flat.where(flat["padding"] == name, drop=True)
            style = padding_style(name) | {"linestyle": "none", "alpha": 0.6, "markersize": 4}
            ax.loglog(of_padding["error"], of_padding["estimate"], label=name, **style)
        span = np.array([flat["error"].min(), flat["error"].max()])
        ax.loglog(span, span, label="estimate = error", **LAW_STYLE | {"linestyle": "-"})
        ax.loglog(span, LARGE * span, label=f"{LARGE} times the error", **LAW_STYLE)
        ax.set(title=label, xlabel="true relative error", ylabel="estimated relative error")
    add_legend(fig)
    return CaptionedFigure(
        "estimates",
        fig,
        "Estimated error against true error (from Hertz) for every distinct case of the sweeps. At marks on "
        "or above the line the estimate bounds the error. Marks far above the line are cases in which two "
        "errors happen to cancel; no estimate can predict this.",
    )


def estimates_table(stored: Mapping[str, xr.Dataset]) -> Table:
    """Return the share of estimates that bound their error, their ratio to it, and their causes."""
    rows = []
    for estimate, (_, label) in ESTIMATES.items():
        flat = estimated_cases(stored, estimate)
        for name in dict.fromkeys(flat["padding"].values.tolist()):
            of_padding = flat.where(flat["padding"] == name, drop=True)
            ratio = of_padding["estimate"] / of_padding["error"]
            shares = [
                float((of_padding[cause] / of_padding["estimate"]).median()) for cause in CAUSES
            ]
            rows.append(
                (
                    label,
                    name,
                    str(of_padding.sizes["case"]),
                    f"{100 * float((ratio >= 1).mean()):.0f} %",
                    f"{float(ratio.median()):.2g}",
                    f"{float(ratio.quantile(0.9)):.2g}",
                    *(f"{100 * share:.0f} %" for share in shares),
                )
            )
    return Table(
        "Error estimates compared with true errors: the share of cases in which the estimate bounds the error, "
        "the median and the 90 % quantile of estimate over error, and the causes of the estimate.",
        (
            "error of the", "padding", "cases", "bounded", "median ratio", "90 % below",
            *(f"share of {cause}" for cause in CAUSES),
        ),
        tuple(rows),
    )  # fmt: skip


def estimates_finding(stored: Mapping[str, xr.Dataset]) -> Finding:
    """Return the share of estimates that bound their error."""
    flats = [estimated_cases(stored, estimate) for estimate in ESTIMATES]
    ratios = [flat["estimate"] / flat["error"] for flat in flats]
    bounded = [float((ratio >= 1).mean()) for ratio in ratios]
    facts = " and ".join(
        f"{label} by a factor of {float(ratio.median()):.2g}"
        for (_, label), ratio in zip(ESTIMATES.values(), ratios, strict=True)
    )
    return Finding(
        f"The error estimate bounds the true error in {100 * min(bounded):.0f} % of "
        f"{max(ratio.sizes['case'] for ratio in ratios)} cases.",
        f"Its median exceeds the error of the {facts}. It is computed from the solution alone and split by "
        "cause: truncation, discretisation and residual.",
        "How reliable is an error estimate?",
    )
