"""Closed forms of line contacts that creep."""

from math import inf, pi, sqrt

import numpy as np

import contactstudy as cs
from contactstudy.domain.arrays import Array
from contactstudy.elasticity.prony import Creep

RIGID = cs.HalfSpace(inf, 0.3)
LOAD, RADIUS = 0.01 * pi / 4, 1.0  # a = 0.1 and p0 = 0.05 for E* = 1
# J = 1 + 1.5 (1 - exp(-t))
SOLID = cs.ViscoelasticHalfSpace(0.4, 0.0, ((0.6, 0.4),))


def rolling_cylinder(
    body: cs.ViscoelasticHalfSpace, load: object = None, **named: object
) -> cs.Scene:
    """A rigid cylinder of radius 1 on ``body``."""
    return cs.Scene(
        load or cs.LineLoad(LOAD),  # type: ignore[arg-type]
        (body, RIGID),
        (cs.Cylinder(RADIUS),),
        **named,  # type: ignore[arg-type]
    )


def half_width(creep: Creep, time: float) -> float:
    """``a^2 = 4 R P Phi(t) / pi`` under a load held since t = 0."""
    return sqrt(4 * RADIUS * LOAD * float(creep(time)) / pi)


def held_pressure(body: cs.ViscoelasticHalfSpace, time: float, x: Array) -> Array:
    """Lee & Radok (1960): ``p = 1/(2R) int E*(t - s) d sqrt(a(s)^2 - x^2)`` while the contact grows."""
    creep, plane = body.creep, 1 - body.poisson_ratio**2

    def modulus(t: Array) -> Array:
        relaxed = sum(e * np.exp(-t / tau) for e, tau in body.relaxation)
        return np.asarray((body.equilibrium_modulus + relaxed) / plane)

    # by parts, so that the root at the edge is integrated, not its slope; Gauss in the root of the time
    # since a point came into contact
    pressure = np.zeros_like(x)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    for place, one in enumerate(np.abs(x)):
        if one >= half_width(creep, time):
            continue
        joined = _joined(creep, float(one), time)
        root = sqrt(time - joined) * (nodes + 1) / 2
        s = joined + root**2
        deep = 4 * RADIUS * LOAD * creep(s) / pi - one**2
        slope = sum(e / tau * np.exp(-(time - s) / tau) for e, tau in body.relaxation) / plane
        inside = (np.sqrt(np.maximum(deep, 0)) * slope * 2 * root * weights).sum()
        inside *= sqrt(time - joined) / 2
        last = sqrt(4 * RADIUS * LOAD * float(creep(time)) / pi - one**2)
        pressure[place] = (float(modulus(np.zeros(()))) * last - inside) / (2 * RADIUS)
    return pressure


def _joined(creep: Creep, x: float, time: float) -> float:
    """When the contact reached x."""
    if x <= half_width(creep, 0.0):
        return 0.0
    low, high = 0.0, time
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if half_width(creep, middle) < x else (low, middle)
    return (low + high) / 2
