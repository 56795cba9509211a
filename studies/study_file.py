"""Studies in Python files, which are read and checked before anything runs."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from contactstudy import InvalidInput
from studies.model.plain_text import one_line, quoted
from studies.model.study import Study
from studies.store.program import content, look


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
        raise InvalidInput(
            f"Study file {quoted(path)} has no study: define study = studies.Study(...) at its top level."
        )
    # worker processes cannot import this file: its functions are pickled by value
    from cloudpickle import register_pickle_by_value

    register_pickle_by_value(module)
    return module


def study_in(path: Path) -> Study:
    """Return the study in ``path``."""
    module, folder = module_in(path), path.absolute().parent
    study: Study = module.study
    # what the file may have read when it was loaded
    vars(module)["__depends__"] = {name: content(folder / name) for name in study.depends}
    return replace(study, folder=folder)


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
