"""Pictures of one contact, and of two beside each other."""

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import display_unit_of
from contactstudy.io.pictures.figure import LAW_STYLE, SETTINGS, add_legend, name_axes, panels
from contactstudy.io.pictures.interference import interference_colours

# Half-width of an interferogram in Hertz's half-widths.
INTERFEROGRAM = 2.0
WARNING_WIDTH = 70  # letters over one panel
PRESSURE: dict[str, Any] = {"color": "#0072B2"}
GAP: dict[str, Any] = {"color": "#009E73"}
STRESS: dict[str, Any] = {"color": "#D55E00"}


def contact_picture(dataset: xr.Dataset) -> Figure:
    """Draw a contact as its dataset labels it: pressure, cross-sections, gap and stress."""
    plane_strain = dataset.sizes["y"] == 1
    drawn = [_across, _gap] if plane_strain else [_map, _along, _across, _gap]
    drawers = {"shear_x": _shear, "von_mises": _stress}
    drawn += [draw for name, draw in drawers.items() if name in dataset]
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(drawn), columns=2 if len(drawn) < 5 else 3, width=4.6, height=3.4)
        for draw, ax in zip(drawn, axes, strict=True):
            draw(ax, dataset)
        add_legend(figure)
        if "warnings" in dataset.attrs:
            warning = fill(str(dataset.attrs["warnings"]), WARNING_WIDTH * min(len(drawn), 2))
            figure.suptitle(f"warning: {warning}", color=STRESS["color"], fontsize="small")
    return figure


def _map(ax: Axes, dataset: xr.Dataset) -> None:
    pressure = dataset["pressure"]
    length, length_unit = display_unit_of(dataset["y"], "m")
    width, across = display_unit_of(dataset["x"], "m")
    factor, pressure_unit = display_unit_of(pressure, "Pa")
    x, y = dataset["x"] / width, dataset["y"] / length
    look: Any = {"cmap": "viridis", "shading": "nearest", "rasterized": True}
    mesh = ax.pcolormesh(y, x, pressure / factor, **look)
    name_axes(ax, f"along [{length_unit}]", f"across [{across}]", f"pressure [{pressure_unit}]")
    ax.grid(visible=False)
    ax.figure.colorbar(mesh, ax=ax)


def _along(ax: Axes, dataset: xr.Dataset) -> None:
    length, length_unit = display_unit_of(dataset["y"], "m")
    factor, pressure_unit = display_unit_of(dataset["pressure"], "Pa")
    axis = np.abs(dataset["x"]) <= np.abs(dataset["x"]).min() * (1 + 1e-9)
    middle = dataset["pressure"].where(axis, drop=True).mean("x")
    ax.plot(dataset["y"] / length, middle / factor, label="in the middle", **PRESSURE)
    if "hertz_peak_pressure" in dataset:
        ax.axhline(float(dataset["hertz_peak_pressure"]) / factor, **LAW_STYLE)
    name_axes(ax, f"along [{length_unit}]", f"pressure [{pressure_unit}]", "along the contact")


