"""References in fifty digits, computed once: ``python -m tests.fifty_digits`` writes them to ``tests/reference``.

A function with the mark ``stored`` is looked up by its own text and its arguments. What is not stored, as where another
processor gives another argument, is computed.
"""

import hashlib
import inspect
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path

import mpmath as mp
import pytest

FILE = Path(__file__).parent / "reference" / "fifty_digits.json"
KERNELS = "tests/contactstudy/elasticity/kernels"
KNOWN: dict[str, str] = json.loads(FILE.read_text(encoding="utf-8")) if FILE.is_file() else {}
USED: dict[str, str] = {}
IS_WRITING = "FIFTY_DIGITS" in os.environ


def stored(compute: Callable[..., mp.mpf]) -> Callable[..., mp.mpf]:
    """A function of numbers whose values are stored with 25 digits."""
    text = inspect.getsource(compute)

    def value(*arguments: float) -> mp.mpf:
        key = hashlib.sha256(f"{text}{[float(a).hex() for a in arguments]}".encode()).hexdigest()[
            :16
        ]
        if IS_WRITING and key not in USED:
            USED[key] = mp.nstr(mp.mpf(compute(*arguments)), 25)
        known = USED if IS_WRITING else KNOWN
        with mp.workdps(50):
            return mp.mpf(known[key]) if key in known else compute(*arguments)

    return value


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
