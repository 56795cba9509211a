import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from tests.studies.cli.conftest import said

EXAMPLES = Path(__file__).parents[3] / "examples"


def solved(name: str, out: Path) -> xr.Dataset:
    assert "CONVERGED" in said("solve", EXAMPLES / f"{name}.toml", "--out", out)
    assert (out / f"{name}.png").stat().st_size > 10_000
    assert not (out / f"{name}.pdf").exists()  # on request
    return xr.load_dataset(out / f"{name}.nc")


def test_the_smooth_example_is_hertz(tmp_path: Path) -> None:
    dataset = solved("smooth", tmp_path)
    assert dataset.sizes["y"] == 1
    assert dataset.sizes["cause"] == 3
    peak = float(dataset["pressure"].max())
    # sqrt(W E* / (pi R)) of 100 N/mm, 10 mm, steel on steel
    assert peak == pytest.approx(np.sqrt(1e5 * 210e9 / 1.82 / np.pi / 0.01), rel=2e-5)
    estimate = float(dataset["peak_pressure_error_estimate"].sum())
    assert abs(peak / float(dataset["hertz_peak_pressure"]) - 1) <= estimate < 1e-4
    assert float(dataset["pressure_l1_error_estimate"].sum()) < 1e-3


@pytest.mark.whole
def test_the_rough_example_yields_at_its_hardness(tmp_path: Path) -> None:
    dataset = solved("rough", tmp_path)
    pressure = dataset["pressure"]
    assert float(pressure.max()) == 4e9
    # less than a tenth of the cells bear the load, a third of these at the hardness
    assert float((pressure > 0).mean()) == pytest.approx(0.11, abs=0.01)
    assert float((pressure == 4e9).sum() / (pressure > 0).sum()) == pytest.approx(0.3, abs=0.1)
    area = float(dataset["hertz_half_width"])
    assert area == pytest.approx(7.428e-5, rel=1e-3)
    cells = dataset.sizes["x"]
    carried = float(pressure.mean()) * np.ptp(dataset["x"].values) * cells / (cells - 1)
    assert carried == pytest.approx(1e5, rel=1e-9)


