"""Quantities of a lubricated contact."""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy.analytic import dowson_higginson_film, film_asymptotes
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.grid import across_and_along
from contactstudy.domain.validation import readable
from contactstudy.io.quantities.quantity import FORMULA, Quantity, with_bound
from contactstudy.io.quantities.stress_quantities import stress_quantities
from contactstudy.scene.lubrication import ConstantDensity, LimitingShear
from contactstudy.scene.shapes.shape import LengthScales, curvature_of

if TYPE_CHECKING:
    from contactstudy.lubrication.lubricated_contact import FilmSolution
    from contactstudy.scene.lubrication import Lubrication

ISOTHERMAL = ", isothermal"


# Attribute of a film, unit and label by the name of each number: of any film, on asperities, and heated.
NUMBERS = {
    "central_film": ("central_film", "m", "central film thickness"),
    "minimum_film": ("minimum_film", "m", "minimum film thickness"),
    "peak_pressure": ("peak_pressure", "Pa", "peak pressure"),
    "friction_coefficient": ("friction", "1", "friction force over load"),
    "power_loss": ("power_loss", "W m-1", "power lost per length"),
    "rolling_resistance": ("rolling_resistance", "1", "coefficient of rolling resistance"),
    "sliding_loss": ("sliding_loss", "W m-1", "power lost by sliding per length"),
    "load_per_length": ("load_per_length", "N m-1", "load per length"),
}
ON_ASPERITIES = {
    "contact_load_fraction": ("contact_load_fraction", "1", "fraction of the load on asperities"),
    "contact_area_ratio": ("contact_area_ratio", "1", "real contact area over Hertz's contact area"),
}
OF_HEAT = {
    "flash_temperature": ("flash_temperature", "K", "largest temperature rise of a surface"),
    "film_temperature": ("film_temperature", "K", "load-weighted mean temperature rise of the film"),
}


def film_quantities(contact: "FilmSolution", estimate: ErrorEstimate) -> dict[str, Quantity]:
    """Return the quantities of a lubricated contact with the `estimate` of its errors."""
    scales, motion = contact.scales, contact.scales.lubrication

    def read(numbers: Mapping[str, tuple[str, str, str]], **fields: Any) -> dict[str, Quantity]:
        return {
            name: Quantity(getattr(contact, attribute), unit, label, **fields)
            for name, (attribute, unit, label) in numbers.items()
        }

    quantities = read(NUMBERS)
    details = {"central_film": ISOTHERMAL, "minimum_film": ISOTHERMAL, "friction_coefficient": _of_friction(motion)}
    quantities |= {name: replace(quantities[name], detail=detail) for name, detail in details.items()}
    if contact.grid.cells[1] > 1:
        position = contact.minimum_film_position
        quantities["minimum_film"] = replace(quantities["minimum_film"], position=position)
    compressible = not isinstance(motion.lubricant.density, ConstantDensity)
    quantities |= {
        "load_parameter": Quantity(scales.load_parameter, "1", "Moes' M", 0.0, ""),
        "viscosity_parameter": Quantity(scales.viscosity_parameter, "1", "Moes' L", 0.0, ""),
        "moes_film": Quantity(
            scales.expected_film * scales.film, "m", "central film thickness by Moes", reason=FORMULA,
            detail=" (incompressible)" * compressible,
        ),
        **_of_formulas(contact),
        **_lambda_ratio(contact),
    }  # fmt: skip
    if motion.supply is not None:
        quantities["meniscus"] = Quantity(contact.meniscus, "m", "position of the inlet meniscus")
    if contact.contact_pressure is not None:
        quantities |= read(ON_ASPERITIES, is_fraction=True)
    if contact.temperatures is not None:
        reduction, label = contact.temperatures.reduction, "central film thickness with a heated inlet"
        quantities |= read(OF_HEAT) | {
            "thermal_reduction": Quantity(reduction, "1", "film with a heated inlet over the isothermal one"),
            "heated_film": Quantity(contact.heated_film, "m", label),
        }
    paddings = across_and_along(contact.padding)
    quantities |= stress_quantities(contact.scene, contact.derived, contact.grid, estimate, paddings)
    errors = {"load_per_length": ErrorParts(residual=contact.residual)} | dict(estimate) | dict(estimate.numbers)
    if "lambda_ratio" in quantities:
        errors["lambda_ratio"] = errors["central_film" if contact.temperatures is None else "heated_film"]
    # the loss by sliding is that of the friction, at a known speed
    if "friction_coefficient" in errors:
        slides = motion.slide_roll_ratio
        if not (slides or contact.friction):
            errors["friction_coefficient"] = ErrorParts()
        errors["sliding_loss"] = errors["friction_coefficient"] if slides else ErrorParts()
    return {name: with_bound(quantity, errors.get(name), estimate.warnings) for name, quantity in quantities.items()}


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
    unit = pi / (8 * load) * scales.film
    label = "minimum film thickness by Dowson and Higginson"
    film = dowson_higginson_film(load, viscosity) * unit if scales.mean_speed else 0.0
    quantities = {"dowson_higginson_film": Quantity(film, "m", label, reason=FORMULA)}
    for regime, asymptote in film_asymptotes(load, viscosity).items():
        name = f"{regime.replace(', ', '_')}_film"
        quantities[name] = Quantity(asymptote * unit, "m", f"asymptote {regime}", reason=FORMULA)
    return quantities


def _lambda_ratio(contact: "FilmSolution") -> dict[str, Quantity]:
    """Return the central film, with its heated inlet, over the rms height of both surfaces; none if smooth."""
    rough = [shape for shape in contact.scene.shapes if _rough(shape)]
    heights = sum((shape.gap(contact.grid) for shape in rough), start=np.zeros((1, 1)))
    if not rough or not (rms := float(np.std(heights))):
        return {}
    detail = f", central film over the rms height of {readable(rms, digits=3)}"
    return {"lambda_ratio": Quantity(contact.heated_film / rms, "1", "lambda ratio", detail=detail)}


def _rough(shape: object) -> bool:
    """Return whether a shape has heights but no curvature, as roughness, textures and measured surfaces do."""
    return not curvature_of(shape) and getattr(shape, "length_scales", LengthScales()).height > 0
