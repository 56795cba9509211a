"""What this machine has."""

import os
from math import inf
from pathlib import Path

# Where Linux limits the memory of a group of processes, version 2 and 1.
LIMITS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")


def memory_size() -> float:
    """Bytes of memory that a process may use; infinite where the system does not say."""
    try:
        size = float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        size = inf
    for path in LIMITS:
        try:
            size = min(size, float(Path(path).read_text()))
        except (OSError, ValueError):  # no such file, or "max"
            continue
    return size
