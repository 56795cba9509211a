"""Drawings of the studies of trust: hard cases, bounds beside true errors."""

from itertools import product

import numpy as np
import xarray as xr

from studies.definitions.accuracy import KINDS, METRICS, USES
from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
from studies.reference.hard_case import Verdict
from studies.reference.hard_cases import CASES
from studies.report.style import LAW_STYLE, captioned, panels, percent

# Hard cases


RIGHT, EXPLAINED, WRONG = (
    verdict.value
    for verdict in (Verdict.WITHIN_STATED_ERROR, Verdict.EXPLAINED_BY_STATUS, Verdict.WRONG)
)
MAX_NAMES = 10  # of cases in a list


def _count(dataset: xr.Dataset, verdict: int) -> int:
    """Return the number of solves with a verdict."""
    return int((dataset["verdict"] == verdict).sum())


def _stability_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    if dataset.sizes["case"] != len(CASES):
        return ()
    fraction = dataset["pressure_error_l1"] / dataset["stated_error"]
    fraction = fraction.where((dataset["verdict"] == RIGHT) & (dataset["stated_error"] > 0))
    claim = "Hard cases end with an error within the stated one, or with a status that explains why there is no answer."
    n_wrong, where = _count(dataset, WRONG), ""
    if n_wrong:
        claim = "Some hard cases end neither within the stated error nor with a status that explains why."
        is_wrong = (dataset["verdict"] == WRONG).any(("padding", "solver"))
        names = [str(name) for name in dataset["case"].values[is_wrong.values]]
        where = f" ({', '.join(names[:MAX_NAMES])}{', ...' * (len(names) > MAX_NAMES)})"
    return (
        Finding(
            claim,
            f"{dataset.sizes['case']} difficult contacts were solved with {dataset.sizes['padding']} paddings and "
            f"{dataset.sizes['solver']} solvers, where the combination applies: {_count(dataset, RIGHT)} solves have "
            f"an error within the one that the program states for its residual, {_count(dataset, EXPLAINED)} end with "
            f"a status that explains why there is no answer, and {n_wrong} do neither{where}. The median error is "
            f"{percent(fraction.median())} of the stated error. The references are dense matrices, built pair by pair "
            "without transforms and solved directly; the coefficients of a cell are the program's own, but for one "
            "case in plane strain.",
            "Is it stable?",
        ),
    )


def _stability_tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    rows = []
    for name in dataset["case"].values:
        case = dataset.sel(case=name)
        right = case.where(case["verdict"] == RIGHT)
        largest = (float(right[part].max()) for part in ("pressure_error_l1", "stated_error"))
        errors = (f"{error:.0e}" if np.isfinite(error) else "none" for error in largest)
        counts = (_count(case, verdict) for verdict in (RIGHT, EXPLAINED, WRONG))
        rows.append((str(name), *map(str, counts), *errors))
    return (
        Table(
            "Hard cases, over all paddings and both solvers: solves with an error within the stated one, with a status "
            "that explains why there is no answer, and with neither; largest and largest stated error of the pressure "
            "in L1. An error by rounding alone may be above a stated one of nearly zero.",
            ("hard case", "within stated", "explained", "neither", "largest error", "largest stated"),
            tuple(rows),
        ),
    )  # fmt: skip


stability = Drawing(lambda dataset: (), _stability_findings, _stability_tables)


# accuracy


LABELS = {
    "l1": "pressure in L1",
    "peak_pressure": "peak pressure",
    "contact_area": "contact area",
    "mean_gap": "mean gap",
}
# Quantities with a narrow bound; the bound of the mean gap holds, but may be wide.
TIGHTLY_BOUNDED = ("l1", "peak_pressure", "contact_area")
SMALLEST = 1e-7  # where errors of zero are drawn


