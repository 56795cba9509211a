from pathlib import Path

import pytest
import xarray as xr

from studies.engine.run import run
from studies.model.drawing import Table
from studies.registry import load
from studies.report.drawings import paper
from studies.report.drawings.line_contact import grid, images, padding, period, price_table
from studies.store.netcdf import read
from tests.studies.conftest import quiet


def swept(name: str, out: Path, **axes: str) -> xr.Dataset:
    run(load(name).override(axes), out, workers=0, repeats=1, log=quiet)
    return read(out / f"{name}.nc")


@pytest.mark.whole
def test_findings_are_silent_where_the_sweeps_cannot_speak(tmp_path: Path) -> None:
    sweep = swept("padding", tmp_path, padding="exact,zero", grid="16", period="2.4")
    assert padding.findings(sweep) == ()
    assert images.findings(swept("images", tmp_path, images="0", period="2.4", grid="16")) == ()
    assert period.findings(swept("period", tmp_path, period="2.4", grid="16")) == ()
    assert grid.findings(swept("grid", tmp_path, grid="16,24")) == ()
    assert price_table(sweep).rows[-1][2].startswith("none stored")


@pytest.mark.whole
def test_the_n_that_meets_a_target_is_the_least_from_which_on_all_do(tmp_path: Path) -> None:
    sweep = swept("images", tmp_path, padding="circular,exact", images="0:9", period="2.4")
    (said,) = images.findings(sweep)
    # a²/(8(n + 1/2)²L²) is 1e-3 at n + 1/2 = 4.66
    assert said.question == "Which n?"
    assert "needs n = 5 at L = 2.4 a" in said.measured


@pytest.mark.whole
def test_the_table_shows_what_is_stored(tmp_path: Path) -> None:
    rows = paper.accuracy_table(swept("paper", tmp_path, padding="circular,exact", images="1")).rows
    assert [row[0] for row in rows] == ["exact", "circular, n = 1"]


@pytest.mark.parametrize(
    ("cells", "kind"),
    [
        (("1.9 %", "0 %", "540 %"), "number"),
        (("0.6 a", "2.4 a"), "number"),
        (("-0.1", "< 1e-12"), "number"),
        (("5 %", "7"), "number"),
        (("0.002", "none"), "number"),
        (("exact", "2 copies"), "text"),
        ((), "number"),
    ],
)
def test_a_column_that_starts_with_numbers_is_one_of_numbers(
    cells: tuple[str, ...], kind: str
) -> None:
    assert Table("", ("column",), tuple((cell,) for cell in cells)).kinds == (kind,)
