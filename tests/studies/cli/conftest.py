from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np
import xarray as xr
from click.testing import CliRunner

from studies.cli.commands import cli


def said(*words: object, code: int = 0) -> str:
    """Output of the command ``contactstudy``, which ends with that code; what it raises is raised."""
    result = CliRunner().invoke(cli, [str(word) for word in words], catch_exceptions=False)
    assert result.exit_code == code, result.output
    return result.output


def ended(dims: str | Sequence[Hashable], outcomes: Any) -> xr.Variable:
    """Outcomes of cases: 1 where one is there."""
    attributes = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "failed ok"}
    return xr.Variable(dims, np.asarray(outcomes, dtype=np.int8), attributes)
