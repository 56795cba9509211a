"""Provenance of stored numbers: versions, revision, machine, command and time."""

import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from contactstudy.elasticity.transforms import TRANSFORMS

# packages that compute and store, those that may be missing last
PACKAGES = ("contactstudy", "numpy", "scipy", "xarray", "netCDF4", "ducc0", "numba")


def provenance() -> Mapping[str, str]:
    """Return versions, revision, machine, command and time as attributes of a Dataset, all of them text."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    return {
        "Conventions": "CF-1.11",
        "source": ", ".join(_versions()),
        "transforms": type(TRANSFORMS).__name__,
        "history": f"{now} {command}",
        "python": platform.python_version(),
        "git_revision": _revision(),
        "cpu": cpu(),
        "cpu_count": str(os.cpu_count()),
        "platform": platform.platform(),
    }


def _versions() -> Iterator[str]:
    """Yield names and versions of the packages that are installed."""
    for name in PACKAGES:
        with suppress(PackageNotFoundError):
            yield f"{name} {version(name)}"


def machine() -> str:
    """Return the name of the machine with its processor and system; times are compared on one machine only."""
    return f"{platform.node()}, {cpu()} x {os.cpu_count()}, {platform.system()}"


@cache
def _revision() -> str:
    """Return the commit of this program's own checkout, with ``-dirty`` where files differ from it."""
    checkout = Path(__file__).parents[2]
    command = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    # without it git would name the repository that the environment happens to lie in
    if (checkout / ".git").exists():
        with suppress(OSError, subprocess.SubprocessError):
            described = subprocess.run(command, cwd=checkout, capture_output=True, text=True, timeout=10, check=True)
            return described.stdout.strip()
    return "unknown (not a git checkout)"


def cpu() -> str:
    """Return the name of the processor."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
