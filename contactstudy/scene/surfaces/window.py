"""One of the equal windows that a measured surface is cut into."""

from dataclasses import dataclass

from contactstudy.domain.checks import InvalidInput, pair, set_fields, whole
from contactstudy.domain.fields import Array


@dataclass(frozen=True)
class Window:
    """Window ``number`` of ``tiles`` (across, along) equal ones, counted from 0, along the length first.

    Points left over where the tiles do not divide them belong to none, at the far ends.
    Raises :class:`~contactstudy.InvalidInput` for a number that there is not.
    """

    tiles: tuple[int, int]
    number: int = 0

    def __post_init__(self) -> None:
        remedy = "give two whole numbers, (across, along)"
        across, along = pair("Window.tiles", self.tiles, remedy)
        tiles = (
            whole("Window.tiles[0]", across, 1, "give at least 1 window across"),
            whole("Window.tiles[1]", along, 1, "give at least 1 window along"),
        )
        count = tiles[0] * tiles[1]
        number = whole("Window.number", self.number, 0, f"give a number from 0 to {count - 1}")
        if number >= count:
            raise InvalidInput(f"Window.number is {number}: give a number from 0 to {count - 1}.")
        set_fields(self, tiles=tiles, number=number)

    def of(self, points: Array) -> Array:
        """The window of ``points`` (x, y)."""
        sides = [count // tiles for count, tiles in zip(points.shape, self.tiles, strict=True)]
        if min(sides) < 2:
            raise InvalidInput(
                f"Window.tiles is {self.tiles}: give fewer, since the surface has {points.shape} points and a "
                "window needs 2 x 2."
            )
        first, second = divmod(self.number, self.tiles[1])
        return points[
            first * sides[0] : (first + 1) * sides[0], second * sides[1] : (second + 1) * sides[1]
        ]