@pytest.mark.whole
def test_the_roller_example_has_no_edge_peak_and_shows_its_stress(tmp_path: Path) -> None:
    dataset = solved("roller", tmp_path)
    peak = float(dataset["hertz_peak_pressure"])
    assert 1.0 < float(dataset["pressure"].max()) / peak < 1.2
    below = dataset["von_mises"].isel(y=dataset.sizes["y"] // 2).max("x") / peak
    # plane strain, nu = 0.3: 0.558 p_H at 0.70 a on the axis (Johnson 1985, sect. 4.2(c)); the roller
    # bears 1 % more in its middle, and the stress along it is not that of plane strain
    assert float(below.max()) == pytest.approx(0.558, rel=0.03)
    assert float(below.idxmax()) / float(dataset["hertz_half_width"]) == pytest.approx(0.7, abs=0.1)


def test_a_plan_says_what_it_will_be_and_what_it_will_cost(tmp_path: Path) -> None:
    path = EXAMPLES / "smooth.toml"
    text = said("plan", path, "--threads", 1)
    planned = cs.read_scene(path).plan()
    cells = planned.grid.cells
    for words in (f"{cells[0]} x {cells[1]} cells", "padding exact", "s on 1 thread", "MB"):
        assert words in text
    fields = json.loads(said("plan", path, "--json", "--threads", 3))
    assert fields["device"] == "Cpu(threads=3)"
    assert fields["grid"]["cells"] == list(cells)
    assert fields["error"] == planned.error
    assert not list(tmp_path.iterdir())


def test_what_is_wrong_with_a_grid_is_said_and_the_solution_flagged(tmp_path: Path) -> None:
    text = (EXAMPLES / "smooth.toml").read_text(encoding="utf-8")
    narrow = tmp_path / "narrow.toml"
    narrow.write_text(text + '\n[grid]\ncells = [32, 1]\nextent = ["150 um", "100 um"]\n')
    output = said("solve", narrow, "--out", tmp_path, code=1)
    assert "the contact is wider" in output
    assert "CONTACT_AT_EDGE" in output
    assert (tmp_path / "narrow.nc").is_file()


@pytest.mark.parametrize(
    ("example", "words", "message"),
    [
        ("smooth", ["--device", "gpu"], "^Gpu needs CuPy"),
        ("smooth", ["--device", "gpu", "--threads", "2"], "^--threads is for --device cpu"),
        ("rubber", ["--device", "gpu"], "^solve.device is given, and .* is solved on this machine.s processor"),
    ],
)  # fmt: skip
def test_a_device_that_cannot_solve_the_scene_is_refused(
    example: str, words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "array_api_compat.cupy", None)
    if example == "rubber":
        monkeypatch.setattr(cs.Gpu, "__post_init__", lambda _: None)
    out = tmp_path / "out"
    with pytest.raises(cs.InvalidInput, match=message):
        said("solve", EXAMPLES / f"{example}.toml", "--out", out, *words)
    assert not out.exists()


def test_a_history_with_adhesion_is_solved(tmp_path: Path) -> None:
    pull = 'kind = "PullOff"\npreload = "5 N/m"'
    history = 'kind = "LoadHistory"\ntimes = [0.0, 1.0]\nper_length = ["1 N/m", "3 N/m"]'
    text = (EXAMPLES / "gripper.toml").read_text(encoding="utf-8")
    assert pull in text
    scene = tmp_path / "history.toml"
    wide = text.replace(pull, history).replace('extent = ["1.2 mm"', 'extent = ["2.4 mm"')
    scene.write_text(wide + "\n[time_steps]\ninstants = 2\n")
    said("solve", scene, "--out", tmp_path)
    assert (tmp_path / "history.nc").is_file()


def test_a_scene_that_cannot_be_read_leaves_nothing_behind(tmp_path: Path) -> None:
    none, out = tmp_path / "none.toml", tmp_path / "out"
    for words in (["plan", none], ["solve", none, "--out", out]):
        with pytest.raises(cs.InvalidInput, match=r"none\.toml cannot be read"):
            said(*words)
    assert not out.exists()


def test_the_rubber_example_is_marched_and_leaves_no_frames_behind(tmp_path: Path) -> None:
    dataset = solved("rubber", tmp_path)
    assert dataset.sizes["time"] == 21
    assert not (tmp_path / "rubber.evolution").exists()
    # worn volume per length: k v int P dt = 1e-10 / Pa 0.1 m/s (0.5 + 3) s 500 N/m
    worn = float(dataset["worn_depth"].isel(time=-1).mean("y").sum("x"))
    cell = float(dataset["x"][1] - dataset["x"][0])
    assert worn * cell == pytest.approx(1e-10 * 0.1 * 3.5 * 500, rel=1e-9)
    assert (np.diff(dataset["contact_area"].values[6:]) >= 0).all()


def test_a_rolling_scene_says_its_shift_and_resistance(tmp_path: Path) -> None:
    text = (EXAMPLES / "rubber.toml").read_text(encoding="utf-8")
    _, _, rest = text.partition("[[solids]]")
    rest = rest.partition("[wear]")[0]
    load = '[load]\nper_length = "500 N/m"\n[rolling]\nspeed = "10 mm/s"\n[plan]\nerror = 0.01\n'
    path = tmp_path / "rolling.toml"
    path.write_text(f"{load}[[solids]]{rest}", encoding="utf-8")
    output = said("solve", path, "--out", tmp_path / "out")
    assert "CONVERGED" in output
    dataset = xr.load_dataset(tmp_path / "out" / "rolling.nc")
    assert re.search(f"resistance .*{float(dataset['rolling_resistance']):.4g}", output)
    assert dataset["pressure_shift"].attrs["units"] == "m"


def test_numbers_come_first_and_json_has_the_same(tmp_path: Path) -> None:
    words = ["solve", EXAMPLES / "smooth.toml", "--out", tmp_path]
    lines = said(*words).splitlines()
    assert lines[1].startswith("  peak pressure ")
    assert "MPa" in lines[1]
    assert "error <= " in lines[1]
    found = json.loads(said(*words, "--json"))
    dataset = xr.load_dataset(tmp_path / "smooth.nc")
    assert found["status"] == "CONVERGED"
    assert found["quantities"]["peak_pressure"]["value"] == float(dataset["pressure"].max())
    assert found["quantities"]["approach"]["value"] == float(dataset["approach"])
    assert all(Path(file).is_file() for file in found["files"])


def test_a_film_that_changes_in_time_is_marched_and_drawn(tmp_path: Path) -> None:
    text = (EXAMPLES / "oil.toml").read_text(encoding="utf-8")
    history = '{times = ["0 us", "50 us"], mean_speed = ["0.5 m/s", "1 m/s"]}'
    text = text.replace('mean_speed = "1 m/s"', f"mean_speed = {history}")
    text += (
        '\n[grid]\ncells = [100, 1]\nextent = ["1.2 mm", "1 mm"]\n\n[time_steps]\ninstants = 3\n'
    )
    (tmp_path / "start.toml").write_text(text, encoding="utf-8")
    output = said("solve", tmp_path / "start.toml", "--out", tmp_path / "out")
    assert "central film thickness at the end" in output
    dataset = xr.load_dataset(tmp_path / "out" / "start.nc")
    assert dataset["film"].dims == ("time", "x", "y")
    assert dataset["mean_speed"].values == pytest.approx([0.5, 0.75, 1.0])
    assert float(dataset["step_error"]) <= 1e-3
    assert (tmp_path / "out" / "start.png").stat().st_size > 10_000
