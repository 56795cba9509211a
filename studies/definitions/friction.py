"""Friction: stress under a sliding contact, the stick zone, and the error of a superposition."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import finite, whole_number
from contactstudy.domain.fields import Array
from contactstudy.scene.friction.partial_slip import PartialSlip
from contactstudy.scene.solids.stress_model import HalfSpaceStress
from contactstudy.scene.stress import SubsurfaceStressOperator, von_mises
from contactstudy.solvers.friction.laws import CiavarellaJaeger
from studies.model.axis import Axis
from studies.model.case import Case, dimensionless
from studies.model.study import Point
from studies.reference.line_contact import HERTZ, P_H, SCENE, STEEL, A

COEFFICIENTS = (0.0, 0.1, 0.2, 0.25, 0.3, 0.4)
# over the half-width
DEPTHS = (1e-6, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8, 0.9)
FRACTIONS = (0.1, 0.3, 0.5, 0.7, 0.9)
MU = 0.3

axes = (
    Axis("poisson_ratio", (0.0, 0.15, 0.3, 0.45), "Poisson's ratio of both bodies"),
    Axis("grid", (401,), "cells across the line contact"),
    Axis("rough_grid", (48,), "cells along each axis of the rough contact and the sphere"),
)


@dataclass(frozen=True)
class Rough(Case):
    """A line contact, with the number of cells of the rough contact that is solved beside it."""

    cells_rough: int = 48


def case_at(point: Point) -> Rough:
    """Return the paper's line contact between bodies of this Poisson's ratio, whose contact modulus is that of steel."""
    ratio = finite("poisson_ratio", point["poisson_ratio"], "give a ratio from 0 to 0.5")
    cells = whole_number("grid", point["grid"], 32, "give at least 32 cells across the width")
    whole_number("rough_grid", point["rough_grid"], 16, "give at least 16 cells along each axis")
    modulus = (1 - ratio**2) / STEEL.compliance
    solid = cs.HalfSpace(modulus, ratio)
    scene = replace(SCENE, solids=(solid, solid))
    grid = cs.Grid((cells, 1), (2.6 * A, A))
    # the rough grid is part of the case, so that it is recomputed where that changes
    return Rough(scene, grid, cs.ExactPeriodicity(), cells_rough=int(point["rough_grid"]))


def measures(case: Rough, solution: cs.Solution) -> Mapping[str, xr.Variable]:
    """Return von Mises' stress over the coefficient, stick zones over the force, and the error of a superposition."""
    highest, depth = _stress(case, solution.pressure)
    hertz = case.scene.hertz
    assert hertz is not None
    stick, stick_sphere = [], []
    for fraction in FRACTIONS:
        slip = PartialSlip(MU, fraction * MU * case.scene.largest_load)
        slipping = replace(case, scene=replace(case.scene, friction=slip))
        stick_width = cs.solve(slipping.prepare()).stick.sum() * case.grid.cell_size[0] / 2
        stick.append(float(stick_width) / hertz.half_width)
        stick_sphere.append(_sphere(case, fraction))
    error, across = _superposition(case)
    over_coefficient = {
        "coefficient": (COEFFICIENTS, "coefficient of friction"),
        "von_mises": (highest, "highest von Mises stress over Hertz peak pressure p_H"),
        "depth": (depth, "depth of the highest von Mises stress over Hertz half-width"),
    }
    over_force = {
        "fraction": (FRACTIONS, "tangential force over the largest that friction can carry"),
        "stick": (stick, "half-width of the stick zone over that of the contact"),
        "stick_sphere": (
            stick_sphere,
            "radius of the stick zone under a sphere over that of the contact",
        ),
    }
    errors = {
        "superposition_error": (
            error,
            "relative L1 error of the Ciavarella-Jäger tangential traction on a rough contact",
        ),
        "transverse_traction": (
            across,
            "largest transverse tangential traction over the largest tangential traction",
        ),
    }
    return {
        name: dimensionless(np.asarray(values), long_name, *dims)
        for measured, dims in (
            (over_coefficient, ["coefficient"]),
            (over_force, ["fraction"]),
            (errors, []),
        )
        for name, (values, long_name) in measured.items()
    }


def _stress(case: Rough, pressure: Array) -> tuple[list[float], list[float]]:
    """Return the largest von Mises stress over p_H for each coefficient of friction, and its depth over a.

    The stress under pressure and full sliding is linear in the coefficient.
    """
    solid = case.scene.solids[0]
    assert isinstance(solid, cs.HalfSpace)
    paddings, depths = (cs.ZeroPadding(), cs.ExactPeriodicity()), tuple(z * A for z in DEPTHS)
    stress = HalfSpaceStress(solid.poisson_ratio)
    below = SubsurfaceStressOperator(case.grid, paddings, stress, depths)
    pressed = below(pressure)
    sheared = below.with_shear(np.stack([pressure, np.zeros_like(pressure)]))(pressure) - pressed
    highest, depth = [], []
    for mu in COEFFICIENTS:
        equivalent = von_mises(pressed + mu * sheared).max(axis=(1, 2))
        highest.append(float(equivalent.max()) / P_H)
        depth.append(DEPTHS[int(equivalent.argmax())])
    return highest, depth


def _sphere(case: Rough, fraction: float) -> float:
    """Return the radius of the stick zone under a sphere over that of the contact, from their areas."""
    width, n = 2.5 * A, case.cells_rough
    force = 4 / 3 * case.scene.contact_modulus * A**3 / HERTZ.radius
    slip = PartialSlip(MU, fraction * MU * force / width)
    load, ball = cs.LineLoad(force / width), cs.Sphere(HERTZ.radius)
    scene = cs.Scene(load, case.scene.solids, (ball,), friction=slip)
    free = cs.ZeroPadding(), cs.ZeroPadding()
    solution = cs.solve(scene.problem(cs.Grid((n, n), (width, width)), free), tolerance=1e-6)
    return float(np.sqrt(solution.stick.sum() / (solution.pressure > 0).sum()))


def _superposition(case: Rough) -> tuple[float, float]:
    """Return the L1 error of the Ciavarella-Jäger traction on a rough contact, and the largest transverse traction.

    The tangential force is half of what friction can carry; both are relative to the traction of the exact solution.
    """
    rms = 0.3 * A**2 / (2 * HERTZ.radius)
    rough = cs.Roughness(rms, hurst=0.8, roll_off=0.8 * A, cut_off=0.2 * A, seed=1)
    slip = PartialSlip(MU, 0.5 * MU * case.scene.largest_load)
    scene = replace(case.scene, shapes=(*case.scene.shapes, rough), friction=slip)
    n = case.cells_rough
    problem = scene.problem(cs.Grid((n, n), (3.2 * A, 3.2 * A)), cs.ExactPeriodicity())
    exact = cs.solve(problem, tolerance=1e-6)
    quick = cs.solve(replace(problem, friction=CiavarellaJaeger(MU, 0.5)), tolerance=1e-6)
    size = np.abs(exact.shear)
    error = np.abs(exact.shear - quick.shear).sum() / size.sum()
    return float(error), float(size[1].max() / size.max())
