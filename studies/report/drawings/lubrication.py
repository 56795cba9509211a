"""Drawing of the study `lubrication`: films over load and viscosity, and what they cost."""

from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.analytic import moes_film
from studies.model.drawing import CaptionedFigure, Finding
from studies.report.style import (
    COLORS,
    LAW_STYLE,
    by_color,
    captioned,
    panels,
    percent,
    select_evenly,
)


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw films beside the formula of Moes, error against cost, and what roughness and cavitation do where varied."""
    one_law = dataset.isel(cavitation=0)
    drawn = [_films(one_law.isel(rms=0, grid=-1))]
    if dataset.sizes["grid"] > 1:
        drawn.append(_cost(one_law.isel(rms=0)))
    if dataset.sizes["rms"] > 1:
        drawn.append(_roughness(one_law.isel(grid=-1)))
    if dataset.sizes["cavitation"] > 1:
        drawn.append(_cavitation(dataset.isel(grid=-1)))
    return tuple(drawn)


def _films(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (films, ratio) = panels(2, width=3.8, height=3.0)
    shown = dataset.sel(viscosity=select_evenly(dataset["viscosity"].values, 5))
    for part, style in by_color(shown, "viscosity", "L = {:g}"):
        films.plot(part["load"], part["film_at_zero_gradient"], linestyle="none", **style)
        formula = [moes_film(load, float(part["viscosity"])) for load in part["load"].values]
        films.plot(part["load"], formula, **LAW_STYLE | {"color": style["color"]})
        ratio.plot(part["load"], part["film_over_moes"], color=style["color"], marker="o")
    films.set(xscale="log", yscale="log", xlabel="load parameter M", ylabel="film, Moes' unit")
    ratio.axhline(1, **LAW_STYLE)
    ratio.set(xscale="log", xlabel="load parameter M", ylabel="film / Moes")
    return captioned(
        "films",
        fig,
        "Film at dp/dx = 0 over the load parameter M, for lubricant parameters L, on the finest grid: points are "
        "solutions, lines the formula of Moes, which was fitted to such solutions within some 5 %. At few cells and "
        "heavy load the inlet is not resolved.",
    )


def _cost(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (ax,) = panels(1, width=4.4, height=3.2)
    coarser = dataset.isel(grid=slice(None, -1))
    error = abs(coarser["central_film"] / dataset["central_film"].isel(grid=-1) - 1)
    for part, style in by_color(coarser.assign(error=error), "grid", "{} cells"):
        time = part["wall_time"].values.ravel()
        ax.plot(time, part["error"].values.ravel(), linestyle="none", alpha=0.6, **style)
    ax.set(xscale="log", yscale="log", xlabel="wall time [s]", ylabel="error of the central film")
    return captioned(
        "film_cost",
        fig,
        "Error of the central film against the wall time of a cold start, a point for each load and viscosity; the "
        f"error is the difference from {int(dataset['grid'].values[-1])} cells.",
    )


def _roughness(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (film, thin) = panels(2, width=3.8, height=3.0)
    cases = select_evenly(product(dataset["load"].values, dataset["viscosity"].values), len(COLORS))
    for (load, viscosity), color in zip(cases, COLORS, strict=False):
        part = dataset.sel(load=load, viscosity=viscosity)
        style: dict[str, Any] = {"color": color, "marker": "o"}
        label = f"M = {load:g}, L = {viscosity:g}"
        smallest = part["minimum_film"] / part["central_film"].isel(rms=0)
        film.plot(part["rms"], smallest, label=label, **style)
        thin.plot(part["rms"], part["thin_load"], **style)
    film.set(xlabel="rms height / film", ylabel="smallest film / smooth central film")
    thin.set(xlabel="rms height / film", ylabel="load on less than half the film")
    return captioned(
        "rough_films",
        fig,
        "Effect of a stationary random roughness on the smallest film and on the fraction of the load that is carried "
        "by less than half of Moes' film.",
    )


def _cavitation(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (spread, film) = panels(2, width=3.8, height=3.0)
    smooth = dataset["central_film"].isel(rms=0, cavitation=0)
    for (part, style), marker in zip(by_color(dataset, "cavitation", "{}"), "os", strict=False):
        style["marker"] = marker
        spread.semilogy(part["rms"], part["flux_spread"].max(["load", "viscosity"]), **style)
        film.plot(part["rms"], (part["central_film"] / smooth).mean(["load", "viscosity"]), **style)
    spread.set(xlabel="rms height / film", ylabel="spread of the flow over x")
    film.set(xlabel="rms height / film", ylabel="central film / smooth film")
    return captioned(
        "cavitation",
        fig,
        "Lubricant that cavitation makes: the range of the flow through all sections up to the end of the pressure, "
        "over its mean, largest over load and viscosity; and the central film, mean over them. A film that only "
        "forbids negative pressure (reynolds) makes lubricant wherever it forms again behind a cavity.",
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return how many operating points converged, and how far films are from the formula of Moes."""
    if 0.0 not in dataset["rms"].values:
        return ()
    smooth = dataset.sel(rms=0.0).isel(cavitation=0)
    total, converged = smooth["converged"].size, int(smooth["converged"].sum())
    fine = smooth.isel(grid=-1)
    ratio = abs(fine["film_over_moes"] - 1).where(fine["resolved"] == 1)
    if not bool(np.isfinite(ratio).any()):
        return ()
    claim = "Smooth films converge from a cold start at every load and viscosity."
    if converged < total:
        claim = f"{total - converged} of {total} films do not converge from a cold start."
    return (
        Finding(
            claim,
            f"{converged} of {total} solutions converged, with {int(smooth['iterations'].max())} steps on the finest "
            f"grid at the most and {int(smooth['iterations'].median())} in the median; the flow varies by "
            f"{float(smooth['flux_spread'].max()):.0e} of itself at the most. Where the cells resolve it, the film is "
            f"within {percent(ratio.max())} of the formula of Moes, and within {percent(ratio.median())} in the "
            f"median.",
            "How thick is the film?",
        ),
    )
