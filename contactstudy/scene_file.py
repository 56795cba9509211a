"""A scene in a TOML file: numbers in SI units, or texts with a unit such as "10 mm"."""

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactstudy.domain.device import Cpu, Device
from contactstudy.domain.errors import InNotebook
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput, parameters
from contactstudy.evolution.march import TimeSteps
from contactstudy.forecast import plan
from contactstudy.io.scene_files.scene_schema import (
    KINDS,
    MeanPressure,
    PlanSettings,
    SceneDocument,
    shape_of,
    with_materials,
)
from contactstudy.io.scene_files.structuring import likely_units, scene_text, structured, with_cycles
from contactstudy.planning.grid_requirements import grid_of_waves
from contactstudy.planning.planned import Plan
from contactstudy.scene.loads import TotalLoad
from contactstudy.scene.scene import AnyLoad, Scene
from contactstudy.scene.shapes.roller import Ellipsoid, Sphere
from contactstudy.scene.shapes.shape import Shape, curvature_of, length_scales_of
from contactstudy.solvers.solve import SolveOptions
from contactstudy.solving import solve

if TYPE_CHECKING:
    from contactstudy.answers.contact import Contact
    from contactstudy.answers.evolution import Evolution
    from contactstudy.answers.lubricated_contact import LubricatedContact


# One of the doubts of a file: a flat under a mean pressure whose padding is periodic, and given along the length alone.
ONE_PADDING = (
    "padding is that along the length alone, and leaves the surface free across, as if it ended there: leave it out, or "
    'give padding_across = "ExactPeriodicity" too.'
)
# A key and a number with a unit that is not in quotes.
BARE_UNIT = re.compile(r"\s*([\w.]+)\s*=\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?\s*[^\W\d][^#\"']*|[\d.]+\s*%)\s*(?:#.*)?")


@dataclass(frozen=True)
class SceneFile(InNotebook):
    """Contents of a scene file: the scene, and grid, padding and options if given; a missing grid is planned.

    Parameters
    ----------
    scene
        The scene.
    plan_settings
        Accuracy and period of the plan.
    options
        Options of a solve.
    grid, padding
        Grid and padding of the file, or None.
    time_steps
        Instants of a scene that changes in time.
    vary
        Fields that the file varies, by their paths, in groups: fields of one group change together.
    doubts
        Warnings: a number without a unit that is likely in another one than SI, a padding that was likely left out.
    """

    scene: Scene
    plan_settings: PlanSettings = field(default_factory=PlanSettings)
    options: SolveOptions = field(default_factory=SolveOptions)
    grid: Grid | None = None
    padding: Padding | Paddings | None = None
    time_steps: TimeSteps = field(default_factory=TimeSteps)
    vary: tuple[Mapping[str, object], ...] = ()
    doubts: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def plan(self, *, device: Device = Cpu()) -> Plan:  # noqa: B008 (frozen)
        """Return the plan for this scene, with the grid and padding of the file; seconds are for the `device`."""
        planned = plan(self.scene, device=device, **self._plan_arguments)
        return replace(planned, warnings=(*self.doubts, *planned.warnings))

    @property
    def _plan_arguments(self) -> dict[str, Any]:
        """Arguments of a plan that the file gives, by name."""
        return {
            "error": self.plan_settings.error,
            "period": self.plan_settings.period,
            "grid": self.grid,
            "padding": self.padding,
            "times": None if self.time_steps == TimeSteps() else self.time_steps,
        }

    def solve(self, **keywords: Any) -> "Contact | LubricatedContact | Evolution":
        """Solve the scene where and as the file says; `keywords` as for :func:`~contactstudy.solve`."""
        return solve(self.scene, **(self._plan_arguments | {"options": self.options} | keywords))


def read_scene(path: str | PathLike[str]) -> SceneFile:
    """Read a scene from a TOML file.

    Tables ``load``, ``solids`` (two), ``shapes`` (each with its ``kind``), ``outputs``, ``friction``, ``wear``,
    ``rolling``, ``lubrication``, ``adhesion``, ``grid``, ``padding``, ``padding_across``, ``plan``, ``solve``,
    ``time_steps`` and ``vary``, and the key ``hardness``, have the fields of the corresponding classes as keys. A solid
    may name its ``material``.

    Raises
    ------
    InvalidInput
        With a line for every key that cannot be used.
    """
    path = Path(path)
    raw, groups = tables_of(path)
    document, doubts = document_from(raw, str(path)), tuple(likely_units(raw))
    try:
        described = scene_file_from(document, path.parent)
    except InvalidInput as error:
        raise InvalidInput("\n".join((f"{path}: {error}", *doubts))) from error
    return replace(described, vary=groups, doubts=(*described.doubts, *doubts))


def tables_of(path: Path) -> tuple[dict[str, Any], tuple[Mapping[str, object], ...]]:
    """Return the tables of a scene file, and the fields that it varies in groups.

    Raises :class:`~contactstudy.InvalidInput` for a file that cannot be read or is not TOML.
    """
    text = ""
    try:
        text = path.read_text(encoding="utf-8-sig")
        raw = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not text in UTF-8"
        raise InvalidInput(f"{path} cannot be read ({reason}): give a scene in TOML.") from error
    except (ValueError, RecursionError) as error:  # Python refuses numbers of thousands of digits by a ValueError
        quotes = _missing_quotes(text, str(error))
        raise InvalidInput(f"{path} is not valid TOML: {error}{quotes}.") from error
    return raw, _groups(path, raw.pop("vary", {}))


