"""Registry of studies: built-in ones by name, others in a Python file.

A study is defined in ``studies/definitions``, or by a scene file in ``studies/chapters``, and drawn in
``studies/report/drawings``, in the module of its name or in that of its family. Both are imported when they are asked
for: what lists, runs or distributes studies imports no plotting library.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from importlib.resources import files
from pathlib import Path
from traceback import extract_tb
from types import ModuleType
from typing import Any, cast

from contactstudy import InvalidInput
from contactstudy.domain.validation import suggestion
from studies.model.axis import Axis
from studies.model.drawing import Drawing, no_items
from studies.model.plain_text import one_line, quoted
from studies.model.study import Study
from studies.store.program import content, look

# Studies by family.
FAMILIES = {
    "settings": ("padding", "period", "images", "grid", "pareto", "paper"),
    "effects": (
        "coating", "friction", "sliding", "creep", "wear", "plastic", "films", "roughness", "rough-paddings"
    ),
    "hard_cases": ("stability",),
}  # fmt: skip
# Scene files whose [vary] is a study, with the value of an axis against which errors are, if any.
SCENES = dict.fromkeys(FAMILIES["effects"], "") | {"rough-paddings": "ExactPeriodicity"}
BUILT_IN = tuple(name for names in FAMILIES.values() for name in names)


def load(name: str) -> Study:
    """Return the built-in study of a name, or the study in a Python file.

    Raises :class:`~contactstudy.InvalidInput` if there is none, or if a file has none.
    """
    if name.endswith(".py"):
        module, folder = module_in(Path(name)), Path(name).absolute().parent
        study = cast(Study, module.study)
        if study.name in BUILT_IN:
            raise InvalidInput(f"Study file {name!r} has the name of a built-in study, {study.name!r}: rename it.")
        # what the file may have read when it was loaded
        vars(module)["__depends__"] = {name: content(folder / name) for name in study.depends}
        return replace(study, folder=folder)
    if name not in SCENES:
        return cast(Study, _part("studies.definitions", name))
    # planning needs the core, which listing does not
    from studies.advice.reference_error import against
    from studies.scene_study.study_of import study_of

    study = replace(study_of(chapter_file(name), name=name), title=_title(name))
    return against(study, "padding", SCENES[name]) if SCENES[name] else study


def chapter_file(name: str) -> Path:
    """Return the path of the scene file of a chapter."""
    return Path(str(files("studies") / "chapters" / f"{name}.toml"))


def _title(name: str) -> str:
    """Return the first line of the scene file of a chapter."""
    return chapter_file(name).read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ")


def outline(name: str) -> tuple[str, tuple[Axis, ...]]:
    """Return the title and the axes of a study; the grids of a scene, which takes seconds, are not planned."""
    if name not in SCENES:
        study = load(name)
        return study.title, study.axes
    from studies.scene_study.study_of import axes_of

    return _title(name), axes_of(chapter_file(name))


def has_own_figures(name: str) -> bool:
    """Return whether a study has figures of its own: a scene has none, and the study in a Python file may have some."""
    if name.endswith(".py"):
        return hasattr(_file_module(name), "figure")
    return not name.endswith(".toml")


def load_drawing(name: str, plot: Sequence[str] = ()) -> Drawing:
    """Return the drawing of the study of a name, or of the study in a Python file.

    A study without figures of its own has the default drawing of the variables `plot`.
    """
    if not has_own_figures(name):
        return default_drawing(plot)
    part = _file_module(name) if name.endswith(".py") else _part("studies.report.drawings", name)
    return Drawing(*(getattr(part, key, no_items) for key in ("figure", "findings", "tables")))


def default_drawing(plot: Sequence[str]) -> Drawing:
    """Return the default drawing, whose figures follow from the varied axes and show the variables `plot`, if any."""
    # imported by name, since pages import this registry
    drawn = importlib.import_module("studies.report.drawings.default")
    return Drawing(partial(drawn.figures, plot=plot))


def _file_module(name: str) -> ModuleType:
    """Return the module of a study in a Python file."""
    return sys.modules.get(module_name(Path(name))) or module_in(Path(name))


def _part(package: str, name: str) -> Any:
    """Return the value of the name of a study in the module of its family."""
    if name not in BUILT_IN:
        hint = suggestion(name, sorted(BUILT_IN))
        raise InvalidInput(f"Study {name!r} is not known: {hint}, or give a .py file.")
    family = next(family for family, names in FAMILIES.items() if name in names)
    return getattr(importlib.import_module(f"{package}.{family}"), name.replace("-", "_"))


def module_name(path: Path) -> str:
    """Return the module name of a study file, with a prefix, so that time.py does not replace Python's module."""
    return f"study_in_file_{path.stem}"


def module_in(path: Path) -> ModuleType:
    """Return the module in `path`, which has a `study`.

    Raises :class:`~contactstudy.InvalidInput`, with file and line, for any error in it.
    """
    name = module_name(path)
    if not os.path.isfile(path):  # noqa: PTH113 (no error for any name)
        raise InvalidInput(f"Study file {quoted(path)} cannot be read: give the path of a Python file.")
    look()
    module = ModuleType(name)
    sys.modules[name] = module
    with _blaming(path):
        # compiled from these bytes, and not from a cache, since their hash identifies the numbers
        source = path.read_bytes()
        vars(module).update(__file__=str(path.absolute()), __source__=source)
        exec(compile(source, str(path.absolute()), "exec"), vars(module))
    look()
    if not isinstance(getattr(module, "study", None), Study):
        raise InvalidInput(f"Study file {quoted(path)} has no study: define study = studies.Study(...) in it.")
    # worker processes cannot import this file: its functions are pickled by value
    from cloudpickle import register_pickle_by_value

    register_pickle_by_value(module)
    return module


@contextmanager
def _blaming(path: Path) -> Iterator[None]:
    """Raise any error of the block as InvalidInput with the file and the line."""
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 (a file may do anything, also exit)
        file = str(path.absolute())
        lines = [frame.lineno for frame in extract_tb(error.__traceback__) if frame.filename == file]
        text: object = error
        if isinstance(error, SyntaxError) and error.filename == file:
            lines, text = [error.lineno], error.msg
        message = one_line(f"{type(error).__name__}: {text}".removesuffix(": "), 500)
        message = str(error) if isinstance(error, InvalidInput) else message
        at = f", line {lines[-1]}" if lines else ""
        raise InvalidInput(f"Study file {quoted(path)}{at}: {message.removesuffix('.')}.") from None
