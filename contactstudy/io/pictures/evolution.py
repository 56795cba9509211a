"""The picture of a contact that changed in time: profiles, a map over time, numbers against time."""

from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from contactstudy.io.pictures.contact import FILMS, LENGTHS, PRESSURES, scaled
from contactstudy.io.pictures.figure import SETTINGS, panels

# Profiles are drawn of so many instants.
PROFILES = 6
# A film is drawn up to so many of Hertz's half-widths from the axis.
FILM_WIDTH = 1.5


def evolution_picture(evolved: xr.Dataset) -> Figure:
    """Draw a march as ``Evolution.to_dataset`` labels it: profiles, a map over time, numbers and errors."""
    worn = "worn_depth" in evolved
    drawn = [_profiles, _map, _numbers, _errors] + [_worn] * worn
    if "residual_displacement" in evolved:
        bodies = [
            str(variable) for variable in evolved if str(variable).startswith("equivalent_plastic")
        ]
        drawn += [_dent, *(partial(_plastic, name=name) for name in bodies)]
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(len(drawn), columns=2, width=4.6, height=3.4)
        for draw, ax in zip(drawn, axes, strict=True):
            draw(ax, evolved)
    return figure


def film_evolution_picture(evolved: xr.Dataset) -> Figure:
    """Draw a march of a film: profiles of pressure and film, the film over time and width, and numbers against time."""
    with mpl.rc_context(SETTINGS):
        figure, axes = panels(4, columns=2, width=4.6, height=3.4)
        reach = FILM_WIDTH * float(evolved["hertz_half_width"][0])
        inside = evolved.sel(x=slice(-reach, reach))
        film = scaled(inside["film"].mean(), FILMS)
        _profiles(axes[0], inside)
        _lines(axes[1], inside, "film", film)
        axes[1].set_yscale("log")
        middle = inside["film"].isel(y=inside.sizes["y"] // 2)
        length, metres = scaled(inside["x"], LENGTHS)
        mesh = axes[2].pcolormesh(
            inside["time"], inside["x"] / length, middle.T / film[0],
            cmap="viridis", shading="nearest", norm="log", rasterized=True,
        )  # fmt: skip
        axes[2].set(
            xlabel="time [s]", ylabel=f"across [{metres}]", title=f"film in the middle [{film[1]}]"
        )
        figure.colorbar(mesh, ax=axes[2])
        for name, color in (("central_film", "#0072B2"), ("minimum_film", "#D55E00")):
            label = evolved[name].attrs["long_name"]
            axes[3].plot(evolved["time"], evolved[name] / film[0], color=color, label=label)
        axes[3].set(xlabel="time [s]", ylabel=f"film [{film[1]}]")
        axes[3].legend()
    return figure


def _lines(ax: Axes, evolved: xr.Dataset, name: str, scale: tuple[float, str]) -> None:
    """Draw a variable across the middle of the length at some instants, later ones brighter."""
    middle = evolved[name].isel(y=evolved.sizes["y"] // 2)
    length, metres = scaled(evolved["x"], LENGTHS)
    chosen = np.unique(np.linspace(0, evolved.sizes["time"] - 1, PROFILES).round().astype(int))
    colors: Any = mpl.colormaps["viridis"](np.linspace(0, 0.9, len(chosen)))
    for number, color in zip(chosen, colors, strict=True):
        instant = middle.isel(time=number)
        label = f"{float(instant['time']):.3g} s"
        ax.plot(evolved["x"] / length, instant / scale[0], color=color, label=label)
    ax.set(xlabel=f"across [{metres}]", ylabel=f"{evolved[name].attrs['long_name']} [{scale[1]}]")
    ax.legend()


def _profiles(ax: Axes, evolved: xr.Dataset) -> None:
    _lines(ax, evolved, "pressure", scaled(evolved["pressure"], PRESSURES))


def _worn(ax: Axes, evolved: xr.Dataset) -> None:
    _lines(ax, evolved, "worn_depth", scaled(evolved["worn_depth"], LENGTHS))


def _dent(ax: Axes, evolved: xr.Dataset) -> None:
    name = "residual_displacement"
    _lines(ax, evolved, name, scaled(abs(evolved[name]), LENGTHS))


def _plastic(ax: Axes, evolved: xr.Dataset, name: str) -> None:
    """Draw the equivalent plastic strain below the middle of the length at the last instant."""
    strain = evolved[name].isel(time=-1, y=evolved.sizes["y"] // 2)
    depth = next(str(dimension) for dimension in strain.dims if str(dimension).startswith("z"))
    length, metres = scaled(evolved["x"], LENGTHS)
    across, down = evolved["x"] / length, evolved[depth] / length
    mesh = ax.pcolormesh(
        across, down, strain * 100, cmap="viridis", shading="nearest", rasterized=True
    )
    ax.set(
        xlabel=f"across [{metres}]",
        ylabel=f"depth [{metres}]",
        title=f"{strain.attrs['long_name']} at the end [%]",
        aspect="equal",
    )
    ax.invert_yaxis()
    ax.figure.colorbar(mesh, ax=ax)


def _map(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw the mean pressure along the length over time and width."""
    pressure = evolved["pressure"].mean("y")
    size, pascals = scaled(pressure, PRESSURES)
    length, metres = scaled(evolved["x"], LENGTHS)
    # an instant given twice is a jump: the map has room for one
    time = evolved["time"].values
    distinct = np.append(np.diff(time) > 0, [True])
    mesh = ax.pcolormesh(
        time[distinct],
        evolved["x"] / length,
        (pressure / size).values[distinct].T,
        cmap="viridis",
        shading="nearest" if distinct.sum() > 1 else "auto",
        rasterized=True,
    )
    ax.set(xlabel="time [s]", ylabel=f"across [{metres}]", title=f"mean pressure [{pascals}]")
    ax.figure.colorbar(mesh, ax=ax)


def _numbers(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw load, peak pressure and contact area over their largest values."""
    for name, color in (
        ("load", "#595959"),
        ("peak_pressure", "#0072B2"),
        ("contact_area", "#009E73"),
    ):
        values = evolved[name]
        largest = float(values.max()) or 1.0
        units = values.attrs["units"]
        label = f"{values.attrs['long_name']} over {largest:.3g} {units}"
        ax.plot(evolved["time"], values / largest, color=color, label=label)
    ax.set(xlabel="time [s]", ylabel="over the largest value")
    ax.set_ylim(bottom=0)
    ax.legend()


def _errors(ax: Axes, evolved: xr.Dataset) -> None:
    """Draw the errors by the steps and by the cells, where they are known and not zero."""
    for name, color in (("step_error", "#D55E00"), ("grid_error", "#0072B2")):
        values = evolved[name].values
        shown = np.isfinite(values) & (values > 0)
        if shown.any():
            label = evolved[name].attrs["long_name"]
            ax.semilogy(
                evolved["time"].values[shown], values[shown], ".-", color=color, label=label
            )
    ax.set(xlabel="time [s]", ylabel="relative error")
    if ax.get_legend_handles_labels()[0]:
        ax.legend()
