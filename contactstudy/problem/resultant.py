"""What the pressures of all cells carry together."""

from dataclasses import dataclass
from typing import Protocol, Self

from contactstudy.domain.devices.arrays import Array
from contactstudy.problem.constraint import Constraint


class Resultant(Protocol):
    """What closes the problem beside the conditions in each cell."""

    def scaled(self, pressure: float, cells: int = 1) -> Self:
        """The same in another unit of pressure (times ``pressure``), on blocks of so many cells."""
        ...

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Whether so many cells under ``constraint`` can meet it."""
        ...

    def uniform(self, cells: int) -> float:
        """The pressure that meets it if it is the same in so many cells."""
        ...

    def admit(self, trial: Array, constraint: Constraint) -> Array:
        """``trial`` cut off at the limits of ``constraint`` and made to meet this, in place."""
        ...

    def nearest(self, trial: Array, constraint: Constraint) -> Array:
        """The admissible pressure nearest to ``trial``, in place: a step against the gap, made so, is downhill."""
        ...

    def levelled(self, trial: Array, cells: Array, constraint: Constraint) -> Array:
        """``trial`` cut off at the limits and made to meet this by a shift of ``cells``, in place."""
        ...

    def error(self, borne: float) -> float:
        """How far a pressure whose sum is ``borne`` is from meeting it, dimensionless."""
        ...


@dataclass(frozen=True)
class PrescribedLoad:
    """``sum(p) = total``: the load over the area of a cell, in the unit of p."""

    total: float

    def scaled(self, pressure: float, cells: int = 1) -> "PrescribedLoad":
        """In another unit, on larger cells."""
        return PrescribedLoad(float(self.total * pressure / cells))

    def is_met_by(self, constraint: Constraint, cells: int) -> bool:
        """Whether the cells can carry the load."""
        return constraint.capacity(cells) >= self.total

    def uniform(self, cells: int) -> float:
        """The load spread evenly."""
        return self.total / cells

    def admit(self, trial: Array, constraint: Constraint) -> Array:
        """Scaled to the load."""
        return constraint.carrying(trial, self.total)

    def nearest(self, trial: Array, constraint: Constraint) -> Array:
        """Shifted to the load."""
        return constraint.nearest(trial, self.total)

    def levelled(self, trial: Array, cells: Array, constraint: Constraint) -> Array:
        """Shifted to the load."""
        return constraint.levelled(trial, cells, self.total)

    def error(self, borne: float) -> float:
        """``|borne / total - 1|``."""
        return abs(borne / self.total - 1)
