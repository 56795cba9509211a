"""Drawing of the study `peers`: figures, findings and tables from its stored data."""

from itertools import product

import numpy as np
import xarray as xr

from studies.definitions.cost.peers import PROGRAMS
from studies.model.drawing import CaptionedFigure
from studies.model.plain_text import thread_count
from studies.reference.line_contact import total_time
from studies.report.style import add_legend, panels

COLORS = dict(zip(PROGRAMS, ("#0072B2", "#D55E00", "#009E73", "#CC79A7"), strict=True))
LINES = ("-", "--", ":", "-.")  # of each number of threads


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Time in all against the grid, a panel for each boundary."""
    boundaries = [str(name) for name in dataset["boundary"].values]
    fig, axes = panels(len(boundaries), share="y")
    threads = dataset["threads"].values.tolist()
    time = total_time(dataset)
    facts = []
    for ax, boundary in zip(axes, boundaries, strict=True):
        for program, number in product(dataset["program"].values, range(len(threads))):
            chosen = {"program": program, "boundary": boundary, "threads": threads[number]}
            one = time.sel(chosen)
            if not np.isfinite(one).any():
                continue
            name = program if len(threads) == 1 else f"{program}, {thread_count(threads[number])}"
            line = {"color": COLORS[str(program)], "linestyle": LINES[number % len(LINES)]}
            ax.loglog(dataset["grid"], one, marker="o", label=name, **line)
            finest = dataset.sel(chosen).isel(grid=-1)
            facts.append(
                f"{boundary}, {name} {float(one[-1]):.2g} s with a difference of "
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
            f"Total time on {' or '.join(map(thread_count, threads))}. At {int(dataset['grid'][-1])} cells: "
            + "; ".join(facts)
            + ". "
            "The difference is the largest one from the converged solution for cells of constant pressure. On "
            "periodic surfaces the other programs represent the pressure as a sum of waves, which is another "
            "discretisation and not an error.",
        ),
    )
