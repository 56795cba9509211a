"""Nested tables of a file as frozen dataclasses, with texts with a unit as numbers in SI units, and back as TOML.

Before that, times in cycles are converted to seconds, and numbers are found that are likely in another unit than SI.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import MISSING, fields, is_dataclass
from difflib import get_close_matches
from math import inf
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np

from contactstudy.domain import validation
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.imports import import_for
from contactstudy.domain.validation import (
    NUMBER,
    InvalidInput,
    hint_of,
    is_default,
    kind_of,
    parameters,
    remedy,
    shortened,
    suggestion,
    valid,
)
from contactstudy.scene.scene import Scene
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.solvers.solve import SolveOptions

# Classes that a table may describe: by the type of the field, and then by the name that the key `kind` gives.
Kinds = Mapping[Any, Mapping[str, type]]
# Name of the class of a table without the key `kind`, where a type has one.
NO_KIND = ""
Target = TypeVar("Target")
# Symbols that books and drawings have for fields.
SYMBOLS_OF_FIELDS = {
    "E": "youngs_modulus", "nu": "poisson_ratio", "v": "poisson_ratio", "R": "radius", "r": "radius", "L": "length",
    "F": "total", "P": "total", "w": "per_length", "W": "per_length", "mu": "coefficient", "k": "coefficient",
    "t": "thickness", "h": "thickness", "eta": "viscosity", "eta0": "viscosity", "alpha": "pressure_viscosity",
    "HV": "hardness", "HRC": "hardness", "diameter": "radius",
}  # fmt: skip
# Bare numbers that are likely in another unit: from where or up to where in SI, and the unit that was likely meant.
LARGE = {
    "radius": (3.0, "mm"), "length": (10.0, "mm"), "thickness": (0.1, "um"), "end_drop": (1e-2, "um"),
    "amplitude": (1e-2, "um"), "rms": (1e-3, "um"),
}  # fmt: skip
SMALL = {
    "youngs_modulus": (1e4, "Pa", "GPa"), "yield_stress": (1e4, "Pa", "MPa"), "hardness": (1e5, "Pa", "GPa"),
    "per_length": (1e3, "N/m", "N/mm"),
}  # fmt: skip
# A time as a number and what it counts, such as "3 cycles" or "1e4 revolutions".
COUNTED = re.compile(r"\s*(\d+\.?\d*(?:[eE]\+?\d+)?)\s*(cycle|rev|revolution|turn)s?\s*")
# Speed of a motion, whose sign is its direction.
SPEED = Annotated[validation.MetresPerSecond, validation.ANY_SIGN]


def structured(raw: object, target: type[Target], kinds: Kinds, source: str) -> Target:
    """Return tables, lists, texts and numbers as the dataclass `target`.

    Parameters
    ----------
    raw
        Tables as a TOML file has them. In them may stand dataclasses that are made already.
    target
        Dataclass of all of them.
    kinds
        Dataclasses that a type can be, by name. The key ``kind`` of a table chooses one. Without it, the table is of
        the kind under ``NO_KIND``, or of the only kind that has all its keys. A name alone is a table without keys.
    source
        Name of the file, with which messages begin.

    Raises
    ------
    InvalidInput
        With a line for every key that cannot be used.
    """
    reader = _Reader(kinds)
    read: Target = reader.read("", raw, target)
    if reader.refusals:
        raise InvalidInput("\n".join(": ".join(filter(None, (source, *refusal))) for refusal in reader.refusals))
    return read


class _Reader:
    """Reads nested tables as dataclasses, given the kinds that each type can be, and keeps what is refused of them."""

    def __init__(self, kinds: Kinds) -> None:
        self.kinds = kinds
        # the path of each key that cannot be used, and a sentence on it
        self.refusals: list[tuple[str, str]] = []

    def read(self, path: str, value: object, hint: Any) -> Any:
        """Return the value at a `path` as an annotation says it; None where it is refused."""
        try:
            return self._read(path, value, hint)
        except InvalidInput as error:
            self.refusals.append((path, str(error)))

    def _read(self, path: str, value: Any, hint: Any) -> Any:
        origin, kind = get_origin(hint), kind_of(hint)
        if kind in self.kinds or origin in (Union, UnionType):
            return self._of_kind(path, value, kind)
        if origin is tuple:
            return self._tuple(path, value, hint)
        if origin is Mapping and isinstance(value, Mapping):
            return {key: self.read(f"{path}[{key!r}]", entry, get_args(hint)[1]) for key, entry in value.items()}
        return self._table(path, value, hint) if is_dataclass(hint) else valid("it", value, hint)

    def _tuple(self, path: str, value: object, hint: Any) -> tuple[Any, ...]:
        """Return a list as a tuple, of any length or of one type for each entry."""
        first, *following = get_args(hint)
        if isinstance(value, Mapping):
            raise InvalidInput("it is one table: write its name in double brackets, once for each entry.")
        if not isinstance(value, list | tuple):
            raise InvalidInput(f"it is {shortened(value)}: {self._needed(path, hint)}.")
        if following == [...]:
            following = [first] * (len(value) - 1)
        elif len(value) != 1 + len(following):
            raise InvalidInput(f"it has {len(value)} entries: give {1 + len(following)}.")
        entries = zip(value, (first, *following), strict=False)
        return tuple(self.read(f"{path}[{n}]", *entry) for n, entry in enumerate(entries))

    def _of_kind(self, path: str, value: object, hint: Any) -> Any:
        """Return a table, or the name of a kind, as the dataclass that its kind or its keys choose."""
        if is_dataclass(value):
            return value
        kinds, plain = self._options(hint)
        if not kinds or (plain and not isinstance(value, Mapping)):
            return self._plain(path, value, plain, hint)
        if isinstance(value, str) and not NUMBER.fullmatch(value):
            value = {"kind": value}
        if not isinstance(value, Mapping):
            raise InvalidInput(f"it is {shortened(value)}: {self._needed(path, hint, value)}.")
        fields_of = {key: entry for key, entry in value.items() if key != "kind"}
        return self._table(path, fields_of, _kind_of(value, kinds), kinds)

    def _options(self, hint: Any) -> tuple[dict[str, type], list[Any]]:
        """Return the dataclasses that an annotation accepts, by the names of their kinds, and its other options."""
        kinds, plain = dict(self.kinds.get(hint, {})), []
        for option in get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,) * (not kinds):
            if option in self.kinds:
                kinds |= self.kinds[option]
            elif isinstance(option, type) and is_dataclass(option):
                kinds[option.__name__] = option
            elif option is not NoneType:
                plain.append(option)
        return kinds, plain

    def _plain(self, path: str, value: object, options: list[Any], hint: Any) -> Any:
        """Return a value as that of the `options` of an annotation which has its form: a list, a table, or neither."""
        origin = next((origin for form, origin in ((Mapping, Mapping), (list, tuple)) if isinstance(value, form)), None)
        likely = [option for option in options if (get_origin(option) in (Mapping, tuple)) == (origin is not None)]
        chosen = [option for option in likely if origin is None or get_origin(option) is origin]
        words = [option for option in chosen if option is str or value in get_args(option)]
        if isinstance(value, str) and words:
            return value
        if len(options) > 1 and all(get_origin(option) is Literal for option in chosen):
            raise InvalidInput(f"it is {shortened(value)}: {self._needed(path, hint)}.")
        return self._read(path, value, chosen[0] if chosen else options[0])

    def _table(self, path: str, value: object, target: Any, kinds: Mapping[str, type] | None = None) -> Any:
        """Return a table as a dataclass; a key that is not known is refused, and read as the one likely meant."""
        if is_dataclass(value):
            return value
        if not isinstance(value, Mapping):
            raise InvalidInput(f"it is {shortened(value)}: {self._needed(path, target, value)}.")
        # the kind may be given although there is only one
        table = {key: entry for key, entry in value.items() if (key, entry) != ("kind", target.__name__)}
        names = {member.name: member for member in fields(target) if member.init}
        unknown = sorted(table.keys() - names.keys())
        meant = {key: _closest(key, names.keys() - table.keys()) for key in unknown}
        table = {meant.get(key, key): entry for key, entry in table.items()}
        arguments, before = {}, len(self.refusals)
        owners = {key: name for name, kind in reversed([*(kinds or {}).items()]) if name for key in parameters(kind)}
        for name, member in names.items():
            key, hint = f"{path}.{name}".lstrip("."), hint_of(target, name)
            if name in table:
                known = len(self.refusals)
                arguments[name] = self.read(key, table[name], hint)
                if name in meant.values():  # the file does not have this key
                    del self.refusals[known:]
            elif member.default is MISSING and member.default_factory is MISSING:
                self.refusals.append((key, f"it is missing: {self._needed(key, hint)}."))
        if unknown:
            self.refusals.append((path, "; ".join(_unknown(key, names, owners.get(key)) for key in unknown) + "."))
        return None if len(self.refusals) > before else target(**arguments)

    def _needed(self, path: str, hint: Any, value: object = None) -> str:
        """Return what to give where a key is missing, or its `value` is of another form."""
        if isinstance(value, list):
            return "write the name of this table in single brackets, once"
        kinds, plain = self._options(hint)
        if plain or not kinds:
            words = [
                _list_of(option) if get_origin(option) is tuple else remedy(option).removeprefix("give ")
                for option in plain
            ]
            return "give " + ", or ".join(words)
        if value is not None and not isinstance(value, bool):
            for kind in kinds.values():
                for name in parameters(kind):
                    with suppress(InvalidInput):
                        valid("it", value, hint_of(kind, name))
                        return f"give it as {path}.{name}"
        if len(kinds) > 1:
            return "give a table with a kind, one of " + ", ".join(filter(None, kinds))
        (kind,) = kinds.values()
        return "give a table of " + ", ".join(parameters(kind))


def _kind_of(table: Mapping[str, object], kinds: Mapping[str, type]) -> type:
    """Return the kind that `table` names, else the only one that has its keys, or those that are likely meant."""
    named = {name: kind for name, kind in kinds.items() if name != NO_KIND}
    if "kind" not in table:
        default = kinds.get(NO_KIND)
        known = {name for kind in named.values() for name in parameters(kind)}
        likely = {key if key in known else _closest(key, known) or key for key in table}
        matching_kinds = {kind for kind in named.values() if likely <= set(parameters(kind))}
        if len(matching_kinds) == 1 and default not in matching_kinds:
            return matching_kinds.pop()
        own_fields = set(parameters(default)) if default is not None else set()
        for name, kind in named.items():
            foreign = set(parameters(kind)) & set(table) - own_fields
            if default is not None and foreign and own_fields & set(table):
                keys = ", ".join(sorted(own_fields & set(table) | foreign))
                raise InvalidInput(f"it has {keys} together: give the keys of {default.__name__}, or those of {name}.")
        if default is not None or len(named) == 1:
            return default or next(iter(named.values()))
        raise InvalidInput(f"it has no kind: {suggestion('None', named)}.")
    chosen = table["kind"]
    if not isinstance(chosen, str) or chosen not in named:
        raise InvalidInput(f"its kind is {shortened(chosen)}: {suggestion(str(chosen), named)}.")
    return named[chosen]


def _closest(key: str, names: Collection[str]) -> str | None:
    """Return the name that a symbol stands for, or that is most similar to a key that is not known; None if none is."""
    if (meant := SYMBOLS_OF_FIELDS.get(key)) in names:
        return meant
    return next(iter(get_close_matches(key, sorted(names), n=1)), None)


def _list_of(hint: Any) -> str:
    """Return how a file writes what is a tuple in Python."""
    first, *following = get_args(hint)
    if kind_of(first) in (int, float, str) or get_origin(first) is tuple:
        return "a list in brackets"
    count = "tables" if following == [...] else f"{1 + len(following)} tables"
    return f"{count}, each below its name in double brackets"


def _unknown(key: str, names: Collection[str], owner: str | None) -> str:
    """Return a sentence on a key that is none of the `names`, without its full stop; `owner` is a kind that has it."""
    if owner:
        others = f"choose from {', '.join(names)}" if names else "leave it out"
        return f"{key!r} is a key of {owner}: give that kind, or {others}"
    meant = SYMBOLS_OF_FIELDS.get(key, "")
    remedy = suggestion(meant if meant in names else key, names) if names else "it has no keys, leave it out"
    return f"unknown key {key!r}: {remedy}"


def likely_units(raw: object, path: str = "") -> Iterator[str]:
    """Yield a sentence for each number without a unit in the tables of a file that is likely in another one than SI."""
    entries: Iterable[tuple[object, object]] = ()
    if isinstance(raw, Mapping):
        entries = ((f"{path}.{key}".lstrip("."), entry) for key, entry in raw.items())
    elif isinstance(raw, list):
        entries = ((f"{path}[{n}]", entry) for n, entry in enumerate(raw))
    for name, entry in entries:
        field = str(name).rpartition(".")[2]
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            yield from likely_units(entry, str(name))
            continue
        largest, smaller = LARGE.get(field, (inf, ""))
        least, si, larger = SMALL.get(field, (0.0, "m", ""))
        is_light = field == "per_length" and not isinstance(entry, int)  # may well be meant
        if largest <= abs(entry) < inf or (0 < entry < least and not is_light):
            yield f"{name} is {entry!r}, which is {entry:g} {si}: was '{entry:g} {smaller or larger}' meant?"


def with_cycles(raw: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a scene file with the times of ``time_steps`` in seconds.

    A cycle is that of a sinusoidal load or of fretting with a period. A revolution of the wearing body is its
    circumference over the speed of rolling, friction or wear.
    """
    steps = raw.get("time_steps")
    if not isinstance(steps, Mapping):
        return dict(raw)

    def seconds(name: str, value: object) -> object:
        if isinstance(value, list):
            return [seconds(f"{name}[{number}]", entry) for number, entry in enumerate(value)]
        counted = COUNTED.fullmatch(value) if isinstance(value, str) else None
        if counted is None:
            return value
        if not (duration := _duration(raw, counted[2])):
            of_revolution = "wear.circumference, and a speed of rolling, friction or wear above 0 m/s"
            needed = "load.frequency, or friction.period" if counted[2] == "cycle" else of_revolution
            raise InvalidInput(f"time_steps.{name} is {value!r}: give {needed}, or the time in s.")
        return float(counted[1]) * duration

    return dict(raw) | {"time_steps": {name: seconds(name, value) for name, value in steps.items()}}


