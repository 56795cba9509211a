"""What a study computes: its axes, the computation at each point, and what is measured there."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion
from studies.model.axis import Axis, Value, one_of
from studies.model.case import Computation

Point = Mapping[str, Value]
# Arguments: the computation and its result, of whatever types the study uses.
Measures = Callable[[Any, Any], Mapping[str, xr.Variable]]


@dataclass(frozen=True, eq=False)
class Study:
    """``points`` to visit, the computation ``scene_at`` a point, and what it ``measures`` there.

    ``points``: the axes. ``scene_at(point)``: the computation at a point, usually a
    :class:`~studies.model.case.Case`; bad values raise :class:`~contactstudy.InvalidInput`.
    ``measures(case, result)``: named variables, scalar or with dimensions of their own; a variable
    named like its dimension is its coordinate. ``times``: "taken" if the cases are timed, else "none".
    """

    name: str
    title: str
    points: tuple[Axis, ...]
    scene_at: Callable[[Point], Computation]
    measures: Measures
    times: str = "taken"

    def __post_init__(self) -> None:
        one_of("times", self.times, ("taken", "none"))

    def override(self, axes: Mapping[str, str | Iterable[Value]]) -> "Study":
        """This study over other values of some of its axes."""
        known = {axis.name: axis for axis in self.points}
        for name in axes:
            if name not in known:
                raise InvalidInput(
                    f"Parameter {name!r} is not one of study {self.name!r}: {suggestion(name, sorted(known))}."
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
