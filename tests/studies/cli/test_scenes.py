"""``new``, ``plan`` and ``solve``."""

import json
import signal
import sys
from pathlib import Path
from threading import Event

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.solvers.solve import ReportingSolver
from studies.cli.scenes import templates
from studies.cli.solving import SolveProgress
from tests.studies.cli.conftest import said
from tests.studies.scene_study.conftest import CYLINDER, LOAD, ROUGH, SMOOTH, STEEL, given

EXAMPLES = Path(__file__).parents[3] / "examples"
# Examples that are called by another name than their kind.
NAMES = {"film": "oil"}


def test_a_scene_to_begin_with_is_an_example(tmp_path: Path) -> None:
    for kind in templates():
        path = tmp_path / f"{NAMES.get(kind, kind)}.toml"
        said("new", kind, "--out", path)
        assert path.read_text(encoding="utf-8") == (EXAMPLES / path.name).read_text(encoding="utf-8")


def test_a_scene_is_begun_by_a_known_name_and_replaces_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "rough " in said("new")
    said("new", "rough")
    for kind, remedy in (("rough", "exists already: give another file"), ("rollers", "did you mean 'roller'")):
        with pytest.raises(cs.InvalidInput, match=remedy):
            said("new", kind)


def test_a_plan_says_what_it_will_be_and_what_it_will_cost() -> None:
    path = EXAMPLES / "smooth.toml"
    text = said("plan", path, "--threads", 1)
    planned = cs.read_scene(path).plan()
    cells = planned.grid.cells
    for words in (f"{cells[0]} x {cells[1]} cells", "padding ExactPeriodicity()", "s on 1 thread", "MB"):
        assert words in text
    fields = json.loads(said("plan", path, "--json", "--threads", 3))
    assert fields["device"] == "Cpu(threads=3)"
    assert fields["grid"]["cells"] == list(cells)
    assert fields["error"] == planned.error


def test_a_plan_says_whether_a_profiled_roller_needs_an_end_and_a_surface_an_extent(tmp_path: Path) -> None:
    text = (EXAMPLES / "edge-stress.toml").read_text(encoding="utf-8")
    for period, is_said in (("10 mm", False), ("12.5 mm", True)):
        longer = text.replace('["0.6 mm", "10 mm"]', f'["0.6 mm", "{period}"]')
        (tmp_path / "roller.toml").write_text(longer, encoding="utf-8")
        plan = said("plan", tmp_path / "roller.toml")
        assert ("add the shape FiniteLength(length=0.01)" in plan) == is_said
    (tmp_path / "rough.toml").write_text(ROUGH)
    assert "shapes[1] has no extent, and gets that of this plan" in said("plan", tmp_path / "rough.toml")


@pytest.mark.parametrize(
    ("example", "words", "message"),
    [
        ("smooth", ["--device", "gpu", "--threads", "2"], "^--threads is for --device cpu"),
        ("rubber", ["--device", "gpu"], "^solve.device is given, and .* is solved on the CPU"),
        ("none", [], r"none\.toml cannot be read"),
    ],
)
def test_what_cannot_be_solved_is_refused_and_leaves_nothing(
    example: str, words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cs.Gpu, "__post_init__", lambda _: None)
    out = tmp_path / "out"
    with pytest.raises(cs.InvalidInput, match=message):
        said("solve", EXAMPLES / f"{example}.toml", "--out", out, *words)
    assert not out.exists()


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
    # the file says where it came from
    assert f"contactstudy {cs.__version__}" in dataset.attrs["source"]
    (tmp_path / "again.toml").write_text(dataset.attrs["scene"])
    assert cs.read_scene(tmp_path / "again.toml").scene == cs.read_scene(EXAMPLES / "smooth.toml").scene


def test_errors_of_some_numbers_are_requested_on_the_command_line(tmp_path: Path) -> None:
    scene, out = EXAMPLES / "smooth.toml", ("--out", tmp_path)
    shown = said("solve", scene, "--error", "peak_pressure = 2 %, half_width = 0.05", *out)
    assert "request met" in shown
    assert "in the half-width of 5 %" in shown
    assert "12 % met by every number" in said("solve", scene, "--error", "12 %", *out)
    with pytest.raises(cs.InvalidInput, match=r"half_width.*give a relative error"):
        said("solve", scene, "--error", "half_width = big", *out)


def test_a_command_ends_with_one_where_a_solve_did_not_converge(tmp_path: Path) -> None:
    path = tmp_path / "smooth.toml"
    path.write_text(SMOOTH + "\n[solve]\nmax_iterations = 1\ntolerance = 1e-12\n", encoding="utf-8")
    assert "ITERATION_LIMIT" in said("solve", path, "--out", tmp_path / "out", code=1)
    assert (tmp_path / "out" / "smooth.nc").is_file()


def test_a_solve_that_is_stopped_leaves_its_pressure_and_goes_on_from_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, out = tmp_path / "smooth.toml", tmp_path / "out"
    scene.write_text(SMOOTH + given(64, "0.4 mm"), encoding="utf-8")
    whole = cs.read_scene(scene).solve()
    seen: list[float] = []
    before = ReportingSolver.iterate

    def stops(self: ReportingSolver, *arguments: object, **named: object) -> object:
        def see(residual: float, pressure: np.ndarray) -> None:
            self.report(residual, pressure)
            seen.append(residual)
            if len(seen) == 4:
                signal.raise_signal(signal.SIGINT)

        return before(ReportingSolver(see, self.solver), *arguments, **named)  # type: ignore[arg-type]

    with monkeypatch.context() as patched:
        patched.setattr(ReportingSolver, "iterate", stops)
        patched.setattr("studies.cli.scenes._announce", lambda *_: None)  # the plan solves too
        said("solve", scene, "--out", out, code=130)
    left = out / "smooth.stopped.nc"
    assert f"{seen[-1]:.1e}" in xr.load_dataset(left).attrs["comment"]
    said("solve", scene, "--out", out, "--start", left)
    ended = xr.load_dataset(out / "smooth.nc")["pressure"].values
    # two solves to a residual of 1e-8
    assert abs(ended - whole.pressure).sum() / whole.pressure.sum() < 1e-6


WEARS = """
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
    scene.write_text(LOAD + STEEL + STEEL + CYLINDER + given(64, "0.6 mm") + WEARS)
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
