"""Quantities of a lubricated contact."""

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.analytic import dowson_higginson_film, film_asymptotes
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.grid import across_and_along
from contactstudy.domain.units import readable
from contactstudy.io.quantities.quantity import FORMULA, Quantity, with_bound
from contactstudy.io.quantities.stress_quantities import stress_quantities
from contactstudy.scene.lubrication.lubricant import ConstantDensity, LimitingShear
from contactstudy.scene.shapes.shape import LengthScales, curvature_of

if TYPE_CHECKING:
    from contactstudy.lubrication.lubricated_contact import FilmSolution
    from contactstudy.scene.lubrication.lubrication import Lubrication

ISOTHERMAL = ", isothermal"
OF_HEATED_INLET = "No bound: the factor of the heated inlet is that of a formula."


def film_quantities(contact: "FilmSolution", estimate: ErrorEstimate) -> dict[str, Quantity]:
    """Return the quantities of a lubricated contact with the `estimate` of its errors."""
    scales, fallback_reasons = contact.scales, estimate.warnings
    quantities = {
        "central_film": Quantity(contact.central_film, "m", "central film thickness", detail=ISOTHERMAL),
        "minimum_film": Quantity(
            contact.minimum_film, "m", "minimum film thickness", detail=ISOTHERMAL,
            position=contact.minimum_film_position if contact.grid.cells[1] > 1 else None,
        ),
        "peak_pressure": Quantity(contact.peak_pressure, "Pa", "peak pressure"),
        "friction_coefficient": Quantity(
            contact.friction, "1", "friction force over load", detail=_of_friction(scales.lubrication)
        ),
        "power_loss": Quantity(contact.power_loss, "W m-1", "power lost per length"),
        "rolling_resistance": Quantity(
            contact.rolling_resistance, "1", "coefficient of rolling resistance"
        ),
        "sliding_loss": Quantity(
            contact.sliding_loss, "W m-1", "power lost by sliding per length"
        ),
        "load_per_length": with_bound(
            Quantity(contact.load_per_length, "N m-1", "load per length"),
            ErrorParts(residual=contact.residual),
        ),
        "load_parameter": Quantity(scales.load_parameter, "1", "Moes' M", 0.0, ""),
        "viscosity_parameter": Quantity(scales.viscosity_parameter, "1", "Moes' L", 0.0, ""),
        "moes_film": Quantity(
            scales.expected_film * scales.film, "m", "central film thickness by Moes", reason=FORMULA,
            detail="" if isinstance(scales.lubrication.lubricant.density, ConstantDensity) else " (incompressible)",
        ),
        **_of_formulas(contact),
        **_lambda_ratio(contact),
    }  # fmt: skip
    if scales.lubrication.supply is not None:
        quantities["meniscus"] = Quantity(contact.meniscus, "m", "position of the inlet meniscus")
    if contact.contact_pressure is not None:
        quantities["contact_load_fraction"] = Quantity(
            contact.contact_load_fraction,
            "1",
            "fraction of the load on asperities",
            is_fraction=True,
        )
        quantities["contact_area_ratio"] = Quantity(
            contact.contact_area_ratio,
            "1",
            "real contact area over Hertz's contact area",
            is_fraction=True,
        )
    if (temperatures := contact.temperatures) is not None:
        quantities["flash_temperature"] = Quantity(
            contact.flash_temperature, "K", "largest temperature rise of a surface"
        )
        quantities["film_temperature"] = Quantity(
            contact.film_temperature, "K", "load-weighted mean temperature rise of the film"
        )
        quantities["thermal_reduction"] = Quantity(
            temperatures.reduction, "1", "film with a heated inlet over the isothermal one"
        )
        quantities["heated_film"] = Quantity(
            temperatures.reduction * contact.central_film,
            "m",
            "central film thickness with a heated inlet",
            reason=OF_HEATED_INLET,
        )
    paddings = across_and_along(contact.padding)
    quantities |= stress_quantities(contact.scene, contact.derived, contact.grid, estimate, paddings)
    errors = dict(estimate) | dict(estimate.numbers)
    if "lambda_ratio" in quantities and quantities["lambda_ratio"].reason != OF_HEATED_INLET:
        errors["lambda_ratio"] = errors["central_film"]
    # the loss by sliding is that of the friction, at a known speed
    if "friction_coefficient" in errors:
        slides = scales.lubrication.slide_roll_ratio
        if not (slides or contact.friction):
            errors["friction_coefficient"] = ErrorParts()
        errors["sliding_loss"] = errors["friction_coefficient"] if slides else ErrorParts()
    return {name: with_bound(quantity, errors.get(name), fallback_reasons) for name, quantity in quantities.items()}


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
    film, temperatures = contact.central_film, contact.temperatures
    detail = f", central film over the rms height of {readable(rms, digits=3)}"
    ratio = Quantity(film / rms, "1", "lambda ratio", detail=detail)
    if temperatures is not None and temperatures.reduction < 1:
        ratio = replace(ratio, value=temperatures.reduction * film / rms, reason=OF_HEATED_INLET)
    return {"lambda_ratio": ratio}


def _rough(shape: object) -> bool:
    """Return whether a shape has heights but no curvature, as roughness, textures and measured surfaces do."""
    return not curvature_of(shape) and getattr(shape, "length_scales", LengthScales()).height > 0
