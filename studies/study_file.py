"""Studies in Python files, which are read and checked before anything runs."""

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from contactstudy import InvalidInput
from studies.model.axis import Axis
from studies.model.plain_text import one_line, quoted, shortened
from studies.model.study import Study
from studies.store.program import content, look

NEEDED = ("axes", "case_at", "measures")
FUNCTIONS = ("case_at", "measures", "figure", "findings", "tables")


def module_name(path: Path) -> str:
    """Return the module name of a study file, with a prefix, so that time.py does not replace Python's module."""
    return f"study_in_file_{path.stem}"


def module_in(path: Path) -> ModuleType:
    """Return the module in `path`, with the names that a study needs.

    Raises :class:`~contactstudy.InvalidInput`, with file and line, for any error in it.
    """
    name = module_name(path)
    if not os.path.isfile(path):  # noqa: PTH113 (no error for any name)
        raise InvalidInput(
            f"Study file {quoted(path)} cannot be read: give the path of a Python file."
        )
    look()
    module = ModuleType(name)
    sys.modules[name] = module
    with _blaming(path):
        # compiled from these bytes, and not from a cache, since their hash identifies the numbers
        source = path.read_bytes()
        vars(module).update(__file__=str(path.absolute()), __source__=source)
        exec(compile(source, str(path.absolute()), "exec"), vars(module))
    look()
    for part in NEEDED:
        if not hasattr(module, part):
            raise InvalidInput(
                f"Study file {quoted(path)} has no {part!r}: define it at the file's top level."
            )
    for part in FUNCTIONS:
        if not callable(getattr(module, part, print)):
            raise InvalidInput(f"{_where(path, part)}: {part} is no function: define it with def.")
    if isinstance(module.axes, Axis):
        vars(module)["axes"] = (module.axes,)
    axes = module.axes
    if not isinstance(axes, tuple | list) or not all(isinstance(axis, Axis) for axis in axes):
        raise InvalidInput(
            f"{_where(path, 'axes')}: axes is {shortened(axes)}: give a tuple of "
            "studies.Axis, such as (Axis('grid', (16, 32), 'cells'),)."
        )
    if not axes:
        raise InvalidInput(f"{_where(path, 'axes')}: axes is empty: give one axis or more.")
    # worker processes cannot import this file: its functions are pickled by value
    from cloudpickle import register_pickle_by_value

    register_pickle_by_value(module)
    return module


def study_in(path: Path) -> Study:
    """Return the study in ``path``."""
    module = module_in(path)
    description = module.__doc__ if isinstance(module.__doc__, str) else path.stem
    title = one_line(description.strip().split("\n")[0], 300)
    times = getattr(module, "times", "taken")
    depends, folder = _depends(path, module), path.absolute().parent
    # what the file may have read when it was loaded
    vars(module)["__depends__"] = {name: content(folder / name) for name in depends}
    try:
        return Study(
            path.stem, title, tuple(module.axes), module.case_at, module.measures, times,
            depends=depends, folder=folder,
        )  # fmt: skip
    except InvalidInput as error:
        blamed = "times" if str(error).startswith("times") else "axes"
        raise InvalidInput(f"{_where(path, blamed)}: {error}") from None


def _depends(path: Path, module: ModuleType) -> tuple[str, ...]:
    """Return the names of the files that a study file depends on."""
    names = getattr(module, "depends", ())
    names = (names,) if isinstance(names, str) else names
    if not isinstance(names, tuple | list) or not all(isinstance(name, str) for name in names):
        raise InvalidInput(
            f"{_where(path, 'depends')}: depends is {shortened(names)}: give the names of files beside the study."
        )
    return tuple(names)


@contextmanager
def _blaming(path: Path) -> Iterator[None]:
    """Raise any error of the block as InvalidInput with the file and the line."""
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # noqa: BLE001 (a file may do anything, also exit)
        line: int | None = None
        file = str(path.absolute())
        if isinstance(error, SyntaxError) and error.filename == file:
            line, message = error.lineno, f"{type(error).__name__}: {error.msg}"
        else:
            trace = error.__traceback__
            while trace is not None:
                if trace.tb_frame.f_code.co_filename == file:
                    line = trace.tb_lineno
                trace = trace.tb_next
            message = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        message = str(error) if isinstance(error, InvalidInput) else one_line(message, 500)
        at = "" if line is None else f", line {line}"
        end = "" if message.endswith(".") else "."
        raise InvalidInput(f"Study file {quoted(path)}{at}: {message}{end}") from None


def _where(path: Path, name: str) -> str:
    """Return a text with the file and the line that defines `name`."""
    text = path.read_text(encoding="utf-8", errors="replace")
    found = re.search(rf"^(?:def |class )?{name}\b", text, re.MULTILINE)
    at = f", line {text.count(chr(10), 0, found.start()) + 1}" if found else ""
    return f"Study file {quoted(path)}{at}"
