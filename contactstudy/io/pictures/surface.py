"""Picture of a measured surface as it enters a contact."""

from textwrap import fill

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactstudy.domain.fields import Array
from contactstudy.domain.units import display_unit_of
from contactstudy.io.pictures.figure import SETTINGS, draw_map, name_axes, panels
from contactstudy.io.quantities.surface_quantities import parameters_text, surface_parameters
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface


def surface_picture(surface: MeasuredSurface, *, raw: bool = False) -> Figure:
    """Draw the prepared heights, their profiles through the middle, and their parameters; the raw heights if asked."""
    maps = [("prepared", surface.prepared)]
    if raw:
        maps.append(("as measured", surface.heights))
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(maps) + 1, columns=len(maps) + 1, width=4.6, height=4.0)
        for (title, heights), ax in zip(maps, axes, strict=False):
            _map(ax, surface, heights, title)
        _profiles(axes[-1], surface)
        figure.suptitle(fill(surface.description, 75 * len(axes)), fontsize="small")
        lines = "\n".join(parameters_text(surface_parameters(surface)))
        axes[-1].text(1.03, 1, lines, transform=axes[-1].transAxes, va="top", family="monospace", size="small")
    return figure


def _places(surface: MeasuredSurface) -> tuple[Array, Array, tuple[float, str]]:
    """Return the places of points across and along, in a unit of display, and this unit."""
    extent = surface.extent or surface.heights.shape
    scale = display_unit_of(extent, "m")
    across, along = (
        (np.arange(count) + 0.5 - count / 2) * size / count / scale[0]
        for count, size in zip(surface.heights.shape, extent, strict=True)
    )
    return across, along, scale


def _map(ax: Axes, surface: MeasuredSurface, heights: Array, title: str) -> None:
    """Draw the heights over the surface; those of a profile over its places."""
    across, along, (_, unit) = _places(surface)
    size, name = display_unit_of(heights, "m")
    if 1 in heights.shape:
        ax.plot(across if len(across) > 1 else along, heights.ravel() / size)
        name_axes(ax, f"place [{unit}]", f"height [{name}]", title)
        return
    names = f"along [{unit}]", f"across [{unit}]", f"height [{name}], {title}"
    draw_map(ax, along, across, heights / size, names)


def _profiles(ax: Axes, surface: MeasuredSurface) -> None:
    """Draw the prepared heights across and along the middle of a surface."""
    across, along, (_, unit) = _places(surface)
    heights = surface.prepared
    size, name = display_unit_of(heights, "m")
    for places, profile, label in (
        (across, heights[:, heights.shape[1] // 2], "across"),
        (along, heights[heights.shape[0] // 2], "along"),
    ):
        if len(places) > 1:
            ax.plot(places, profile / size, label=label, linewidth=0.9)
    ax.legend()
    name_axes(ax, f"place [{unit}]", f"height [{name}]", "in the middle")