def _across(ax: Axes, dataset: xr.Dataset) -> None:
    width, length_unit = display_unit_of(dataset["x"], "m")
    factor, pressure_unit = display_unit_of(dataset["pressure"], "Pa")
    x, pressure = dataset["x"] / width, dataset["pressure"] / factor
    style = PRESSURE
    if dataset.sizes["y"] > 1:
        band = pressure.min("y"), pressure.max("y")
        look: Any = {"color": style["color"], "alpha": 0.18, "linewidth": 0}
        ax.fill_between(x, *band, label="lowest to highest", **look)
    ax.plot(x, pressure.isel(y=dataset.sizes["y"] // 2), label="in the middle", **style)
    if "attraction" in dataset:
        attraction = -dataset["attraction"].isel(y=dataset.sizes["y"] // 2) / factor
        ax.plot(x, attraction, label="attraction, downwards", **STRESS)
    if "hertz_half_width" in dataset:
        t = dataset["x"] / float(dataset["hertz_half_width"])
        hertz = float(dataset["hertz_peak_pressure"]) * np.sqrt(np.clip(1 - t**2, 0, None))
        ax.plot(x, hertz / factor, label="Hertz", **LAW_STYLE)
    name_axes(ax, f"across [{length_unit}]", f"pressure [{pressure_unit}]", "across the contact")


def _gap(ax: Axes, dataset: xr.Dataset) -> None:
    width, length_unit = display_unit_of(dataset["x"], "m")
    middle = dataset.isel(y=dataset.sizes["y"] // 2)
    factor, height = display_unit_of(middle["gap"], "m")
    ax.plot(dataset["x"] / width, middle["gap"] / factor, **GAP)
    name_axes(ax, f"across [{length_unit}]", f"gap [{height}]", "gap in the middle")


def _shear(ax: Axes, dataset: xr.Dataset) -> None:
    width, length_unit = display_unit_of(dataset["x"], "m")
    middle = dataset.isel(y=dataset.sizes["y"] // 2)
    factor, pressure_unit = display_unit_of(abs(middle["shear_x"]) + abs(middle["shear_y"]), "Pa")
    for name, direction, style in (("shear_x", "across", PRESSURE), ("shear_y", "along", GAP)):
        if middle[name].any():
            shear, label = middle[name] / factor, f"shear {direction}"
            ax.plot(dataset["x"] / width, shear, label=label, **style)
    name_axes(ax, f"across [{length_unit}]", f"shear [{pressure_unit}]", "shear in the middle")


def _stress(ax: Axes, dataset: xr.Dataset) -> None:
    middle = dataset["von_mises"].isel(y=dataset.sizes["y"] // 2)
    width, across = display_unit_of(dataset["x"], "m")
    depth, length_unit = display_unit_of(dataset["z"], "m")
    factor, pressure_unit = display_unit_of(middle, "Pa")
    if middle.sizes["z"] == 1:
        ax.plot(dataset["x"] / width, middle.isel(z=0) / factor, **STRESS)
        ax.set(xlabel=f"across [{across}]", ylabel=f"von Mises [{pressure_unit}]")
    else:
        x, down = dataset["x"] / width, dataset["z"] / depth
        filled = ax.contourf(x, down, middle / factor, 24, cmap="magma")
        z = dataset["z"].values
        # the bond of a coating, where depths stand twice
        for bond in z[1:][np.diff(z) < 1e-6 * z[-1]]:
            ax.axhline(bond / depth, color="white", linestyle="--", linewidth=0.8)
        ax.invert_yaxis()
        ax.figure.colorbar(filled, ax=ax)
        ax.set(xlabel=f"across [{across}]", ylabel=f"depth [{length_unit}]")
    ax.set_title(f"von Mises stress in the middle [{pressure_unit}]")
    ax.grid(visible=False)


def comparison_picture(fields: xr.Dataset, at: tuple[float, float]) -> Figure:
    """Draw the difference of two contacts as a map, and both pressures across the place `at` (x, y) [m]."""
    factor, pressure_unit = display_unit_of(fields["a"], "Pa")
    width, length_unit = display_unit_of(fields["x"], "m")
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(1 if fields.sizes["y"] == 1 else 2, columns=2, width=4.6, height=3.4)
        if fields.sizes["y"] > 1:
            length, along = display_unit_of(fields["y"], "m")
            change = fields["difference"] / factor
            largest = float(np.abs(change).max()) or 1.0
            mesh = axes[0].pcolormesh(
                fields["y"] / length, fields["x"] / width, change, cmap="RdBu_r", vmin=-largest, vmax=largest,
                shading="nearest", rasterized=True,
            )  # fmt: skip
            name_axes(
                axes[0], f"along [{along}]", f"across [{length_unit}]", f"b - a [{pressure_unit}]"
            )
            axes[0].grid(visible=False)
            figure.colorbar(mesh, ax=axes[0])
        section = fields.sel(y=at[1], method="nearest")
        x = fields["x"] / width
        axes[-1].plot(x, section["a"] / factor, label="a", color="#0072B2")
        axes[-1].plot(x, section["b"] / factor, label="b", color="#D55E00", linestyle="--")
        name_axes(
            axes[-1],
            f"across [{length_unit}]",
            f"pressure [{pressure_unit}]",
            "where they differ most",
        )
        add_legend(figure)
    return figure


def film_picture(
    contact: xr.Dataset,
    colours: str = "pressure",
    refractive_index: float = 1.5,
    wavelengths: Sequence[float] | None = None,
) -> Figure:
    """Return pressure and film across the middle of a lubricated contact, and a map.

    The map is of the pressure where that varies along the length, or of the film in ``colours`` of interference.
    """
    if colours not in ("pressure", "interference"):
        raise InvalidInput(f"plot.colours is {colours!r}: give 'pressure' or 'interference'.")
    interference = colours == "interference"
    mapped = interference or contact.sizes["y"] > 1
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(3 if mapped else 2, columns=3, width=4.6, height=3.4)
        _across(axes[0], contact)
        middle = contact["film"].isel(y=contact.sizes["y"] // 2)
        width, length_unit = display_unit_of(contact["x"], "m")
        factor, height = display_unit_of(middle, "m")
        axes[1].semilogy(contact["x"] / width, middle / factor, **GAP)
        name_axes(axes[1], f"across [{length_unit}]", f"film [{height}]", "film in the middle")
        if interference:
            _interferogram(axes[2], contact, refractive_index, wavelengths)
        elif mapped:
            _map(axes[2], contact)
        add_legend(figure)
    return figure


def _interferogram(
    ax: Axes, contact: xr.Dataset, refractive_index: float, wavelengths: Sequence[float] | None
) -> None:
    """Draw the film near the contact in colours of interference; one line of cells as a band."""
    reach = INTERFEROGRAM * float(contact["hertz_half_width"])
    film = contact["film"].sel(x=slice(-reach, reach))
    width, across = display_unit_of(film["x"], "m")
    length, along = display_unit_of(film["y"], "m")
    x, y = film["x"].values / width, film["y"].values / length
    dx, dy = x[1] - x[0], y[1] - y[0] if len(y) > 1 else 1.0
    ax.imshow(
        interference_colours(film.values, refractive_index, wavelengths),
        origin="lower",
        aspect="auto",
        extent=(y[0] - dy / 2, y[-1] + dy / 2, x[0] - dx / 2, x[-1] + dx / 2),
    )
    if len(y) == 1:
        ax.set_xticks([])
    name_axes(ax, f"along [{along}]", f"across [{across}]", "film by interference")
    ax.grid(visible=False)
