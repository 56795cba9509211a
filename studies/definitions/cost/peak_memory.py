"""The most memory that a computation holds at once."""

import tracemalloc
from collections.abc import Callable

# Iterations after which a solve holds no more than before: all its fields are there after the second.
ENOUGH = 3


def peak_bytes(compute: Callable[[], object]) -> int:
    """Bytes that ``compute`` holds at the most, of what Python and numpy take."""
    tracemalloc.start()
    try:
        compute()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
