"""Scenes that solve in milliseconds."""

from pathlib import Path

import pytest

SMOOTH = """
[load]
per_length = "100 N/mm"
[[solids]]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[[solids]]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[[shapes]]
kind = "Cylinder"
radius = "10 mm"
[plan]
error = 1e-2
"""

ROUGH = SMOOTH.replace(
    "[plan]",
    """
[[shapes]]
kind = "Roughness"
rms = "0.1 um"
hurst = 0.8
roll_off = "120 um"
cut_off = "60 um"
seed = 3
[plan]""",
).replace("1e-2", '0.2\nperiod = "0.48 mm"')


@pytest.fixture
def smooth(tmp_path: Path) -> Path:
    path = tmp_path / "smooth.toml"
    path.write_text(SMOOTH)
    return path


@pytest.fixture
def rough(tmp_path: Path) -> Path:
    path = tmp_path / "rough.toml"
    path.write_text(ROUGH)
    return path
