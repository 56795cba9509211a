"""What each effect costs as it is added to a scene."""

import tracemalloc
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import contactstudy as cs
from contactstudy.domain.arrays import Array
from contactstudy.domain.checks import whole
from studies.model.axis import Axis, one_of
from studies.model.case import Case, number
from studies.model.study import Plate, Point
from studies.reference.line_contact import HERTZ, SCENE, total_time
from studies.report.formatting import percent
from studies.report.style import finish, panels

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
FLATTENING = A**2 / (2 * HERTZ.radius)
WIDTH, PERIOD = 3.6, 0.9  # half-widths: square cells, a quarter as many along as across


def _with(scene: cs.Scene, shape: cs.Shape) -> cs.Scene:
    return replace(scene, shapes=(*scene.shapes, shape))


WAVY = _with(SCENE, cs.Waviness(0.05 * FLATTENING, across=0.45 * A, along=0.9 * A))
TEXTURED = _with(WAVY, cs.Texture(cs.Dimple(0.3 * FLATTENING, 0.2 * A), pitch=(0.45 * A, 0.45 * A)))
ROUGH = _with(
    TEXTURED,
    cs.Roughness(0.1 * FLATTENING, hurst=0.8, roll_off=0.225 * A, cut_off=0.06 * A, seed=1),
)
YIELDING = replace(ROUGH, hardness=2.5 * P_H)
# The greatest shear of the smooth contact lies at 0.786 a.
STRESSED = replace(YIELDING, outputs=(cs.SubsurfaceStress(depths=(0.786 * A,)),))
# Each has what those before it have, and one effect more; the smooth one is solved in both dimensions.
SCENES: dict[str, cs.Scene] = {
    "smooth, 1-D": SCENE,
    "smooth, 2-D": SCENE,
    "waviness": WAVY,
    "texture": TEXTURED,
    "roughness": ROUGH,
    "hardness": YIELDING,
    "stress": STRESSED,
}
COLOR = "#0072B2"

points = (
    Axis("effect", tuple(SCENES), "effect added last"),
    Axis("grid", (512,), "cells across the width"),
)


@dataclass(frozen=True)
class Whole:
    """A case to solve, and all that its scene asks to be found from the solution."""

    case: Case

    def prepare(self) -> cs.Problem:
        """Influence coefficients, transforms, gap."""
        return self.case.prepare()

    def run(self, prepared: cs.Problem) -> cs.Solution:
        """The solve, then the outputs."""
        solution = self.case.run(prepared)
        for output in prepared.outputs:
            output.fields(solution.pressure)
        return solution

    def record(self, result: cs.Solution) -> Mapping[str, xr.Variable]:
        """That of the case."""
        return self.case.record(result)


def scene_at(point: Point) -> Whole:
    """A line contact, exactly periodic, with all effects up to the one named."""
    effect = one_of("effect", point["effect"], SCENES)
    cells = whole("grid", point["grid"], 4, "give at least 4 cells across the width")
    along = 1 if effect == "smooth, 1-D" else cells // 4
    grid = cs.Grid(cells=(cells, along), extent=(WIDTH * A, PERIOD * A))
    return Whole(Case(SCENES[effect], grid, cs.ExactPeriodicity()))


def measures(case: Whole, result: cs.Solution) -> Mapping[str, xr.Variable]:
    """The most memory that is held at once."""
    tracemalloc.start()
    try:
        case.run(case.prepare())
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    label = {"units": "MB", "long_name": "peak memory of set-up, solve and outputs"}
    return {
        "memory": xr.Variable((), peak / 1e6, label),
        "contact_share": number(float((result.pressure > 0).mean()), "share of cells in contact"),
    }


def figure(dataset: xr.Dataset) -> tuple[Plate, ...]:
    """A bar for each scene: time, iterations, transforms and memory."""
    here = dataset.isel(grid=-1)
    names = [str(name) for name in here["effect"].values]
    place = np.arange(float(len(names)))
    plate, axes = panels(4, columns=2, width=3.6, height=0.6 + 0.32 * len(names), share="y")
    setup, solve = here["setup_time"].values, here["solve_time"].values
    axes[0].barh(place, setup, color="#E69F00", label="set-up")
    axes[0].barh(place, solve, left=setup, color=COLOR, label="solve and outputs")
    _numbers(axes[0], place, setup + solve, "{:.2g}")
    for ax, variable, form in (
        (axes[1], "memory", "{:.3g}"),
        (axes[2], "iterations", "{:.0f}"),
        (axes[3], "convolutions", "{:.0f}"),
    ):
        ax.barh(place, here[variable].values, color=COLOR)
        _numbers(ax, place, here[variable].values, form)
    for ax, label in zip(
        axes,
        ("wall time [s]", "peak memory [MB]", "iterations", "transform pairs of the solve"),
        strict=True,
    ):
        ax.set_xlabel(label)
        ax.grid(visible=False, axis="y")
    labels = [name if name.startswith("smooth") else f"+ {name}" for name in names]
    axes[0].set_yticks(place, labels)
    axes[0].invert_yaxis()
    finish(plate)
    return (Plate("effects", plate, _words(here)),)


def _numbers(ax: Axes, place: Array, values: Array, form: str) -> None:
    """Each bar's value at its end."""
    for y, value in zip(place, values, strict=True):
        ax.text(value, y, " " + form.format(value), va="center", fontsize="small")
    ax.margins(x=0.18)


def _words(dataset: xr.Dataset) -> str:
    cells = int(dataset["grid"])
    words = (
        f"What each effect costs: every scene has the effects above it and one more. {cells} x {cells // 4} "
        f"cells over {WIDTH:g} a x {PERIOD:g} a, {cells} x 1 for the first, exact periodicity, a residual of "
        "1e-8, one thread. Time and memory are those of set-up, solve and outputs together."
    )
    both = ["smooth, 1-D", "smooth, 2-D"]
    if set(both) <= set(dataset["effect"].values.tolist()):
        time = total_time(dataset).sel(effect=both).values
        words += (
            " Where nothing varies along the length, one cell along it gives the same pressure in "
            f"{percent(time[0] / time[1])} of the time. Heights add up in one field, so that no shape asks "
            "for more memory or longer transforms: what it costs is iterations. Stress adds none of these, "
            "but coefficients and transforms of its own, "
            "one for each of six components at each depth (here one)."
        )
    return words
