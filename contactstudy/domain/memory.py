"""How much memory there is, so that what cannot fit is refused before it is made."""

import resource
from contextlib import suppress
from pathlib import Path

CGROUP = Path("/sys/fs/cgroup")


def available_bytes() -> float:
    """Memory that this process may still take [bytes]; infinite where the system does not say."""
    found = [float("inf")]
    with suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text().splitlines():
            name, _, amount = line.partition(":")
            if name in ("MemAvailable", "SwapFree"):
                found[0] = (0.0 if found[0] == float("inf") else found[0]) + 1024 * float(
                    amount.split()[0]
                )
    with suppress(OSError, ValueError):
        limit = float((CGROUP / "memory.max").read_text())
        found.append(limit - float((CGROUP / "memory.current").read_text()))
    soft, _ = resource.getrlimit(resource.RLIMIT_AS)
    if soft != resource.RLIM_INFINITY:
        with suppress(OSError, ValueError, IndexError):
            pages = int(Path("/proc/self/statm").read_text().split()[0])
            found.append(float(soft - pages * resource.getpagesize()))
    return max(min(found), 0.0)
