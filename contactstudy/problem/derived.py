"""What follows from a pressure on one grid, with its labels."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from numpy.typing import NDArray

from contactstudy.domain.devices.arrays import Array


@dataclass(frozen=True, eq=False)
class Field:
    """Values with their dimensions, unit, long name and other CF attributes.

    A field named like its only dimension is a coordinate.
    """

    dimensions: tuple[str, ...]
    values: NDArray[Any]
    units: str
    long_name: str
    attributes: Mapping[str, str] = field(default_factory=dict)


class Derived(Protocol):
    """What follows from the pressure on one grid, found when it is called for."""

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Fields by name, under ``pressure`` (x, y) [Pa]."""
        ...


@runtime_checkable
class Sheared(Protocol):
    """What follows from shear on the surface as well."""

    def under(self, shear: Array) -> Derived:
        """The same under ``shear`` (component, x, y) [Pa] on the first body."""
        ...
