"""What a scene may ask to be found from its solution, and how it is labelled."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from contactstudy.arrays import Array
from contactstudy.grid import Grid
from contactstudy.padding import Paddings
from contactstudy.solids import HalfSpace


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


class Output(Protocol):
    """A value in ``Scene.outputs``."""

    def check(self, solids: tuple[HalfSpace, ...]) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if these bodies cannot give it."""
        ...

    def of(self, solids: tuple[HalfSpace, ...], grid: Grid, paddings: Paddings) -> Derived:
        """The same for these bodies on a grid; nothing is computed yet."""
        ...
