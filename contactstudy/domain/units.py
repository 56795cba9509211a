"""Types of physical quantities with their SI units, to which texts such as ``"10 mm"`` are converted."""

from dataclasses import dataclass
from typing import Annotated


@dataclass(frozen=True)
class Unit:
    """A unit: its symbol, the name of the quantity and an example, for error messages."""

    symbol: str
    quantity: str
    example: str


BYTES = Unit("byte", "an amount of memory", "4 GB")
SECONDS = Unit("s", "a time", "2 min")

Metres = Annotated[float, Unit("m", "a length", "10 mm")]
Pascals = Annotated[float, Unit("Pa", "a pressure", "1.2 GPa")]
NewtonsPerMetre = Annotated[float, Unit("N/m", "a load per length", "100 N/mm")]
JoulesPerSquareMetre = Annotated[float, Unit("J/m^2", "a work per area", "50 mJ/m^2")]
Newtons = Annotated[float, Unit("N", "a load", "2 kN")]
PerMetre = Annotated[float, Unit("1/m", "a spin", "0.5 1/m")]
PerPascal = Annotated[float, Unit("1/Pa", "a wear coefficient", "1e-17 1/Pa")]
PressureViscosity = Annotated[float, Unit("1/Pa", "a pressure-viscosity coefficient", "20 1/GPa")]
ThermalConductivity = Annotated[float, Unit("W/(m*K)", "a thermal conductivity", "46 W/(m*K)")]
HeatCapacity = Annotated[float, Unit("J/(m^3*K)", "a heat capacity", "3.6 MJ/(m^3*K)")]
PerKelvin = Annotated[float, Unit("1/K", "a fraction per temperature", "0.04 1/K")]
PascalSeconds = Annotated[float, Unit("Pa*s", "a viscosity", "40 mPa*s")]
MetresPerSecond = Annotated[float, Unit("m/s", "a speed", "100 mm/s")]
Seconds = Annotated[float, Unit("s", "a time", "2 min")]
Hertz = Annotated[float, Unit("Hz", "a frequency", "50 Hz")]
Radians = Annotated[float, Unit("rad", "an angle", "90 degree")]
Number = Annotated[float, Unit("", "a number", "0.3")]
