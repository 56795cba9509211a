"""Other libraries take our datasets, as the page on it says, where they are installed."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

import studies.accessor  # noqa: F401 (the accessor)
from studies.cli.commands import cli
from tests.test_readme import BLOCK, SAID

PAGE = Path(__file__).parents[2] / "docs/how-to/interoperate.md"
BLOCKS = BLOCK.findall(PAGE.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    """The solution and the study that the page makes first, and their folder."""
    folder = tmp_path_factory.mktemp("page")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        names: dict[str, object] = {}
        exec(BLOCKS[0][1], names)
    return names | {"folder": folder}


@pytest.mark.whole
@pytest.mark.filterwarnings("default")  # those of other libraries are theirs
@pytest.mark.parametrize(
    "library", ["cf_xarray", "pint_xarray", "zarr", "hvplot"], ids=lambda name: name
)
def test_the_block_of_a_library_prints_what_it_says(
    library: str,
    known: dict[str, object],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    pytest.importorskip(library)
    monkeypatch.chdir(known["folder"])
    (block,) = (
        text
        for kind, text in BLOCKS
        if kind == "py" and re.search(rf"^import {library}\b(?!\.units)", text, re.M)
    )
    exec(block, dict(known))
    assert capsys.readouterr().out.splitlines() == SAID.findall(block)


@pytest.mark.whole
@pytest.mark.filterwarnings("default")
def test_a_study_with_units_of_pint_gives_the_same_answers(known: dict[str, object]) -> None:
    pytest.importorskip("pint_xarray")
    plain = known["dataset"]
    assert isinstance(plain, xr.Dataset)
    quantified = plain.pint.quantify()
    assert not isinstance(quantified["solve_time"].data, type(plain["solve_time"].data))
    for error in ("pressure_error_l1", "axis_pressure_error"):
        assert quantified.study.pareto(error).equals(plain.study.pareto(error))
    assert quantified.study.table().equals(plain.study.table())
    order = {"padding": "exact", "period": 2.4, "images": 1}
    assert quantified.study.order("pressure_error_l1", "grid", **order) == plain.study.order(
        "pressure_error_l1", "grid", **order
    )


@pytest.mark.whole
def test_the_library_of_paraview_reads_the_fields_of_a_solution(known: dict[str, object]) -> None:
    vtk = pytest.importorskip("vtk")
    pytest.importorskip("pyevtk")
    folder, solved = known["folder"], known["solved"]
    assert isinstance(folder, Path)
    assert isinstance(solved, xr.Dataset)
    cli.main(["show", str(folder / "solved.nc"), "--format", "vtk"], standalone_mode=False)
    reader = vtk.vtkXMLRectilinearGridReader()
    reader.SetFileName(str(folder / "solved.vtr"))
    reader.Update()
    cells = reader.GetOutput().GetCellData()
    for name in ("pressure", "gap", "displacement"):
        field = solved[name]
        assert cells.GetArray(name).GetRange() == (float(field.min()), float(field.max()))
        # VTK counts cells along x first
        assert cells.GetArray(name).GetValue(5) == float(field[5, 0])


@pytest.mark.whole
def test_snakemake_runs_the_rules_of_the_page_once(tmp_path: Path) -> None:
    snakemake = shutil.which(
        "snakemake", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    )
    if snakemake is None:
        pytest.skip("snakemake is not installed")
    (rules,) = (text for kind, text in BLOCKS if text.startswith("rule "))
    (tmp_path / "Snakefile").write_text(rules)
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PYTHONPATH": str(PAGE.parents[2]),
    }
    for said in ("2 of 2 steps", "Nothing to be done"):
        done = subprocess.run(
            [snakemake, "--cores", "1"],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
        assert said in done.stderr
    assert (tmp_path / "outputs/padding/price.png").is_file()
