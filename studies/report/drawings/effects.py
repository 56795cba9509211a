"""Figures and claims of the chapters of effects, as data, with closed forms as named laws.

The scenes are in ``studies/chapters``. The laws repeat the numbers of these scenes, and hold for no changed copy of
one.
"""

from collections.abc import Callable
from math import pi

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.grid import Array
from studies.report.claims import Claim, drawing, largest_error
from studies.report.drawings.default import LAWS
from studies.report.plots import Law, Plot

LOAD, RADIUS = 1e5, 0.01  # [N/m], [m]
STEEL = 210e9 / (1 - 0.3**2)  # E* of a rigid cylinder on steel [Pa]


def hertz(modulus: float) -> cs.analytic.HertzLine:
    """Return Hertz's contact of a cylinder of 10 mm with a contact modulus [Pa] under 100 N/mm."""
    return cs.analytic.HertzLine(LOAD, RADIUS, modulus)


# Coating


def on_coating(quantity: str) -> Callable[[Array, xr.Dataset], float]:
    """Return the law of a quantity of Hertz's contact on a body of the coating alone."""

    def of(_: Array, part: xr.Dataset) -> float:
        modulus = float(part["solids_0_coating_youngs_modulus"]) / (1 - 0.3**2)
        return float(getattr(hertz(modulus), quantity))

    return of


COATING = Plot(
    "coating", ("half_width", "peak_pressure"), "solids_0_thickness", hue="solids_0_coating_youngs_modulus",
    laws=tuple(Law("on the coating alone", name, on_coating(name)) for name in ("half_width", "peak_pressure")),
    labels={"solids_0_thickness": "thickness of the coating", "solids_0_coating_youngs_modulus": "coating of"},
    caption="A rigid cylinder on coated steel, over the thickness of the coating. Hertz's half-width on steel alone is "
    f"{1e6 * hertz(STEEL).half_width:.0f} µm.",
)  # fmt: skip
coating = drawing(COATING)


# Friction

FRICTION_LIMIT = 3e4  # [N/m]
SLIP = Plot(
    "slip", ("stick_fraction",), "friction_tangential",
    laws=(Law("Cattaneo (1938)", "stick_fraction", lambda force, _: np.sqrt(1 - force / FRICTION_LIMIT)),),
    caption="Partial slip of a cylinder under a tangential force of up to 30 N/mm, where it slides: the part of the "
    "contact that sticks, beside sqrt(1 - Q / mu P).",
)  # fmt: skip
friction = drawing(
    SLIP,
    claims=[
        Claim(
            "How much of a contact slips below the limit of friction?",
            "The stick zone is Cattaneo's, within {off} of the contact.",
            numbers={
                "off": lambda d: abs(d["stick_fraction"] - np.sqrt(1 - d["friction_tangential"] / FRICTION_LIMIT)).max()
            },
        )
    ],
)
SLIDING = Plot(
    "sliding", ("largest_von_mises", "largest_von_mises_depth"), "friction_coefficient", log="",
    labels={"largest_von_mises": "highest von Mises stress", "largest_von_mises_depth": "its depth"},
    caption="A cylinder that slides on steel: the highest von Mises stress and its depth. The stress is known at the "
    "depths that the scene names.",
)  # fmt: skip
sliding = drawing(SLIDING)


# Creep and wear

RUBBER = cs.ViscoelasticHalfSpace(1e6, 0.49, ((1.5e6, 0.4),))
PLANE = 1 / (1 - 0.49**2)  # modulus in plane strain over that in tension
HELD = cs.analytic.LeeRadok(
    500.0, 0.05, PLANE * 1e6, tuple((PLANE * modulus, time) for modulus, time in RUBBER.relaxation), RUBBER.creep
)  # fmt: skip


def held_peak(time: Array) -> Array:
    """Return the peak pressure [Pa] at instants [s]."""
    return np.array([float(HELD.pressure(0.0, instant)) for instant in time])


IN_TIME = {"time_steps_end": "time", "final_contact_area": "contact width", "final_peak_pressure": "peak pressure"}
LEE_RADOK = Law("Lee & Radok (1960)", "final_peak_pressure", lambda time, _: held_peak(time))
CREEP = Plot(
    "creep", ("final_contact_area", "final_peak_pressure"), "time_steps_end", log="",
    laws=(Law(LEE_RADOK.label, "final_contact_area", lambda time, _: 2 * HELD.half_width(time)), LEE_RADOK),
    labels=IN_TIME,
    caption="A rigid cylinder pressed suddenly into a viscoelastic body and held.",
)  # fmt: skip
creep = drawing(
    CREEP,
    claims=[
        Claim(
            "How far does creep spread a contact?",
            "As Lee and Radok's closed form says: the peak pressure is within {off} of it at every time.",
            numbers={"off": largest_error(LEE_RADOK, "time_steps_end")},
        )
    ],
)
WEAR_RATE = 1e-15 * 0.1 * LOAD  # worn area of the section per time [m^2/s]


def worn_width(time: Array) -> Array:
    """Return the contact width of a wearing cylinder: the cubes of Hertz's half-width and of a rigid flat's added."""
    cubes: Array = hertz(STEEL).half_width ** 3 + 1.5 * RADIUS * WEAR_RATE * np.asarray(time)
    return 2 * np.cbrt(cubes)


