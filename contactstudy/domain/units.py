"""Types of physical quantities with their SI units, to which texts such as ``"10 mm"`` are converted."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Unit:
    """A unit: its symbol, the name of the quantity and an example, for error messages."""

    symbol: str
    quantity: str
    example: str


Metres = Annotated[float, Unit("m", "a length", "10 mm")]
Pascals = Annotated[float, Unit("Pa", "a pressure", "1.2 GPa")]
HARDNESS = Unit("Pa", "a hardness", "700 HV")
Hardness = Annotated[float, HARDNESS]
NewtonsPerMetre = Annotated[float, Unit("N/m", "a load per length", "100 N/mm")]
JoulesPerSquareMetre = Annotated[float, Unit("J/m^2", "a work per area", "50 mJ/m^2")]
Newtons = Annotated[float, Unit("N", "a load", "2 kN")]
PerMetre = Annotated[float, Unit("1/m", "a spin", "0.5 1/m")]
PerPascal = Annotated[float, Unit("1/Pa", "a specific wear rate", "1e-6 mm3/(N m)")]
Compressibility = Annotated[float, Unit("1/Pa", "a compressibility", "0.6 1/GPa")]
PressureViscosity = Annotated[float, Unit("1/Pa", "a pressure-viscosity coefficient", "20 1/GPa")]
ThermalConductivity = Annotated[float, Unit("W/(m*K)", "a thermal conductivity", "46 W/(m*K)")]
VolumetricHeatCapacity = Annotated[float, Unit("J/(m^3*K)", "a volumetric heat capacity", "3.6 MJ/(m^3*K)")]
Kelvins = Annotated[float, Unit("K", "a temperature", "333 K")]
PerKelvin = Annotated[float, Unit("1/K", "a temperature coefficient", "0.04 1/K")]
PascalSeconds = Annotated[float, Unit("Pa*s", "a viscosity", "40 mPa*s")]
MetresPerSecond = Annotated[float, Unit("m/s", "a speed", "100 mm/s")]
Seconds = Annotated[float, Unit("s", "a time", "2 min")]
PerSecond = Annotated[float, Unit("Hz", "a frequency", "50 Hz")]
Radians = Annotated[float, Unit("rad", "an angle", "1 degree")]
Number = Annotated[float, Unit("", "a number", "0.3")]

# Units for display, by the SI unit, largest first: the first one in which the value is at least 1 is used,
# of areas 1e-3 and of volumes 1e-4.
DISPLAY_UNITS: Mapping[str, tuple[tuple[float, str], ...]] = {
    "Pa": ((1e9, "GPa"), (1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa")),
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")),
    "m2": ((1.0, "m²"), (1e-6, "mm²"), (1e-12, "µm²")),
    "m3": ((1.0, "m³"), (1e-9, "mm³"), (1e-18, "µm³")),
    "m2 m-1": ((1e-3, "mm²/mm"),),
    "m3 m-1": ((1e-6, "mm³/mm"), (1e-15, "µm³/mm")),
    "N": ((1e3, "kN"), (1.0, "N")),
    "N m-1": ((1e3, "N/mm"), (1.0, "N/m")),
    "N m-2": ((1e6, "N/mm per mm"),),
    "W": ((1e3, "kW"), (1.0, "W"), (1e-3, "mW")),
    "W m-1": ((1.0, "W/m"),),
    "J m-1": ((1.0, "J/m"), (1e-3, "mJ/m"), (1e-6, "µJ/m"), (1e-9, "nJ/m")),
    "1/Pa": ((1e-9, "1/GPa"), (1.0, "1/Pa")),
    "rad": ((1.0, "rad"), (1e-3, "mrad")),
    "1": ((1.0, ""),),
}


def display_unit(largest: float, unit: str) -> tuple[float, str]:
    """Return size and name of the unit in which numbers up to `largest`, in the SI unit `unit`, are read best."""
    scales = DISPLAY_UNITS.get(unit, ((1.0, unit),))
    # successive units of areas and volumes differ by 1e6, 1e9 and more
    least = {"m2": 1e-3, "m3": 1e-4}.get(unit[:2], 1.0)
    return next((scale for scale in scales if abs(largest) >= least * scale[0]), scales[-1])


def display_unit_of(values: ArrayLike, unit: str) -> tuple[float, str]:
    """Return size and name of the unit in which the largest finite number of `values`, in SI units, is read best."""
    sizes = np.abs(np.asarray(values))
    return display_unit(float(np.max(sizes, where=np.isfinite(sizes), initial=0.0)), unit)


def readable(value: float, unit: str = "m", digits: int = 4) -> str:
    """Return a value as text in a unit with few digits, such as ``"0.5 GPa"``, by default a length."""
    size, name = display_unit(value, unit)
    return f"{value / size:.{digits}g} {name}".strip()
