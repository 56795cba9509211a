"""The heights of a scene's shapes on any grid, and the scene's problem there."""

from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.problem.problem import Problem
from contactstudy.scene.shapes.shape import Shape


@dataclass(frozen=True)
class ShapesSource:
    """``shapes`` whose heights are sampled anew on each grid; ``make`` builds the problem there.

    ``ends_along`` says whether one of them ends a roller.
    """

    shapes: tuple[Shape, ...]
    ends_along: bool
    make: Callable[[Grid], Problem]

    @property
    def finest(self) -> tuple[float, float]:
        """The shortest of all shapes that name theirs."""
        details = [shape.detail for shape in self.shapes if hasattr(shape, "detail")]
        return (
            min((one.finest[0] for one in details), default=inf),
            min((one.finest[1] for one in details), default=inf),
        )

    @property
    def names_scales(self) -> bool:
        """Whether every shape has a ``detail``."""
        return all(hasattr(shape, "detail") for shape in self.shapes)

    def gap(self, grid: Grid) -> Array:
        """The sum of all shapes, no larger than it must be."""
        total: Array = sum((shape.gap(grid) for shape in self.shapes), start=grid.x[:, None] * 0)
        return total

    def problem(self, grid: Grid) -> Problem:
        """The scene's own."""
        return self.make(grid)


def sized(shapes: tuple[Shape, ...], grid: Grid) -> tuple[Shape, ...]:
    """``shapes`` that can be sampled on other grids: heights given cell for cell get the extent of ``grid``."""
    return tuple(shape.sized(grid) if hasattr(shape, "sized") else shape for shape in shapes)


def ends_along(shapes: tuple[Shape, ...], grid: Grid) -> bool:
    """Whether a roller ends within the period of ``grid``, so that contact may reach its ends."""
    lengths = [shape.detail.roller for shape in shapes if hasattr(shape, "detail")]
    return any(0 < length <= grid.period * (1 + 1e-9) for length in lengths)