def _duration(raw: Mapping[str, Any], counted: str) -> float:
    """Return the duration of a cycle, or of a revolution of the wearing body [s]; 0 if it is not known."""

    def entry(table: str, key: str, hint: Any) -> float:
        value = raw[table].get(key) if isinstance(raw.get(table), Mapping) else None
        return 0.0 if value is None else float(valid(f"{table}.{key}", value, hint))

    if counted == "cycle":
        frequency = entry("load", "frequency", validation.PerSecond)
        return 1 / frequency if frequency else entry("friction", "period", validation.Seconds)
    speed = next(filter(None, (entry(table, "speed", SPEED) for table in ("rolling", "friction", "wear"))), 0.0)
    return entry("wear", "circumference", validation.Metres) / abs(speed) if speed else 0.0


def scene_text(
    scene: Scene,
    *,
    grid: Grid | None = None,
    padding: Padding | Paddings | None = None,
    settings: Mapping[str, object] | None = None,
    scene_path: Path | None = None,
) -> str:
    """Return the TOML of `scene`, with its grid, its padding and the tables of `settings` if they are given.

    Heights that came from no file are written to files next to the path `scene_path`; without it their digest stands in
    their place.

    Raises
    ------
    InvalidInput
        For a shape or a body that no file can hold.
    """
    return _toml(_fields(scene, "Scene", scene_path) | _tables(grid, padding, settings or {}))


