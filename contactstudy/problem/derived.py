"""What follows from a pressure on one grid, with its labels."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from contactstudy.domain.arrays import Array


@dataclass(frozen=True, eq=False)
class Field:
    """Values with their dimensions, unit and name in words; a coordinate, if named like its dimension."""

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str


class Derived(Protocol):
    """What follows from the pressure on one grid, found when it is called for."""

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Fields by name, under ``pressure`` (width, length) [Pa]."""
        ...
