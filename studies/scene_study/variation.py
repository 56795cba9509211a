"""The axis of a study that a varied field of a scene makes, with the value of the field at each of its values."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, make_dataclass, replace
from glob import glob, has_magic
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_origin

import numpy as np

import contactstudy as cs
from contactstudy import InvalidInput, MeasuredSurface, Reading, Tile
from contactstudy.domain.checks import parameters
from contactstudy.domain.identity import digest
from contactstudy.io.scene_files.scene_schema import KINDS, SceneDocument, Turn
from contactstudy.io.scene_files.structuring import structured
from studies.model.axis import Axis, Value
from studies.scene_study.fields import SceneField, document_of, find_field, non_optional, replaced
from studies.scene_study.values import parse_values

SURFACES, TILES = "surfaces", "tiles"
# Keys of a measured surface in a file, in the order in which they are applied.
SURFACE_KEYS = ("file", "tile", "turn")
# Long names of axes by path; other axes have the words of their path.
LONG_NAMES = {
    "load.per_length": "load per length",
    "friction.tangential": "tangential force per length",
    "friction.total": "tangential force",
    "friction.longitudinal": "longitudinal creepage",
    "friction.lateral": "lateral creepage",
    "friction.coefficient": "coefficient of friction",
}


@dataclass(frozen=True, eq=False)
class Variation:
    """Axis of a study, with the values of fields of the scene file along it.

    Parameters
    ----------
    axis
        Name, values and unit.
    changes
        Fields, and for each value of the axis the value of the field; several fields change together.
    notes
        Sentences on the axis.
    """

    axis: Axis
    changes: tuple[tuple[SceneField, Mapping[Value, Any]], ...]
    notes: tuple[str, ...] = ()

    @property
    def field(self) -> SceneField:
        """Field that names the axis."""
        return self.changes[0][0]

    @property
    def is_load(self) -> bool:
        """True if the axis is the load."""
        return self.field.path[0] == "load"


def with_values(document: SceneDocument, point: Iterable[tuple[Variation, Value]]) -> SceneDocument:
    """Return `document` with the values of all fields at the values of the axes.

    A part is replaced before its own fields are: a padding before its number of images.
    """
    changes = [
        (field, value, values[value]) for varied, value in point for field, values in varied.changes
    ]
    for field, value, new in sorted(changes, key=lambda change: _rank(change[0].path)):
        try:
            if _rank(field.path)[1] < len(SURFACE_KEYS):
                document = _with_surface(document, field.path, new)
            else:
                document = replaced(document, field.path, new)
        except InvalidInput as error:
            raise InvalidInput(f"{field.name} = {value!r}: {error}") from None
    return document


def _rank(path: Sequence[str]) -> tuple[int, int]:
    """Return what sorts fields by when they are set: by depth, and a surface is read, then cut, then turned."""
    is_key = path[0] == "shapes" and path[-1] in SURFACE_KEYS
    return len(path), SURFACE_KEYS.index(path[-1]) if is_key else len(SURFACE_KEYS)


def joint_variation(varied: Sequence[Variation]) -> Variation:
    """Return one axis along which several fields change, from the first value of each.

    The axis has the name and the values of the first field.

    Raises
    ------
    InvalidInput
        Unless all have equally many values.
    """
    counts = [len(part.axis.values) for part in varied]
    names = [part.field.name for part in varied]
    if len(set(counts)) > 1:
        raise InvalidInput(
            f"vary has {', '.join(map(str, counts))} values of {', '.join(names)}, which change together: give "
            "equally many different values of each."
        )
    axis = varied[0].axis
    changes = tuple(
        (field, dict(zip(axis.values, values.values(), strict=True)))
        for part in varied
        for field, values in part.changes
    )
    labels = [f"{part.field.name} = {', '.join(map(str, part.axis.values))}" for part in varied[1:]]
    return Variation(axis, changes, (f"along {axis.name}: {'; '.join(labels)}",))


def variation(
    described: cs.SceneFile, name: str, values_given: object, folder: Path, *, order: str = "rising"
) -> Variation:
    """Return the axis of a field over other values.

    Parameters
    ----------
    described
        Scene file whose field is varied.
    name
        Name of the field: a path, or a short name.
    values_given
        Values, as a text as on the command line, or a sequence.
    folder
        Folder at which paths of surfaces start.
    order
        Order of numbers on the axis, "rising" or as "given".

    Raises
    ------
    InvalidInput
        For a field that the scene lacks and values that it cannot have.
    """
    document = document_of(described)
    if name == SURFACES:
        return _surfaces(document, values_given, folder)
    if name == TILES:
        return _tiles(document, values_given)
    field = find_field(document, name)
    if field.path[-1] == "file":
        return _surfaces(document, values_given, folder, field)
    raw = (
        parse_values(name, values_given, field.number_type)
        if isinstance(values_given, str)
        else _as_list(name, values_given)
    )
    values: dict[Value, Any] = {}
    for entry in raw:
        made = _converted(field, entry)
        label = _label(made, entry)
        if isinstance(label, str) and digest(values.get(label, made)) != digest(made):
            label = f"{label} ({len(values)})"  # of an array that its representation shortens
        values.setdefault(label, made)
    # an infinite value, such as a rigid body's modulus, has no place on a scale: such values are names
    if all(isinstance(label, int | float) and np.isfinite(label) for label in values):
        if any(isinstance(label, float) for label in values):
            # equal values from different sums get one label
            values = {float(f"{label:.15g}"): made for label, made in values.items()}
        values = dict(sorted(values.items())) if order == "rising" else values
    else:
        names = (label if isinstance(label, str) else f"{label:.12g}" for label in values)
        values = dict(zip(names, values.values(), strict=True))
    long_name = LONG_NAMES.get(field.name) or _long_name(document, field)
    if field.unit and any(isinstance(label, str) for label in values):
        long_name = f"{long_name} [{field.unit}]"  # names have no unit in a file
    units = field.unit.replace("N/m", "N m-1") or "1"
    # the load that a contact carries is a measure
    name = "load_case" if field.name == "load" else "_".join(field.path)
    axis = Axis(name, tuple(values), long_name, units)
    return Variation(axis, ((field, values),))


def _as_list(name: str, values: object) -> list[object]:
    """Return the values of a sequence as a list."""
    if isinstance(values, Mapping) or not isinstance(values, Iterable):
        raise InvalidInput(
            f"vary[{name!r}] is {values!r}: give a list of values, or a text with commas."
        )
    raw = [entry.item() if isinstance(entry, np.generic) else entry for entry in values]
    if not raw:
        raise InvalidInput(f"vary[{name!r}] has no values: give one or more.")
    return raw


def _converted(field: SceneField, raw: object) -> Any:
    """Return a value as the type that stands at `field`."""
    if is_dataclass(raw) or (isinstance(raw, tuple) and raw and is_dataclass(raw[0])):
        return raw  # a Python object, which the scene checks
    if raw in (None, "none") and NoneType in get_args(field.annotation):
        return None
    if isinstance(raw, tuple):
        raw = list(raw)
    kind = non_optional(field.annotation)
    try:
        holder = make_dataclass("Value", [("value", kind)], frozen=True)
        return structured({"value": raw}, holder, KINDS, field.name).value
    except InvalidInput as error:
        sentence = re.sub(
            f"^{re.escape(field.name)}: value(?=[.:[])", field.name, str(error), flags=re.M
        )
        if field.name == "load" and not isinstance(raw, dict):
            sentence = f"load: it is {raw!r}: vary load.per_length, or give tables with a kind."
        if get_origin(kind) is tuple and not isinstance(raw, list):
            remedy = "give each value as a list of tables with their keys, in brackets"
            if {int, float} & {
                *get_args(kind),
                *get_args(get_args(kind)[0]),
            }:  # such as cells, or lengths with a unit
                count = 1 if Ellipsis in get_args(kind) else len(get_args(kind))
                remedy = f"give each value as a list in brackets, such as {[raw] * count}"
            sentence = f"{field.name}: it is {raw!r}: {remedy}."
        if is_dataclass(kind) and not isinstance(raw, dict):
            names = parameters(kind)
            sentence = (
                f"{field.name}: it is {raw!r}: give a field of it, "
                f"{' or '.join(f'{field.name}.{name}' for name in names)}."
            )
        raise InvalidInput(sentence) from None


def _label(made: Any, raw: object) -> Value:
    """Return the value on the axis: numbers and names as they are, dataclasses by their representation."""
    if isinstance(made, int | float | str) and not isinstance(made, bool):
        return made
    if isinstance(raw, str):
        return raw
    if is_dataclass(made):
        return repr(made)
    return str(raw)


def _long_name(document: SceneDocument, field: SceneField) -> str:
    """Return the long name of a field, such as "rms of Roughness"."""
    path = field.path
    # an entry of a list of numbers
    if len(path) > 2 and path[-1].isdigit() and path[-2] != "shapes":
        return f"{path[-2].replace('_', ' ')} {path[-1]} of {path[-3]}"
    name = path[-1].replace("_", " ").replace("youngs", "Young's").replace("poisson", "Poisson's")
    if path[0] == "solids" and len(path) == 3:
        return f"{name} of solids[{path[1]}]"
    if field.path[0] == "shapes" and len(field.path) > 2:
        return f"{name} of {type(document.shapes[int(field.path[1])]).__name__}"
    return f"{name} of {field.path[-2]}" if len(field.path) > 1 else name


def _only_surface(document: SceneDocument, what: str) -> str:
    """Return the index of the only measured surface of the scene, as text."""
    shapes = enumerate(document.shapes)
    indices = [str(number) for number, shape in shapes if isinstance(shape, MeasuredSurface)]
    if len(indices) != 1:
        raise InvalidInput(
            f"{what} are varied, but the scene has {len(indices)} shapes of the kind MeasuredSurface: give it one"
            + (f", or vary one by its path, such as shapes.{indices[0]}.file." if indices else ".")
        )
    return indices[0]


def _surfaces(
    document: SceneDocument, surfaces_given: object, folder: Path, field: SceneField | None = None
) -> Variation:
    """Return an axis of measured surfaces: files by name or pattern, topographies, or arrays with sizes."""
    field = field or SceneField(("shapes", _only_surface(document, "surfaces"), "file"), str)
    present = document.shapes[int(field.path[1])]
    assert isinstance(present, MeasuredSurface)
    items = surfaces_given.split(",") if isinstance(surfaces_given, str) else surfaces_given
    if not isinstance(items, Iterable):
        items = [items]
    values: dict[Value, Any] = {}
    for number, item in enumerate(_expanded_items(items, folder)):
        surface = _surface(item, present)
        name = Path(item).name if isinstance(item, str | Path) else getattr(item, "name", None)
        name = str(name or (Path(surface.file).name if surface.file else f"surface {number}"))
        if name in values:
            name = str(item) if isinstance(item, str | Path) else f"{name} ({number})"
        values[name] = surface
    if not values:
        raise InvalidInput("surfaces has no values: give one or more.")
    axis = Axis("surface", tuple(values), "measured surface")
    return Variation(axis, ((field, values),))


def _expanded_items(items: Iterable[Any], folder: Path) -> list[Any]:
    """Return surfaces with patterns replaced by the files that they match, and containers by their entries."""
    surfaces: list[Any] = []
    for item in items:
        if not isinstance(item, str | Path):
            # containers of the package SurfaceTopography hold several
            is_one = hasattr(item, "shape") or hasattr(item, "heights")
            surfaces += list(item) if hasattr(item, "__iter__") and not is_one else [item]
            continue
        pattern = str(item).strip()
        # relative to the working directory, then to the scene
        paths = [Path(pattern), folder / pattern]
        if has_magic(pattern):
            # not Path.glob, which has no absolute patterns
            lists = (sorted(glob(str(path))) for path in paths)  # noqa: PTH207
            matched = next((path for path in lists if path), [])
        else:
            matched = [str(path) for path in paths if path.is_file()][:1]
        if not matched:
            raise InvalidInput(
                f"surfaces has {pattern!r}, which no file matches: give existing files."
            )
        surfaces += matched
    return surfaces


def _surface(item: Any, present: MeasuredSurface) -> MeasuredSurface:
    """Return a surface as it is, or heights or a file prepared like the surface that the scene has."""
    if isinstance(item, MeasuredSurface):
        return item
    rules = {
        name: getattr(present, name)
        for name in ("missing", "trend", "filter", "seam", "seam_across")
    }
    is_file = isinstance(item, str | Path)
    if is_file:
        keys = {key.name: getattr(present.reading, key.name) for key in fields(Reading)}
        surface = MeasuredSurface.read(item, **keys, **rules)
    else:
        surface = MeasuredSurface(item, **rules)
    surface = surface if present.tile is None else surface.cut(present.tile)
    surface = surface.turned() if present.is_turned else surface
    # heights without sizes of their own
    has_sizes = is_file or surface.extent is not None
    return surface if has_sizes else replace(surface, extent=present.extent)


def _tiles(document: SceneDocument, tiles_given: object) -> Variation:
    """Return equal tiles of a surface as an axis, such as ``2x6`` across and along."""
    field = SceneField(("shapes", _only_surface(document, "tiles"), "tile"), Tile)
    text = tiles_given
    if not isinstance(text, str):
        text = "x".join(map(str, _as_list(TILES, tiles_given)))
    parts = text.replace(" ", "").split("x")
    if len(parts) != 2 or not all(part.isdigit() for part in parts):
        raise InvalidInput(f"tiles is {text!r}: give how many across and along, such as 2x6.")
    tiles = int(parts[0]), int(parts[1])
    values: dict[Value, Any] = {n: Tile(tiles, n) for n in range(tiles[0] * tiles[1])}
    if not values:
        raise InvalidInput(f"tiles is {text!r}: give at least 1x1.")
    long_name = f"tile of the surface, {tiles[0]} across and {tiles[1]} along it"
    return Variation(Axis("tile", tuple(values), long_name), ((field, values),))


def _with_surface(document: SceneDocument, path: tuple[str, ...], new: Any) -> SceneDocument:
    """Return `document` with another surface, with a tile of its surface, or with it turned."""
    shape = document.shapes[int(path[1])]
    assert isinstance(shape, MeasuredSurface)
    if path[-1] == "file":
        shape = new
    elif path[-1] == "tile":
        if shape.tile is not None:
            raise InvalidInput("the surface is a tile already: leave tile out of the file.")
        # a surface is cut before it is turned
        shape = _as_measured(shape).cut(new).turned() if shape.is_turned else shape.cut(new)
    elif (new is Turn.QUARTER) != shape.is_turned:
        shape = _as_measured(shape) if shape.is_turned else shape.turned()
    return replaced(document, path[:2], shape)  # type: ignore[no-any-return]


def _as_measured(surface: MeasuredSurface) -> MeasuredSurface:
    """Return a surface that was rotated by 90 degrees as it was before."""
    return replace(surface.turned().turned().turned(), file=surface.file)
