"""Fields of a scene file by their paths, such as ``shapes.1.rms``: their types, and other values for them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from contactstudy import InvalidInput, MeasuredSurface
from contactstudy.domain.checks import parameters, suggestion
from contactstudy.domain.units import Unit
from contactstudy.io.scene_files.scene_schema import MeasuredSurfaceTable, SceneDocument
from contactstudy.scene_file import SceneFile

Path = tuple[str, ...]

# Short names of fields that are often varied.
SHORT_NAMES: Mapping[str, str] = {
    "n": "padding.images",
    "images": "padding.images",
    "period": "plan.period",
    "error": "plan.error",
    "tolerance": "solve.tolerance",
    "solver": "solve.solver",
    "precision": "solve.precision",
    "max_iterations": "solve.max_iterations",
}
# Keys of a measured surface in a file, which the surface has used and no longer holds.
FILE_KEYS = ("file", "turn", "tile")


@dataclass(frozen=True)
class SceneField:
    """Field of a scene file: the keys and indices that lead to it, and the type of its value, with its unit."""

    path: Path
    annotation: Any

    @property
    def name(self) -> str:
        """Path as written in a command, such as ``shapes.1.rms``."""
        return ".".join(self.path)

    @property
    def unit(self) -> str:
        """Symbol of the SI unit, empty without one."""
        for candidate in (self.annotation, *get_args(self.annotation)):
            for note in getattr(candidate, "__metadata__", ()):
                if isinstance(note, Unit):
                    return note.symbol
        return ""

    @property
    def number_type(self) -> type:
        """Type of the numbers that the field may hold."""
        return int if self.annotation is int else float


def document_of(described: SceneFile) -> SceneDocument:
    """Return the keys of a scene file."""
    scene, padding = described.scene, described.padding
    across, along = padding if isinstance(padding, tuple) else (None, padding)
    names = [key.name for key in fields(SceneDocument) if hasattr(scene, key.name)]
    entries: dict[str, Any] = {name: getattr(scene, name) for name in names}
    entries |= {"grid": described.grid, "padding": along, "padding_across": across}
    entries |= {"plan": described.plan_settings, "solve": described.options}
    return SceneDocument(**entries | {"time_steps": described.time_steps})


def find_field(document: SceneDocument, name: str) -> SceneField:
    """Return the field with a name: a path, a short name such as ``tolerance``, or a field that one shape alone has.

    Raises :class:`~contactstudy.InvalidInput` for a name that is no field, with those that there are.
    """
    if name in SHORT_NAMES and not (name == "period" and document.grid is not None):
        return _at(document, tuple(SHORT_NAMES[name].split(".")))
    if name == "period":
        return _at(document, ("grid", "extent", "1"))
    path = tuple(name.replace("[", ".").replace("]", "").split("."))  # as messages write an entry
    keys = [key.name for key in fields(SceneDocument)]
    if path[0] in keys:
        return _at(document, path)
    owners = [n for n, shape in enumerate(document.shapes) if path[0] in _names(shape)]
    if len(owners) == 1:
        return _at(document, ("shapes", str(owners[0]), *path))
    if owners:
        several = ", ".join(f"shapes.{number}.{name}" for number in owners)
        raise InvalidInput(f"Field {name!r} is one of several shapes: give one of {several}.")
    hint = suggestion(path[0], sorted([*keys, *SHORT_NAMES]))
    example = _names(document.shapes[0])[0] if document.shapes else "radius"
    raise InvalidInput(
        f"Field {name!r} is not in the scene: {hint}, or a path such as load.per_length or shapes.0.{example}."
    )


def _at(document: SceneDocument, path: Path) -> SceneField:
    """Return the field at a path; raise InvalidInput where the path leads nowhere."""
    value: Any = document
    kind: Any = SceneDocument
    for depth, part in enumerate(path):
        before = ".".join(path[:depth])
        if value is None or isinstance(value, str):
            raise InvalidInput(
                f"Field {'.'.join(path)!r} needs {before}, which the scene does not give: give {before} in the file."
            )
        if isinstance(value, tuple | list):
            if not part.isdigit() or int(part) >= len(value):
                listed = ", ".join(
                    f"{number} {type(entry).__name__ if is_dataclass(entry) else entry}"
                    for number, entry in enumerate(value)
                )
                raise InvalidInput(
                    f"Field {'.'.join(path)!r} has {part!r} for an entry of {before}: give one of "
                    f"{listed or 'none: there are no entries'}."
                )
            kind = _entry(kind, int(part))
            value = value[int(part)]
        elif is_dataclass(value):
            names = _names(value)
            if part not in names:
                raise InvalidInput(
                    f"Field {'.'.join(path)!r} is not in the scene: {before + ' has no ' if before else ''}"
                    f"{part!r}, {suggestion(part, names)}."
                )
            owner: type = MeasuredSurfaceTable if _is_of_file(value, part) else type(value)
            kind = get_type_hints(owner, include_extras=True)[part]
            value = None if _is_of_file(value, part) else getattr(value, part)
        else:
            raise InvalidInput(
                f"Field {'.'.join(path)!r} has parts, but {before} is {value!r}, which has none: give {before}."
            )
    return SceneField(path, kind)


def _is_of_file(value: object, part: str) -> bool:
    """Return whether a key of a measured surface is known from its file only."""
    return isinstance(value, MeasuredSurface) and part in FILE_KEYS


def _names(value: Any) -> list[str]:
    """Return the names of the fields of a dataclass."""
    names = parameters(value)
    if isinstance(value, MeasuredSurface):
        return [*FILE_KEYS, "missing", "trend", "filter", "seam", "extent"]
    return names


def _entry(kind: Any, number: int) -> Any:
    """Return the type of one entry of a tuple, which may be one of several types."""
    for option in (kind, *(get_args(kind) if get_origin(kind) in (Union, UnionType) else ())):
        if get_origin(option) is tuple:
            entries = get_args(option)
            return entries[0] if entries[-1] is ... else entries[number]
    return kind


def replaced(value: Any, path: Sequence[str], new: object) -> Any:
    """Return `value` with `new` at `path`, as a copy; raise InvalidInput where the path leads nowhere."""
    if not path:
        return new
    first, below = path[0], path[1:]
    is_row = isinstance(value, tuple | list)
    if int(first) >= len(value) if is_row else not hasattr(value, first):
        raise InvalidInput(f"{value!r} has no {first!r}: leave out the values that are without it.")
    if is_row:
        number = int(first)
        return (*value[:number], replaced(value[number], below, new), *value[number + 1 :])
    return replace(value, **{first: replaced(getattr(value, first), below, new)})


def non_optional(annotation: Any) -> Any:
    """Return a type without the None of an optional field."""
    if get_origin(annotation) in (Union, UnionType):
        options = tuple(option for option in get_args(annotation) if option is not NoneType)
        return options[0] if len(options) == 1 else Union[options]  # noqa: UP007 (made at run time)
    return annotation