def _accuracy_figures(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw bounds against true errors, a panel for each quantity and a colour for each kind of surface."""
    dataset = _one_axis(dataset)
    fig, axes = panels(len(TIGHTLY_BOUNDED), columns=3, width=3.6, height=3.6)
    kinds = dataset["kind"].values.astype(int)
    for ax, metric in zip(axes, TIGHTLY_BOUNDED, strict=True):
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
    missing = int((~np.isfinite(dataset["peak_pressure_bound"])).sum())
    caption = (
        f"Bounds beside true errors of {dataset.sizes['case']} contacts. The truth is a closed form or a grid 3 to 200 "
        "times finer; pressures are compared as cell means. Marks on or above the line are bounded. Not drawn are "
        f"infinite bounds ({missing} of the peak pressure)."
    )
    return (captioned("accuracy", fig, caption),)


def _accuracy_findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return the fraction of bounds that hold, on every kind of surface on which no margin is set."""
    dataset, by_use = _one_axis(dataset), []
    for number, use in enumerate(USES):
        chosen = dataset.isel(case=dataset["use"].values == number)
        if chosen.sizes["case"]:
            fractions = [_summary(*_pairs(chosen, metric))[0] for metric in TIGHTLY_BOUNDED]
            fractions_text = " / ".join(map(_fraction_text, fractions))
            by_use.append(f"{fractions_text} of {chosen.sizes['case']} contacts ({use})")
    dataset = dataset.isel(case=dataset["use"].values != USES.index("calibration"))
    parts, lowest = [], np.nan
    for metric in TIGHTLY_BOUNDED:
        fraction, median, missing = _summary(*_pairs(dataset, metric))
        lowest = float(np.fmin(lowest, fraction))
        parts.append(
            f"{LABELS[metric]}: {_fraction_text(fraction)} bounded, in the median {median:.2g} times too large, "
            f"{missing} without a bound"
        )
    without_reason = int(dataset["missing_without_reason"].sum())
    return (
        Finding(
            f"Of the error bounds of {dataset.sizes['case']} contacts of every kind, on which no margin is set, "
            f"{_fraction_text(lowest)} hold where there is one.",
            f"{'; '.join(parts)}. By use of the contacts: {'; '.join(by_use)}. {without_reason} bounds are missing "
            "without a reason. A bound is missing where "
            "the pressure at a sharp edge is infinite, and where the grid does not show the surface.",
            "How far to trust an answer?",
        ),
    )


def _accuracy_tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """Return bounds by kind of surface, and the worst errors beyond their bound."""
    dataset = _one_axis(dataset)
    kinds = dataset["kind"].values.astype(int)
    rows, misses = [], []
    for kind in np.unique(kinds):
        row = [KINDS[kind], str(int((kinds == kind).sum()))]
        for metric in TIGHTLY_BOUNDED:
            error, bound = _pairs(dataset, metric)
            fraction, median, missing = _summary(error[kinds == kind], bound[kinds == kind])
            ratio = f"{median:.2g}" if np.isfinite(median) else "none"
            row += [_fraction_text(fraction), ratio, str(missing)]
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
    columns = product(TIGHTLY_BOUNDED, ("bounded", "median ratio", "no bound"))
    heads = [f"{LABELS[metric]}: {what}" for metric, what in columns]
    return (
        Table(
            "Bounds by kind of surface: the fraction of finite bounds that are no smaller than the error, how many "
            "times larger they are in the median, and how many cases have no bound.",
            ("surface", "cases", *heads),
            tuple(rows),
        ),
        Table(
            f"Errors larger than their bound: the worst of {len(misses)}.",
            ("case", "quantity", "true error", "bound"),
            tuple(row for _, row in misses[:MAX_NAMES]),
        ),
    )


def _one_axis(dataset: xr.Dataset) -> xr.Dataset:
    """Return the contacts along one axis: those of the matrix are the same for all seeds."""
    if "seed" not in dataset.dims:
        return dataset
    parts = [dataset.isel(seed=0, drop=True)]
    for seed in range(1, dataset.sizes["seed"]):
        of_seed = dataset.isel(seed=seed, drop=True)
        parts.append(of_seed.isel(case=of_seed["use"].values == USES.index("random")))
    return xr.concat(parts, "case")


def _pairs(dataset: xr.Dataset, metric: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the true errors, nan where they are not known, and the bounds."""
    bound = dataset[f"{metric}_bound"]
    error = dataset.get(f"{metric}_error", xr.full_like(bound, np.nan))
    return error.values, bound.values


def _summary(error: np.ndarray, bound: np.ndarray) -> tuple[float, float, int]:
    """Return the fraction of finite bounds that hold, their median over the error, and how many bounds are missing.

    The errors are those that are known; without a finite bound the fraction is nan and the median infinite.
    """
    is_known = ~np.isnan(error)
    error, bound = error[is_known], bound[is_known]
    finite = np.isfinite(bound)
    fraction = float((bound >= error)[finite].mean()) if finite.any() else np.nan
    ratios = bound[finite & (error > 0)] / error[finite & (error > 0)]
    median = float(np.median(ratios)) if ratios.size else np.inf
    return fraction, median, int((~finite).sum())


def _fraction_text(fraction: float) -> str:
    """Return a fraction in per cent; "none" for nan."""
    return "none" if np.isnan(fraction) else f"{100 * fraction:.1f} %"


accuracy = Drawing(_accuracy_figures, _accuracy_findings, _accuracy_tables)
