"""SI units of quantities, kept with their types; texts with units are converted to them."""

from dataclasses import dataclass
from typing import Annotated


@dataclass(frozen=True)
class Unit:
    """A unit: its symbol, the name of the quantity and an example, for error messages."""

    symbol: str
    quantity: str
    example: str


BYTES = Unit("byte", "a memory", "4 GB")
SECONDS = Unit("s", "a time", "2 min")

Metres = Annotated[float, Unit("m", "a length", "10 mm")]
Pascals = Annotated[float, Unit("Pa", "a pressure", "1.2 GPa")]
NewtonsPerMetre = Annotated[float, Unit("N/m", "a load per length", "100 N/mm")]
Radians = Annotated[float, Unit("rad", "an angle", "90 degree")]
Number = Annotated[float, Unit("", "a number", "0.3")]
