import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import contactstudy as cs
from studies.cli.commands import cli
from studies.reference.line_contact import hertz_means
from tests.studies.scene_study.conftest import SMOOTH


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recommend")
    (folder / "smooth.toml").write_text(SMOOTH, encoding="utf-8")
    return folder


def recommended(folder: Path, *words: str) -> str:
    scene = ["--scene", str(folder / "smooth.toml"), "--out", str(folder / "out")]
    done = CliRunner().invoke(cli, ["recommend", *scene, *words], catch_exceptions=False)
    assert done.exit_code == 0
    return done.stdout


def test_the_block_of_a_recommendation_solves_the_scene_to_the_error(folder: Path) -> None:
    text = recommended(folder, "--error", "0.01", "--seconds", "2")
    block = text.partition("instead of its tables grid, padding and solve:\n")[2]
    (folder / "chosen.toml").write_text(SMOOTH + block, encoding="utf-8")
    answer = cs.read_scene(folder / "chosen.toml").solve()
    true = hertz_means(answer.scene.hertz, answer.grid)
    assert np.abs(answer.pressure - true).sum() <= 0.01 * true.sum()


def test_a_second_recommendation_reads_the_rounds_of_the_first(folder: Path) -> None:
    first = json.loads(recommended(folder, "--error", "0.01", "--seconds", "2", "--json"))
    # far less than a measurement takes
    again = json.loads(recommended(folder, "--error", "0.01", "--seconds", "1e-3", "--json"))
    assert again == first
    assert first["meets_request"]
