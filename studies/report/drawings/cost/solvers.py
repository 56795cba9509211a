"""Drawing of the study `solvers`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

from studies.definitions.cost.solvers import SOLVERS
from studies.model.drawing import CaptionedFigure, Finding
from studies.model.outcome import CaseStatus
from studies.report.formatting import power
from studies.report.style import LAW_STYLE, add_legend, panels

TITLES = {"preconditioned_cg": "preconditioned CG", "polonsky_keer": "Polonsky & Keer"}
COLORS = {"preconditioned_cg": "#0072B2", "polonsky_keer": "#D55E00"}
LINES = {"smooth": "-", "wavy": "--", "rough": ":"}


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Time, iterations and convolutions against the grid, with the growth of each fitted."""
    cells = dataset["grid"].values
    fig, axes = panels(3)
    labels = {
        "solve_time": "wall time to solve [s]",
        "iterations": "iterations",
        "convolutions": "transform pairs of the full grid",
    }
    for ax, (variable, label) in zip(axes, labels.items(), strict=True):
        for solver in (str(name) for name in dataset["solver"].values):
            for surface in (str(name) for name in dataset["surface"].values):
                line = dataset[variable].sel(solver=solver, surface=surface)
                style = {"color": COLORS[solver], "linestyle": LINES[surface], "marker": "o"}
                ax.loglog(cells, line, label=f"{TITLES[solver]}, {surface}", **style)
        if variable == "solve_time":
            least = float(dataset[variable].isel(grid=0).min())
            ax.loglog(cells, least * (cells / cells[0]) ** 2, label="N²", **LAW_STYLE)
        ax.set(xlabel="cells N across and along", ylabel=label)
        ax.set_xticks(cells, [str(n) for n in cells])
        ax.minorticks_off()
    add_legend(fig)
    return (CaptionedFigure("solvers", fig, _caption(dataset)),)


def _caption(dataset: xr.Dataset) -> str:
    facts = []
    finest = dataset.isel(grid=-1)
    for solver in (str(name) for name in dataset["solver"].values):
        one = finest.sel(solver=solver)
        growth = ""
        if dataset.sizes["grid"] > 1:
            times = dataset["solve_time"].sel(solver=solver)
            rates = [
                np.polyfit(np.log(dataset["grid"].values), np.log(times.sel(surface=s).values), 1)[
                    0
                ]
                for s in dataset["surface"].values
            ]
            growth = f", growing like {power('N', min(rates), 1)} to {power('N', max(rates), 1)}"
        facts.append(
            f"{TITLES[solver]}: {int(one['iterations'].min())} to "
            f"{int(one['iterations'].max())} iterations, {float(one['solve_time'].min()):.2g} to "
            f"{float(one['solve_time'].max()):.2g} s{growth}, at most "
            f"{float(one['memory'].max()):.0f} fields of memory"
        )
    return (
        "Cost of a solve with exact periodicity to a residual of 1e-8, on one thread, without "
        f"set-up. At {int(finest['grid'])} x {int(finest['grid'])} cells, " + "; ".join(facts) + "."
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Which solver."""
    solvers = set(dataset["solver"].values.tolist())
    if not solvers >= set(SOLVERS) or not (dataset["case_status"] == CaseStatus.OK).all():
        return ()
    finest = dataset.isel(grid=-1)
    new, old = (finest.sel(solver=name) for name in ("preconditioned_cg", "polonsky_keer"))
    facts = "; ".join(
        f"{surface}: "
        + " against ".join(
            f"{int(one['iterations'])} iterations in {float(one['solve_time']):.2g} s"
            for one in (solver.sel(surface=surface) for solver in (new, old))
        )
        for surface in finest["surface"].values.tolist()
    )
    ratio = old["solve_time"] / new["solve_time"]
    return (
        Finding(
            f"Preconditioned conjugate gradients: {float(ratio.min()):.1f} to {float(ratio.max()):.1f} times "
            "faster than the scheme of Polonsky & Keer.",
            f"At {int(finest['grid'])} x {int(finest['grid'])} cells, against Polonsky & Keer: {facts}.",
            "Which solver?",
        ),
    )
