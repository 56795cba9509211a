"""What a scene may ask to be found from its solution."""

from typing import Protocol, runtime_checkable

from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Paddings
from contactstudy.problem.problem import Derived
from contactstudy.scene.bodies.solids import Body


@runtime_checkable
class Output(Protocol):
    """A value in ``Scene.outputs``."""

    def check(self, solids: tuple[Body, ...]) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if these bodies cannot give it."""
        ...

    def of(self, solids: tuple[Body, ...], grid: Grid, paddings: Paddings) -> Derived:
        """The same for these bodies on a grid; nothing is computed yet."""
        ...
