"""A cylinder pressed into a yielding half-space and unloaded, beside known contacts and a hardness."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, pi

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.discretisation.contact_edge import half_widths
from contactstudy.domain.checks import non_negative, positive, whole_number
from contactstudy.domain.fields import Array
from studies.model.axis import Axis
from studies.model.case import SceneCase, TimedAnswer, dimensionless_variables
from studies.model.study import Point

# Hertz's half-width and the yield stress are 1.
MODULUS, POISSON = 1000.0, 0.3
STRAIN = 1 / MODULUS
PLANE = MODULUS / (1 - POISSON**2)
RIGID = cs.HalfSpace(inf, 0.3)
# Half-widths; the dent is measured against the surface at DATUM.
WIDTH, DATUM = 6.4, 3.0
# Mean pressure over the yield stress of an indentation in a fully plastic body. Source: Tabor (1951), ch. 4.
HARDNESS_OVER_YIELD = 2.8

# p_H = 3 Y, hardening modulus 0.1 E, nu = 0.3, in many steps and on fine cells; finite elements agree to 0.3 %.
PRESSURE, HARDENING = 3.0, 0.1
REFERENCE = {
    "peak_pressure": 0.7872,
    "half_width": 1.150,
    "dent": 1.205,
    "plastic_depth": 2.54,
    "plastic_strain": 1.012,
}

axes = (
    Axis("pressure", (2.0, 3.0, 4.0), "Hertz's peak pressure over the yield stress"),
    Axis("hardening", (HARDENING,), "isotropic hardening modulus over Young's modulus"),
    Axis("steps", (2, 8), "steps up to the largest load"),
    Axis("grid", (24, 48), "cells across the width"),
)

# not timed: the cost is counted in solves
times = "none"


def case_at(point: Point) -> SceneCase:
    """Return an evolution that loads in equal steps and unloads in one step."""
    peak = positive("pressure", point["pressure"], "give a peak pressure above 0 yield stresses")
    hardening = non_negative("hardening", point["hardening"], "must be at least 0")
    steps = whole_number("steps", point["steps"], 2, "give at least 2 steps")
    cells = whole_number("grid", point["grid"], 16, "give at least 16 cells across the width")
    body = cs.ElasticPlasticHalfSpace(MODULUS, POISSON, 1.0, hardening * MODULUS)
    scene = cs.Scene(
        cs.LoadHistory(times=(0, 1, 2), per_length=(0, pi * peak / 2, 0)),
        (body, RIGID),
        (cs.Cylinder(PLANE / (2 * peak)),),
    )
    times = (*np.linspace(0, 1, steps + 1)[1:].tolist(), 2.0)
    grid = cs.Grid((cells, 1), (WIDTH, 1.0))
    steps_in_load = cs.TimeSteps(times, error_estimator=cs.ErrorEstimator.NONE)
    return SceneCase(scene, grid, cs.ExactPeriodicity(), time_steps=steps_in_load)


def measures(case: SceneCase, result: TimedAnswer) -> Mapping[str, xr.Variable]:
    """Return the contact under the largest load and the remaining dent, and both with a hardness in place of yield."""
    peak = case.scene.largest_load * 2 / pi
    x = case.grid.x
    loaded, last = result.trajectory.frames[-2:]
    equivalent_strain = last.coupled_state["equivalent0"]
    yielded = np.flatnonzero((equivalent_strain > 0).any(axis=(1, 2)))
    deepest = float(last.coupled_state["edges0"][yielded[-1] + 1]) if yielded.size else 0.0
    largest_strain = float(equivalent_strain.max()) / STRAIN
    surface = last.fields["residual_displacement"].values[:, 0]
    middle, far = np.interp((0.0, DATUM), x, surface)
    answers = {
        "peak_pressure": (loaded.peak_pressure / peak, "peak pressure over Hertz's"),
        "half_width": (_half_width(loaded.pressure, x), "half-width over Hertz's"),
        "dent": ((middle - far) / STRAIN, f"dent below the surface at {DATUM:g} a over a Y / E"),
        "plastic_depth": (deepest, "depth of the plastic zone over Hertz's half-width"),
        "plastic_strain": (largest_strain, "largest equivalent plastic strain over Y / E"),
    }
    body = case.scene.solids[0]
    hardening = getattr(body, "hardening_modulus", 0.0) / MODULUS
    has_reference = abs(peak - PRESSURE) < 1e-9 and abs(hardening - HARDENING) < 1e-9
    errors = {
        f"{name}_error": (abs(value / REFERENCE[name] - 1), f"relative error of {name} where known")
        for name, (value, _) in answers.items()
        if has_reference
    }
    limited = _hardness_limited(case)
    difference = np.abs(limited.pressure - loaded.pressure).sum() / loaded.pressure.sum()
    dent = float(limited.dent.max()) / STRAIN
    capped = {
        "pressure": (limited.pressure.max() / peak, "peak pressure over Hertz's"),
        "half_width": (_half_width(limited.pressure, x), "half-width over Hertz's"),
        "dent": (dent, "largest depth of yielding over a Y / E"),
        "difference": (difference, "relative L1 difference from the elastoplastic pressure"),
    }
    cap = {
        f"hardness_limited_{name}": (value, f"hardness-limited elastic contact: {what}")
        for name, (value, what) in capped.items()
    }
    layers = len(last.coupled_state["edges0"]) - 1, "layers of the volume that may yield"
    return dimensionless_variables(answers | errors | cap | {"layers": layers})


def _hardness_limited(case: SceneCase) -> cs.Solution:
    """Solve an elastic contact of the same largest load, with a hardness."""
    scene = replace(
        case.scene,
        load=cs.LineLoad(case.scene.largest_load),
        solids=(cs.HalfSpace(MODULUS, POISSON), RIGID),
        hardness=HARDNESS_OVER_YIELD,
    )
    return cs.solve(scene.problem(case.grid, case.padding))


def _half_width(pressure: Array, x: Array) -> float:
    """Return the half-width of the contact."""
    return float(half_widths(pressure, x)[0])
