"""Pictures of one contact, and of two beside each other."""

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactstudy.domain.units import display_unit_of
from contactstudy.io.pictures.figure import (
    BLUE,
    GREEN,
    LAW_STYLE,
    PURPLE,
    RED,
    SETTINGS,
    add_legend,
    draw_map,
    finish,
    in_display_unit,
    in_the_middle,
    name_axes,
    panels,
    second_axis,
)

# Fraction of half a roller's length that is drawn at each end, and half-width of a film in Hertz's half-widths.
OF_LENGTH, FILM_WIDTH = 0.4, 2.0


def contact_picture(dataset: xr.Dataset) -> Figure:
    """Draw a contact as its dataset labels it: pressure, cross-sections, gap and stress."""
    plane_strain = dataset.sizes["y"] == 1
    drawn = [_across, _gap] if plane_strain else [_map, _along, _across, _gap]
    drawers = {
        "drop": _ends, "shear_x": _shear, "loop_force": _fretting_loop, "von_mises": _stress,
    }  # fmt: skip
    drawn += [draw for name, draw in drawers.items() if name in dataset]
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(drawn), columns=2 if len(drawn) < 5 else 3, width=4.6, height=3.4)
        for draw, ax in zip(drawn, axes, strict=True):
            draw(ax, dataset)
        return finish(figure, dataset)


