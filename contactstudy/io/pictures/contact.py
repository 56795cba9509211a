"""Pictures of one contact, and of two beside each other."""

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactstudy.domain.units import display_unit_of
from contactstudy.io.pictures.figure import (
    LAW_STYLE,
    SETTINGS,
    add_legend,
    draw_map,
    finish,
    in_display_unit,
    name_axes,
    panels,
)

# Fraction of half a roller's length that is drawn at each end, and half-width of a film in Hertz's half-widths.
OF_LENGTH, FILM_WIDTH = 0.4, 2.0
TEMPERATURE: dict[str, Any] = {"color": "#CC79A7"}
PRESSURE: dict[str, Any] = {"color": "#0072B2"}
GAP: dict[str, Any] = {"color": "#009E73"}
STRESS: dict[str, Any] = {"color": "#D55E00"}


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
    x, across = in_display_unit(dataset["x"], "m", "across")
    y, along = in_display_unit(dataset["y"], "m", "along")
    pressure, title = in_display_unit(dataset["pressure"], "Pa", "pressure")
    draw_map(ax, y, x, pressure, (along, across, title))


def _along(ax: Axes, dataset: xr.Dataset) -> None:
    y, along = in_display_unit(dataset["y"], "m", "along")
    scale, unit = display_unit_of(dataset["pressure"], "Pa")
    axis = np.abs(dataset["x"]) <= np.abs(dataset["x"]).min() * (1 + 1e-9)
    middle = dataset["pressure"].where(axis, drop=True).mean("x")
    ax.plot(y, middle / scale, label="in the middle", **PRESSURE)
    if "hertz_peak_pressure" in dataset:
        ax.axhline(float(dataset["hertz_peak_pressure"]) / scale, **LAW_STYLE)
    name_axes(ax, along, f"pressure [{unit}]", "along the contact")


