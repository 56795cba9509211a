"""References in fifty digits, computed once: ``python -m tests.fifty_digits`` writes them to ``tests/reference``.

A function with the mark ``stored`` is looked up by its name and its arguments. These must be the same numbers on every
processor: products and square roots are; powers, logarithms and sines of numpy are not. ``over_decades`` draws such
numbers, and ``float`` of a value of mpmath is one.
"""

import hashlib
import json
import math
import os
import sys
from collections.abc import Callable
from functools import wraps
from pathlib import Path

import mpmath as mp
import numpy as np
import pytest
from numpy.typing import NDArray

FILE = Path(__file__).parent / "reference" / "fifty_digits.json"
KERNELS = "tests/contactstudy/elasticity/kernels"
DIGITS = 25  # stored
CHECKED = 16  # one reference in so many is computed again in every run
KNOWN: dict[str, str] = json.loads(FILE.read_text(encoding="utf-8")) if FILE.is_file() else {}
USED: dict[str, str] = {}
IS_WRITING = "FIFTY_DIGITS" in os.environ


def stored(compute: Callable[..., mp.mpf]) -> Callable[..., mp.mpf]:
    """A function of numbers whose values are stored with 25 digits.

    Raises LookupError where a value is not stored, or is not what the function gives.
    """

    @wraps(compute)
    def value(*arguments: float) -> mp.mpf:
        words = [compute.__name__, *(float(a).hex() for a in arguments)]
        key = hashlib.sha256(" ".join(words).encode()).hexdigest()[:16]
        if IS_WRITING and key not in USED:
            USED[key] = mp.nstr(compute(*arguments), DIGITS)
        known = USED if IS_WRITING else KNOWN
        with mp.workdps(50):
            if key not in known:
                raise LookupError(f"{words} is not stored: run python -m tests.fifty_digits")
            found = mp.mpf(known[key])
            if int(key, 16) % CHECKED == 0 and not IS_WRITING:
                expected = compute(*arguments)
                if abs(found - expected) > mp.mpf(10) ** (1 - DIGITS) * abs(expected):
                    raise LookupError(f"{words} has changed: run python -m tests.fifty_digits")
            return found

    return value


def over_decades(rng: np.random.Generator, low: float, high: float, size: int | None = None) -> NDArray[np.float64]:
    """Numbers from ``10**low`` to ``10**high``, as many in each octave, the same on every processor."""
    octaves = [int(decade * math.log2(10)) for decade in (low, high)]
    if low == high:
        return np.ldexp(np.ones(() if size is None else size), octaves[0])
    return np.ldexp(1 + rng.random(size), rng.integers(*octaves, size))


def main() -> None:
    """Run the tests of the kernels, all of whose references are computed anew, and store them."""
    os.environ["FIFTY_DIGITS"] = "write"
    from tests import fifty_digits  # the module that the tests import, not this one

    code = pytest.main(["-q", "-n", "0", "--whole", KERNELS])
    lines = ",\n".join(f'"{key}": "{value}"' for key, value in sorted(fifty_digits.USED.items()))
    FILE.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    sys.exit(code)


if __name__ == "__main__":
    main()
