"""The picture of a contact that changed in time: profiles, a map over time, numbers against time."""

from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactstudy.domain.units import display_unit_of, readable
from contactstudy.io.pictures.figure import (
    BLUE,
    GREEN,
    LAW_STYLE,
    RED,
    SETTINGS,
    draw_map,
    finish,
    in_display_unit,
    in_the_middle,
    name_axes,
    panels,
)

# Number of instants whose profiles are drawn.
PROFILES = 6
# Decades that a logarithmic axis of errors has at the most.
DECADES = 6
BESIDE: Any = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
# Half-width of a picture of a film in Hertz's half-widths.
FILM_WIDTH = 1.5
# Variables of each body that yields, before the suffix of the body.
STRAIN, STRESS, DENT = "equivalent_plastic_strain", "residual_stress", "residual_displacement"


def evolution_picture(evolved: xr.Dataset) -> Figure:
    """Draw an evolution as ``Evolution.to_dataset`` labels it: profiles, a map over time, numbers and errors."""
    drawn: list[Any] = [
        partial(_lines, name="pressure"),
        _map,
        _numbers,
        _loop if "attraction" in evolved else _errors,
        *(partial(_lines, name=name) for name in ("wear_depth", "shear_x") if name in evolved),
    ]
    if dents := [str(name) for name in evolved if str(name).startswith(DENT)]:
        bodies = [
            str(name).removeprefix(STRAIN)
            for name in evolved
            if str(name).startswith(STRAIN) and evolved[name].values.any()
        ]
        drawn += [partial(_dent, name=name) for name in dents]
        for body in bodies:
            drawn += [partial(_plastic, name=STRAIN + body)]
            drawn += [partial(_residual, name=STRESS + body)] * (STRESS + body in evolved)
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(drawn), columns=2, width=5.4, height=3.4)
        for draw, ax in zip(drawn, axes, strict=True):
            draw(ax, evolved)
        return finish(figure, evolved)


def film_evolution_picture(evolved: xr.Dataset) -> Figure:
    """Draw a film in time: profiles of pressure and film, the film over time and width, and numbers against time."""
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(4, columns=2, width=5.4, height=3.4)
        reach = FILM_WIDTH * float(evolved["hertz_half_width"][0])
        inside = evolved.sel(x=slice(-reach, reach))
        film = display_unit_of(inside["film"].mean(), "m")
        _lines(axes[0], inside, "pressure")
        _lines(axes[1], inside, "film", film)
        axes[1].set_yscale("log")
        middle = in_the_middle(inside["film"])
        x, across = in_display_unit(inside["x"], "m", "across")
        names = "time [s]", across, f"film in the middle [{film[1]}]"
        draw_map(axes[2], inside["time"], x, middle.T / film[0], names, norm="log")
        axes[2].set_xlim(*inside["time"].values[[0, -1]])
        for name, color in (("central_film", BLUE), ("minimum_film", RED)):
            label = evolved[name].attrs["long_name"]
            axes[3].plot(evolved["time"], evolved[name] / film[0], color=color, label=label)
        axes[3].set(xlabel="time [s]", ylabel=f"film [{film[1]}]")
        return finish(figure, evolved)


def passes_picture(rolled: xr.Dataset) -> Figure:
    """Draw residual stress and plastic strain against depth after some passes, the first dark, the last bright."""
    chosen = np.unique(np.linspace(0, rolled.sizes["pass_number"] - 1, PROFILES).round().astype(int))
    colors: Any = mpl.colormaps["viridis"](np.linspace(0, 0.9, len(chosen)))
    depth, down = in_display_unit(rolled["z"], "m", "depth")
    factor, pressure_unit = display_unit_of(abs(rolled["residual_stress"]), "Pa")
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(2, columns=2, width=4.6, height=3.4)
        for number, color in zip(chosen, colors, strict=True):
            after = rolled.isel(pass_number=number)
            label = f"pass {int(after['pass_number'])}"
            stress = after["residual_stress"].sel(component="xx") / factor
            axes[0].plot(stress, depth, color=color, label=label)
            strain = after["equivalent_plastic_strain"] * 100
            axes[1].plot(strain, depth, color=color)
        axes[0].set(xlabel=f"residual stress in the rolling direction [{pressure_unit}]")
        axes[1].set(xlabel="equivalent plastic strain [%]")
        for ax in axes:
            ax.set(ylabel=down)
            ax.invert_yaxis()
        return finish(figure, rolled)


def _lines(ax: Axes, evolved: xr.Dataset, name: str, scale: tuple[float, str] | None = None) -> None:
    """Draw a variable across the middle of the length at some instants, the first dark, the last bright.

    The `scale` is the value of one unit and its name; None chooses it.
    """
    scale = scale or display_unit_of(abs(evolved[name]), evolved[name].attrs["units"])
    middle = in_the_middle(evolved[name])
    x, across = in_display_unit(evolved["x"], "m", "across")
    chosen = _instants(middle.values)
    colors: Any = mpl.colormaps["viridis"](np.linspace(0, 0.9, len(chosen)))
    for number, color in zip(chosen, colors, strict=True):
        instant = middle.isel(time=number)
        label = f"{float(instant['time']):.3g} s"
        ax.plot(x, instant / scale[0], color=color, label=label)
    label = evolved[name].attrs["long_name"]
    ax.set(xlabel=across, ylabel=f"{label} [{scale[1]}]")
    ax.legend(**BESIDE)


