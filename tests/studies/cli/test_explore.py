import json
import re
import shutil
import subprocess
from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.cli.explore import MAX_VALUES, contents, page_of
from tests.conftest import LineContact
from tests.studies.cli.conftest import ended, said

BROWSER = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")


@pytest.fixture
def study() -> xr.Dataset:
    """A study over a load of two decades and a name, one of whose cases failed."""
    peak = np.array([[1e8, 2e8], [3e8, np.nan], [9e8, 8e8]])
    dims, label = ("load", "mode"), {"units": "Pa", "long_name": "peak pressure"}
    return xr.Dataset(
        {
            "peak_pressure": (dims, peak, label),
            "case_status": ended(dims, [[1, 1], [1, 0], [1, 1]]),
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


@pytest.fixture
def evolution() -> xr.Dataset:
    pressure = 1e6 * np.arange(24.0).reshape(4, 6, 1)
    return xr.Dataset(
        {"pressure": (("time", "x", "y"), pressure, {"units": "Pa", "long_name": "pressure"})},
        {"time": ("time", [0.0, 1.0, 2.0, 4.0], {"units": "s", "long_name": "time"})},
    )


def shown(page: str, folder: Path, script: str = "") -> str:
    """What a browser makes of a page, without a network, after a script that acts on it."""
    if BROWSER is None:
        pytest.skip("no Chromium on this machine")
    path = folder / "page.html"
    path.write_text(page.replace("</body>", f"<script>{script}</script></body>"), encoding="utf-8")
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--window-size=1200,800"]
    offline = ["--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={folder / 'profile'}"]
    patience = ["--virtual-time-budget=20000", "--dump-dom", path.as_uri()]
    done = subprocess.run([*command, *offline, *patience], capture_output=True, text=True, timeout=120)
    # less the scripts, whose text is no part of what is shown
    return re.sub(r"<script.*?</script>", "", done.stdout, flags=re.DOTALL)


def values(variable: dict[str, Any]) -> np.ndarray:
    return np.frombuffer(b64decode(variable["data"]), dtype="<f4")


def test_a_page_loads_nothing_from_elsewhere(study: xr.Dataset, contact: xr.Dataset) -> None:
    for dataset in (study, contact):
        page = page_of(dataset, "page")
        assert not re.search(r"<(script|link|img)[^>]*(src|href)=", page)
        assert "default-src 'none'" in page


def test_numbers_are_in_the_units_that_are_usual(study: xr.Dataset, evolution: xr.Dataset) -> None:
    shows = contents(study, "study")
    assert shows["axes"]["load"]["values"] == [1, 10, 100]
    assert shows["axes"]["load"]["unit"] == "N/mm"
    peak = shows["variables"]["peak_pressure"]
    assert peak["unit"] == "MPa"
    assert values(peak)[[0, 1, 2, 4, 5]] == pytest.approx([100, 200, 300, 900, 800])
    assert np.isnan(values(peak)[3])
    assert contents(evolution, "evolution")["variables"]["pressure"]["unit"] == "MPa"


def test_an_evolution_begins_at_the_instant_of_its_largest_pressure(evolution: xr.Dataset) -> None:
    unloaded = evolution.assign(pressure=evolution["pressure"] * xr.DataArray([1, 1, 2, 0], dims="time"))
    assert contents(unloaded, "evolution")["instant"] == 2


BREAK = "document.body.dataset.broken=1"
HOSTILE = f'"><img src=x onerror="{BREAK}"></title></script><script>{BREAK}</script>'


def test_nothing_in_a_hostile_file_is_executed(study: xr.Dataset, tmp_path: Path) -> None:
    study.attrs["title"] = HOSTILE
    study["peak_pressure"].attrs |= {"long_name": HOSTILE, "units": HOSTILE}
    study["load"].attrs |= {"long_name": HOSTILE, "units": HOSTILE}
    study = study.assign_coords(mode=[HOSTILE, "b"]).rename(peak_pressure=HOSTILE.replace("/", "|"))
    study["number"] = ((), 1.0, {"long_name": HOSTILE, "units": HOSTILE})
    page = page_of(study, HOSTILE)
    drawn = shown(page, tmp_path)
    assert "data-broken" not in drawn
    assert "<img" not in drawn
    assert "onerror" in drawn  # it is shown as text
    [data] = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    assert json.loads(data)["axes"]["mode"]["values"][0] == HOSTILE


def test_a_fine_contact_is_shown_by_means_of_blocks() -> None:
    ones = np.ones((800, 501))
    axes = {"x": ("x", np.linspace(-1, 1, 800)), "y": ("y", np.linspace(-1, 1, 501))}
    fine = xr.Dataset({"pressure": (("x", "y"), ones), "gap": (("x", "y"), ones), "load": ("x", ones[:, 0])}, axes)
    shows = contents(fine, "fine")
    pressure = shows["variables"]["pressure"]
    assert MAX_VALUES / 8 < len(values(pressure)) <= MAX_VALUES
    assert (values(pressure) == 1).all()
    across, along = (shows["axes"][dim]["values"] for dim in pressure["dims"])
    assert len(across) * len(along) == len(values(pressure))
    assert along[-1] == 1  # a block of the last cell alone
    assert len(values(shows["variables"]["load"])) == 800  # what is small is shown as it is


def test_the_command_writes_a_page_beside_the_file(study: xr.Dataset, tmp_path: Path) -> None:
    study.to_netcdf(tmp_path / "study.nc")
    said("show", tmp_path / "study.nc", "--format", "html")
    assert "<title>study: two modes</title>" in (tmp_path / "study-explore.html").read_text(encoding="utf-8")


def test_a_file_without_numbers_is_refused() -> None:
    with pytest.raises(cs.InvalidInput, match="holds no numbers over an axis"):
        page_of(xr.Dataset(), "nothing")
