"""Sensitivity of a scene: what its quantities change by as each of its numbers is lowered and raised alone."""

import json
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from functools import partial
from math import copysign, isfinite
from os import PathLike
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NoReturn, get_args

import xarray as xr

from contactstudy import InvalidInput, Scene, SceneFile
from contactstudy.domain.validation import NUMBER, PLUS_MINUS, SYMBOLS, notes, parameters, parted
from contactstudy.scene_file import document_from, scene_file_from
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.axis import Axis, Value
from studies.model.outcome import CaseStatus
from studies.model.plain_text import Log
from studies.model.study import Study
from studies.scene_study.document import at, replaced, with_surfaces
from studies.scene_study.measures import measures
from studies.scene_study.study_of import case_at, on_shared_grids, read_tables

# What a number of the scene is: lowered, as it is in the file, or raised.
LOWERED, GIVEN, RAISED = SIDES = ("lowered", "as given", "raised")
# Relative change of a number without a tolerance.
CHANGE = 0.01
# Tables of the contact itself; the others are settings of its solution and places to look at.
DESCRIBED = ("load", "solids", "shapes", "hardness", "friction", "wear", "rolling", "lubrication", "adhesion")
# Keys that name something, or say where a surface is known.
NO_NUMBERS = "kind", "material", "file", "extent", "period"


@dataclass(frozen=True)
class Refused:
    """Computation of a scene that cannot have a changed number, for a `reason`."""

    reason: str

    def prepare(self) -> NoReturn:
        """Raise :class:`~contactstudy.InvalidInput` with the reason."""
        raise InvalidInput(self.reason)

    run = record = prepare


def sensitivity_study(scene: Scene | SceneFile | str | PathLike[str]) -> Study:
    """Return the study of a scene over each of its numbers, lowered, as given and raised.

    The size of a number changes by the tolerance behind it, such as ``"10 mm +- 0.05 mm"``, else by 1 %; that of all
    numbers of a list together, and that of both bodies where they must be alike. Whole numbers, numbers that are zero
    without a tolerance, and those of grid, padding, plan, solver, steps in time and outputs are left out. Its axes are
    ``number``, the path as that of a varied field, and ``side``.

    Raises :class:`~contactstudy.InvalidInput` for a scene without a number that it could change.
    """
    raw, _, text, source = read_tables(scene)
    folder = Path(source).parent
    base = document_from(raw, source)
    surfaces: dict[object, Any] = {}

    def file_of(tables: Mapping[str, Any]) -> SceneFile:
        document = with_surfaces(document_from(tables, source), folder, surfaces)
        file = scene_file_from(document, folder)
        if file.grid is not None:  # the grid may not hold a surface of another size
            on_shared_grids([file])
        return file

    as_given = file_of(raw)
    are_alike = raw["solids"][0] == raw["solids"][1]
    changes, left_out = dict[str, str](), list[str]()
    points: dict[tuple[str, ...], SceneFile | Refused] = {}
    for path, value in _leaves({key: raw[key] for key in DESCRIBED if key in raw}):
        name = ".".join(path)
        ends = [_changed(name, value, sign) for sign in (-1, 1)]
        if not _is_number(at(base, path)[1], value) or ends[0] == ends[1]:
            left_out += [name] if _has_number(value) else []
            continue
        scenes = [_or_refused(file_of, replaced(raw, path, end)) for end in ends]
        if all(isinstance(entry, Refused) for entry in scenes) and path[0] == "solids" and are_alike:
            if path[1] == "1":  # it was changed together with that of the first body
                continue
            name, second_body = f"solids.{'.'.join(path[2:])}", ("solids", "1", *path[2:])
            both = (replaced(replaced(raw, path, end), second_body, end) for end in ends)
            scenes = [_or_refused(file_of, tables) for tables in both]
        if all(isinstance(entry, Refused) for entry in scenes):
            left_out.append(f"{name} ({scenes[0].reason.rstrip('.')})")  # type: ignore[union-attr]
            continue
        changes[name], points[name, GIVEN] = _text(value), as_given
        points[name, LOWERED], points[name, RAISED] = scenes
    if not changes:
        raise InvalidInput(f"{source} has no number to raise and lower: give one that is not zero.")
    placed, notes = on_shared_grids([entry for entry in points.values() if isinstance(entry, SceneFile)])
    if left_out:
        about = "not changed, as they are whole, zero or infinite, or for a reason: " + ", ".join(left_out)
        notes = (*notes, about)
    on_grids = iter(placed)
    cases: dict[tuple[Value, ...], Any] = {
        key: entry if isinstance(entry, Refused) else next(on_grids) for key, entry in points.items()
    }
    axes = (
        Axis("number", tuple(changes), "number of the scene that is changed"),
        Axis("side", SIDES, "whether the number is lowered or raised"),
    )
    name = f"{Path(source).stem}-sensitivity"
    return Study(
        name,
        f"{name}: each number of the scene lowered and raised",
        axes,
        partial(case_at, ("number", "side"), cases),
        measures,
        times="none",
        notes=notes,
        attributes={"scene": text, "changes": json.dumps(changes)},
    )


