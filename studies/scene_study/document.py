"""A scene file as a document: tables in which values at paths are varied, and which the ordinary reader then reads."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from glob import glob, has_magic
from itertools import product
from math import isfinite, prod
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

import contactstudy as cs
from contactstudy import InvalidInput, MeasuredSurface
from contactstudy.domain.files import digest
from contactstudy.domain.validation import Unit, kind_of, parameters, suggestion
from contactstudy.io.scene_files.scene_schema import MeasuredSurfaceTable, SceneDocument
from contactstudy.scene.shapes.shape import curvature_of
from contactstudy.scene.surfaces.text_surface import Reading
from contactstudy.scene_file import SceneFile, document_from, scene_file_from
from studies.model.axis import Axis, Value, check_count, parse_values
from studies.model.plain_text import one_line, shortened

Table = Mapping[str, Any]
# Points of a sweep, of which each has a document.
MAX_POINTS = 100_000
# Short names of keys that are often varied.
SHORT_NAMES = {
    "n": "padding.images",
    "images": "padding.images",
    "period": "plan.period",
    "error": "plan.error",
    "tolerance": "solve.tolerance",
    "solver": "solve.solver",
    "precision": "solve.precision",
    "max_iterations": "solve.max_iterations",
}
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
class Varied:
    """Key of a document that is varied: its path, its values as a file has them, and the name of its axis."""

    path: tuple[str, ...]
    values: Sequence[Any]
    axis: str
    long_name: str = ""

    @property
    def name(self) -> str:
        """Path as written in a command, such as ``shapes.1.rms``."""
        return ".".join(self.path)


def tables(described: SceneFile) -> dict[str, Any]:
    """Return the tables of a scene, whose entries are Python objects."""
    across, along = described.padding if isinstance(described.padding, tuple) else (None, described.padding)
    entries = {key.name: getattr(described.scene, key.name, None) for key in fields(SceneDocument)}
    entries |= {"grid": described.grid, "padding": along, "padding_across": across}
    entries |= {"plan": described.plan_settings, "solve": described.options}
    entries |= {"time_steps": described.time_steps}
    return {key: entry for key, entry in entries.items() if entry is not None}


def replaced(raw: Any, path: Sequence[str], value: object) -> Any:
    """Return a copy of tables with a value at a path; tables on the way are made, and the value None is left out.

    Raises :class:`~contactstudy.InvalidInput` for an entry that a list lacks.
    """
    if not path:
        return value
    first, *below = path
    if isinstance(raw, list | tuple):
        if not first.isdigit() or int(first) >= len(raw):
            names = (
                f"{k} {entry.get('kind', '') if isinstance(entry, dict) else _kind(entry)}".strip()
                for k, entry in enumerate(raw)
            )
            raise InvalidInput(f"{first!r} is none of its entries, {', '.join(names) or 'none'}.")
        k = int(first)
        return [*raw[:k], replaced(raw[k], below, value), *raw[k + 1 :]]
    if is_dataclass(raw):
        if not type(raw).__module__.startswith("contactstudy."):  # no file can name a class of the user
            if first not in parameters(raw):
                raise InvalidInput(f"{raw!r} has no {first!r}: {suggestion(first, parameters(raw))}.")
            return replace(raw, **{first: replaced(getattr(raw, first), below, value)})  # type: ignore[type-var]
        raw = _table_of(raw)
    if isinstance(raw, str):  # a kind may stand for its table
        raw = {"kind": raw}
    if not isinstance(raw, Mapping):
        raise InvalidInput(f"it is {raw!r}, which has no {first!r}: give a table.")
    new = replaced(raw.get(first, {}), below, value)
    return {key: entry for key, entry in {**raw, first: new}.items() if entry is not None}


def _kind(entry: object) -> str:
    """Return the name of the kind of an entry, or the entry."""
    return type(entry).__name__ if is_dataclass(entry) else str(entry)


def _table_of(value: Any) -> dict[str, Any]:
    """Return a dataclass as a table of its kind; that of a measured surface has its file, or the bare surface."""
    if not isinstance(value, MeasuredSurface):
        return {"kind": type(value).__name__} | {n: getattr(value, n) for n in parameters(value)}
    rules = {n: getattr(value, n) for n in ("missing", "trend", "seam", "seam_across", "filter")}
    turn = "quarter" if value.is_turned else "none"
    table: dict[str, Any] = {"kind": "MeasuredSurface", "turn": turn} | rules
    if value.file is not None:
        reading = {key.name: getattr(value.reading, key.name) for key in fields(Reading)}
        return table | reading | {"file": value.file, "tile": value.tile}
    upright = value.turned().turned().turned() if value.is_turned else value
    return table | {"file": replace(upright, tile=None), "extent": upright.extent}


def varied(raw: Table, document: SceneDocument, name: str, values_given: object, folder: Path) -> Varied:
    """Return the key with a name, and its values.

    Parameters
    ----------
    raw, document
        Tables of the scene, and what the reader makes of them.
    name
        A path, a short name, a key that one shape alone has, ``surfaces`` or ``tiles``.
    given
        Values, as a text as on the command line, or a sequence.
    folder
        Folder at which paths of surfaces start.

    Raises
    ------
    InvalidInput
        For a key that a scene cannot have, and for a text that gives no values.
    """
    path = _path(raw, document, name)
    if name == "tiles":
        return _tiles(path, values_given)
    if path[-1] == "file":
        return Varied(path, _surfaces(values_given, folder), "surface", "measured surface")
    _, annotation = at(document, path)
    is_whole = annotation is None or int in map(kind_of, (annotation, *get_args(annotation)))
    if not isinstance(values_given, str):
        values = _listed(name, values_given)
        if get_origin(annotation) is tuple:  # a list in a file has no type of numpy
            values = [element.tolist() if isinstance(element, np.ndarray) else element for element in values]
    else:
        try:
            values = parse_values(name, values_given, int if is_whole else float)
        except InvalidInput:
            if annotation is not None:  # the type of a part that the file leaves out is not known
                raise
            values = parse_values(name, values_given, float)
    # the name `load` is that of a measure, the load that a contact carries
    return Varied(path, values, "load_case" if path == ("load",) else "_".join(path))


def _path(raw: Table, document: SceneDocument, name: str) -> tuple[str, ...]:
    """Return the path of a name; raise InvalidInput for one that begins with no key."""
    if name in ("surfaces", "tiles"):
        return _surface_path(document, name)
    keys = [key.name for key in fields(SceneDocument)]
    key = "grid.extent.1" if name == "period" and "grid" in raw else SHORT_NAMES.get(name, name)
    path = tuple(key.replace("[", ".").replace("]", "").split("."))  # messages write an entry as in solids[0]
    if path[0] in keys:
        return path
    owners = [k for k, shape in enumerate(document.shapes) if path[0] in parameters(_described(shape))]
    if len(owners) == 1:
        return "shapes", str(owners[0]), *path
    if owners:
        several = ", ".join(f"shapes.{k}.{name}" for k in owners)
        raise InvalidInput(f"Field {name!r} is one of several shapes: give one of {several}.")
    hint = suggestion(path[0], sorted([*keys, *SHORT_NAMES]))
    raise InvalidInput(f"Field {name!r} is not in the scene: {hint}, or a path such as shapes.0.radius.")


def _described(shape: object) -> Any:
    """Return what has the keys of a shape in a file."""
    return MeasuredSurfaceTable if isinstance(shape, MeasuredSurface) else shape


def at(document: SceneDocument, path: Sequence[str]) -> tuple[Any, Any]:
    """Return the value at a path, and the type of the innermost key; None for what there is not."""
    value: Any = document
    annotation: Any = None
    for part in path:
        if isinstance(value, tuple | list):
            value = value[int(part)] if part.isdigit() and int(part) < len(value) else None
            inner = get_args(annotation)  # tuple[X, ...] or tuple[X, Y]
            annotation = inner[0] if inner else None
            continue
        owner = _described(value)
        hints = (
            get_type_hints(owner if isinstance(owner, type) else type(owner), include_extras=True)
            if is_dataclass(owner)
            else {}
        )
        annotation, value = hints.get(part), getattr(value, part, None)
    return value, annotation


def _unit(annotation: Any) -> str:
    """Return the symbol of the SI unit of a type, empty without one."""
    notes = [
        note
        for option in (annotation, *get_args(annotation))
        for note in getattr(option, "__metadata__", ())
        if isinstance(note, Unit)
    ]
    return notes[0].symbol if notes else ""


def _listed(name: str, values: object) -> list[Any]:
    """Return the values of a sequence as a list."""
    if isinstance(values, Mapping) or not isinstance(values, Iterable):
        raise InvalidInput(f"vary[{name!r}] is {values!r}: give a list of values, or a text with commas.")
    raw = [entry.item() if isinstance(entry, np.generic) else entry for entry in values]
    if not raw:
        raise InvalidInput(f"vary[{name!r}] has no values: give one or more.")
    return raw


def _surface_path(document: SceneDocument, what: str) -> tuple[str, ...]:
    """Return the path of the file of the only measured surface of the scene, or of its tile."""
    kinds = MeasuredSurface, MeasuredSurfaceTable
    places = [str(k) for k, shape in enumerate(document.shapes) if isinstance(shape, kinds)]
    key = "tile" if what == "tiles" else "file"
    if len(places) != 1:
        raise InvalidInput(f"{what} vary the one MeasuredSurface of a scene with {len(places)}: give shapes.N.{key}.")
    return "shapes", places[0], key


def _tiles(path: tuple[str, ...], values_given: object) -> Varied:
    """Return equal tiles of a surface as values, such as ``2x6`` across and along."""
    text = values_given if isinstance(values_given, str) else "x".join(map(str, _listed("tiles", values_given)))
    parts = text.replace(" ", "").split("x")
    if len(parts) != 2 or not all(part.isdigit() and int(part) for part in parts):
        raise InvalidInput(f"tiles is {text!r}: give how many across and along, such as 2x6.")
    across, along = map(int, parts)
    values = [cs.Tile((across, along), n) for n in range(across * along)]
    return Varied(path, values, "tile", f"tile of the surface, {across} across and {along} along it")


def _surfaces(values_given: object, folder: Path) -> list[Any]:
    """Return files by name or pattern as absolute paths, and what else is a surface as it is."""
    items: Any = values_given.split(",") if isinstance(values_given, str) else values_given
    surfaces: list[Any] = []
    for item in items if isinstance(items, Iterable) else [items]:
        if not isinstance(item, str | Path):
            surfaces.append(item)
        else:
            # relative to the working directory, then to the scene; not Path.glob, which has no absolute patterns
            paths = [str(base / str(item).strip()) for base in (Path(), folder)]
            lists = (sorted(glob(p)) if has_magic(p) else [p] * Path(p).is_file() for p in paths)  # noqa: PTH207
            matched = next(filter(None, lists), [])
            if not matched:
                raise InvalidInput(f"surfaces has {str(item)!r}, which no file matches: give existing files.")
            surfaces += [str(Path(path).absolute()) for path in matched]
    if not surfaces:
        raise InvalidInput("surfaces has no values: give one or more.")
    return surfaces


def varied_scenes(
    raw: Table, groups: Sequence[Mapping[str, object]], folder: Path, source: str
) -> tuple[tuple[Axis, ...], dict[tuple[Value, ...], SceneFile], tuple[str, ...]]:
    """Return the axes of groups of keys, the scenes by the values of these, and notes on keys that change together.

    The axis of the load is the last.

    Parameters
    ----------
    raw
        Tables of the scene.
    groups
        Values by the names of keys; the keys of one group change together, in the order in which they are given.
    folder
        Folder at which paths of surfaces start.
    source
        Beginning of messages on the scene itself.

    Raises
    ------
    InvalidInput
        For keys that a scene cannot have, and values that these cannot have.
    """
    base = document_from(raw, source)
    keys = [[varied(raw, base, name, values_given, folder) for name, values_given in group.items()] for group in groups]
    keys.sort(key=lambda group: group[0].path[0] == "load")
    for group in keys:
        counts = [len(key.values) for key in group]
        if len(set(counts)) > 1:
            raise InvalidInput(
                f"vary has {', '.join(map(str, counts))} values of {', '.join(key.name for key in group)}, which "
                "change together: give equally many values of each."
            )
    counts = [len(group[0].values) for group in keys]
    check_count("vary", prod(counts), "points", MAX_POINTS)
    documents = {index: _document(raw, keys, index, source) for index in product(*map(range, counts))}
    labels = [_labels(group, k, len(keys), documents) for k, group in enumerate(keys)]
    axes = [_axis(group[0], group_labels, base) for group, group_labels in zip(keys, labels, strict=True)]
    names = [axis.name for axis in axes]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInput(f"{name} is varied twice: write all its values in one list.")
    surfaces: dict[object, Any] = {}
    points: dict[tuple[Value, ...], SceneFile] = {}
    for index, document in documents.items():
        if all(j in group_labels for j, group_labels in zip(index, labels, strict=True)):
            point = tuple(group_labels[j] for j, group_labels in zip(index, labels, strict=True))
            try:
                points[point] = scene_file_from(with_surfaces(document, folder, surfaces), folder)
            except InvalidInput as error:
                raise InvalidInput(f"{_said(keys, index)}: {error}") from None
    notes = [
        f"along {axis.name}: "
        + "; ".join(
            f"{key.name} = {', '.join(map(str, _own_labels(key, k, len(keys), documents)))}" for key in group[1:]
        )
        for k, (axis, group) in enumerate(zip(axes, keys, strict=True))
        if len(group) > 1
    ]
    return tuple(axes), points, tuple(notes)


def with_other_values(
    raw: Table, groups: Sequence[Mapping[str, object]], values: Mapping[str, object], source: str
) -> list[Mapping[str, object]]:
    """Return groups of keys with other `values` of some, whichever way these are named, and those of further keys."""
    base = document_from(raw, source)
    names = {_path(raw, base, name): name for name in values}
    named_groups = [[names.get(_path(raw, base, name), name) for name in group] for group in groups]
    further = [[name] for name in values if not any(name in group for group in named_groups)]
    every = {name: values_given for group in groups for name, values_given in group.items()} | dict(values)
    return [{name: every[name] for name in group} for group in (*named_groups, *further)]


def _said(keys: Sequence[Sequence[Varied]], index: Sequence[int]) -> str:
    """Return the values of all keys at a point in words."""
    return ", ".join(
        f"{key.name} = {shortened(key.values[j])}" for group, j in zip(keys, index, strict=True) for key in group
    )


def _document(raw: Table, keys: Sequence[Sequence[Varied]], index: Sequence[int], source: str) -> SceneDocument:
    """Return the document at a point; a part is replaced before its own keys are, a padding before its images."""
    changes = [(key, key.values[j]) for group, j in zip(keys, index, strict=True) for key in group]
    for key, value in sorted(changes, key=lambda change: len(change[0].path)):
        path = key.path
        if path[-1] == "file" and not isinstance(value, str):
            # heights without rules of their own are prepared as those in whose place they stand
            is_whole = isinstance(value, MeasuredSurface)
            path, value = (path[:-1], value) if is_whole else (path, MeasuredSurface(value))
        try:
            is_removed = isinstance(value, str) and value == "none" and path[-1] != "turn"
            raw = replaced(raw, path, None if is_removed else value)
        except InvalidInput as error:
            raise InvalidInput(f"{source}: {key.name} = {shortened(value)}: {error}") from None
    return document_from(raw, f"{source} with {_said(keys, index)}")


def with_surfaces(document: SceneDocument, folder: Path, read: dict[object, Any]) -> SceneDocument:
    """Return a document whose measured surfaces are read, each once for all points."""
    curvature = sum(map(curvature_of, document.shapes))
    shapes: list[Any] = list(document.shapes)
    for k, table in enumerate(shapes):
        if isinstance(table, MeasuredSurfaceTable):
            key = table, curvature > 0
            if key not in read:
                read[key] = table.described(folder, (curvature, document.solids))
            shapes[k] = read[key]
    return replace(document, shapes=tuple(shapes))


def _own_labels(
    key: Varied, position: int, count: int, documents: Mapping[tuple[int, ...], SceneDocument]
) -> list[Value]:
    """Return the labels of the values of a key: numbers and names as they are in the scene, else their text."""
    labels: list[Value] = []
    for j, raw in enumerate(key.values):
        index = tuple(j if k == position else 0 for k in range(count))
        made = at(documents[index], key.path)[0]
        if key.axis == "surface" or isinstance(made, MeasuredSurface):
            name = raw if isinstance(raw, str) else getattr(raw, "name", None) or getattr(raw, "file", None)
            label: Value = Path(name).name if name else f"surface {j}"
            label = f"{label} ({j})" if label in labels else label
        elif key.axis == "tile":
            label = raw.number
        elif isinstance(made, int | float | str) and not isinstance(made, bool):
            label = made
        else:
            text = raw if isinstance(raw, str) else repr(made) if is_dataclass(made) else str(raw)
            label = one_line(text)
        if isinstance(label, str) and label in labels and digest(raw) != digest(key.values[labels.index(label)]):
            label = f"{label} ({j})"  # of an array that its representation shortens
        labels.append(label)
    # an infinite value, such as a rigid body's modulus, has no place on a scale: such values are names
    if all(isinstance(label, int | float) and isfinite(label) for label in labels):
        # equal values from different sums get one label
        is_float = any(isinstance(label, float) for label in labels)
        return [float(f"{label:.15g}") for label in labels] if is_float else labels
    return [label if isinstance(label, str) else f"{label:.12g}" for label in labels]


def _labels(
    group: Sequence[Varied], position: int, count: int, documents: Mapping[tuple[int, ...], SceneDocument]
) -> dict[int, Value]:
    """Return the values of an axis by their number; equal ones stand once, and numbers of a key alone rise."""
    labels = _own_labels(group[0], position, count, documents)
    first = {label: j for j, label in reversed(list(enumerate(labels)))}
    if len(group) > 1 and len(first) < len(labels):
        raise InvalidInput(f"{group[0].name} has a value twice, and others change with it: give different values.")
    is_rising = len(group) == 1 and not any(isinstance(label, str) for label in labels)
    chosen = sorted(first) if is_rising else list(dict.fromkeys(labels))
    return {first[label]: label for label in chosen}


def _axis(key: Varied, labels: Mapping[int, Value], base: SceneDocument) -> Axis:
    """Return the axis of a key, with its unit."""
    values = tuple(labels.values())
    unit = _unit(at(base, key.path)[1])
    long_name = key.long_name or LONG_NAMES.get(key.name) or _long_name(base, key.path)
    if unit and any(isinstance(label, str) for label in values):
        long_name = f"{long_name} [{unit}]"  # names have no unit in a file
    return Axis(key.axis, values, long_name, unit.replace("N/m", "N m-1") or "1")


def _long_name(document: SceneDocument, path: Sequence[str]) -> str:
    """Return the long name of a key, such as "rms of Roughness"."""
    if len(path) > 2 and path[-1].isdigit() and path[-2] != "shapes":  # an entry of a list of numbers
        return f"{path[-2].replace('_', ' ')} {path[-1]} of {path[-3]}"
    name = path[-1].replace("_", " ").replace("youngs", "Young's").replace("poisson", "Poisson's")
    if path[0] == "solids" and len(path) == 3:
        return f"{name} of solids[{path[1]}]"
    if path[0] == "shapes" and len(path) > 2:
        return f"{name} of {type(at(document, path[:2])[0]).__name__.removesuffix('Table')}"
    return f"{name} of {path[-2]}" if len(path) > 1 else name
