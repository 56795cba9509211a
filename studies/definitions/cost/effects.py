"""What each effect costs as it is added to a scene."""

import tracemalloc
from collections.abc import Mapping
from dataclasses import dataclass, replace

import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole
from studies.model.axis import Axis, one_of
from studies.model.case import Case, number
from studies.model.study import Point
from studies.reference.line_contact import FLATTENING, HERTZ, SCENE

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
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

points = (
    Axis("effect", tuple(SCENES), "effect added last"),
    Axis("grid", (512,), "cells across the width"),
)


@dataclass(frozen=True)
class SolveWithOutputs:
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


def scene_at(point: Point) -> SolveWithOutputs:
    """A line contact, exactly periodic, with all effects up to the one named."""
    effect = one_of("effect", point["effect"], SCENES)
    cells = whole("grid", point["grid"], 4, "give at least 4 cells across the width")
    along = 1 if effect == "smooth, 1-D" else cells // 4
    grid = cs.Grid(cells=(cells, along), extent=(WIDTH * A, PERIOD * A))
    return SolveWithOutputs(Case(SCENES[effect], grid, cs.ExactPeriodicity()))


def measures(case: SolveWithOutputs, result: cs.Solution) -> Mapping[str, xr.Variable]:
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
