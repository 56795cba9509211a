"""Studies: their axes, the computation at each point, and what is measured there."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactstudy import InvalidInput
from contactstudy.domain.errors import InNotebook
from contactstudy.domain.validation import suggestion
from studies.model.axis import Axis, Value, one_of
from studies.model.plain_text import name_problem, one_line, place_of, shortened

if TYPE_CHECKING:
    import xarray as xr

    from studies.model.case import Computation

Point = Mapping[str, Value]
# Arguments: the computation and its result, of whatever types the study uses.
Measures = Callable[[Any, Any], "Mapping[str, xr.Variable]"]


@dataclass(frozen=True, eq=False)
class Study(InNotebook):
    """A study: its axes, the computation at each point, and what is measured there.

    Parameters
    ----------
    name, title
        Name of its files, and a line for people.
    axes
        Axes whose product is visited.
    case_at
        ``case_at(point)`` returns the computation at a point, usually a :class:`~studies.model.case.Case`; bad
        values raise :class:`~contactstudy.InvalidInput`.
    measures
        ``measures(case, result)`` returns named variables, scalar or with dimensions of their own; a variable
        named like its dimension is its coordinate.
    times
        "taken" if the cases are timed, else "none".
    notes
        Sentences on all points, such as the grid that they share; kept with the results.
    attributes
        Attributes of the stored Dataset.
    depends
        Files that it reads, beside ``folder``: where one changes, what is stored is recomputed.
    folder
        Folder of the study file, which gives it.
    """

    name: str
    title: str
    axes: tuple[Axis, ...]
    case_at: Callable[[Point], Computation]
    measures: Measures
    times: str = "taken"
    notes: tuple[str, ...] = ()
    attributes: Mapping[str, str] = field(default_factory=dict)
    depends: tuple[str, ...] = ()
    folder: Path = Path()

    def __post_init__(self) -> None:
        one_of("times", self.times, ("taken", "none"))
        for part in ("case_at", "measures"):
            if not callable(getattr(self, part)):
                raise InvalidInput(f"Study.{part} is {shortened(getattr(self, part))}: give a function.")
        if not self.axes or not all(isinstance(axis, Axis) for axis in self.axes):
            raise InvalidInput(
                f"Study.axes is {shortened(self.axes)}: give studies.Axis, such as (Axis('grid', (16, 32), 'cells'),)."
            )
        if problem := name_problem(self.name):
            raise InvalidInput(f"A study is called {shortened(self.name)}: {problem}.")
        names = [axis.name for axis in self.axes]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise InvalidInput(f"Study {self.name!r} has two axes {twice!r}: give each a name of its own.")

    @property
    def size(self) -> int:
        """Number of points."""
        return prod(len(axis.values) for axis in self.axes)

    def check_size(self, max_count: int | None) -> None:
        """Raise InvalidInput for more than `max_count` points; None allows any."""
        if max_count is not None and self.size > max_count:
            raise InvalidInput(
                f"Study {self.name!r} has {self.size} points, more than {max_count}: give fewer, or run it from Python "
                "with RunOptions(max_points=None)."
            )

    def override(self, axes: Mapping[str, str | Iterable[Value]]) -> Study:
        """Return this study with other values of some axes.

        Parameters
        ----------
        axes
            Values by name of the axis, as for :meth:`~studies.model.axis.Axis.override`.

        Raises
        ------
        InvalidInput
            For an axis or a value that the study does not have.
        """
        present = {axis.name: axis for axis in self.axes}
        for name in axes:
            if name not in present:
                raise InvalidInput(
                    f"Axis {name!r} is not one of study {self.name!r}: {suggestion(name, sorted(present))}."
                )
        changed = {name: present[name].override(values) for name, values in axes.items()}
        return replace(self, axes=tuple((present | changed).values()))

    def visits(self) -> Iterator[tuple[Point, Computation]]:
        """Yield every point with its case, in the order of the axes (last one fastest)."""
        names = [axis.name for axis in self.axes]
        for values in product(*(axis.values for axis in self.axes)):
            point = dict(zip(names, values, strict=True))
            try:
                case = self.case_at(point)
            except InvalidInput:
                raise
            except Exception as error:  # noqa: BLE001 (a study file may do anything)
                raise InvalidInput(
                    f"case_at of study {self.name!r} raises {type(error).__name__}{place_of(error, __file__)} at "
                    f"{one_line(point, 200)}: {one_line(error, 300)}."
                ) from None
            yield point, case

    def cases(self) -> list[Computation]:
        """Return the case at every point, in the order of the axes (last one fastest)."""
        return [case for _, case in self.visits()]