def _or_refused(make: Callable[[Any], SceneFile], tables: Any) -> SceneFile | Refused:
    """Return what a function makes of what it is given, or why it cannot."""
    try:
        return make(tables)
    except InvalidInput as error:
        return Refused(str(error))


def sensitivity(
    scene: Scene | SceneFile | str | PathLike[str],
    out: Path | None = None,
    *,
    options: RunOptions | None = None,
    log: Log = print,
) -> xr.Dataset:
    """Return what the quantities of a scene change by as each of its numbers is lowered and raised alone.

    Parameters
    ----------
    scene
        A scene, what :func:`~contactstudy.read_scene` reads, or the path of a file.
    out
        Folder in which the sweep is stored, and goes on where it was stopped; None keeps nothing.
    options, log
        As of :func:`~studies.run`.

    Returns
    -------
    xarray.Dataset
        See :func:`changes_in`.
    """
    with TemporaryDirectory() as folder:
        return changes_in(run(sensitivity_study(scene), out or Path(folder), options=options, log=log))


def changes_in(sweep: xr.Dataset) -> xr.Dataset:
    """Return the changes of all quantities with a bound in the stored sweep of a :func:`sensitivity_study`.

    Each quantity and its ``<name>_bound`` are those of the scene as given. ``<name>_change`` (number, side) is what it
    changes by, and ``<name>_change_bound`` the larger bound of both answers: a smaller change may be an error of these,
    although most of that cancels on one grid. ``change`` (number,) is the number with its tolerance.
    """
    good = sweep.where(sweep["case_status"] == CaseStatus.OK)
    original, sides = good.sel(side=GIVEN, drop=True), good.sel(side=[LOWERED, RAISED])
    names = json.loads(sweep.attrs["changes"])
    variables = {"change": ("number", [names[key] for key in sweep["number"].values.tolist()])}
    result = xr.Dataset(variables, {"number": sweep["number"], "side": sides["side"]}, sweep.attrs)
    for name in map(str, sweep.data_vars):
        bound = f"{name}_bound"
        if bound not in sweep or sweep[name].dims != ("number", "side"):
            continue
        for name_kept in (name, bound):
            result[name_kept] = original[name_kept].isel(number=0, drop=True).assign_attrs(sweep[name_kept].attrs)
        result[f"{name}_change"] = (sides[name] - original[name]).assign_attrs(
            units=sweep[name].attrs.get("units", "1"), long_name=f"change: {sweep[name].attrs.get('long_name', name)}"
        )
        larger = sides[bound].where(sides[bound] > original[bound], original[bound])
        result[f"{name}_change_bound"] = larger.assign_attrs(result[f"{name}_change"].attrs)
    return result


def _leaves(raw: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the path and the value of each number and text, and of each list of these, in tables or dataclasses."""
    if is_dataclass(raw):
        entries = [(name, getattr(raw, name)) for name in parameters(raw)]
    elif isinstance(raw, Mapping):
        entries = list(raw.items())
    elif isinstance(raw, list | tuple) and any(isinstance(entry, Mapping) or is_dataclass(entry) for entry in raw):
        entries = [(str(number), entry) for number, entry in enumerate(raw)]
    else:
        yield path, raw
        return
    for key, value in entries:
        if key not in NO_NUMBERS:
            yield from _leaves(value, (*path, key))


def _is_number(annotation: Any, value: object) -> bool:
    """Return whether a value of a key with this type is a physical number, or a list of such.

    Of a key whose type is not known the value decides.
    """
    if annotation is None:
        return not isinstance(value, int) and _has_number(value)
    return notes(annotation)[0] is not None or any(
        _is_number(part, value) for part in get_args(annotation) if get_args(part)
    )


def _has_number(value: object) -> bool:
    """Return whether a value is a number, also as a text with a unit, or a list of such."""
    if isinstance(value, list | tuple):
        return bool(value) and all(map(_has_number, value))
    if isinstance(value, str):
        match = NUMBER.fullmatch(PLUS_MINUS.split(value.strip())[0])
        return match is not None and not (match[2] and match[2] != "%" and not SYMBOLS.fullmatch(match[2]))
    return isinstance(value, int | float) and not isinstance(value, bool)


def _changed(name: str, value: Any, sign: int) -> Any:
    """Return a number, a text with a number, or a list of these, raised (sign 1) or lowered (-1) in size."""
    if isinstance(value, list | tuple):
        return [_changed(f"{name}[{number}]", entry, sign) for number, entry in enumerate(value)]
    if not _has_number(value):
        return value
    if not isinstance(value, str):
        return value * (1 + sign * CHANGE) if isfinite(value) else value
    number, unit, tolerance = parted(name, value)
    size = float(number)
    if not isfinite(size):
        return value
    change = size * CHANGE if tolerance is None else copysign(tolerance, size)
    return f"{size + sign * change:.15g} {unit}".strip()


def _text(value: Any) -> str:
    """Return a number as the scene has it, with its tolerance; of a list the first one."""
    if isinstance(value, list | tuple):
        return f"{_text(value[0])}, ..." if len(value) > 1 else _text(value[0])
    if isinstance(value, str) and PLUS_MINUS.search(value):
        return PLUS_MINUS.sub(" ± ", value)
    return f"{value} ± {100 * CHANGE:g} %"