def settings_text(grid: Grid, padding: Padding | Paddings, options: SolveOptions) -> str:
    """Return the TOML tables of a grid, a padding and the options of a solve, to be added to a scene's."""
    return _toml(_tables(grid, padding, {"solve": options}))


def _tables(grid: Grid | None, padding: Padding | Paddings | None, settings: Mapping[str, object]) -> dict[str, object]:
    """Return the tables of what is given of a grid, a padding and `settings`, by their names in a file."""
    across, along = padding if isinstance(padding, tuple) else (None, padding)
    tables = {"grid": grid, "padding": along, "padding_across": across, **settings}
    return {name: _toml_value(value, name) for name, value in tables.items() if value is not None}


def _toml(table: Mapping[str, object]) -> str:
    tomli_w = import_for("contactstudy.write_scene", "tomli_w")
    return str(tomli_w.dumps(table))


def _fields(value: Any, name: str, scene_path: Path | None) -> dict[str, Any]:
    """Return the fields of a dataclass that are not at their default."""
    return {
        member.name: _toml_value(getattr(value, member.name), f"{name}.{member.name}", scene_path)
        for member in fields(value)
        if member.init and not is_default(member, getattr(value, member.name))
    }


def _toml_value(value: object, name: str, scene_path: Path | None = None) -> Any:
    """Return a value as types of TOML: tables with their kind, lists, texts, numbers."""
    if isinstance(value, MeasuredSurface):
        return _measured_surface_table(value, name, scene_path)
    if is_dataclass(value) and type(value).__module__.startswith("contactstudy"):
        return {"kind": type(value).__name__} | _fields(value, name, scene_path)
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, tuple | list):
        return [_toml_value(entry, f"{name}[{number}]", scene_path) for number, entry in enumerate(value)]
    if isinstance(value, Mapping):
        return {key: _toml_value(entry, f"{name}.{key}") for key, entry in value.items()}
    if isinstance(value, bool | int | float | str):
        return value
    raise InvalidInput(f"{name} is a {type(value).__name__}, which no scene file can hold: write it in Python.")


def _measured_surface_table(surface: MeasuredSurface, name: str, scene_path: Path | None) -> dict[str, Any]:
    """Return a measured surface as a table that names its file."""
    table: dict[str, Any] = {"kind": "MeasuredSurface"}
    if surface.file is not None:
        table["file"] = surface.file
        table |= _fields(surface.reading, name, scene_path)
        if surface.is_turned:
            table["turn"] = "quarter"
        if surface.tile is not None:
            table["tile"] = _toml_value(surface.tile, f"{name}.tile")
    elif scene_path is None:
        table["file"] = f"heights with the digest {surface.digest}, not stored"
    else:
        # named by what it holds, so that no file of another surface is overwritten
        size = "" if surface.extent is None else "-{!r}x{!r}m".format(*surface.extent)
        table["file"] = f"{scene_path.stem}-surface-{surface.digest}{size}.nc"
        surface.write(scene_path.parent / table["file"])
    rules = {rule: getattr(surface, rule) for rule in ("missing", "trend", "filter", "seam", "seam_across")}
    return table | {rule: _toml_value(of, f"{name}.{rule}") for rule, of in rules.items() if of is not None}
