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
from contactstudy.io.pictures.figure import LAW_STYLE, SETTINGS, add_legend, panels
from contactstudy.io.pictures.interference import interference_colours

# Half-width of an interferogram in Hertz's half-widths.
INTERFEROGRAM = 2.0
WARNING_WIDTH = 70  # letters over one panel
PRESSURE: dict[str, Any] = {"color": "#0072B2"}
GAP: dict[str, Any] = {"color": "#009E73"}
STRESS: dict[str, Any] = {"color": "#D55E00"}


def picture(solved: xr.Dataset) -> Figure:
    """Draw a contact as its dataset labels it: pressure, cross-sections, gap and stress."""
    plane_strain = solved.sizes["y"] == 1
    drawn = [_across, _gap] if plane_strain else [_map, _along, _across, _gap]
    drawers = {"shear_x": _shear, "von_mises": _stress}
    drawn += [draw for name, draw in drawers.items() if name in solved]
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(drawn), columns=2 if len(drawn) < 5 else 3, width=4.6, height=3.4)
        for draw, ax in zip(drawn, axes, strict=True):
            draw(ax, solved)
        add_legend(figure)
        if "warnings" in solved.attrs:
            warning = fill(str(solved.attrs["warnings"]), WARNING_WIDTH * min(len(drawn), 2))
            figure.suptitle(f"warning: {warning}", color=STRESS["color"], fontsize="small")
    return figure


def _map(ax: Axes, solved: xr.Dataset) -> None:
    pressure = solved["pressure"]
    length, metres = display_unit_of(solved["y"], "m")
    width, across = display_unit_of(solved["x"], "m")
    size, pascals = display_unit_of(pressure, "Pa")
    mesh = ax.pcolormesh(
        solved["y"] / length,
        solved["x"] / width,
        pressure / size,
        cmap="viridis",
        shading="nearest",
        rasterized=True,
    )
    ax.set(xlabel=f"along [{metres}]", ylabel=f"across [{across}]", title=f"pressure [{pascals}]")
    ax.grid(visible=False)
    ax.figure.colorbar(mesh, ax=ax)


def _along(ax: Axes, solved: xr.Dataset) -> None:
    length, metres = display_unit_of(solved["y"], "m")
    size, pascals = display_unit_of(solved["pressure"], "Pa")
    axis = np.abs(solved["x"]) <= np.abs(solved["x"]).min() * (1 + 1e-9)
    middle = solved["pressure"].where(axis, drop=True).mean("x")
    ax.plot(solved["y"] / length, middle / size, label="in the middle", **PRESSURE)
    if "hertz_peak_pressure" in solved:
        ax.axhline(float(solved["hertz_peak_pressure"]) / size, **LAW_STYLE)
    ax.set(xlabel=f"along [{metres}]", ylabel=f"pressure [{pascals}]", title="along the contact")


