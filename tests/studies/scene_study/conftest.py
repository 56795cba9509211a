from pathlib import Path

import pytest

LOAD = '[load]\nper_length = "100 N/mm"\n'
STEEL = '[[solids]]\nyoungs_modulus = "210 GPa"\npoisson_ratio = 0.3\n'
CYLINDER = '[[shapes]]\nkind = "Cylinder"\nradius = "10 mm"\n'
SMOOTH = f"{LOAD}{STEEL}{STEEL}{CYLINDER}[plan]\nerror = 1e-2\n"


def given(cells: int, width: str, length: str = "1 mm") -> str:
    return f'[grid]\ncells = [{cells}, 1]\nextent = ["{width}", "{length}"]\n'


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
