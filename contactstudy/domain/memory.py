"""Available memory of this machine: a solve that does not fit is refused before it starts."""

from contextlib import suppress
from importlib import import_module
from math import inf
from pathlib import Path

CGROUP = Path("/sys/fs/cgroup")


def available_bytes() -> float:
    """Return the memory that this process may still take [bytes]; infinite where the system does not say."""
    return max(min(_of_system(), _of_container(), _of_process()), 0.0)


def _of_system() -> float:
    """Return free memory and swap [bytes].

    They are read from Linux directly, and on other systems from psutil, if it is installed.
    """
    with suppress(OSError, ValueError, IndexError, KeyError):
        lines = Path("/proc/meminfo").read_text(encoding="utf-8").splitlines()
        amounts = {
            name: amount.split() for name, _, amount in (line.partition(":") for line in lines)
        }
        return 1024 * sum(float(amounts[name][0]) for name in ("MemAvailable", "SwapFree"))
    with suppress(ImportError, OSError):
        psutil = import_module("psutil")
        return float(psutil.virtual_memory().available + psutil.swap_memory().free)
    return inf


def _of_container() -> float:
    """Return the memory left in a container [bytes]; infinite where there is no limit."""
    with suppress(OSError, ValueError):
        limit, used = (
            float((CGROUP / f"memory.{name}").read_text(encoding="utf-8"))
            for name in ("max", "current")
        )
        return limit - used
    return inf


def _of_process() -> float:
    """Return what the limit of the address space leaves, if the system sets one [bytes]."""
    with suppress(ImportError, OSError, ValueError, IndexError):
        resource = import_module("resource")
        soft, _ = resource.getrlimit(resource.RLIMIT_AS)
        if soft != resource.RLIM_INFINITY:
            pages = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0])
            return float(soft - pages * resource.getpagesize())
    return inf
