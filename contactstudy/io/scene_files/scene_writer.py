"""A scene as TOML that :func:`~contactstudy.read_scene` reads back."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.imports import import_for
from contactstudy.domain.validation import InvalidInput, is_default
from contactstudy.scene.scene import Scene
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.solvers.solve import SolveOptions


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
