import json
import signal
import sys
from pathlib import Path
from threading import Event

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.cli.solving import SolveProgress
from tests.studies.cli.conftest import said

EXAMPLES = Path(__file__).parents[3] / "examples"


def solved(name: str, out: Path) -> xr.Dataset:
    assert "CONVERGED" in said("solve", EXAMPLES / f"{name}.toml", "--out", out)
    assert (out / f"{name}.png").stat().st_size > 10_000
    assert not (out / f"{name}.pdf").exists()  # on request
    return xr.load_dataset(out / f"{name}.nc")


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


@pytest.mark.parametrize(
    ("example", "words", "message"),
    [
        ("smooth", ["--device", "gpu"], "^Gpu needs CuPy"),
        ("smooth", ["--device", "gpu", "--threads", "2"], "^--threads is for --device cpu"),
        ("rubber", ["--device", "gpu"], "^solve.device is given, and .* is solved on the CPU"),
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


def test_a_scene_that_cannot_be_read_leaves_nothing_behind(tmp_path: Path) -> None:
    none, out = tmp_path / "none.toml", tmp_path / "out"
    for words in (["plan", none], ["solve", none, "--out", out]):
        with pytest.raises(cs.InvalidInput, match=r"none\.toml cannot be read"):
            said(*words)
    assert not out.exists()


def test_the_file_of_a_contact_that_frets_holds_the_loop_that_its_picture_draws(
    tmp_path: Path,
) -> None:
    said("solve", EXAMPLES / "fretting.toml", "--out", tmp_path, "--error", "20 %")
    assert xr.load_dataset(tmp_path / "fretting.nc")["loop_force"].sizes == {"loop": 17}


@pytest.mark.whole
def test_the_rubber_example_is_marched_and_leaves_no_frames_behind(tmp_path: Path) -> None:
    dataset = solved("rubber", tmp_path)
    assert dataset.sizes["time"] == 21
    assert not (tmp_path / "rubber.evolution").exists()
    # wear volume per length: k v int P dt = 1e-10 / Pa 0.1 m/s (0.5 + 3) s 500 N/m
    worn = float(dataset["wear_depth"].isel(time=-1).mean("y").sum("x"))
    cell = float(dataset["x"][1] - dataset["x"][0])
    assert worn * cell == pytest.approx(1e-10 * 0.1 * 3.5 * 500, rel=1e-9)
    assert (np.diff(dataset["contact_area"].values[6:]) >= 0).all()


def test_numbers_are_printed_with_their_errors_and_json_has_the_same(tmp_path: Path) -> None:
    words = ["solve", EXAMPLES / "smooth.toml", "--out", tmp_path]
    peak = next(line for line in said(*words).splitlines() if "peak pressure" in line)
    assert "MPa" in peak
    assert "error <= " in peak
    found = json.loads(said(*words, "--json"))
    dataset = xr.load_dataset(tmp_path / "smooth.nc")
    assert found["status"] == "CONVERGED"
    assert found["quantities"]["peak_pressure"]["value"] == float(dataset["pressure"].max())
    assert found["quantities"]["approach"]["value"] == float(dataset["approach"])
    assert all(Path(file).is_file() for file in found["files"])


def test_errors_of_some_numbers_are_requested_on_the_command_line(tmp_path: Path) -> None:
    scene, out = EXAMPLES / "smooth.toml", ("--out", tmp_path)
    request = "peak_pressure = 2 %, half_width = 0.05"
    shown = said("solve", scene, "--error", request, *out)
    assert "request met" in shown
    assert "in the half-width of 5 %" in shown
    assert "12 % met by every number" in said("solve", scene, "--error", "12 %", *out)
    with pytest.raises(cs.InvalidInput, match=r"half_width.*give a relative error"):
        said("solve", scene, "--error", "half_width = big", *out)


LONG = """
[load]
per_length = "100 N/mm"
[[solids]]
material = "steel"
[[solids]]
material = "steel"
[[shapes]]
kind = "Cylinder"
radius = "10 mm"
[grid]
cells = [64, 1]
extent = ["0.6 mm", "1 mm"]
[wear]
coefficient = 1e-14
speed = "1 m/s"
[time_steps]
end = 1000
instants = 2000
"""


def test_a_scene_in_time_that_is_terminated_says_how_far_it_is_and_how_to_go_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = tmp_path / "long.toml"
    scene.write_text(LONG)
    take, shown, reports = SolveProgress.__call__, Event(), []

    def echo(text: str, **_: object) -> None:
        sys.stdout.write(text)
        if "of 1e+03 s, 00:" in text:
            shown.set()

    def stops(self: SolveProgress, progress: cs.Progress) -> None:
        take(self, progress)
        reports.append(progress.text)
        if progress.fraction > 0.01:
            assert shown.wait(60)
            signal.raise_signal(signal.SIGTERM)

    monkeypatch.setattr("studies.cli.scenes._announce", lambda *_: None)
    monkeypatch.setattr("studies.cli.solving.LINE_INTERVAL", 0.1)
    monkeypatch.setattr("studies.cli.solving.click.echo", echo)
    monkeypatch.setattr(SolveProgress, "__call__", stops)
    text = said("solve", scene, "--out", tmp_path, code=128 + signal.SIGTERM)
    assert f"stopped at {reports[-1]}; the same command goes on from there" in text
    assert list((tmp_path / "long.evolution").glob("frame_*.npz"))
