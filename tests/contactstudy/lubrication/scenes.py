"""Lubricated scenes by the parameters of Moes."""

from dataclasses import replace
from math import pi, sqrt
from typing import Any

import contactstudy as cs
from contactstudy.lubrication.lubricated_contact import FilmSolution

RADIUS, LOAD, VISCOSITY = 0.01, 1e5, 0.04
STEEL = cs.HalfSpace(210e9, 0.3)
DRY = cs.Scene(cs.LineLoad(LOAD), (STEEL, STEEL), (cs.Cylinder(RADIUS),))


def by_moes(load_parameter: float, viscosity_parameter: float, *shapes: cs.Shape, **laws: object) -> cs.Scene:
    """Steel cylinders with a Barus lubricant of constant density, unless ``laws`` name others."""
    hertz = DRY.hertz
    resistance = 3 * pi**2 / (8 * load_parameter**2)
    speed = resistance * hertz.half_width**3 * hertz.peak_pressure / (12 * VISCOSITY * RADIUS**2)
    coefficient = viscosity_parameter * sqrt(load_parameter / (2 * pi)) / hertz.peak_pressure
    named = {"viscosity_law": cs.Barus(), "density": cs.ConstantDensity()} | laws
    oil = cs.Lubricant(VISCOSITY, coefficient, **named)  # type: ignore[arg-type]
    return cs.Scene(DRY.load, DRY.solids, (*DRY.shapes, *shapes), lubrication=cs.Lubrication(oil, speed, 0.1))


def with_motion(scene: cs.Scene, **changed: Any) -> cs.Scene:
    return replace(scene, lubrication=replace(scene.lubrication, **changed))


def grid(cells: int, inlet: float, along: int = 1, period: float = 1.0) -> cs.Grid:
    """``inlet`` and ``period`` in Hertz's half-widths."""
    a = DRY.hertz.half_width
    return cs.Grid((cells, along), (2 * inlet * a, period * a))


def in_moes_units(contact: FilmSolution, film: float) -> float:
    """A film [m] as (h / R) (eta0 u_s / (E' R))^(-1/2)."""
    return film / contact.scales.film * 8 * contact.scales.load_parameter / pi
