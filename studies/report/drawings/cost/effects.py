"""Drawing of the study `effects`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from contactstudy.domain.fields import Array
from studies.definitions.cost.effects import COARSER, IN_TIME, PERIOD, WIDTH, YIELD
from studies.model.drawing import CaptionedFigure
from studies.reference.line_contact import total_time
from studies.report.formatting import percent
from studies.report.style import add_legend, panels

COLOR = "#0072B2"
# Rows of scenes that have not all effects above them.
ALONE = ("smooth", "one step", "two steps")


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """A bar for each scene: time, iterations, transforms and memory."""
    here = dataset.isel(grid=-1)
    names = [str(name) for name in here["effect"].values]
    place = np.arange(float(len(names)))
    fig, axes = panels(4, columns=2, width=3.6, height=0.6 + 0.32 * len(names), share="y")
    setup, solve = here["setup_time"].values, here["solve_time"].values
    axes[0].barh(place, setup, color="#E69F00", label="set-up")
    axes[0].barh(place, solve, left=setup, color=COLOR, label="solve and outputs")
    _numbers(axes[0], place, setup + solve, "{:.2g}")
    for ax, variable, form in (
        (axes[1], "memory", "{:.3g}"),
        (axes[2], "iterations", "{:.0f}"),
        (axes[3], "convolutions", "{:.0f}"),
    ):
        ax.barh(place, here[variable].values, color=COLOR)
        _numbers(ax, place, here[variable].values, form)
    for ax, label in zip(
        axes,
        ("wall time [s]", "peak memory [MB]", "iterations", "transform pairs of the solve"),
        strict=True,
    ):
        ax.set_xlabel(label)
        ax.grid(visible=False, axis="y")
    labels = [name if name.startswith(ALONE) else f"+ {name}" for name in names]
    axes[0].set_yticks(place, labels)
    axes[0].invert_yaxis()
    add_legend(fig)
    return (CaptionedFigure("effects", fig, _caption(here)),)


def _numbers(ax: Axes, place: Array, values: Array, form: str) -> None:
    """Each bar's value at its end."""
    for y, value in zip(place, values, strict=True):
        ax.text(value, y, " " + form.format(value), va="center", fontsize="small")
    ax.margins(x=0.18)


def _caption(dataset: xr.Dataset) -> str:
    cells = int(dataset["grid"])
    words = (
        f"Cost of each effect: every scene has all effects above it and one more, but the sliding one has no "
        f"coating. {cells} x {cells // 4} "
        f"cells over {WIDTH:g} a x {PERIOD:g} a ({cells} x 1 for the first), exact periodicity, a residual of "
        "1e-8, one thread. Time and memory include set-up, solve and outputs."
    )
    both = ["smooth, 1-D", "smooth, 2-D"]
    if set(both) <= set(dataset["effect"].values.tolist()):
        time = total_time(dataset).sel(effect=both).values
        words += (
            " If nothing varies along the length, one cell along it gives the same pressure in "
            f"{percent(time[0] / time[1])} of the time. All heights are added to one field, so no shape needs "
            "more memory or longer transforms: a shape costs iterations. Stress adds no iterations, "
            "but it needs influence coefficients and transforms of its own, "
            "one for each of six components at each depth (here one depth), and as many again under shear. A coating "
            "costs set-up alone."
        )
    if YIELD in dataset["effect"].values.tolist():
        words += (
            " Yield is alone on the smooth cylinder, in plane strain, one cell along and "
            f"{cells // COARSER} across: the load comes in two steps, of which a solution of the contact is "
            "sought together with the plastic strain, and all contacts on the way count."
        )
    if set(IN_TIME) & set(dataset["effect"].values.tolist()):
        words += (
            " Creep and wear are alone on the wavy cylinder, a sudden load and one step in time: iterations and "
            "transform pairs are those of the step, which starts from the pressure before, while time "
            "and memory count both. A step adds at most one convolution to a solve."
        )
    return words
