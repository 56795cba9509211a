import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

import contactstudy as cs
from studies.cli.commands import cli
from studies.reference.line_contact import HERTZ
from tests.studies.advice.test_recommendation import samples

EXAMPLES = Path(__file__).parents[3] / "examples"


@pytest.fixture(autouse=True)
def clockless(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seconds in proportion to the images summed and the points transformed, whatever the clock says."""
    monkeypatch.setattr("contactstudy.planning.cost.sample_timings", samples)


def run(*words: str) -> Result:
    return CliRunner().invoke(cli, ["recommend", "--out", "nowhere", *words])


def fields(*words: str) -> dict[str, dict[str, object]]:
    result = run("--json", *words)
    assert result.exit_code == 0, result.output
    return json.loads(result.output)  # type: ignore[no-any-return]


def test_a_smooth_contact_wants_one_cell_along_its_length() -> None:
    said = fields("--error", "1e-4")
    assert said["meets"]
    best = said["best"]
    assert best["mode"] == "line"
    assert best["grid"]["cells"][1] == 1  # type: ignore[index]
    assert best["error"] <= 1e-4  # type: ignore[operator]
    assert best["bytes"] < said["runner_up"]["bytes"]  # type: ignore[operator]
    text = run("--error", "1e-4").output
    for words in ("use: exact, one cell along the length", "runner-up:", "s on one thread", "MB"):
        assert words in text


def test_the_period_of_the_sweeps_contact_is_in_half_widths() -> None:
    _, length = fields("--period", "1.5")["best"]["grid"]["extent"]  # type: ignore[index]
    assert length == pytest.approx(1.5 * HERTZ.half_width)


def test_units_of_memory_and_time_are_read() -> None:
    request = fields("--memory", "4GB", "--seconds", "2 min")["asked"]
    assert request["memory"] == 4e9
    assert request["seconds"] == 120
    assert fields("--seconds", "10")["asked"]["seconds"] == 10


def test_what_cannot_be_had_is_said_with_the_best_there_is() -> None:
    few = run("--error", "1e-12", "--metric", "peak_pressure", "--memory", "1 MB").output
    assert "no setting meets the requested error; the most accurate setting" in few
    assert "no setting fits" in run("--seconds", "1 ns").output


@pytest.mark.whole
def test_a_scene_in_a_file_is_recommended_a_grid() -> None:
    rough = fields(str(EXAMPLES / "rough.toml"), "--error", "0.05")
    planned = cs.read_scene(EXAMPLES / "rough.toml").plan()
    assert rough["best"]["mode"] == "exact"
    assert rough["best"]["grid"]["extent"] == list(planned.grid.extent)  # type: ignore[index]
    roller = fields(str(EXAMPLES / "roller.toml"), "--error", "0.1")
    assert roller["best"]["mode"] == "free"
    assert roller["runner_up"] is None
    assert fields(str(EXAMPLES / "smooth.toml"))["best"]["mode"] == "line"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--error", "0"], "error is 0.0: give a relative error above 0"),
        (["--metric", "l2"], "metric is 'l2': choose from peak_pressure, l1, half_width"),
        (["--memory", "4 m"], "memory is '4 m': give a memory, such as '4 GB'"),
        (["--memory", "nan"], "memory is nan: give a memory above 0"),
        (["--seconds", "-1"], "seconds is -1.0: give a time above 0"),
        (["--period", "0"], "period is 0.0: give a period above 0 half-widths"),
        (
            [str(EXAMPLES / "rough.toml"), "--metric", "half_width"],
            "metric is 'half_width': give l1",
        ),
        (["none.toml"], "none.toml cannot be read"),
    ],
)
def test_bad_arguments_are_one_sentence(words: list[str], sentence: str) -> None:
    result = run(*words)
    assert isinstance(result.exception, cs.InvalidInput)
    assert sentence in str(result.exception)
    assert "\n" not in str(result.exception)


@pytest.mark.cases(1)
@pytest.mark.parametrize("scene", [None, "roller.toml"])
def test_the_lines_of_python_run_as_they_stand(scene: str | None) -> None:
    words = () if scene is None else (str(EXAMPLES / scene),)
    best = fields("--error", "0.02", *words)["best"]
    known: dict[str, object] = {}
    exec("\n".join(best["python"]), known)  # type: ignore[call-overload]
    solution = known["solution"]
    assert isinstance(solution, cs.Solution)
    assert list(solution.pressure.shape) == best["grid"]["cells"]  # type: ignore[index]
    assert isinstance(known["pressure"], np.ndarray)