def _map(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the pressure over the grid."""
    x, across = in_display_unit(dataset["x"], "m", "across")
    y, along = in_display_unit(dataset["y"], "m", "along")
    pressure, title = in_display_unit(dataset["pressure"], "Pa", "pressure")
    draw_map(ax, y, x, pressure, (along, across, title))
    if "half_length" in dataset:  # a point contact is drawn to equal scale
        ax.set_aspect(display_unit_of(dataset["x"], "m")[0] / display_unit_of(dataset["y"], "m")[0])


def _along(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the pressure along the middle of the contact, and Hertz's peak pressure."""
    y, along = in_display_unit(dataset["y"], "m", "along")
    scale, unit = display_unit_of(dataset["pressure"], "Pa")
    axis = np.abs(dataset["x"]) <= np.abs(dataset["x"]).min() * (1 + 1e-9)
    middle = dataset["pressure"].where(axis, drop=True).mean("x")
    ax.plot(y, middle / scale, label="in the middle", color=BLUE)
    if "hertz_peak_pressure" in dataset:
        ax.axhline(float(dataset["hertz_peak_pressure"]) / scale, **LAW_STYLE)
    name_axes(ax, along, f"pressure [{unit}]", "along the contact")


def _across(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the pressure across, with its range along the length, the attraction and Hertz's pressure."""
    x, across = in_display_unit(dataset["x"], "m", "across")
    scale, unit = display_unit_of(dataset["pressure"], "Pa")
    pressure = dataset["pressure"] / scale
    if dataset.sizes["y"] > 1:
        band = pressure.min("y"), pressure.max("y")
        look: Any = {"color": BLUE, "alpha": 0.18, "linewidth": 0}
        ax.fill_between(x, *band, label="lowest to highest", **look)
    ax.plot(x, in_the_middle(pressure), label="in the middle", color=BLUE)
    if "attraction" in dataset:
        attraction = -in_the_middle(dataset["attraction"]) / scale
        ax.plot(x, attraction, label="attraction, downwards", color=RED)
    if "hertz_half_width" in dataset:
        t = dataset["x"] / float(dataset["hertz_half_width"])
        hertz = float(dataset["hertz_peak_pressure"]) * np.sqrt(np.clip(1 - t**2, 0, None))
        ax.plot(x, hertz / scale, label="Hertz", **LAW_STYLE)
    name_axes(ax, across, f"pressure [{unit}]", "across the contact")


def _gap(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the gap across the middle of the length."""
    x, across = in_display_unit(dataset["x"], "m", "across")
    gap, up = in_display_unit(in_the_middle(dataset["gap"]), "m", "gap")
    ax.plot(x, gap, color=GREEN)
    name_axes(ax, across, up, "gap in the middle")


def _shear(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw both components of the tangential traction across the middle of the length."""
    x, across = in_display_unit(dataset["x"], "m", "across")
    middle = in_the_middle(dataset)
    scale, unit = display_unit_of(abs(middle["shear_x"]) + abs(middle["shear_y"]), "Pa")
    for name, direction, color in (("shear_x", "traction across", RED), ("shear_y", "traction along", GREEN)):
        if middle[name].any():
            ax.plot(x, middle[name] / scale, label=direction, color=color)
    name_axes(ax, across, f"traction [{unit}]", "tangential traction in the middle")


def _ends(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the largest pressure across, and the drop, against the distance from the end of a roller."""
    drop = dataset["drop"].dropna("y")
    y = drop["y"]
    middle, half = float(y[[0, -1]].mean()), float(y[-1] - y[0]) * (0.5 + 0.5 / max(len(y) - 1, 1))
    pressure, up = in_display_unit(dataset["pressure"].max("x").sel(y=y), "Pa", "pressure")
    depth, down = in_display_unit(drop, "m", "drop")
    beside = second_axis(ax, down, RED)
    symmetric = np.allclose(pressure, pressure[::-1], atol=1e-3 * float(pressure.max()))
    for side, style in ((1, "-"), (-1, "--"))[: 1 if symmetric else 2]:
        shown = side * (y - middle) >= (1 - OF_LENGTH) * half
        distance, along = in_display_unit((half - side * (y - middle))[shown], "m", "from the end")
        end = "" if symmetric else f"end at {'larger' if side > 0 else 'smaller'} y"
        ax.plot(distance, pressure[shown], style, label=end, color=BLUE)
        beside.plot(distance, depth[shown], style, color=RED)
    name_axes(ax, along, up, "at the ends")
    ax.yaxis.label.set_color(BLUE)
    beside.invert_yaxis()


def _fretting_loop(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the tangential force over the slip in a cycle."""
    slid, slip = in_display_unit(dataset["loop_slip"], "m", "slip")
    unit = dataset["loop_force"].attrs["units"]
    force, up = in_display_unit(dataset["loop_force"], unit, "tangential force")
    ax.plot(slid, force, ".-", color=BLUE)
    name_axes(ax, slip, up, "loop of a cycle")


def _stress(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the von Mises stress below the middle of the length, over the depth where there are several."""
    middle = in_the_middle(dataset["von_mises"])
    x, across = in_display_unit(dataset["x"], "m", "across")
    z, down = in_display_unit(dataset["z"], "m", "depth")
    stress, up = in_display_unit(middle, "Pa", "von Mises")
    ax.set(xlabel=across)
    if middle.sizes["z"] == 1:
        ax.plot(x, stress.isel(z=0), color=RED)
        ax.set(ylabel=up)
    else:
        filled = ax.contourf(x, z, stress, 24, cmap="magma")
        # the interface of a coating, where depths stand twice
        for interface in z.values[1:][np.diff(z) < 1e-6 * float(z[-1])]:
            ax.axhline(interface, color="white", linestyle="--", linewidth=0.8)
        ax.invert_yaxis()
        ax.figure.colorbar(filled, ax=ax)
        ax.set(ylabel=down)
    ax.set_title(up.replace("von Mises", "von Mises stress in the middle"))
    ax.grid(visible=False)


def comparison_picture(fields: xr.Dataset, at: tuple[float, float]) -> Figure:
    """Draw the difference of two contacts as a map, and both pressures across the place `at` (x, y) [m]."""
    scale, unit = display_unit_of(fields["a"], "Pa")
    x, across = in_display_unit(fields["x"], "m", "across")
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(1 if fields.sizes["y"] == 1 else 2, columns=2, width=4.6, height=3.4)
        if fields.sizes["y"] > 1:
            y, along = in_display_unit(fields["y"], "m", "along")
            change = fields["difference"] / scale
            largest = float(np.abs(change).max()) or 1.0
            names, limits = (along, across, f"b - a [{unit}]"), {"vmin": -largest, "vmax": largest}
            draw_map(axes[0], y, x, change, names, cmap="RdBu_r", **limits)
        section = fields.sel(y=at[1], method="nearest")
        axes[-1].plot(x, section["a"] / scale, label="a", color=BLUE)
        axes[-1].plot(x, section["b"] / scale, label="b", color=RED, linestyle="--")
        name_axes(axes[-1], across, f"pressure [{unit}]", "where they differ most")
        add_legend(figure)
    return figure


def film_picture(contact: xr.Dataset) -> Figure:
    """Draw pressure and film across the middle of a lubricated contact, and a map of a pressure that varies along it."""
    mapped = contact.sizes["y"] > 1
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(3 if mapped else 2, columns=3, width=4.6, height=3.4)
        _film(axes[0], contact)
        x, across = in_display_unit(contact["x"], "m", "across")
        film, up = in_display_unit(in_the_middle(contact["film"]), "m", "film")
        axes[1].semilogy(x, film, color=GREEN)
        ratio = contact.get("lambda_ratio")
        of_film = "" if ratio is None else f", lambda ratio {float(ratio):.3g}"
        name_axes(axes[1], across, up, f"film in the middle{of_film}")
        if mapped:
            _map(axes[2], contact)
        return finish(figure, contact)


def _film(ax: Axes, contact: xr.Dataset) -> None:
    """Draw pressure, film and temperature across the middle of a film, each on a scale of its own."""
    middle = in_the_middle(contact)
    reach = FILM_WIDTH * float(contact["hertz_half_width"])
    inside = middle.sel(x=slice(-reach, reach))
    _across(ax, contact.sel(x=slice(-reach, reach)))
    ax.yaxis.label.set_color(BLUE)
    scales = [("film", "m", "film", GREEN)]
    if "film_temperature_rise" in contact:
        scales.append(("film_temperature_rise", "K", "temperature rise", PURPLE))
    x, _ = in_display_unit(inside["x"], "m", "across")
    for number, (name, unit, label, color) in enumerate(scales):
        # in the unit of the film in the contact, which is hundreds of times as thick beside it
        shown = inside[name].where(inside["film"] < 8 * inside["film"].min()) if name == "film" else inside[name]
        values, up = in_display_unit(shown, unit, label)
        beside = second_axis(ax, up, color, 1 + 0.2 * number)
        beside.plot(x, values, label=label, color=color)
        beside.set_ylim(bottom=0)
    ax.set_title("pressure and film" if len(scales) == 1 else "pressure, film and temperature")
