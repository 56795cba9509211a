"""How far a solve is, in per cent."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.cli.solving import SolveProgress, _keep_stopped, pressure_in


class Bar:
    """Keeps what it is told."""

    n = 0
    said = ""

    def set_postfix_str(self, text: str, *, refresh: bool) -> None:
        assert not refresh
        self.said = text

    def update(self, count: int) -> None:
        assert count == 0


def seen(*residuals: float, tolerance: float = 1e-8) -> tuple[list[int], SolveProgress, Bar]:
    bar = Bar()
    progress = SolveProgress(tolerance, cast(Any, bar))
    shown = []
    for residual in residuals:
        progress.see(residual, np.full((2, 1), residual))
        shown.append(bar.n)
    return shown, progress, bar


def test_a_bar_goes_as_the_logarithm_of_the_residual_from_the_first_to_the_tolerance() -> None:
    shown, progress, bar = seen(1.0, 1e-2, 10.0, 1e-4, 1e-8, 1e-12)
    assert shown == [0, 25, 0, 50, 100, 100]
    assert (progress.iterations, progress.residual) == (6, 1e-12)
    assert bar.said == "residual 1.0e-12 of 1.0e-08"


def test_what_begins_near_the_tolerance_counts_from_ten_times_it() -> None:
    assert seen(2e-8)[0] == [round(100 * np.log10(5))]
    assert seen(np.inf, 0.0, np.nan, 1e-4, 1e-6)[0] == [0, 0, 0, 0, 50]


def test_a_stopped_solve_keeps_its_pressure_in_pascal_and_its_residual(tmp_path: Path) -> None:
    grid = cs.Grid((2, 1), (2.0, 1.0))
    problem: Any = SimpleNamespace(scales=SimpleNamespace(pressure=2e6), grid=grid)
    path = _keep_stopped(seen(1e-3)[1], problem, tmp_path / "stopped.nc")
    kept = xr.load_dataset(path)
    np.testing.assert_array_equal(pressure_in(path), [[2e3], [2e3]])
    assert kept["pressure"].attrs["units"] == "Pa"
    assert float(kept["residual"]) == 1e-3
    np.testing.assert_array_equal(kept["x"].values, grid.x)
