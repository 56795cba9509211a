"""Drawing of the study `peers`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

from studies.definitions.cost.peers import PROGRAMS
from studies.model.drawing import CaptionedFigure
from studies.reference.line_contact import total_time
from studies.report.style import add_legend, panels

COLORS = dict(zip(PROGRAMS, ("#0072B2", "#D55E00", "#009E73", "#CC79A7"), strict=True))


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Time in all against the grid, a panel for each boundary."""
    boundaries = [str(name) for name in dataset["boundary"].values]
    fig, axes = panels(len(boundaries), share="y")
    time = total_time(dataset)
    facts = []
    for ax, boundary in zip(axes, boundaries, strict=True):
        for program in (str(name) for name in dataset["program"].values):
            one = time.sel(program=program, boundary=boundary)
            if not np.isfinite(one).any():
                continue
            ax.loglog(dataset["grid"], one, marker="o", color=COLORS[program], label=program)
            finest = dataset.sel(program=program, boundary=boundary).isel(grid=-1)
            facts.append(
                f"{boundary}, {program} {float(one[-1]):.2g} s with a difference of "
                f"{float(finest['difference']):.0e}"
            )
        ax.set(title=boundary, xlabel="cells across and along")
        ax.set_xticks(dataset["grid"], [str(n) for n in dataset["grid"].values])
        ax.minorticks_off()
    axes[0].set_ylabel("wall time, set-up and solve [s]")
    add_legend(fig)
    return (
        CaptionedFigure(
            "peers",
            fig,
            f"Total time on one thread. At {int(dataset['grid'][-1])} cells: "
            + "; ".join(facts)
            + ". "
            "The difference is the largest one from the converged solution for cells of constant pressure. On "
            "periodic surfaces the other programs represent the pressure as a sum of waves, which is another "
            "discretisation and not an error.",
        ),
    )
