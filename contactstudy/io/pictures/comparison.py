"""The picture of two contacts beside each other."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from contactstudy.io.compare import Comparison
from contactstudy.io.pictures.contact import LENGTHS, PRESSURES, scaled
from contactstudy.io.pictures.figure import SETTINGS, add_legend, panels


def compare_picture(found: Comparison) -> Figure:
    """The difference as a map, where there is a length, and both pressures across its largest place."""
    fields = found.difference
    size, pascals = scaled(fields["a"], PRESSURES)
    width, metres = scaled(fields["x"], LENGTHS)
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(1 if fields.sizes["y"] == 1 else 2, columns=2, width=4.6, height=3.4)
        if fields.sizes["y"] > 1:
            length, along = scaled(fields["y"], LENGTHS)
            change = fields["difference"] / size
            most = float(np.abs(change).max()) or 1.0
            mesh = axes[0].pcolormesh(
                fields["y"] / length, fields["x"] / width, change, cmap="RdBu_r", vmin=-most, vmax=most,
                shading="nearest", rasterized=True,
            )  # fmt: skip
            axes[0].set(
                xlabel=f"along [{along}]", ylabel=f"across [{metres}]", title=f"b - a [{pascals}]"
            )
            axes[0].grid(visible=False)
            figure.colorbar(mesh, ax=axes[0])
        there = fields.sel(y=found.at[1], method="nearest")
        x = fields["x"] / width
        axes[-1].plot(x, there["a"] / size, label="a", color="#0072B2")
        axes[-1].plot(x, there["b"] / size, label="b", color="#D55E00", linestyle="--")
        axes[-1].set(
            xlabel=f"across [{metres}]",
            ylabel=f"pressure [{pascals}]",
            title="where they differ most",
        )
        add_legend(figure)
    return figure
