"""The version of this program, when it was loaded, and a hash of its code."""

import hashlib
import time
from functools import cache
from pathlib import Path

VERSION = "0.1.0"
# instant at which its first module was loaded [s since the epoch]
LOADED = time.time()
# folders and modules of the core that cannot change a number
NOT_NUMERICAL = ("io", "planning", "forecast.py")


@cache
def source_hash(core: Path = Path(__file__).parents[2]) -> str:
    """Return a hash of the modules in the package ``core`` that can change a number."""
    digest = hashlib.sha256()
    for path in sorted(core.rglob("*.py")):
        name = path.relative_to(core)
        if name.parts[0] not in NOT_NUMERICAL:
            source = path.read_bytes()
            digest.update(f"{name} {len(source)} ".encode() + source)
    return digest.hexdigest()[:12]
