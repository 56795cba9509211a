"""Provenance of stored numbers: versions, revision, machine, command and time."""

import json
import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path

from contactstudy.elasticity.transforms import TRANSFORMS

# packages that compute and store
PACKAGES = ("contactstudy", "numpy", "scipy", "xarray", "netCDF4")


def provenance() -> Mapping[str, str]:
    """Return versions, revision, machine, command and time as attributes of a Dataset, all of them text."""
    now = datetime.now(UTC).isoformat(timespec="seconds")
    command = shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]])
    return {
        "Conventions": "CF-1.11",
        "source": ", ".join(f"{name} {version(name)}" for name in PACKAGES),
        "transforms": type(TRANSFORMS).__name__,
        "history": f"{now} {command}",
        "python": platform.python_version(),
        "git_revision": _revision(),
        "cpu": cpu(),
        "cpu_count": str(os.cpu_count()),
        "threads": "1",
        "platform": platform.platform(),
    }


def machine() -> str:
    """Return the name of the machine with its processor and system; times are compared on one machine only."""
    return f"{platform.node()}, {cpu()} x {os.cpu_count()}, {platform.system()}"


@cache
def _revision() -> str:
    """Return the commit of this program's code, with a mark where files differ from it.

    The commit is that of the program's own checkout, or of the one it was installed from, not that of a repository which
    the environment happens to lie in.
    """
    checkout = Path(__file__).parents[2]
    if not (checkout / ".git").exists():
        return _installed()
    try:
        describe = ["describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
        command = ["git", "-C", str(checkout), *describe]
        completed = subprocess.run(command, capture_output=True, text=True, timeout=10, check=True)
    except (OSError, subprocess.SubprocessError):
        return "unknown (not a git checkout)"
    return completed.stdout.strip()


def _installed() -> str:
    """Return the commit that the installer recorded; a text that says so if there is none."""
    try:
        record = distribution("contactstudy").read_text("direct_url.json")
        commit = json.loads(record or "{}").get("vcs_info", {}).get("commit_id")
    except (PackageNotFoundError, ValueError):
        commit = None
    return str(commit or "unknown (not a git checkout)")


def cpu() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor() or platform.machine())
