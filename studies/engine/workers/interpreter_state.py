"""State of the interpreter that a case may change, restored before each case, so that their order has no effect.

Modules that a case imports or changes, and its effects outside the process, cannot be restored.
"""

import decimal
import hashlib
import locale
import os
import random
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

Part = tuple[Callable[[], Any], Callable[[Any], object]]


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _set_environment(environment: dict[Any, Any]) -> None:
    os.environ.clear()
    os.environ.update({os.fsdecode(k): os.fsdecode(v) for k, v in environment.items()})


def _environment() -> dict[Any, Any]:
    # encoded: decoding all of it takes longer than the rest of this module
    return dict(os.environ._data)  # type: ignore[attr-defined]


def _set_warnings(filters: list[Any]) -> None:
    warnings.simplefilter("default")  # which also forgets what was shown under the filters so far
    warnings.filters[:] = filters  # type: ignore[index]


def _set_xarray_options(options: dict[str, Any]) -> None:
    now = xr.get_options()
    # changed options alone, since setting some options at all is deprecated
    xr.set_options(**{name: value for name, value in options.items() if now[name] != value})


# how each part of the state is read, as a value that equals another one of the same state, and how it is set
PARTS: tuple[Part, ...] = (
    (os.getcwd, os.chdir),
    (_environment, _set_environment),
    (_umask, os.umask),
    (lambda: list(sys.path), lambda path: sys.path.__setitem__(slice(None), path)),
    (sys.getrecursionlimit, sys.setrecursionlimit),
    (lambda: list(warnings.filters), _set_warnings),
    (lambda: locale.setlocale(locale.LC_ALL), lambda name: locale.setlocale(locale.LC_ALL, name)),
    (
        lambda: decimal.getcontext().__reduce__()[1],
        lambda parts: decimal.setcontext(decimal.Context(*parts)),
    ),
    (np.geterr, lambda errors: np.seterr(**errors)),
    (np.geterrcall, np.seterrcall),
    (np.get_printoptions, lambda options: np.set_printoptions(**options)),
    (lambda: dict(xr.get_options()), _set_xarray_options),
)


@dataclass(frozen=True)
class InterpreterState:
    """State of this interpreter at one moment."""

    values: tuple[Any, ...]

    @classmethod
    def now(cls) -> "InterpreterState":
        """Return the present state."""
        return cls(tuple(read() for read, _ in PARTS))

    def restore(self, name: str) -> None:
        """Restore this state, and seed the generators of numpy and random with the name of a case."""
        for (read, write), value in zip(PARTS, self.values, strict=True):
            try:
                present = read()
            except OSError:  # a working directory that was removed
                present = None
            with suppress(OSError):
                if present != value:
                    write(value)
        seed = hashlib.blake2b(name.encode(), digest_size=4).digest()
        random.seed(seed)
        np.random.seed(int.from_bytes(seed))  # noqa: NPY002 (for cases that use numpy's own generator)


@contextmanager
def restored_state() -> Iterator[InterpreterState]:
    """Provide the present state to a block of cases, and restore it at the end, random generators included."""
    before = InterpreterState.now()
    seeds = random.getstate(), np.random.get_state()  # noqa: NPY002
    try:
        yield before
    finally:
        before.restore("")
        random.setstate(seeds[0])
        np.random.set_state(seeds[1])  # noqa: NPY002
