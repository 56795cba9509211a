"""Drawing of the study `accuracy`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

from studies.definitions.accuracy import KINDS, METRICS
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.report.style import LAW_STYLE, add_legend, panels

LABELS = {
    "l1": "pressure in L1",
    "peak_pressure": "peak pressure",
    "contact_area": "contact area",
    "mean_gap": "mean gap",
}
# Those that the promise is about; the mean gap's bound is meant to hold, not to be narrow.
PROMISED = ("l1", "peak_pressure", "contact_area")
SMALLEST = 1e-7  # where errors of nothing are drawn


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Bound against true error, a panel for each quantity and a colour for each kind of surface."""
    fig, axes = panels(len(PROMISED), columns=3, width=3.6, height=3.6)
    kinds = dataset["kind"].values.astype(int)
    for ax, metric in zip(axes, PROMISED, strict=True):
        error, bound = _pairs(dataset, metric)
        for kind in np.unique(kinds):
            own = (kinds == kind) & np.isfinite(bound) & np.isfinite(error)
            ax.loglog(
                np.maximum(error[own], SMALLEST), np.maximum(bound[own], SMALLEST), ls="none", ms=4,
                color=f"C{kind % 10}", marker="ox^sv"[kind // 10 % 5], alpha=0.7, label=KINDS[kind],
            )  # fmt: skip
        span = np.array([SMALLEST, 2.0])
        ax.loglog(span, span, label="bound = error", **LAW_STYLE)
        ax.set(title=LABELS[metric], xlabel="true relative error", ylabel="bound")
    add_legend(fig)
    return (CaptionedFigure("accuracy", fig, _caption(dataset)),)


def _caption(dataset: xr.Dataset) -> str:
    missing = int((~np.isfinite(dataset["peak_pressure_bound"])).sum())
    return (
        f"Bounds beside true errors of {dataset.sizes['case']} contacts. The truth is a closed form or a grid 4 to 200 "
        "times finer; pressures are compared as cell means. Marks on or above the line are bounded. Not drawn are "
        f"infinite bounds ({missing} of the peak pressure), which come with a reason."
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """How far an answer can be trusted, on every kind of surface."""
    parts, lowest = [], 1.0
    for metric in PROMISED:
        held, median, missing = _summary(*_pairs(dataset, metric))
        lowest = min(lowest, held)
        parts.append(
            f"{LABELS[metric]}: {100 * held:.1f} % bounded, in the median {median:.2g} times too large, "
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


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """By kind of surface, and every miss."""
    kinds = dataset["kind"].values.astype(int)
    rows, misses = [], []
    for kind in np.unique(kinds):
        row = [KINDS[kind], str(int((kinds == kind).sum()))]
        for metric in PROMISED:
            error, bound = _pairs(dataset, metric)
            held, median, missing = _summary(error[kinds == kind], bound[kinds == kind])
            row += [f"{100 * held:.1f} %", f"{median:.2g}", str(missing)]
        rows.append(tuple(row))
    for metric in METRICS:
        error, bound = _pairs(dataset, metric)
        misses += [
            (str(name), LABELS[metric], f"{true:.2g}", f"{said:.2g}")
            for name, true, said in zip(dataset["case"].values, error, bound, strict=True)
            if said < true
        ]
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
            "Every case whose error is larger than its bound.",
            ("case", "quantity", "true error", "bound"),
            tuple(misses),
        ),
    )


def _pairs(dataset: xr.Dataset, metric: str) -> tuple[np.ndarray, np.ndarray]:
    """True errors, nan where they are not known, and bounds."""
    error = dataset[f"{metric}_error"].values.astype(float)
    return np.where(error < 0, np.nan, error), dataset[f"{metric}_bound"].values.astype(float)


def _summary(error: np.ndarray, bound: np.ndarray) -> tuple[float, float, int]:
    """The share that is bounded, the median of bound over error, and how many have no bound."""
    known = ~np.isnan(error)
    error, bound = error[known], bound[known]
    finite = np.isfinite(bound) & (error > 0)
    held = float((bound >= error).mean()) if error.size else 1.0
    median = float(np.median(bound[finite] / error[finite])) if finite.any() else np.inf
    return held, median, int((~np.isfinite(bound)).sum())
