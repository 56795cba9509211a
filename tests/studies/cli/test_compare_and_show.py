import csv
import re
import shlex
import signal
import tomllib
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

import contactstudy as cs
from contactstudy import InvalidInput
from contactstudy.solvers.solve import ReportingSolver
from studies.cli.commands import cli
from tests.studies.cli.conftest import ended, said
from tests.studies.scene_study.conftest import ROUGH, SMOOTH, given

FILM = """[lubrication]
mean_speed = "1 m/s"
[lubrication.lubricant]
viscosity = "40 mPa*s"
pressure_viscosity = "20 1/GPa"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("shown")
    (path / "smooth.toml").write_text(SMOOTH)
    (path / "heavy.toml").write_text(SMOOTH.replace("100 N/mm", "110 N/mm"))
    (path / "rough.toml").write_text(ROUGH)
    for name in ("smooth", "heavy", "rough"):
        said("solve", path / f"{name}.toml", "--out", path / "out")
    vary = ["--vary", "load.per_length=50 N/mm,100 N/mm", "--vary", "radius=10 mm,20 mm"]
    said(
        "run",
        path / "smooth.toml",
        *vary,
        "--out",
        path / "study",
        "--workers",
        0,
        "--repeats",
        "0",
    )
    return path


def test_a_solution_says_where_it_came_from(folder: Path) -> None:
    attributes = xr.load_dataset(folder / "out" / "smooth.nc").attrs
    assert f"contactstudy {cs.__version__}" in attributes["source"]
    assert attributes["history"][:2] == "20"
    scene = folder / "again.toml"
    scene.write_text(attributes["scene"])
    assert cs.read_scene(scene).scene == cs.read_scene(folder / "smooth.toml").scene


def test_two_solutions_are_compared(folder: Path) -> None:
    words = folder / "out" / "smooth.nc", folder / "out" / "heavy.nc"
    text = said("compare", *words, "--out", folder / "compared")
    assert "load: +10 %" in text
    assert (folder / "compared" / "smooth-heavy.png").is_file()


def test_a_comparison_names_the_key_that_was_changed_in_the_file(tmp_path: Path) -> None:
    for drop in (10, 12):
        crown = f'[[shapes]]\nkind = "Crown"\nend_drop = "{drop} um"\nlength = "1 mm"\n'
        grid = '[grid]\ncells = [24, 16]\nextent = ["0.6 mm", "1 mm"]\n'
        scene = tmp_path / f"crown-{drop}.toml"
        scene.write_text("# a crowned roller\n\n" + SMOOTH + crown + grid + '[padding]\nkind = "ZeroPadding"\n')
        said("solve", scene, "--out", tmp_path)
    first, second = (tmp_path / f"crown-{drop}.nc" for drop in (10, 12))
    text = said("compare", first, second)
    assert "scenes differ in shapes.1.end_drop: 10 um and 12 um" in text
    assert "radius" not in text
    answers = [cs.read_scene(path.with_suffix(".toml")).solve() for path in (first, second)]
    (changed,) = cs.compare(*answers).differing
    assert changed.endswith("which are end drops of 10 µm and 12 µm")


def test_two_runs_of_a_study_are_compared(folder: Path) -> None:
    study = folder / "study" / "smooth-sweep.nc"
    changed = folder / "changed.nc"
    dataset = xr.load_dataset(study)
    assert "no measure differs" in said("compare", study, study)
    named = folder / "named.nc"  # as a solution names its field
    dataset.rename(mean_pressure="pressure").to_netcdf(named)
    assert "no measure differs" in said("compare", named, named)
    dataset["peak_pressure"][0, 1] *= 1.5
    dataset.to_netcdf(changed)
    text = said("compare", study, changed)
    assert "peak_pressure: from" in text
    assert "4 points in both" in text
    assert "contact_area" not in text


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", ["smooth", "rough"])
def test_a_solution_is_drawn_in_every_format(folder: Path, tmp_path: Path, name: str) -> None:
    said("show", folder / "out" / f"{name}.nc", "--out", tmp_path, "--format", "png,pdf,svg,vtk")
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.{suffix}" for suffix in ("png", "pdf", "svg", "vtr")}
    text = (tmp_path / f"{name}.vtr").read_bytes()
    assert b"RectilinearGrid" in text
    assert b"pressure" in text
    # the edges of the cells, in order: x, y, z; each block of bytes after its size
    scene = tomllib.loads(xr.load_dataset(folder / "out" / f"{name}.nc").attrs["scene"])
    half = np.array(scene["grid"]["extent"]) / 2
    for edge in (*half, *-half):
        assert any((edge + k * np.spacing(edge)).tobytes() in text for k in range(-9, 10))


@pytest.mark.parametrize(
    "lines",
    [
        FILM,
        FILM.replace('"1 m/s"', "{kind = 'SpeedHistory', times = [0, 1e-3], mean_speed = [1, 2]}")
        + "[time_steps]\nstep = 5e-4\n",
        '[wear]\ncoefficient = 1e-16\nspeed = "1 m/s"\n[time_steps]\nend = 1\ninstants = 2\n',
    ],
    ids=["film", "film in time", "dry in time"],
)  # fmt: skip
def test_what_solve_wrote_is_drawn(lines: str, tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(SMOOTH + given(96, "0.8 mm") + lines)
    said("solve", tmp_path / "one.toml", "--out", tmp_path)
    said("show", tmp_path / "one.nc", "--out", tmp_path / "shown")
    assert (tmp_path / "shown" / "one.png").is_file()


def test_a_scene_is_solved_and_swept_into_one_folder(folder: Path) -> None:
    vary = ["--vary", "load.per_length=80 N/mm", "--workers", "0", "--repeats", "0"]
    said("run", folder / "smooth.toml", *vary, "--out", folder / "out")
    assert (folder / "out" / "smooth.nc").is_file()
    assert (folder / "out" / "smooth-sweep.nc").is_file()


def test_a_file_of_another_kind_is_not_replaced_nor_drawn(folder: Path) -> None:
    solution, study = folder / "out" / "smooth.nc", folder / "study" / "smooth-sweep.nc"
    (folder / "wrong").mkdir()
    wrong = folder / "wrong" / "smooth.nc"
    wrong.write_bytes(study.read_bytes())
    with pytest.raises(cs.InvalidInput, match="holds a study, which the solution would replace"):
        said("solve", folder / "smooth.toml", "--out", wrong.parent)
    wrong = wrong.with_stem("smooth-sweep")
    wrong.write_bytes(solution.read_bytes())
    vary = ["--vary", "load.per_length=80 N/mm", "--workers", "0", "--repeats", "0"]
    with pytest.raises(cs.InvalidInput, match="holds a solution, which the study would replace"):
        said("run", folder / "smooth.toml", *vary, "--out", wrong.parent)
    assert wrong.read_bytes() == solution.read_bytes()
    other = folder / "other"
    other.mkdir()
    axes = ("padding", "images", "period", "grid")
    old = xr.Dataset({"case_status": ended(axes, [[[[1]]]]), "step_error": 0.1})
    old = old.assign_coords(padding=["exact"], images=[6], period=[2.4], grid=[64])
    old.to_netcdf(other / "grid.nc")
    with pytest.raises(cs.InvalidInput, match=r"without the variable .*: run the study again"):
        said("show", other / "grid.nc")


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("compare out/smooth.nc study/smooth-sweep.nc", "of different kinds"),
        ("show out/smooth.nc --format jpeg", "png, pdf, svg, vtk, html"),
        ("show study/smooth-sweep.nc --format vtk", "run a study with --fields"),
        ("show out/smooth.nc --plot central_film", "--plot is for a study"),
        ("show out/smooth.nc gap", "a name is for a study"),
        ("show study/smooth-sweep.nc --csv --format png", "give excel with --csv"),
        ("show study/smooth-sweep.nc --csv pressure", "run the study with --fields"),
        ("show out/smooth.nc --csv presure", "did you mean 'pressure'"),
        ("show out/smooth.nc --format excel", "give --csv too"),
        (
            "compare study/smooth-sweep.nc study/smooth-sweep.nc --out x",
            "--out is for two solutions",
        ),
        ("run xyz", "choose from coating, creep"),
        ("run nowhere.py", "cannot be read"),
        ("run padding --plot peak_pressure", "--plot is for a scene or a study without figures"),
        (
            "run smooth.toml --vary 'radius=1 mm' --plot peak_presure --out none",
            "did you mean 'peak_pressure'",
        ),
        ("report --error 0.1", "--error is for --scene"),
        ("report --scene smooth.toml --workers 1", "--workers is for chapters"),
        ("run padding --repeats 0 --retry times", "leave one of them out"),
        ("show nowhere.nc", "cannot be read"),
        ("solve smooth.toml --start study/smooth-sweep.nc", "no pressure"),
        ("run padding --vary perid=1", "did you mean 'period'"),
        ("run smooth.toml", "without anything to vary"),
        ("run smooth.toml --vary load.per_length", "a field and its values"),
        ("run smooth.toml --vary load.per_length=", "a field and its values"),
        ("run smooth.toml --vary 'radius=1 mm' --vary 'radius=2 mm'", "twice"),
        ("run smooth.toml --vary 'radius=1 mm' --vary 'shapes.0.radius=2 mm'", "twice"),
        ("run smooth.toml --vary 'radiuss=1 mm'", "is not in the scene"),
        ("run smooth.toml --vary 'padding={kind='", "close its brackets"),
    ],
)
def test_what_cannot_be_done_is_answered_in_a_sentence(
    folder: Path, line: str, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    with pytest.raises(cs.InvalidInput, match=message):
        said(*shlex.split(line))


def test_a_plan_says_where_a_surface_is_that_of_its_grid(folder: Path) -> None:
    assert "shapes[1] has no extent, and gets that of this plan" in said("plan", folder / "rough.toml")
    assert "extent" not in said("plan", folder / "smooth.toml")


def test_a_solve_that_is_stopped_leaves_its_pressure_and_goes_on_from_it(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = xr.load_dataset(folder / "out" / "rough.nc")
    cells = [whole.sizes["x"], whole.sizes["y"]]
    extent = [n * float(whole[axis][1] - whole[axis][0]) for n, axis in zip(cells, "xy", strict=True)]
    given = folder / "given.toml"
    text = (folder / "rough.toml").read_text(encoding="utf-8")
    given.write_text(f"{text}\n[grid]\ncells = {cells}\nextent = {extent}\n", encoding="utf-8")
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
        said("solve", given, "--out", folder / "halt", code=130)
    left = folder / "halt" / "given.stopped.nc"
    halted = xr.load_dataset(left)
    assert f"{seen[-1]:.1e}" in halted.attrs["comment"]
    said("solve", given, "--out", folder / "halt", "--start", left)
    ended = xr.load_dataset(folder / "halt" / "given.nc")
    assert ended["pressure"].shape == whole["pressure"].shape
    # two solves to a residual of 1e-8
    assert float(abs(ended["pressure"] - whole["pressure"]).sum() / whole["pressure"].sum()) < 1e-6


def table(file: Path, *words: object) -> list[dict[str, str]]:
    said("show", file, "--csv", *words, "--out", file.parent)
    text = file.with_suffix(".csv").read_text(encoding="utf-8")
    return list(csv.DictReader(StringIO(text)))


def test_a_study_is_a_table_with_a_row_for_each_point(tmp_path: Path) -> None:
    points = xr.Dataset(
        {
            "case_status": ended(("load", "n"), [[1, 1, 1], [1, 0, 1]]),
            "peak": (("n", "load"), np.arange(6.0).reshape(3, 2), {"units": "Pa"}),
            "field": (("n", "load", "x"), np.zeros((3, 2, 4))),
            "solver_status": ended(("load", "n"), [[1, 1, 1], [1, 0, 1]]).where([[True], [False]]),
        },
        {"load": ("load", [1e3, 2e3], {"units": "N m-1"}), "n": ("n", [0, 1, 2], {"units": "1"})},
    )
    points.to_netcdf(tmp_path / "points.nc")
    rows = table(tmp_path / "points.nc")
    assert set(rows[0]) == {"load [N/mm]", "n", "peak [Pa]", "case_status", "solver_status"}
    assert [row["peak [Pa]"] for row in rows] == ["0", "2", "4", "1", "3", "5"]
    assert [row["case_status"] for row in rows] == ["ok", "ok", "ok", "ok", "failed", "ok"]
    assert [row["solver_status"] for row in rows] == ["ok", "ok", "ok", "", "", ""]
    assert [(row["load [N/mm]"], row["n"]) for row in rows[2:4]] == [("1", "2"), ("2", "0")]


def test_a_solution_is_one_row_of_its_numbers(folder: Path) -> None:
    (row,) = table(folder / "out" / "smooth.nc")
    stored = xr.load_dataset(folder / "out" / "smooth.nc")
    peak = float(stored["pressure"].max())
    assert float(row["peak_pressure [MPa]"]) == pytest.approx(peak / 1e6, rel=1e-12)
    assert row["status"] == "CONVERGED"


def test_a_table_has_the_quantities_or_what_is_named(folder: Path) -> None:
    study = folder / "study" / "smooth-sweep.nc"
    (row, *others) = table(study)
    assert len(others) == 3
    assert {"peak_pressure [MPa]", "peak_pressure_bound [MPa]", "case_status"} <= set(row)
    assert not {"iterations", "case_key", "pressure_l1_estimate"} & set(row)
    assert {"iterations", "case_key", "pressure_l1_estimate"} <= set(table(study, "all")[0])
    named = table(study, "--plot", "residual", "peak_pressure")[0]
    assert list(named)[-2:] == ["residual", "peak_pressure [MPa]"]
    marked = said("show", study, "peak_pressure", "--csv", "--format", "excel")
    assert marked.startswith("\ufeffshapes_0_radius [mm],")


def test_fields_of_the_cases_of_a_sweep_are_a_table_and_a_series_for_paraview(folder: Path, tmp_path: Path) -> None:
    scene = tmp_path / "deep.toml"
    scene.write_text(
        SMOOTH + given(16, "0.4 mm") + '[[outputs]]\nkind = "SubsurfaceStress"\ndepths = ["50 um", "90 um"]\n'
    )
    vary = ["--vary", "load.per_length=80 N/mm,90 N/mm", "--workers", "0", "--repeats", "0"]
    said("run", scene, *vary, "--fields", "--out", tmp_path)
    sweep = tmp_path / "deep-sweep.nc"
    rows = table(sweep, "von_mises")
    cells = xr.open_dataset(sweep, group=f"fields/case_{xr.load_dataset(sweep)['case_key'].values[1]}")
    assert len(rows) == 2 * cells["von_mises"].size
    of_last = [row for row in rows if row["load_per_length [N/mm]"] == "90"]
    assert float(of_last[0]["von_mises [MPa]"]) * 1e6 == pytest.approx(
        float(cells["von_mises"].transpose("z", "x", "y")[0, 0, 0])
    )
    text = said("show", sweep, "--format", "vtk", "--out", tmp_path / "vtk")
    written = [Path(line.removeprefix("wrote ")) for line in text.splitlines()]
    assert [path.name for path in written] == ["deep-sweep.pvd", "deep-sweep-stress.pvd"]
    for path in written:
        named = re.findall(r'file="([^"]*)"', path.read_text())
        assert len(named) == 2
        assert all((path.parent / name).is_file() for name in named)
    stresses = (tmp_path / "vtk" / "deep-sweep-stress-1.vtr").read_bytes()
    values = cells["stress"].sel(component="xz").transpose("x", "y", "z").values[:, :, ::-1]
    assert b"stress_xz" in stresses
    assert np.ascontiguousarray(values).tobytes(order="F") in stresses


def test_a_march_is_a_row_for_each_instant(tmp_path: Path) -> None:
    evolution = xr.Dataset(
        {
            "load": ("time", [1.0, 2.0], {"units": "N m-1"}),
            "pressure": (("time", "x"), np.ones((2, 3))),
        },
        {"time": ("time", [0.0, 0.5], {"units": "s"})},
    )
    evolution.to_netcdf(tmp_path / "evolution.nc")
    assert table(tmp_path / "evolution.nc") == [
        {"time [s]": "0", "load [N/m]": "1"},
        {"time [s]": "0.5", "load [N/m]": "2"},
    ]


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
    text = said("show", tmp_path / "scene.toml")
    assert "waves below lambda_s = 25 µm were removed" in text
    assert (tmp_path / "scene-shapes-0.png").is_file()


def test_no_file_makes_show_end_in_a_traceback(tmp_path: Path) -> None:
    points = {"case_status": ("load", [1, 1]), "stiffness": ("load", [-1.0, 2.0]),
              "stiffness_bound": ("load", [-1.0, np.inf])}  # fmt: skip
    odd = {
        "negative": (xr.Dataset(points, {"load": [1.0, 2.0]}), {0}),
        "three axes": (xr.Dataset({"pressure": (("x", "y", "z"), np.zeros((2, 1, 2)))}), {0, 1, 2}),
        "nothing": (xr.Dataset(), {0, 1, 2}),
        "statuses": (xr.Dataset({"case_status": ("load", [1, 1])}), {0, 1, 2}),
    }
    for name, (dataset, codes) in odd.items():
        dataset.to_netcdf(tmp_path / f"{name}.nc")
        for words in ([], ["--csv"]):
            done = CliRunner().invoke(cli, ["show", str(tmp_path / f"{name}.nc"), *words])
            is_said = isinstance(done.exception, SystemExit | InvalidInput | None)
            assert is_said, (name, words, done.exception)
            assert done.exit_code in codes, (name, done.output)
