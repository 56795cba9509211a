"""How the stored error estimates compare with the true errors."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.report.formatting import paddings
from studies.report.style import LAW_STYLE, add_legend, padding_style, panels

# estimate, error, and the name of what both are of
ESTIMATES = {
    "peak_pressure_estimate": ("peak_pressure_error", "peak pressure"),
    "pressure_l1_estimate": ("pressure_error_l1", "pressure in L1"),
}
CAUSES = "truncation", "discretisation", "residual"
LARGE = 5  # times the true error: limit for the median estimate


def sweeps_with_estimates(stored: Mapping[str, xr.Dataset]) -> Mapping[str, xr.Dataset]:
    """The sweeps that hold both an estimate and a true error, by name."""
    wanted = {"padding"} | set(ESTIMATES) | {error for error, _ in ESTIMATES.values()}
    return {name: dataset for name, dataset in stored.items() if wanted <= set(dataset.variables)}


def cases(stored: Mapping[str, xr.Dataset], estimate: str) -> xr.Dataset:
    """Every distinct case as a flat list of ``error``, ``estimate``, its parts and ``padding``."""
    error, _ = ESTIMATES[estimate]
    parts = [f"{estimate}_{cause}" for cause in CAUSES]
    rows: dict[tuple[object, ...], None] = {}  # a set that keeps its order
    for dataset in stored.values():
        for name in paddings(dataset):
            one = dataset.sel(padding=name)
            columns = [one[variable].values.ravel() for variable in (error, estimate, *parts)]
            rows.update({(name, *map(float, row)): None for row in zip(*columns, strict=True)})
    names, numbers = [row[0] for row in rows], np.array([row[1:] for row in rows], dtype=float)
    numbers = np.abs(numbers)  # an error has a sign
    there = np.isfinite(numbers).all(axis=1) & (numbers[:, 0] > 0)
    labels = ("error", "estimate", *CAUSES)
    flat = {label: ("case", column[there]) for label, column in zip(labels, numbers.T, strict=True)}
    return xr.Dataset(flat | {"padding": ("case", np.array(names)[there])})


def figure(stored: Mapping[str, xr.Dataset]) -> CaptionedFigure:
    """Estimate against true error, a panel for each metric."""
    fig, axes = panels(len(ESTIMATES), width=4.4, height=3.8)
    for ax, (estimate, (_, label)) in zip(axes, ESTIMATES.items(), strict=True):
        flat = cases(stored, estimate)
        for name in dict.fromkeys(flat["padding"].values.tolist()):
            own = flat.where(flat["padding"] == name, drop=True)
            style = padding_style(name) | {"linestyle": "none", "alpha": 0.6, "markersize": 4}
            ax.loglog(own["error"], own["estimate"], label=name, **style)
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


def table(stored: Mapping[str, xr.Dataset]) -> Table:
    """How often an estimate bounds its error, how large it is beside it, and what it is made of."""
    rows = []
    for estimate, (_, label) in ESTIMATES.items():
        flat = cases(stored, estimate)
        for name in dict.fromkeys(flat["padding"].values.tolist()):
            own = flat.where(flat["padding"] == name, drop=True)
            ratio = own["estimate"] / own["error"]
            shares = [float((own[cause] / own["estimate"]).median()) for cause in CAUSES]
            rows.append(
                (
                    label,
                    name,
                    str(own.sizes["case"]),
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


def finding(stored: Mapping[str, xr.Dataset]) -> Finding:
    """How far the estimates can be trusted."""
    flats = [cases(stored, estimate) for estimate in ESTIMATES]
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