def _across(ax: Axes, dataset: xr.Dataset) -> None:
    x, across = in_display_unit(dataset["x"], "m", "across")
    scale, unit = display_unit_of(dataset["pressure"], "Pa")
    pressure = dataset["pressure"] / scale
    style = PRESSURE
    if dataset.sizes["y"] > 1:
        band = pressure.min("y"), pressure.max("y")
        look: Any = {"color": style["color"], "alpha": 0.18, "linewidth": 0}
        ax.fill_between(x, *band, label="lowest to highest", **look)
    ax.plot(x, pressure.isel(y=dataset.sizes["y"] // 2), label="in the middle", **style)
    if "attraction" in dataset:
        attraction = -dataset["attraction"].isel(y=dataset.sizes["y"] // 2) / scale
        ax.plot(x, attraction, label="attraction, downwards", **STRESS)
    if "hertz_half_width" in dataset:
        t = dataset["x"] / float(dataset["hertz_half_width"])
        hertz = float(dataset["hertz_peak_pressure"]) * np.sqrt(np.clip(1 - t**2, 0, None))
        ax.plot(x, hertz / scale, label="Hertz", **LAW_STYLE)
    name_axes(ax, across, f"pressure [{unit}]", "across the contact")


def _gap(ax: Axes, dataset: xr.Dataset) -> None:
    x, across = in_display_unit(dataset["x"], "m", "across")
    gap, up = in_display_unit(dataset["gap"].isel(y=dataset.sizes["y"] // 2), "m", "gap")
    ax.plot(x, gap, **GAP)
    name_axes(ax, across, up, "gap in the middle")


def _shear(ax: Axes, dataset: xr.Dataset) -> None:
    x, across = in_display_unit(dataset["x"], "m", "across")
    middle = dataset.isel(y=dataset.sizes["y"] // 2)
    scale, unit = display_unit_of(abs(middle["shear_x"]) + abs(middle["shear_y"]), "Pa")
    for name, direction, style in (
        ("shear_x", "traction across", STRESS),
        ("shear_y", "traction along", GAP),
    ):
        if middle[name].any():
            ax.plot(x, middle[name] / scale, label=direction, **style)
    name_axes(ax, across, f"traction [{unit}]", "tangential traction in the middle")


def _ends(ax: Axes, dataset: xr.Dataset) -> None:
    """Draw the largest pressure across, and the drop, against the distance from the end of a roller."""
    drop = dataset["drop"].dropna("y")
    y = drop["y"]
    middle, half = float(y[[0, -1]].mean()), float(y[-1] - y[0]) * (0.5 + 0.5 / max(len(y) - 1, 1))
    pressure, up = in_display_unit(dataset["pressure"].max("x").sel(y=y), "Pa", "pressure")
    depth, down = in_display_unit(drop, "m", "drop")
    beside = ax.twinx()
    symmetric = np.allclose(pressure, pressure[::-1], atol=1e-3 * float(pressure.max()))
    for side, style in ((1, "-"), (-1, "--"))[: 1 if symmetric else 2]:
        shown = side * (y - middle) >= (1 - OF_LENGTH) * half
        distance, along = in_display_unit((half - side * (y - middle))[shown], "m", "from the end")
        end = "" if symmetric else f"end at {'larger' if side > 0 else 'smaller'} y"
        ax.plot(distance, pressure[shown], style, label=end, color=PRESSURE["color"])
        beside.plot(distance, depth[shown], style, color=STRESS["color"])
    name_axes(ax, along, up, "at the ends")
    ax.yaxis.label.set_color(PRESSURE["color"])
    beside.set_ylabel(down, color=STRESS["color"])
    beside.spines["right"].set_visible(True)
    beside.invert_yaxis()
    beside.grid(visible=False)


def _fretting_loop(ax: Axes, dataset: xr.Dataset) -> None:
    slid, across = in_display_unit(dataset["loop_slip"], "m", "slip")
    unit = dataset["loop_force"].attrs["units"]
    force, up = in_display_unit(dataset["loop_force"], unit, "tangential force")
    ax.plot(slid, force, ".-", **PRESSURE)
    name_axes(ax, across, up, "loop of a cycle")


def _stress(ax: Axes, dataset: xr.Dataset) -> None:
    middle = dataset["von_mises"].isel(y=dataset.sizes["y"] // 2)
    x, across = in_display_unit(dataset["x"], "m", "across")
    z, down = in_display_unit(dataset["z"], "m", "depth")
    stress, up = in_display_unit(middle, "Pa", "von Mises")
    ax.set(xlabel=across)
    if middle.sizes["z"] == 1:
        ax.plot(x, stress.isel(z=0), **STRESS)
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
        axes[-1].plot(x, section["a"] / scale, label="a", color="#0072B2")
        axes[-1].plot(x, section["b"] / scale, label="b", color="#D55E00", linestyle="--")
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
        film, up = in_display_unit(contact["film"].isel(y=contact.sizes["y"] // 2), "m", "film")
        axes[1].semilogy(x, film, **GAP)
        ratio = contact.get("lambda_ratio")
        of_film = "" if ratio is None else f", lambda ratio {float(ratio):.3g}"
        name_axes(axes[1], across, up, f"film in the middle{of_film}")
        if mapped:
            _map(axes[2], contact)
        return finish(figure, contact)


def _film(ax: Axes, contact: xr.Dataset) -> None:
    """Draw pressure, film and temperature across the middle of a film, each on a scale of its own."""
    middle = contact.isel(y=contact.sizes["y"] // 2)
    reach = FILM_WIDTH * float(contact["hertz_half_width"])
    inside = middle.sel(x=slice(-reach, reach))
    _across(ax, contact.sel(x=slice(-reach, reach)))
    ax.yaxis.label.set_color(PRESSURE["color"])
    scales = [("film", "m", "film", GAP)]
    if "film_temperature_rise" in contact:
        scales.append(("film_temperature_rise", "K", "temperature rise", TEMPERATURE))
    x, _ = in_display_unit(inside["x"], "m", "across")
    for number, (name, unit, label, style) in enumerate(scales):
        beside = ax.twinx()
        # in the unit of the film in the contact, which is hundreds of times as thick beside it
        shown = inside[name].where(inside["film"] < 8 * inside["film"].min()) if name == "film" else inside[name]
        values, up = in_display_unit(shown, unit, label)
        beside.plot(x, values, label=label, **style)
        beside.set_ylim(bottom=0)
        beside.set_ylabel(up, color=style["color"])
        beside.spines["right"].set(visible=True, position=("axes", 1 + 0.2 * number))
        beside.grid(visible=False)
    ax.set_title("pressure and film" if len(scales) == 1 else "pressure, film and temperature")
