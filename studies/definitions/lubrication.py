"""Films of smooth and rough line contacts over load and viscosity, beside the formula of Moes; error against cost."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi, sqrt

import xarray as xr

import contactstudy as cs
from contactstudy.analytic import moes_film
from contactstudy.domain.checks import non_negative, positive, whole_number
from studies.model.axis import Axis, one_of
from studies.model.case import SceneCase, TimedAnswer, dimensionless_variables
from studies.model.study import Point
from studies.reference.line_contact import HERTZ, SCENE

# The dimensionless film does not depend on the material.
VISCOSITY = 0.04
# Length of the inlet in half-widths, and over sqrt(2 H).
INLET, FILMS = 4.5, 6.0
# Waves of the surface [a]: random, an eighth of the length and more.
ROLL_OFF, CUT_OFF, SEED = 0.5, 0.25, 1
EYRING = 5e6
CAVITATION: Mapping[str, cs.ElrodAdams | cs.ReynoldsCavitation] = {
    "elrod-adams": cs.ElrodAdams(),
    "reynolds": cs.ReynoldsCavitation(),
}

axes = (
    Axis(
        "load",
        (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0),
        "Moes' load parameter M",
    ),
    Axis(
        "viscosity",
        (0.0, 1.0, 2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0),
        "Moes' lubricant parameter L",
    ),
    Axis("rms", (0.0,), "rms height over the film of Moes' formula"),
    Axis("cavitation", ("elrod-adams",), "elrod-adams, which conserves mass, or reynolds"),
    Axis("grid", (100, 200, 400), "cells across the width"),
)

# wall times are recorded with the films
times = "none"


def case_at(point: Point) -> SceneCase:
    """Return steel cylinders with a Barus lubricant of constant density, solved from a cold start."""
    load = positive("load", point["load"], "give a load parameter M above 0")
    viscosity = non_negative("viscosity", point["viscosity"], "must be at least 0")
    rms = non_negative("rms", point["rms"], "give an rms height of 0 or more")
    cavitation = one_of("cavitation", point["cavitation"], CAVITATION)
    cells = whole_number("grid", point["grid"], 16, "give at least 16 cells across the width")
    a = HERTZ.half_width
    film = moes_film(load, viscosity) * pi / (8 * load)
    speed = (
        3 * pi**2 / (8 * load**2) * a**3 * HERTZ.peak_pressure / (12 * VISCOSITY * HERTZ.radius**2)
    )
    coefficient = viscosity * sqrt(load / (2 * pi)) / HERTZ.peak_pressure
    laws = cs.Barus(), cs.ConstantDensity(), cs.Eyring(EYRING)
    oil = cs.Lubricant(VISCOSITY, coefficient, *laws)
    height = rms * film * a**2 / HERTZ.radius
    width = 2 * max(INLET, FILMS * sqrt(2 * film)) * a
    surface = cs.Roughness(
        height, hurst=0.8, roll_off=ROLL_OFF * a, cut_off=CUT_OFF * a, seed=SEED,
        extent=(width, a),
    )  # fmt: skip
    lubrication = cs.Lubrication(oil, speed, 0.1, cavitation=CAVITATION[cavitation])
    shapes = (*SCENE.shapes, surface) if rms else SCENE.shapes
    scene = replace(SCENE, shapes=shapes, lubrication=lubrication)
    along = max(cells // 2, 16) if rms else 1
    return SceneCase(scene, cs.Grid((cells, along), (width, a)), cs.ExactPeriodicity())


def measures(case: SceneCase, solved: TimedAnswer) -> Mapping[str, xr.Variable]:
    """Return films in Moes' units, how evenly lubricant flows, friction, the load on a thin film and the time taken."""
    contact = solved.answer
    assert isinstance(contact, cs.LubricatedContact)
    scales = contact.scales
    load = scales.load_parameter
    units = 8 * load / pi / scales.film
    moes = moes_film(load, scales.viscosity_parameter)
    flat = contact.flow / contact.mean_speed
    _, thin_load = contact.thinner_than(moes / units / 2)
    converged = contact.status is not cs.Status.FILM_NOT_CONVERGED
    resolved = contact.status is cs.Status.CONVERGED
    largest = contact.peak_pressure / HERTZ.peak_pressure
    measured = {
        "central_film": (
            contact.central_film * units,
            "central film, (h/R) (eta0 u_s/(E' R))^-1/2",
        ),
        "minimum_film": (
            contact.minimum_film * units,
            "smallest film, (h/R) (eta0 u_s/(E' R))^-1/2",
        ),
        "film_at_zero_gradient": (flat * units, "film at dp/dx = 0, (h/R) (eta0 u_s/(E' R))^-1/2"),
        "film_over_moes": (flat * units / moes, "film at dp/dx = 0 over Moes'"),
        "friction": (contact.friction, "coefficient of friction at a slide-to-roll ratio of 0.1"),
        "flux_spread": (contact.flux_spread, "range of the flow over x over its mean"),
        "thin_load": (thin_load, "fraction of the load on less than half of Moes' film"),
        "peak_pressure": (largest, "peak pressure over Hertz's"),
        "converged": (converged, "1 where the iteration converged"),
        "resolved": (resolved, "1 where the cells resolve the film too"),
    }
    label = {"units": "s", "long_name": "wall time of the solve"}
    wall_time = xr.Variable((), solved.seconds, label)
    return dimensionless_variables(measured) | {"wall_time": wall_time}
