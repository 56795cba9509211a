"""``show`` and ``compare``: pictures of what is stored, and what differs."""

import shlex
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

import contactstudy as cs
from studies.cli.commands import cli
from tests.studies.cli.conftest import ended, said
from tests.studies.scene_study.conftest import CYLINDER, LOAD, SMOOTH, STEEL, given


def test_two_solutions_are_compared(folder: Path) -> None:
    words = folder / "out" / "smooth.nc", folder / "out" / "heavy.nc"
    text = said("compare", *words, "--out", folder / "compared")
    assert "load: +10 %" in text
    assert (folder / "compared" / "smooth-heavy.png").is_file()


def test_a_comparison_names_the_key_that_was_changed_in_the_file(tmp_path: Path) -> None:
    for drop in (10, 12):
        crown = f'[[shapes]]\nkind = "Crown"\nend_drop = "{drop} um"\nlength = "1 mm"\n'
        scene = tmp_path / f"crown-{drop}.toml"
        scene.write_text(f"# a crowned roller\n\n{SMOOTH}{crown}{given(24, '0.6 mm')}")
        said("solve", scene, "--out", tmp_path)
    text = said("compare", *(tmp_path / f"crown-{drop}.nc" for drop in (10, 12)))
    assert "scenes differ in shapes.1.end_drop: 10 um and 12 um" in text
    assert "radius" not in text


def test_two_runs_of_a_study_are_compared(folder: Path) -> None:
    study = folder / "study" / "smooth-sweep.nc"
    changed = folder / "changed.nc"
    dataset = xr.load_dataset(study)
    assert "no measure differs" in said("compare", study, study)
    dataset["peak_pressure"][0, 1] *= 1.5
    dataset.to_netcdf(changed)
    text = said("compare", study, changed)
    assert "peak_pressure: from" in text
    assert "4 points in both" in text
    assert "contact_area" not in text


def test_a_contact_and_an_evolution_are_drawn_in_every_format(folder: Path, tmp_path: Path) -> None:
    said("show", folder / "out" / "smooth.nc", "--out", tmp_path / "shown", "--format", "png,pdf,svg")
    worn = '[wear]\ncoefficient = 1e-16\nspeed = "1 m/s"\n[time_steps]\nend = 1\ninstants = 2\n'
    (tmp_path / "worn.toml").write_text(LOAD + STEEL + STEEL + CYLINDER + given(32, "0.8 mm") + worn)
    said("solve", tmp_path / "worn.toml", "--out", tmp_path)
    said("show", tmp_path / "worn.nc", "--out", tmp_path / "shown")
    drawn = {path.name for path in (tmp_path / "shown").iterdir()}
    assert drawn == {"smooth.png", "smooth.pdf", "smooth.svg", "worn.png"}