CUBES = Law("cubes added: a³ = a_H³ + 3/2 R k P s", "final_contact_area", lambda time, _: worn_width(time))
WEAR = Plot(
    "wear", ("final_contact_area", "final_peak_pressure"), "time_steps_end", log="xy",
    laws=(
        Law("rigid cylinder", "final_contact_area", lambda time, _: 2 * np.cbrt(1.5 * RADIUS * WEAR_RATE * time)),
        CUBES,
    ),
    labels=IN_TIME | {"time_steps_end": "sliding time"},
    caption="A cylinder that wears by Archard's law at 0.1 m/s. A rigid one has a flat that grows like the cube root "
    "of the distance s; adding the cube of Hertz's half-width is a fair estimate from the start.",
)  # fmt: skip
wear = drawing(
    WEAR,
    claims=[
        Claim(
            "How does wear widen a contact?",
            "Like the cube root of the distance: the estimate a³ = a_H³ + 3/2 R k P s is within {off} of the width.",
            numbers={"off": largest_error(CUBES, "time_steps_end")},
        )
    ],
)


# Plastic strain

PLASTIC = Plot(
    "plastic", ("peak_pressure", "dent_depth"), "load_per_length_1", hue="solids_0_hardening_modulus", log="",
    laws=(Law("elastic (Hertz)", "peak_pressure", lambda load, _: np.sqrt(load * STEEL / (pi * RADIUS))),),
    labels={"load_per_length_1": "largest load", "solids_0_hardening_modulus": "hardening modulus",
            "dent_depth": "depth of the dent"},
    caption="A rigid cylinder pressed into steel that yields at 1 GPa, and unloaded: the pressure under the largest "
    "load, and the dent that remains.",
)  # fmt: skip
plastic = drawing(PLASTIC)


# Films and roughness

FILMS = Plot(
    "films", ("central_film", "minimum_film"), "lubrication_mean_speed",
    hue="lubrication_lubricant_pressure_viscosity", laws=LAWS,
    labels={"lubrication_mean_speed": "mean speed", "lubrication_lubricant_pressure_viscosity": "pressure-viscosity"},
    caption="Film between steel cylinders over the speed, for pressure-viscosity coefficients of the oil. Dotted: the "
    "formula of Moes for the central film, and of Dowson and Higginson for the smallest.",
)  # fmt: skip
films = drawing(
    FILMS,
    claims=[
        Claim(
            "How thick is the film?",
            "The central film is within {off} of the formula of Moes.",
            numbers={"off": largest_error(LAWS[0])},
        )
    ],
)
ROUGHNESS = Plot(
    "roughness", ("contact_area_over_hertz", "peak_pressure"), "shapes_1_rms", hue="shapes_1_peklenik",
    over=("shapes_1_seed",),
    labels={"shapes_1_rms": "rms height", "shapes_1_peklenik": "Peklenik number"},
    caption="A rough cylinder: lines are the median of two surfaces, bands their range. The Peklenik number is the "
    "correlation length across the contact over that along it: below 1 grooves run along the length.",
)  # fmt: skip
roughness = drawing(ROUGHNESS)


# Paddings on rough surfaces

ROUGH_PADDINGS = Plot(
    "paddings", ("pressure_error_l1",), "shapes_1_rms", hue="padding", over=("shapes_1_seed",), log="y",
    labels={"shapes_1_rms": "rms height", "pressure_error_l1": "L1 error of the pressure"},
    caption="L1 error of every padding against exact periodicity on the same surface and grid, over the rms height of "
    "the roughness: the median of four surfaces (Hurst exponent 0.8, Peklenik number 1), and their range.",
)  # fmt: skip


def _error(padding: str, place: int, kind: str) -> Callable[[xr.Dataset], float]:
    """Return a function for an error of a `padding` at one rms height, by its `place`: of `kind` median, min or max."""

    def of(dataset: xr.Dataset) -> float:
        errors = dataset["pressure_error_l1"].sel(padding=padding).isel(shapes_1_rms=place)
        return float(getattr(errors, kind)())

    return of


COMPARED = {
    "duplicated": "DuplicatedPadding",
    "superposed": "Superposition(images=6)",
    "circular": "CircularSuperposition(images=6)",
}
rough_paddings = drawing(
    ROUGH_PADDINGS,
    claims=[
        Claim(
            "Does roughness change the error of a padding?",
            "Hardly: duplicated padding errs by {duplicated_smooth} on the smooth cylinder and by {duplicated_low} to "
            "{duplicated_high} at an rms height of {rms}.",
            "With n = 6 the error goes from {superposed_smooth} to {superposed_low} to {superposed_high} (superposed), "
            "and from {circular_smooth} to {circular_low} to {circular_high} (circular), over {count} surfaces.",
            {
                "rms": lambda d: f"{1e6 * float(d['shapes_1_rms'][-1]):g} µm",
                "count": lambda d: int(d.sizes["shapes_1_seed"]),
                **{
                    f"{short}_{word}": _error(name, place, kind)
                    for short, name in COMPARED.items()
                    for word, place, kind in (("smooth", 0, "median"), ("low", -1, "min"), ("high", -1, "max"))
                },
            },
            {"padding": tuple(COMPARED.values()), "shapes_1_rms": (0.0,)},
        )
    ],
)  # fmt: skip
