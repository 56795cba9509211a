"""Saves the figures of the gallery's examples, each with a text alternative made from its axes."""

from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst


def of_axes(ax: Axes) -> str:
    """Title, labels and curves of one pair of axes, or what the colours of a map are."""
    if ax.get_label() == "<colorbar>":
        return f"colours: {ax.get_ylabel()}" if ax.get_ylabel() else ""
    plotted = " over ".join(label for label in (ax.get_ylabel(), ax.get_xlabel()) if label)
    text = ": ".join(part for part in (ax.get_title(), plotted) if part)
    if curves := ax.get_legend_handles_labels()[1]:
        text += " (" + "; ".join(curves) + ")"
    return text.replace("$", "")


def alternative(figure: Figure) -> str:
    """What stands for a figure where it cannot be seen."""
    parts = [of_axes(ax) for ax in figure.axes]
    return ". ".join(part for part in parts if part)


def scrape(block: object, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """The figures of a block of code: those of pyplot, and those that a block has made without it."""
    made = [one for one in block_vars["example_globals"].values() if isinstance(one, Figure)]
    figures = [plt.figure(number) for number in plt.get_fignums()]
    saved = block_vars.setdefault("saved_figures", set())
    text = ""
    for figure in dict.fromkeys(figures + made):
        if id(figure) not in saved:
            saved.add(id(figure))
            path = next(block_vars["image_path_iterator"])
            figure.savefig(path)
            text += figure_rst([path], gallery_conf["src_dir"], alternative(figure))
    plt.close("all")
    return text