def _across(ax: Axes, solved: xr.Dataset) -> None:
    width, metres = display_unit_of(solved["x"], "m")
    size, pascals = display_unit_of(solved["pressure"], "Pa")
    x, pressure = solved["x"] / width, solved["pressure"] / size
    style = PRESSURE
    if solved.sizes["y"] > 1:
        band = pressure.min("y"), pressure.max("y")
        ax.fill_between(
            x, *band, color=style["color"], alpha=0.18, linewidth=0, label="lowest to highest"
        )
    ax.plot(x, pressure.isel(y=solved.sizes["y"] // 2), label="in the middle", **style)
    if "attraction" in solved:
        attraction = -solved["attraction"].isel(y=solved.sizes["y"] // 2) / size
        ax.plot(x, attraction, label="attraction, downwards", **STRESS)
    if "hertz_half_width" in solved:
        t = solved["x"] / float(solved["hertz_half_width"])
        hertz = float(solved["hertz_peak_pressure"]) * np.sqrt(np.clip(1 - t**2, 0, None))
        ax.plot(x, hertz / size, label="Hertz", **LAW_STYLE)
    ax.set(xlabel=f"across [{metres}]", ylabel=f"pressure [{pascals}]", title="across the contact")


def _gap(ax: Axes, solved: xr.Dataset) -> None:
    width, metres = display_unit_of(solved["x"], "m")
    middle = solved.isel(y=solved.sizes["y"] // 2)
    size, height = display_unit_of(middle["gap"], "m")
    ax.plot(solved["x"] / width, middle["gap"] / size, **GAP)
    ax.set(xlabel=f"across [{metres}]", ylabel=f"gap [{height}]", title="gap in the middle")


def _shear(ax: Axes, solved: xr.Dataset) -> None:
    width, metres = display_unit_of(solved["x"], "m")
    middle = solved.isel(y=solved.sizes["y"] // 2)
    size, pascals = display_unit_of(abs(middle["shear_x"]) + abs(middle["shear_y"]), "Pa")
    for name, direction, style in (("shear_x", "across", PRESSURE), ("shear_y", "along", GAP)):
        if middle[name].any():
            ax.plot(solved["x"] / width, middle[name] / size, label=f"shear {direction}", **style)
    ax.set(xlabel=f"across [{metres}]", ylabel=f"shear [{pascals}]", title="shear in the middle")


def _stress(ax: Axes, solved: xr.Dataset) -> None:
    middle = solved["von_mises"].isel(y=solved.sizes["y"] // 2)
    width, across = display_unit_of(solved["x"], "m")
    depth, metres = display_unit_of(solved["z"], "m")
    size, pascals = display_unit_of(middle, "Pa")
    if middle.sizes["z"] == 1:
        ax.plot(solved["x"] / width, middle.isel(z=0) / size, **STRESS)
        ax.set(xlabel=f"across [{across}]", ylabel=f"von Mises [{pascals}]")
    else:
        filled = ax.contourf(
            solved["x"] / width, solved["z"] / depth, middle / size, 24, cmap="magma"
        )
        z = solved["z"].values
        for bond in z[1:][
            np.diff(z) < 1e-6 * z[-1]
        ]:  # the bond of a coating, where depths stand twice
            ax.axhline(bond / depth, color="white", linestyle="--", linewidth=0.8)
        ax.invert_yaxis()
        ax.figure.colorbar(filled, ax=ax)
        ax.set(xlabel=f"across [{across}]", ylabel=f"depth [{metres}]")
    ax.set_title(f"von Mises stress in the middle [{pascals}]")
    ax.grid(visible=False)


def compare_picture(fields: xr.Dataset, at: tuple[float, float]) -> Figure:
    """Draw the difference of two contacts as a map, and both pressures across the place `at` (x, y) [m]."""
    size, pascals = display_unit_of(fields["a"], "Pa")
    width, metres = display_unit_of(fields["x"], "m")
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(1 if fields.sizes["y"] == 1 else 2, columns=2, width=4.6, height=3.4)
        if fields.sizes["y"] > 1:
            length, along = display_unit_of(fields["y"], "m")
            change = fields["difference"] / size
            largest = float(np.abs(change).max()) or 1.0
            mesh = axes[0].pcolormesh(
                fields["y"] / length, fields["x"] / width, change, cmap="RdBu_r", vmin=-largest, vmax=largest,
                shading="nearest", rasterized=True,
            )  # fmt: skip
            axes[0].set(
                xlabel=f"along [{along}]", ylabel=f"across [{metres}]", title=f"b - a [{pascals}]"
            )
            axes[0].grid(visible=False)
            figure.colorbar(mesh, ax=axes[0])
        section = fields.sel(y=at[1], method="nearest")
        x = fields["x"] / width
        axes[-1].plot(x, section["a"] / size, label="a", color="#0072B2")
        axes[-1].plot(x, section["b"] / size, label="b", color="#D55E00", linestyle="--")
        axes[-1].set(
            xlabel=f"across [{metres}]",
            ylabel=f"pressure [{pascals}]",
            title="where they differ most",
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
        width, metres = display_unit_of(contact["x"], "m")
        size, height = display_unit_of(middle, "m")
        axes[1].semilogy(contact["x"] / width, middle / size, **GAP)
        axes[1].set(
            xlabel=f"across [{metres}]", ylabel=f"film [{height}]", title="film in the middle"
        )
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
    ax.set(xlabel=f"along [{along}]", ylabel=f"across [{across}]", title="film by interference")
    ax.grid(visible=False)
