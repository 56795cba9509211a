from collections.abc import Hashable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from studies.cli.commands import cli
from tests.studies.scene_study.conftest import SMOOTH


def said(*words: object, code: int = 0) -> str:
    """Output of the command ``contactstudy``, which ends with that code; what it raises is raised."""
    result = CliRunner().invoke(cli, [str(word) for word in words], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result.output


def ended(dims: str | Sequence[Hashable], outcomes: Any) -> xr.Variable:
    """Outcomes of cases: 1 where one is there."""
    attributes = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "failed ok"}
    return xr.Variable(dims, np.asarray(outcomes, dtype=np.int8), attributes)


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two solutions and a sweep of a smooth scene."""
    path = tmp_path_factory.mktemp("shown")
    for name, load in (("smooth", "100 N/mm"), ("heavy", "110 N/mm")):
        (path / f"{name}.toml").write_text(SMOOTH.replace("100 N/mm", load))
        said("solve", path / f"{name}.toml", "--out", path / "out")
    oil = "\n[lubrication]\nmean_speed = 1\nlubricant = {viscosity = 0.04, pressure_viscosity = 0}\n"
    (path / "oil.toml").write_text(SMOOTH + oil)
    vary = ("--vary", "load.per_length=50,100 N/mm", "--vary", "radius=10,20 mm", "--workers", 0)
    said("run", path / "smooth.toml", *vary, "--out", path / "study")
    return path
