"""What a study is: four names in a Python file, and a few more where it has something to say."""

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import xarray as xr

from contactstudy import InvalidInput
from contactstudy.checks import remedy
from studies.axis import Axis, Value, one_of
from studies.case import Computation
from studies.finding import Finding, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Point = Mapping[str, Value]
# of what a study computes, and of its result: as specific as the study
Measures = Callable[[Any, Any], Mapping[str, xr.Variable]]

# Those the report is made of, and those that want more than this project installs.
BUILT_IN = (
    "paper",
    "padding",
    "images",
    "period",
    "grid",
    "kernels",
    "speed",
    "roughness",
    "effects",
    "pareto",
    "stability",
)
OPTIONAL = ("peers",)


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
    :class:`~studies.case.Case`; bad values raise :class:`~contactstudy.InvalidInput`.
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


def load(name: str) -> Study:
    """The built-in study of that name, or the one in a Python file.

    Raises :class:`~contactstudy.InvalidInput` where there is none, or one of its four names is missing.
    """
    if name.endswith(".py"):
        if Path(name).stem in BUILT_IN + OPTIONAL:
            raise InvalidInput(f"Study file {name!r} has the name of a built-in study: rename it.")
        return _study(Path(name).stem, _from_file(Path(name)))
    if name not in BUILT_IN + OPTIONAL:
        known = remedy(name, sorted(BUILT_IN + OPTIONAL))
        raise InvalidInput(f"Study {name!r} is not known: {known}, or give a .py file.")
    return _study(name, importlib.import_module(f"studies.{name}"))


def _from_file(path: Path) -> ModuleType:
    # a name of its own, lest a file called time.py be taken for Python's
    name = f"study_in_file_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if not path.is_file() or spec is None or spec.loader is None:
        raise InvalidInput(
            f"Study file {str(path)!r} cannot be read: give the path of a Python file."
        )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    # workers know nothing of this file: send its functions by value, not by name
    from cloudpickle import register_pickle_by_value

    sys.modules[name] = module
    register_pickle_by_value(module)
    return module


def _study(name: str, module: ModuleType) -> Study:
    for part in ("points", "scene_at", "measures", "figure"):
        if not hasattr(module, part):
            raise InvalidInput(
                f"Study {name!r} has no {part!r}: define it at the file's top level."
            )
    title = (module.__doc__ or name).strip().split("\n")[0]
    return Study(
        name,
        title,
        tuple(module.points),
        module.scene_at,
        module.measures,
        module.figure,
        getattr(module, "findings", silent),
        getattr(module, "tables", silent),
        getattr(module, "times", "taken"),
    )
