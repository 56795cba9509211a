"""Nested tables of a scene file as frozen dataclasses, and a scene as tables in TOML.

A table describes a class, whose fields are its keys. Where there are several, as of the shapes of a scene, the class is
called its *kind*. Numbers and texts are checked, and converted to SI units, by the annotations of the fields. Two steps
are apart: `with_cycles` first converts times in cycles to seconds, and `likely_units` finds numbers that are likely in
another unit than SI.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import MISSING, fields, is_dataclass
from difflib import get_close_matches
from functools import reduce
from math import inf
from operator import or_
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

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
# Symbols that books and drawings have for fields, and the diameter, which is no field of round bodies.
SYMBOLS_OF_FIELDS = {
    "E": "youngs_modulus", "nu": "poisson_ratio", "v": "poisson_ratio", "R": "radius", "r": "radius", "L": "length",
    "F": "total", "P": "total", "w": "per_length", "W": "per_length", "mu": "coefficient", "k": "coefficient",
    "t": "thickness", "h": "thickness", "eta": "viscosity", "eta0": "viscosity", "alpha": "pressure_viscosity",
    "HV": "hardness", "HRC": "hardness", "diameter": "radius",
}  # fmt: skip
# By field, the limits between which a number in SI units is likely, the SI unit, and the one in which a number beyond
# them was likely meant. Lengths and moduli beyond are no machine part's or no solid's, loads below hardly press.
LIKELY = {
    "radius": (0, 3.0, "m", "mm"), "length": (0, 10.0, "m", "mm"), "thickness": (0, 0.1, "m", "um"),
    "end_drop": (0, 1e-2, "m", "um"), "amplitude": (0, 1e-2, "m", "um"), "rms": (0, 1e-3, "m", "um"),
    "youngs_modulus": (1e4, inf, "Pa", "GPa"), "yield_stress": (1e4, inf, "Pa", "MPa"),
    "hardness": (1e5, inf, "Pa", "GPa"), "per_length": (1e3, inf, "N/m", "N/mm"),
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
        the kind that has most of its keys; of several, of that under ``NO_KIND``. A name alone is a table without keys.
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
        raise InvalidInput("\n".join(f"{source}: {refusal}" for refusal in reader.refusals))
    return read


class _Reader:
    """Reads nested tables as dataclasses, given the kinds that each type can be, and keeps what is refused of them."""

    def __init__(self, kinds: Kinds) -> None:
        self.kinds = kinds
        # a sentence on each key that cannot be used, which begins with its path
        self.refusals: list[str] = []

    def read(self, path: str, value: Any, hint: Any) -> Any:
        """Return the value at a `path`, such as ``shapes[0].radius``, as an annotation says it; None if refused."""
        kinds, others = self._options(hint)
        try:
            if kinds and (isinstance(value, Mapping) or not others):
                return self._described(path, value, kinds)
            entries = next((get_args(option) for option in others if get_origin(option) is tuple), ())
            if any(self._options(entry)[0] for entry in entries):
                return self._tuple(path, value, entries)
            # None and a dataclass in place of its table, which Python may give but no file, are taken as they are
            return value if value is None or is_dataclass(value) else valid(path, value, reduce(or_, others))
        except InvalidInput as error:
            self.refusals.append(str(error))

    def _options(self, hint: Any) -> tuple[dict[str, type], list[Any]]:
        """Return the dataclasses that an annotation accepts, by the names of their kinds, and its other options."""
        kinds: dict[str, type] = {}
        others = []
        is_union = get_origin(hint) in (Union, UnionType) and hint not in self.kinds
        for option in get_args(hint) if is_union else (hint,):
            if (kind := kind_of(option)) in self.kinds:
                kinds |= self.kinds[kind]
            elif isinstance(option, type) and is_dataclass(option):
                kinds[option.__name__] = option
            elif option is not NoneType:
                others.append(option)
        return kinds, others

    def _tuple(self, path: str, value: object, entries: tuple[Any, ...]) -> tuple[Any, ...]:
        """Return a list of tables as a tuple, by the annotations of its `entries`: one for each, or one and ``...``."""
        any_number = entries[-1] is ...
        if not isinstance(value, list | tuple) or not (any_number or len(value) == len(entries)):
            raise InvalidInput(f"{path} is {shortened(value)}: {_tables_to_give(entries)}.")
        hints = (entries[0],) * len(value) if any_number else entries
        return tuple(self.read(f"{path}[{n}]", *entry) for n, entry in enumerate(zip(value, hints, strict=True)))

    def _described(self, path: str, value: object, kinds: Mapping[str, type]) -> Any:
        """Return a table, or the name of a kind, as the dataclass of the `kinds` that its key `kind` or its keys choose.

        An unknown key is refused, and the key that it likely stands for is not said to be missing besides.
        """
        if is_dataclass(value):
            return value
        if isinstance(value, str) and not NUMBER.fullmatch(value):
            value = {"kind": value}
        if not isinstance(value, Mapping):
            raise InvalidInput(f"{path} is {shortened(value)}: {_table_to_give(path, kinds, value)}.")
        target = _kind_of(path, value, kinds)
        names = {member.name: member for member in fields(target) if member.init}
        unknown = sorted(value.keys() - names.keys() - {"kind"})
        meant = {_closest(key, names.keys() - value.keys()) for key in unknown}
        before = len(self.refusals)
        arguments = {}
        for name, member in names.items():
            key, hint = f"{path}.{name}".lstrip("."), hint_of(target, name)
            if name in value:
                arguments[name] = self.read(key, value[name], hint)
            elif member.default is MISSING and member.default_factory is MISSING and name not in meant:
                self.refusals.append(f"{key}: it is missing: {self._needed(key, hint)}.")
        if unknown:
            # reversed, so that the first kind which has a key is its owner
            owners = {key: name for name, kind in reversed([*kinds.items()]) if name for key in parameters(kind)}
            sentences = "; ".join(_unknown(key, names, owners.get(key)) for key in unknown)
            self.refusals.append(f"{path}: {sentences}.".removeprefix(": "))
        if len(self.refusals) > before:
            return None
        try:
            return target(**arguments)
        except InvalidInput as error:
            raise InvalidInput(f"{path}: {error}") from error

    def _needed(self, path: str, hint: Any) -> str:
        """Return what to give for a key that is missing."""
        kinds, others = self._options(hint)
        if not others:
            return _table_to_give(path, kinds)
        if get_origin(hint) is tuple and any(self._options(entry)[0] for entry in get_args(hint)):
            return _tables_to_give(get_args(hint))
        return remedy(reduce(or_, others))


def _at(path: str, sentence: str) -> str:
    """Return a sentence on what stands at a `path`, which begins with it; the file itself has none."""
    return f"{path}: {sentence}" if path else sentence


def _table_to_give(path: str, kinds: Mapping[str, type], value: object = None) -> str:
    """Return what to give for a table of one of `kinds`, where there is none, or a `value` of another form."""
    if isinstance(value, list):
        return "write the name of this table in single brackets, once"
    if value is not None and not isinstance(value, bool):
        for kind in kinds.values():
            for name in parameters(kind):
                with suppress(InvalidInput):
                    valid(name, value, hint_of(kind, name))
                    return f"give it as {path}.{name}"
    if len(kinds) > 1:
        return "give a table with a kind, one of " + ", ".join(filter(None, kinds))
    (kind,) = kinds.values()
    return "give a table of " + ", ".join(parameters(kind))


def _tables_to_give(entries: tuple[Any, ...]) -> str:
    """Return what to give for tables by the annotations of their `entries`: one for each, or one and ``...``."""
    count = "tables" if entries[-1] is ... else f"{len(entries)} tables"
    return f"give {count}, each below its name in double brackets"


def _kind_of(path: str, table: Mapping[str, object], kinds: Mapping[str, type]) -> type:
    """Return the kind that `table` names, else the one that has most of its keys, or of those likely meant by them."""
    named = {name: kind for name, kind in kinds.items() if name != NO_KIND}
    if "kind" in table:
        chosen = table["kind"]
        if not isinstance(chosen, str) or chosen not in named:
            raise InvalidInput(_at(path, f"its kind is {shortened(chosen)}: {suggestion(str(chosen), named)}."))
        return named[chosen]
    known = {name for kind in named.values() for name in parameters(kind)}
    keys = {key if key in known else _closest(key, known) for key in table}
    counts = {kind: len(keys.intersection(parameters(kind))) for kind in named.values()}
    most = [kind for kind, count in counts.items() if count == max(counts.values())]
    if len(most) > 1 and kinds.get(NO_KIND) not in most:
        raise InvalidInput(_at(path, f"it has no kind: {suggestion('None', named)}."))  # lists all kinds
    return most[0] if len(most) == 1 else kinds[NO_KIND]


def _closest(key: str, names: Collection[str]) -> str | None:
    """Return the name that a symbol stands for, or that is most similar to a key that is not known; None if none is."""
    if (meant := SYMBOLS_OF_FIELDS.get(key)) in names:
        return meant
    return next(iter(get_close_matches(key, sorted(names), n=1)), None)


def _unknown(key: str, names: Collection[str], owner: str | None) -> str:
    """Return a sentence on a key that is none of the `names`, without its full stop; `owner` is a kind that has it."""
    if owner:
        others = f"choose from {', '.join(names)}" if names else "leave it out"
        return f"{key!r} is a key of {owner}: give that kind, or {others}"
    remedy = suggestion(_closest(key, names) or key, names) if names else "it has no keys, leave it out"
    return f"unknown key {key!r}: {remedy}{', half of it' * (key == 'diameter' and 'radius' in names)}"


def likely_units(raw: object, path: str = "") -> Iterator[str]:
    """Yield a sentence for each number without a unit in the tables of a file that is likely in another one than SI."""
    entries: Iterable[tuple[str, object]] = ()
    if isinstance(raw, Mapping):
        entries = ((f"{path}.{key}".lstrip("."), entry) for key, entry in raw.items())
    elif isinstance(raw, list):
        entries = ((f"{path}[{n}]", entry) for n, entry in enumerate(raw))
    for name, entry in entries:
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            yield from likely_units(entry, name)
            continue
        field = name.rpartition(".")[2]
        least, largest, si, meant = LIKELY.get(field, (0, inf, "", ""))
        # a small load with a decimal point may be meant
        is_light = field == "per_length" and not isinstance(entry, int)
        if (0 < entry < least and not is_light) or largest <= abs(entry) < inf:
            yield f"{name} is {entry!r}, which is {entry:g} {si}: was '{entry:g} {meant}' meant?"


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
        frequency = entry("load", "frequency", validation.Frequency)
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
    """Return the TOML of `scene`, with its grid, its padding and the `settings`, tables by name, if they are given.

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
    """Return tables as TOML; raises InvalidInput where the package for it is missing."""
    tomli_w = import_for("contactstudy.write_scene", "tomli_w")
    return str(tomli_w.dumps(table))


def _fields(value: Any, name: str, scene_path: Path | None) -> dict[str, Any]:
    """Return the fields of a dataclass that are not at their default, as types of TOML by their names.

    Messages call the dataclass by its `name`; heights of surfaces are written beside `scene_path`.
    """
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
    """Return a measured surface as a table that names its file; without one it is written beside `scene_path`."""
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