def test_a_file_of_another_kind_is_not_replaced_nor_drawn(folder: Path) -> None:
    solution, study = folder / "out" / "smooth.nc", folder / "study" / "smooth-sweep.nc"
    (folder / "wrong").mkdir()
    wrong = folder / "wrong" / "smooth.nc"
    wrong.write_bytes(study.read_bytes())
    with pytest.raises(cs.InvalidInput, match="holds a study, which the solution would replace"):
        said("solve", folder / "smooth.toml", "--out", wrong.parent)
    wrong = wrong.with_stem("smooth-sweep")
    wrong.write_bytes(solution.read_bytes())
    with pytest.raises(cs.InvalidInput, match="holds a solution, which the study would replace"):
        said("run", folder / "smooth.toml", "--vary", "load.per_length=80 N/mm", "--workers", 0, "--out", wrong.parent)
    assert wrong.read_bytes() == solution.read_bytes()
    axes = ("padding", "images", "period", "grid")
    old = xr.Dataset({"case_status": ended(axes, [[[[1]]]]), "step_error": 0.1})
    old.assign_coords(padding=["exact"], images=[6], period=[2.4], grid=[64]).to_netcdf(folder / "grid.nc")
    assert "its variables do not fit a figure" in said("show", folder / "grid.nc", code=1)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("compare out/smooth.nc study/smooth-sweep.nc", "of different kinds"),
        ("show out/smooth.nc --format jpeg", "png, pdf, svg, vtk, html"),
        ("show study/smooth-sweep.nc --format vtk", "run a study with --fields"),
        ("show out/smooth.nc gap", "a name is for a study"),
        ("show study/smooth-sweep.nc --csv --format png", "give excel with --csv"),
        ("show study/smooth-sweep.nc --csv pressure", "'pressure', which is not stored: run the study with --fields"),
        ("show study/smooth-sweep.nc --csv peak_presure", "did you mean 'peak_pressure'"),
        ("show study/smooth-sweep.nc nosuch", "The variable to draw is 'nosuch': choose from"),
        ("show out/smooth.nc --csv presure", "did you mean 'pressure'"),
        ("show nowhere.nc", "cannot be read"),
        ("run nowhere.py", "cannot be read"),
        ("run padding --plot peak_pressure", "--plot is for a scene or a study without figures"),
        ("run padding --repeats 0 --retry times", "leave one of them out"),
        ("run padding --vary perid=1", "did you mean 'period'"),
        ("run smooth.toml", "nothing to vary"),
        ("run smooth.toml --vary load.per_length=", "a field and its values"),
        ("run smooth.toml --vary 'radius=1 mm' --vary 'radius=2 mm'", "twice"),
        ("run smooth.toml --vary 'radius=1 mm' --vary 'shapes.0.radius=2 mm'", "twice"),
        ("report --error 0.1", "--error is for --scene"),
        ("report --scene smooth.toml --workers 1", "--workers is for chapters"),
        ("solve smooth.toml --start study/smooth-sweep.nc", "no pressure"),
        (
            "solve oil.toml --start out/smooth.nc",
            "--start is 'out/smooth.nc', and a film does not begin from a pressure",
        ),
        ("solve smooth.toml --error 'approach = 1 %, approach = 2 %'", "--error names approach twice"),
        ("show nowhere.csv --unit um --extent '1 mm'", "--extent is '1 mm': give a width and a length"),
    ],
)
def test_what_cannot_be_done_is_answered_in_a_sentence(
    folder: Path, line: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    with pytest.raises(cs.InvalidInput, match=message):
        said(*shlex.split(line))


def test_a_measured_surface_is_shown_with_its_parameters_before_any_contact(tmp_path: Path) -> None:
    heights = 0.1 * np.cos(np.pi * (np.arange(64) + 0.5) / 8)[:, None] * np.ones(48)
    np.savetxt(tmp_path / "map.csv", heights, delimiter=";", fmt="%.5f")
    text = said("show", tmp_path / "map.csv", "--unit", "um", "--extent", "64 um, 48 um", "raw")
    assert "64 x 48 points (across x along) over 64 µm x 48 µm" in text
    assert "Sq   70.71 nm" in text
    assert (tmp_path / "map.png").stat().st_size > 10_000
    surface = '[[shapes]]\nkind = "MeasuredSurface"\nfile = "map.csv"\nunit = "um"\nextent = ["64 um", "48 um"]\n'
    solids = '[[solids]]\nmaterial = "steel"\n' * 2
    filtered = 'filter = { lambda_s = "25 um" }\n'
    (tmp_path / "scene.toml").write_text(f"load.per_length = 1e3\n{solids}{surface}{filtered}")
    assert "waves below lambda_s = 25 µm were removed" in said("show", tmp_path / "scene.toml")
    assert (tmp_path / "scene-shapes-0.png").is_file()


def test_no_file_makes_show_end_in_a_traceback(tmp_path: Path) -> None:
    odd = {
        "three axes": xr.Dataset({"pressure": (("x", "y", "z"), np.zeros((2, 1, 2)))}),
        "nothing": xr.Dataset(),
        "no numbers": xr.Dataset({"a": ("x", [1, 2])}),
        "statuses": xr.Dataset({"case_status": ("load", [1, 1])}),
    }
    for name, dataset in odd.items():
        dataset.to_netcdf(tmp_path / f"{name}.nc")
        for words in ([], ["--csv"]):
            done = CliRunner().invoke(cli, ["show", str(tmp_path / f"{name}.nc"), *words])
            assert isinstance(done.exception, SystemExit | cs.InvalidInput | None), (name, words, done.exception)
            assert "Error" not in done.output.replace("Error: ", ""), (name, words, done.output)