def _instants(values: Any) -> list[int]:
    """Return the numbers of the instants to draw of values (time, x), evenly spaced without those that are all zero."""
    drawn = np.flatnonzero(values.any(axis=1))
    if not len(drawn):
        return [len(values) - 1]
    return sorted(set(drawn[np.linspace(0, len(drawn) - 1, PROFILES).round().astype(int)].tolist()))


def _dent(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    _lines(ax, evolved, name)
    ax.set_ylabel(f"{ax.get_ylabel()}, into the bodies")
    ax.invert_yaxis()


def _plastic(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the equivalent plastic strain below the middle of the length at the last instant."""
    strain = in_the_middle(evolved[name]).isel(time=-1)
    depth = next(str(dimension) for dimension in strain.dims if str(dimension).startswith("z"))
    scale, unit = display_unit_of(evolved["x"], "m")
    x, z = evolved["x"] / scale, evolved[depth] / scale
    title = f"{strain.attrs['long_name']} at the end [%]"
    draw_map(ax, x, z, strain * 100, (f"across [{unit}]", f"depth [{unit}]", title))
    ax.set_aspect("equal")
    ax.invert_yaxis()


def _residual(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the residual stress below the middle of the contact against the depth, at the last instant."""
    stress = in_the_middle(evolved[name]).isel(time=-1, x=evolved.sizes["x"] // 2)
    depth = next(str(dimension) for dimension in stress.dims if str(dimension).startswith("z"))
    length, length_unit = display_unit_of(evolved["x"], "m")
    factor, pressure_unit = display_unit_of(abs(stress), "Pa")
    for component, direction, color in (("xx", "across", BLUE), ("yy", "along", GREEN), ("zz", "in depth", RED)):
        values = stress.sel(component=component) / factor
        ax.plot(values, evolved[depth] / length, color=color, label=direction)
    of = str(evolved[STRAIN + name.removeprefix(STRESS)].attrs["long_name"]).partition(" of ")[2]
    name_axes(
        ax,
        f"residual stress below the middle, tension positive [{pressure_unit}]",
        f"depth [{length_unit}]",
        f"residual stress{of and f' of {of}'} at the end",
    )
    ax.invert_yaxis()
    ax.legend(**BESIDE)


def _map(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw the mean pressure along the length over time and width."""
    pressure, title = in_display_unit(evolved["pressure"].mean("y"), "Pa", "mean pressure")
    x, across = in_display_unit(evolved["x"], "m", "across")
    # an instant given twice is a jump: the map has room for one
    time = evolved["time"].values
    distinct = np.append(np.diff(time) > 0, [True])
    shading = "nearest" if distinct.sum() > 1 else "auto"
    values, names = pressure.values[distinct].T, ("time [s]", across, title)
    draw_map(ax, time[distinct], x, values, names, shading=shading)
    if distinct.sum() > 1:
        ax.set_xlim(time[0], time[-1])


def _numbers(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw load, peak pressure and contact area over their largest values."""
    for name, color in (("load", "#595959"), ("peak_pressure", BLUE), ("contact_area", GREEN)):
        values = evolved[name]
        largest = float(values.max()) or 1.0
        label = f"{values.attrs['long_name']} over {readable(largest, values.attrs['units'], 3)}"
        ax.plot(evolved["time"], values / largest, color=color, label=label)
    ax.set(xlabel="time [s]", ylabel="relative to the maximum")
    ax.set_ylim(bottom=min(0.0, float(evolved["load"].min() / (evolved["load"].max() or 1.0))))
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))


def _loop(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw the load against the approach, where the bodies touch: a loop of approach and separation."""
    touching = (evolved["pressure"] > 0).any(("x", "y"))
    approach, across = in_display_unit(evolved["approach"].where(touching), "m", "approach")
    ax.plot(approach, evolved["load"].where(touching), ".-", color=BLUE)
    ax.axhline(0.0, **LAW_STYLE)
    name_axes(ax, across, "load [N/m]", "approach and separation")


def _errors(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw the time-discretisation and the discretisation error, where they are known and not zero."""
    for name, color in (("time_discretisation_error", RED), ("grid_error", BLUE)):
        values = evolved[name].values
        shown = np.isfinite(values) & (values > 0)
        if shown.any():
            label = evolved[name].attrs["long_name"]
            time = evolved["time"].values[shown]
            ax.semilogy(time, values[shown], ".-", color=color, label=label)
    ax.set(xlabel="time [s]", ylabel="relative error")
    if ax.get_legend_handles_labels()[0]:
        ax.set_ylim(bottom=max(ax.get_ylim()[0], ax.get_ylim()[1] * 10.0**-DECADES))
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2))
