"""Shear heating of a film: thermal properties of the lubricant and of the bodies."""

from math import exp, inf, log
from typing import Annotated

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import (
    Kelvins,
    PerKelvin,
    ThermalConductivity,
    VolumetricHeatCapacity,
)
from contactstudy.domain.validation import AT_LEAST_ZERO, Limits, validated
from contactstudy.scene.solids.bodies import Body, Layered

# Viscosity [Pa s] of Roelands' pole, the limit at high temperature, and the temperature [K] at which his viscosity
# diverges (Roelands 1966).
LEAST_VISCOSITY, LEAST_TEMPERATURE = exp(-9.67), 138.0
# Young's moduli [Pa] of steel.
OF_STEEL = (1.9e11, 2.2e11)
ABOVE_LEAST = Limits(f"above {LEAST_TEMPERATURE:g} K", lambda x: LEAST_TEMPERATURE < x < inf)


@validated
class ThermalBody:
    """Thermal properties of a body, those of steel by default.

    Parameters
    ----------
    conductivity
        Thermal conductivity [W/(m K)], above 0.
    heat_capacity
        Heat capacity per volume [J/(m^3 K)], density times specific heat, above 0.
    coating
        Properties of the coating of a :class:`~contactstudy.CoatedHalfSpace`; None without one.

    Raises
    ------
    InvalidInput
        For other values.
    """

    conductivity: ThermalConductivity = 46.0
    heat_capacity: VolumetricHeatCapacity = 3.6e6
    coating: "ThermalBody | None" = None

    def check_together(self) -> None:
        """Check that there is one coating at the most."""
        if self.coating is not None and self.coating.coating is not None:
            raise InvalidInput(
                f"ThermalBody.coating.coating is {self.coating.coating!r}: give the ThermalBody of one coating."
            )


@validated
class FilmHeat:
    """Heat of a sheared film, which lowers its viscosity and with it the friction.

    Pressure and film thickness are those of the isothermal film. The friction is that of a film thinned by its heated
    inlet.

    Parameters
    ----------
    temperature_viscosity
        Temperature-viscosity coefficient beta [1/K], the relative fall of viscosity with temperature at the supply, at
        least 0 (0: temperatures change nothing).
    conductivity
        Thermal conductivity of the lubricant [W/(m K)], above 0.
    first, second
        :class:`ThermalBody` of each body; None for steel, without a coating.
    supply_temperature
        Temperature of the lubricant's supply [K], above 138, at which viscosity and beta are given.

    Raises
    ------
    InvalidInput
        For other values.
    """

    temperature_viscosity: Annotated[PerKelvin, AT_LEAST_ZERO] = 0.04
    conductivity: ThermalConductivity = 0.14
    first: ThermalBody | None = None
    second: ThermalBody | None = None
    supply_temperature: Annotated[Kelvins, ABOVE_LEAST] = 313.15

    @property
    def bodies(self) -> tuple[ThermalBody, ThermalBody]:
        """Properties of both bodies."""
        return self.first or ThermalBody(), self.second or ThermalBody()

    def check(self, solids: tuple[Body, Body]) -> None:
        """Raise :class:`~contactstudy.InvalidInput` where a body or its coating has no properties of its own."""
        for number, (name, solid) in enumerate(zip(("first", "second"), solids, strict=True)):
            body, coated = getattr(self, name), isinstance(solid, Layered)
            modulus = getattr(solid, "youngs_modulus", 0.0)
            if body is None and (coated or not OF_STEEL[0] <= modulus <= OF_STEEL[1]):
                raise InvalidInput(
                    f"FilmHeat.{name} is None, the properties of steel, and Scene.solids[{number}] is {solid!r}: give "
                    "ThermalBody(conductivity=..., heat_capacity=...), with its coating if it has one."
                )
            if getattr(solid, "interlayers", ()):
                raise InvalidInput(
                    f"Scene.solids[{number}].interlayers stand together with FilmHeat.{name}: heat is conducted through "
                    "one coating alone, leave the interlayers or the FilmHeat out."
                )
            if body is not None and (body.coating is None) == coated:
                has = "no coating" if coated else "a coating"
                raise InvalidInput(
                    f"FilmHeat.{name} has {has}, unlike Scene.solids[{number}]: give ThermalBody.coating for a coated "
                    "body alone."
                )

    def thinning(self, rise: Array, viscosity: float) -> Array:
        """Return the change of ``ln(eta)`` at a temperature rise [K] of a lubricant of ``viscosity`` [Pa s].

        ``ln(eta / eta_l)`` falls as ``(T - T_l)^(-S)``, with eta_l and T_l its limits, and S
        the slope that `temperature_viscosity` gives at the supply (Roelands 1966).
        """
        above = self.supply_temperature - LEAST_TEMPERATURE
        height = log(viscosity / LEAST_VISCOSITY)
        slope = self.temperature_viscosity * above / height
        return np.asarray(height * np.expm1(-slope * np.log1p(rise / above)))
