"""Cost of each effect as it is added to a scene."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole
from contactstudy.evolution.evolution import Trajectory
from contactstudy.problem.problem import Sheared
from contactstudy.scene.coated import CoatedHalfSpace
from contactstudy.scene.friction import Sliding
from studies.definitions.solvers import peak_bytes
from studies.model.axis import Axis, one_of
from studies.model.case import Case, Computation, EvolutionCase, contact_fraction
from studies.model.study import Point
from studies.reference.line_contact import FLATTENING, HERTZ, SCENE, STEEL

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
WIDTH, PERIOD = 3.6, 0.9  # half-widths: square cells, a quarter as many along as across


def _with(scene: cs.Scene, shape: cs.Shape) -> cs.Scene:
    """Return a scene with a further shape."""
    return replace(scene, shapes=(*scene.shapes, shape))


WAVY = _with(SCENE, cs.Waviness(0.05 * FLATTENING, across=0.45 * A, along=0.9 * A))
TEXTURED = _with(WAVY, cs.Texture(cs.Dimple(0.3 * FLATTENING, 0.2 * A), pitch=(0.45 * A, 0.45 * A)))
ROUGH = _with(
    TEXTURED,
    cs.Roughness(0.1 * FLATTENING, hurst=0.8, roll_off=0.225 * A, cut_off=0.06 * A, seed=1),
)
COATED = replace(
    ROUGH,
    solids=(
        CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 0.03 * A, STEEL),
        STEEL,
    ),
)
YIELDING = replace(COATED, hardness=2.5 * P_H)
# The greatest shear of the smooth contact lies at 0.786 a; in the body without a coating.
STRESSED = replace(YIELDING, outputs=(cs.SubsurfaceStress(depths=(0.786 * A,), solid=1),))
# How a coated body couples shear and pressure is not known.
SLIDING = replace(STRESSED, solids=ROUGH.solids, friction=Sliding(0.1))
# Each has what those before it have, and one effect more, but the one that slides has no coating; the
# smooth one is solved in both dimensions.
SCENES: dict[str, cs.Scene] = {
    "smooth, 1-D": SCENE,
    "smooth, 2-D": SCENE,
    "waviness": WAVY,
    "texture": TEXTURED,
    "roughness": ROUGH,
    "coating": COATED,
    "hardness": YIELDING,
    "stress": STRESSED,
    "sliding, no coating": SLIDING,
}

# Effects in time, each alone on the wavy cylinder: a sudden load and one step after it.
RUBBER = cs.ViscoelasticHalfSpace(0.4 * 210e9, 0.3, ((0.6 * 210e9, 1.0),))
IN_TIME: dict[str, cs.Scene] = {
    "one step of creep": replace(WAVY, solids=(RUBBER, RUBBER)),
    "one step of wear": replace(WAVY, wear=cs.Wear(0.01 * A / SCENE.contact_modulus, 1.0)),
}

# Alone on the smooth cylinder, in plane strain: layers as thin as cells are wide need far more memory
# than the contact, so that a part of the cells across has to do.
YIELD, COARSER = "two steps of yield, 1-D", 4
BODY = cs.ElasticPlasticHalfSpace(210e9, 0.3, yield_stress=0.4 * P_H, hardening_modulus=4.2e9)
LOADED = cs.LoadHistory((0, 1, 2), (0, SCENE.load.largest / 2, SCENE.load.largest))

points = (
    Axis("effect", (*SCENES, *IN_TIME, YIELD), "effect added last"),
    Axis("grid", (512,), "cells across the width"),
)


@dataclass(frozen=True)
class SolveWithOutputs(Case):
    """A case that is solved with all outputs of its scene."""

    def run(self, prepared: cs.Problem) -> cs.Contact:
        """Solve, then compute the outputs; return the solution."""
        solution = super().run(prepared)
        for output in prepared.outputs:
            if solution.traction is not None and isinstance(output, Sheared):
                output = output.under(solution.shear)
            output.fields(solution.pressure)
        return solution


@dataclass(frozen=True)
class LastStep(EvolutionCase):
    """An evolution whose last step alone is recorded."""

    def record(self, result: Trajectory) -> Mapping[str, xr.Variable]:
        """Return the solver's numbers of the last step."""
        return super().record(replace(result, frames=result.frames[-1:]))


def scene_at(point: Point) -> SolveWithOutputs | EvolutionCase:
    """Return a line contact, exactly periodic, with all effects up to the one named, or steps of one in time."""
    effect = one_of("effect", point["effect"], (*SCENES, *IN_TIME, YIELD))
    cells = whole("grid", point["grid"], 4, "give at least 4 cells across the width")
    if effect == YIELD:
        scene = replace(SCENE, load=LOADED, solids=(BODY, STEEL))
        coarse = cs.Grid(cells=(max(cells // COARSER, 2), 1), extent=(WIDTH * A, PERIOD * A))
        return EvolutionCase(scene, coarse, cs.ExactPeriodicity(), (1.0, 2.0), step_error="NONE")
    along = 1 if effect == "smooth, 1-D" else cells // 4
    grid = cs.Grid(cells=(cells, along), extent=(WIDTH * A, PERIOD * A))
    if effect in IN_TIME:
        return LastStep(IN_TIME[effect], grid, cs.ExactPeriodicity(), (0.0, 0.2), step_error="NONE")
    return SolveWithOutputs(SCENES[effect], grid, cs.ExactPeriodicity())


def measures(case: Computation, result: cs.Contact | Trajectory) -> Mapping[str, xr.Variable]:
    """Return the peak memory and the fraction in contact."""
    peak = peak_bytes(lambda: case.run(case.prepare()))
    pressure = result.pressure if isinstance(result, cs.Contact) else result.frames[-1].pressure
    label = {"units": "MB", "long_name": "peak memory of set-up, solve and outputs"}
    return {
        "memory": xr.Variable((), peak / 1e6, label),
        "contact_fraction": contact_fraction(pressure),
    }
