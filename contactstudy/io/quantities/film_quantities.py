"""Numbers of a lubricated contact by name, with units, labels and, as far as they need no further film, bounds.

A bound is infinite until a film is compared with others, which ``contactstudy.answers.lubricated_contact`` does; the
reasons why some numbers never get one are set here.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, pi
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy.analytic import dowson_higginson_film, film_asymptotes
from contactstudy.domain.errors import NO_PEAK, NO_STRESS, ErrorEstimate, ErrorParts
from contactstudy.domain.grid import across_and_along
from contactstudy.domain.validation import readable
from contactstudy.io.quantities.quantity import FORMULA, NO_ESTIMATE, Quantity
from contactstudy.io.quantities.stress_quantities import stress_quantities
from contactstudy.scene.lubrication import ConstantDensity, LimitingShear
from contactstudy.scene.shapes.shape import LengthScales, curvature_of

if TYPE_CHECKING:
    from contactstudy.lubrication.lubricated_contact import FilmSolution
    from contactstudy.scene.lubrication import Lubrication

ISOTHERMAL = ", isothermal"
FLOODED = (
    "No bound: lubricant fills the gap up to the edge of the grid, and the meniscus lies beyond, give a wider grid."
)


# Attribute of a film, unit and label by the name of each number: of any film, starved, on asperities, and heated.
NUMBERS = {
    "central_film": ("central_film", "m", "central film thickness"),
    "minimum_film": ("minimum_film", "m", "minimum film thickness"),
    "peak_pressure": ("peak_pressure", "Pa", "peak pressure"),
    "friction_coefficient": ("friction", "1", "friction force over load"),
    "power_loss": ("power_loss", "W m-1", "power lost per length"),
    "rolling_resistance": ("rolling_resistance", "1", "coefficient of rolling resistance"),
    "sliding_loss": ("sliding_loss", "W m-1", "power lost by sliding per length"),
}
OF_SUPPLY = {"meniscus": ("meniscus", "m", "position of the inlet meniscus")}
ON_ASPERITIES = {
    "contact_load_fraction": ("contact_load_fraction", "1", "fraction of the load on asperities"),
    "contact_area_ratio": ("contact_area_ratio", "1", "real contact area over Hertz's contact area"),
}
OF_HEAT = {
    "flash_temperature": ("flash_temperature", "K", "largest temperature rise of a surface"),
    "film_temperature": ("film_temperature", "K", "load-weighted mean temperature rise of the film"),
    "thermal_reduction": ("temperatures.reduction", "1", "film with a heated inlet over the isothermal one"),
    "heated_film": ("heated_film", "m", "central film thickness with a heated inlet"),
}
# Numbers with the friction by sliding in them.
BY_SLIDING = "friction_coefficient", "power_loss", "sliding_loss"


def film_quantities(contact: "FilmSolution", l1: ErrorParts) -> dict[str, Quantity]:
    """Return the quantities of a lubricated contact.

    Each that has neither an exact value nor a reason of its own for no bound has that of the `l1` error of the pressure,
    or none yet.
    """
    scales, motion = contact.scales, contact.scales.lubrication
    reason = l1.reason or NO_ESTIMATE

    def read(numbers: Mapping[str, tuple[str, str, str]], **fields: Any) -> dict[str, Quantity]:
        return {
            name: Quantity(attrgetter(attribute)(contact), unit, label, reason=reason, **fields)
            for name, (attribute, unit, label) in numbers.items()
        }

    quantities = read(NUMBERS)
    details = {"central_film": ISOTHERMAL, "minimum_film": ISOTHERMAL, "friction_coefficient": _of_friction(motion)}
    quantities |= {name: replace(quantities[name], detail=detail) for name, detail in details.items()}
    if contact.grid.cells[1] > 1:
        position = contact.minimum_film_position
        quantities["minimum_film"] = replace(quantities["minimum_film"], position=position)
    compressible = not isinstance(motion.lubricant.density, ConstantDensity)
    load = contact.load_per_length
    quantities |= {
        "load_per_length": Quantity(load, "N m-1", "load per length", contact.residual * load, ""),
        "load_parameter": Quantity(scales.load_parameter, "1", "Moes' M", 0.0, ""),
        "viscosity_parameter": Quantity(scales.viscosity_parameter, "1", "Moes' L", 0.0, ""),
        "moes_film": Quantity(
            scales.expected_film * scales.film, "m", "central film thickness by Moes", reason=FORMULA,
            detail=" (incompressible)" * compressible,
        ),
        **_of_formulas(contact),
        **_lambda_ratio(contact, reason),
    }  # fmt: skip
    if motion.supply is not None:
        quantities |= read(OF_SUPPLY)
    if contact.contact_pressure is not None:
        quantities |= read(ON_ASPERITIES, is_fraction=True)
    if contact.temperatures is not None:
        quantities |= read(OF_HEAT)
    spike, of_heat = contact.spike_reason, "" if contact.temperatures is None else contact.temperatures.reason
    of_sliding = of_heat or contact.friction_reason
    own = {
        "peak_pressure": spike,
        "meniscus": FLOODED if contact.is_flooded else "",
        **dict.fromkeys(OF_HEAT, of_heat),
        **dict.fromkeys(BY_SLIDING, of_sliding),
    }
    if not motion.slide_roll_ratio:
        own["power_loss"] = ""
        quantities["sliding_loss"] = replace(quantities["sliding_loss"], bound=0.0, reason="")
        if not contact.friction:
            friction = quantities["friction_coefficient"]
            quantities["friction_coefficient"] = replace(friction, bound=0.0, reason="")
    for name, why in own.items():
        if why and name in quantities:
            quantities[name] = replace(quantities[name], bound=inf, reason=why)
    of_peak = ErrorParts(discretisation=inf, reason=spike) if spike else None
    estimate, paddings = ErrorEstimate(l1, of_peak), across_and_along(contact.padding)
    stresses = stress_quantities(contact.scene, contact.derived, contact.grid, estimate, paddings)
    # the orthogonal shear stress lies deeper than a spike acts: on 200 films its changes between grids bounded it,
    # while those of other stresses were up to 12 times too small
    below_spike = {
        name: replace(of, reason=reason)
        for name, of in stresses.items()
        if name.startswith("orthogonal_shear") and of.reason == NO_STRESS + spike.removeprefix(NO_PEAK)
    }
    return quantities | stresses | below_spike


def _of_friction(motion: "Lubrication") -> str:
    """Return what is said of a friction: that it is isothermal, and the limit of its stress."""
    detail = "" if motion.thermal is not None else ISOTHERMAL
    if isinstance(law := motion.lubricant.shear, LimitingShear):
        detail += f", limiting stress {readable(law.ambient, 'Pa', 2)} + {law.coefficient:g} p"
    return detail


def _of_formulas(contact: "FilmSolution") -> dict[str, Quantity]:
    """Return the film thickness by Dowson and Higginson, and the asymptotes of Moes' film."""
    scales = contact.scales
    load, viscosity = scales.load_parameter, scales.viscosity_parameter
    unit = pi / (8 * load) * scales.film  # [m] of the film thickness of Moes
    label = "minimum film thickness by Dowson and Higginson"
    film = dowson_higginson_film(load, viscosity) * unit  # at no mean speed M is infinite, and L and unit are 0
    quantities = {"dowson_higginson_film": Quantity(film, "m", label, reason=FORMULA)}
    for regime, asymptote in film_asymptotes(load, viscosity).items():
        name = f"{regime.replace(', ', '_')}_film"
        quantities[name] = Quantity(asymptote * unit, "m", f"asymptote {regime}", reason=FORMULA)
    return quantities


def _lambda_ratio(contact: "FilmSolution", reason: str) -> dict[str, Quantity]:
    """Return the central film, with its heated inlet, over the rms height of both surfaces; none if smooth.

    The `reason` is why it has no bound.
    """
    rough = [shape for shape in contact.scene.shapes if _rough(shape)]
    heights = sum((shape.gap(contact.grid) for shape in rough), start=np.zeros((1, 1)))
    if not rough or not (rms := float(np.std(heights))):
        return {}
    detail = f", central film over the rms height of {readable(rms, digits=3)}"
    return {"lambda_ratio": Quantity(contact.heated_film / rms, "1", "lambda ratio", reason=reason, detail=detail)}


def _rough(shape: object) -> bool:
    """Return whether a shape has heights but no curvature, as roughness, textures and measured surfaces do."""
    return not curvature_of(shape) and getattr(shape, "length_scales", LengthScales()).height > 0
