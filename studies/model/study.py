"""What a study is: four names in a Python file, and a few more where it has something to say."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.checks import remedy
from studies.model.axis import Axis, Value, one_of
from studies.model.case import Computation
from studies.model.finding import Finding, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Point = Mapping[str, Value]
# of what a study computes, and of its result: as specific as the study
Measures = Callable[[Any, Any], Mapping[str, xr.Variable]]


@dataclass(frozen=True, eq=False)
class Plate:
    """A figure with its file name and the words that go under it."""

    name: str
    figure: "Figure"
    caption: str


def silent(dataset: xr.Dataset) -> tuple[()]:
    """What a study says that only draws."""
    return ()


@dataclass(frozen=True, eq=False)
class Study:
    """``points`` to visit, ``scene_at`` a point, what one ``measures`` there, and the ``figure`` drawn.

    ``points``: the axes. ``scene_at(point)``: the computation at a point, mostly a
    :class:`~studies.model.case.Case`; bad values raise :class:`~contactstudy.InvalidInput`.
    ``measures(case, result)``: named variables,
    scalar or with dimensions of their own; a variable named like its dimension is its coordinate.
    ``figure(dataset)``: the plates, drawn from the stored Dataset alone. ``findings(dataset)`` and
    ``tables(dataset)``: what the report says beside them; nothing, unless the file defines them. ``times``
    of its cases are "taken", or "none" where nothing is to be said about them.
    """

    name: str
    title: str
    points: tuple[Axis, ...]
    scene_at: Callable[[Point], Computation]
    measures: Measures
    figure: Callable[[xr.Dataset], Sequence[Plate]]
    findings: Callable[[xr.Dataset], Sequence[Finding]] = silent
    tables: Callable[[xr.Dataset], Sequence[Table]] = silent
    times: str = "taken"

    def __post_init__(self) -> None:
        one_of("times", self.times, ("taken", "none"))

    def override(self, axes: Mapping[str, str | Iterable[Value]]) -> "Study":
        """This study over other values of some of its axes."""
        known = {axis.name: axis for axis in self.points}
        for name in axes:
            if name not in known:
                raise InvalidInput(
                    f"Parameter {name!r} is not one of study {self.name!r}: {remedy(name, sorted(known))}."
                )
        changed = tuple(
            axis.override(axes[axis.name]) if axis.name in axes else axis for axis in self.points
        )
        return replace(self, points=changed)

    def visits(self) -> Iterator[tuple[Point, Computation]]:
        """Every point with its case, in the order of the axes (last one fastest)."""
        names = [axis.name for axis in self.points]
        for values in product(*(axis.values for axis in self.points)):
            point = dict(zip(names, values, strict=True))
            yield point, self.scene_at(point)

    def cases(self) -> list[Computation]:
        """The case at every point, in the order of the axes (last one fastest)."""
        return [case for _, case in self.visits()]
