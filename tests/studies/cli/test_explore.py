"""Test the page that shows a study or a contact in a browser, without a network."""

import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

import contactstudy as cs
from studies.cli.commands import cli
from studies.cli.explore import MOST_CELLS, contact_chart, page_of, study_chart
from tests.conftest import LineContact

altair = pytest.importorskip("altair")
pytest.importorskip("vl_convert")

BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")
OUTCOMES = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "failed ok"}


@pytest.fixture
def study() -> xr.Dataset:
    """A study over a load of two decades and a name, one of whose cases failed."""
    peak = np.array([[1e8, 2e8], [3e8, np.nan], [9e8, 8e8]])
    status = np.array([[1, 1], [1, 0], [1, 1]], dtype=np.int8)
    return xr.Dataset(
        {
            "peak_pressure": (
                ("load", "mode"),
                peak,
                {"units": "Pa", "long_name": "peak pressure"},
            ),
            "case_status": (("load", "mode"), status, OUTCOMES),
        },
        {
            "load": ("load", [1e3, 1e4, 1e5], {"units": "N m-1", "long_name": "load"}),
            "mode": ["a", "b"],
        },
        {"title": "two modes"},
    )


@pytest.fixture
def contact(line_contact: LineContact) -> xr.Dataset:
    solution = cs.solve(line_contact.scene, line_contact.grid((32, 8), 1.4), cs.ExactPeriodicity())
    return solution.to_dataset()


def shown(page: str, folder: Path, width: int = 390) -> str:
    """What a browser makes of a page, without a network."""
    if BROWSER is None:
        pytest.skip("no Chromium on this machine")
    path = folder / "page.html"
    path.write_text(page, encoding="utf-8")
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--window-size={width},800"]
    offline = ["--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder / 'profile'}"]
    patience = ["--virtual-time-budget=20000", "--dump-dom", path.as_uri()]
    done = subprocess.run(
        [*command, *offline, *patience], capture_output=True, text=True, timeout=120
    )
    return done.stdout


def test_a_page_loads_nothing_from_elsewhere(study: xr.Dataset, contact: xr.Dataset) -> None:
    for dataset in (study, contact):
        page = page_of(dataset, "page")
        assert not re.search(r"<(script|link)[^>]*(src|href)=", page)
        assert "width=device-width" in page


def test_a_browser_draws_a_study_with_its_choosers(study: xr.Dataset, tmp_path: Path) -> None:
    drawn = shown(page_of(study, "page"), tmp_path)
    assert "peak pressure [Pa] over load [N m-1], by mode" in drawn
    for label in ("x axis", "variable", "colour", "logarithmic x", "load [N m-1]: value no."):
        assert label in drawn
    assert drawn.count('type="range"') == 2
    # a point for each case with a number, in a chart for lines and one for points
    assert drawn.count('aria-roledescription="point"') == 5


def test_a_browser_draws_a_contact_with_a_chooser(contact: xr.Dataset, tmp_path: Path) -> None:
    drawn = shown(page_of(contact, "page"), tmp_path)
    assert "<canvas" in drawn
    assert '<option value="gap">' in drawn


def test_a_fine_contact_is_shown_by_means_of_blocks() -> None:
    values = np.ones((400, 300))
    axes = {"x": ("x", np.linspace(-1, 1, 400)), "y": ("y", np.linspace(-1, 1, 300))}
    fine = xr.Dataset(dict.fromkeys(("pressure", "gap"), (("x", "y"), 1000000.0 * values)), axes)
    chart = contact_chart(altair, fine)
    assert 1000 < len(chart.data) <= MOST_CELLS
    assert (chart.data["pressure"] == 1).all()


def test_the_command_writes_a_page_beside_the_file(study: xr.Dataset, tmp_path: Path) -> None:
    study.to_netcdf(tmp_path / "study.nc")
    result = CliRunner().invoke(cli, ["explore", str(tmp_path / "study.nc")])
    assert result.exit_code == 0, result.output
    assert "<title>study: two modes</title>" in (tmp_path / "study-explore.html").read_text(
        encoding="utf-8"
    )


def test_a_file_of_another_kind_is_refused() -> None:
    with pytest.raises(cs.InvalidInput, match="neither a solution nor a study"):
        page_of(xr.Dataset(), "nothing")


@pytest.mark.parametrize(
    ("values", "logarithmic"), [([1.0, 31.0], True), ([1.0, 30.0], False), ([0.0, 100.0], False)]
)
def test_an_axis_is_logarithmic_if_it_spans_more_than_a_factor_of_30(
    values: list[float],
    logarithmic: bool,  # noqa: FBT001
    study: xr.Dataset,
) -> None:
    chart = study_chart(altair, study.isel(load=slice(2)).assign_coords(load=values))
    [shown_so] = [each.value for each in chart.params if each.name == "logx"]
    assert shown_so == logarithmic