def document_from(raw: Mapping[str, Any], source: str) -> SceneDocument:
    """Return the tables of a scene file, in which Python objects may stand, as its keys with their types.

    Raises :class:`~contactstudy.InvalidInput`, which begins with the `source`, with a line for every key that cannot be
    used.
    """
    try:
        raw = with_cycles(with_materials(raw))
    except InvalidInput as error:
        raise InvalidInput(f"{source}: {error}") from error
    return structured(raw, SceneDocument, KINDS, source)


def write_scene(described: Scene | SceneFile, path: str | PathLike[str]) -> None:
    """Write a scene, or the contents of a scene file, to a TOML file.

    The heights of a measured surface that was not read from a file are written beside it, as netCDF.

    Parameters
    ----------
    described
        A scene, or the result of :func:`~contactstudy.read_scene`.
    path
        File to write.

    Raises
    ------
    InvalidInput
        For a shape or a body that no file can hold, or a file that cannot be written.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise InvalidInput(f"{path} cannot be written (no such folder): give a path in an existing folder.")
    if isinstance(described, Scene):
        text = scene_text(described, scene_path=path)
    else:
        settings = {"plan": described.plan_settings, "solve": described.options, "time_steps": described.time_steps}
        settings |= {"vary": described.vary or None}
        grid, padding = described.grid, described.padding
        text = scene_text(described.scene, grid=grid, padding=padding, settings=settings, scene_path=path)
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InvalidInput(f"{path} cannot be written ({error.strerror}): give another path.") from None


def scene_file_from(document: SceneDocument, folder: Path = Path()) -> SceneFile:
    """Return the scene of `document`; files of surfaces start at `folder`."""
    # what a profile for a load follows from; surfaces of a scene without curvature repeat across too
    context = sum(map(curvature_of, document.shapes)), document.solids
    shapes = tuple(shape_of(shape, folder, context) for shape in document.shapes)
    is_flat = isinstance(document.load, MeanPressure)
    if is_flat and document.grid is None and not any(scales.spacing for scales in length_scales_of(shapes)):
        document = replace(document, grid=grid_of_waves(shapes))
    of_scene = {name: getattr(document, name) for name in parameters(Scene)}
    scene = Scene(**of_scene | {"load": _with_length(document, shapes), "shapes": shapes})
    padding: Padding | Paddings | None = document.padding
    doubts: tuple[str, ...] = ()
    if is_flat and document.padding_across is None:
        if document.padding is None:  # nominally flat: periodic both ways
            padding = ExactPeriodicity(), ExactPeriodicity()
        elif document.padding.wraps or document.padding.window is None:
            doubts = (ONE_PADDING,)
    if document.padding_across is not None:
        if document.padding is None:
            raise InvalidInput("padding_across is given without padding: give the one along the length too.")
        padding = document.padding_across, document.padding
    return SceneFile(scene, document.plan, document.solve, document.grid, padding, document.time_steps, doubts=doubts)


def _missing_quotes(text: str, error: str) -> str:
    """Return what to write in place of a number with a unit without quotes, in the line of a TOML `error`, or ``""``."""
    line = re.search(r"at line (\d+)", error)
    lines = text.splitlines()
    source = lines[int(line[1]) - 1] if line and int(line[1]) <= len(lines) else ""
    bare = BARE_UNIT.fullmatch(source)
    return f': a value with a unit is in quotes, write {bare[1]} = "{bare[2].strip()}"' if bare else ""


def _groups(path: Path, vary: object) -> tuple[Mapping[str, object], ...]:
    """Return the varied fields of a file in groups: one for each field of a table, or for each table of a list."""
    if isinstance(vary, Mapping):
        return tuple({field: values} for field, values in _paths(vary).items())
    if isinstance(vary, list) and all(isinstance(group, Mapping) and group for group in vary):
        return tuple(_paths(group) for group in vary)
    raise InvalidInput(
        f"{path}: vary is {vary!r}: give a table of fields and their values, such as load.per_length = '50:400:8 N/mm'."
    )


def _paths(table: Mapping[str, object], before: str = "") -> dict[str, object]:
    """Return the values of nested tables by their paths."""
    paths: dict[str, object] = {}
    for key, value in table.items():
        paths |= _paths(value, f"{before}{key}.") if isinstance(value, Mapping) else {before + key: value}
    return paths


def _with_length(document: SceneDocument, shapes: Iterable[Shape]) -> AnyLoad:
    """Return the load; a total load on shapes without a length is spread over the length of the grid, if known."""
    load, grid, scales = document.load, document.grid, length_scales_of(shapes)
    if isinstance(load, MeanPressure):
        measured = [of_shape.known_width for of_shape in scales if of_shape.spacing]
        return load.load(grid.extent[0] if grid else min(measured, default=None), tuple(shapes))
    # a point contact needs no length
    has_length = any(0 < of_shape.roller < inf for of_shape in scales)
    has_length = has_length or any(isinstance(shape, Sphere | Ellipsoid) for shape in shapes)
    period = grid.length if grid else document.plan.period
    if isinstance(load, TotalLoad) and load.length is None and not has_length and period:
        return replace(load, length=period)
    return load
