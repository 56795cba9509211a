from pathlib import Path

import pytest

import studies
from studies.engine.run import run
from studies.registry import load, load_drawing
from studies.store import provenance
from tests.studies.conftest import python

WITHOUT_FIGURE = """
import contactstudy as cs
from studies import Axis, Case

axes = Axis("radius", (0.01, 0.02), "radius of the cylinder", units="m")
times = "none"


def case_at(point):
    steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
    scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(radius=point["radius"]),))
    a = scene.hertz.half_width
    return Case(scene, cs.Grid(cells=(32, 1), extent=(2.4 * a, a)), cs.ExactPeriodicity())


def measures(case, solution):
    return {"peak_pressure": solution.pressure.max()}
"""


def test_every_public_name_is_there() -> None:
    for name in studies.__all__:
        assert getattr(studies, name) is not None, name
    assert set(studies.__all__) <= set(dir(studies))
    with pytest.raises(AttributeError, match="no attribute"):
        _ = studies.Axes


def test_a_study_without_a_figure_is_drawn(tmp_path: Path) -> None:
    path = tmp_path / "radii.py"
    path.write_text(WITHOUT_FIGURE)
    dataset = run(load(str(path)), tmp_path, workers=0, log=lambda _: None)
    (one,) = load_drawing(str(path)).figure(dataset)
    # points may be one axis; the only measure has the only panel
    (ax,) = one.figure.axes
    assert "peak pressure" in ax.get_ylabel()
    assert [float(x) for x in ax.lines[0].get_xdata()] == pytest.approx([10, 20])  # mm


def test_the_revision_is_the_program_s(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # installed below a repository of the user's: what git says there is not asked
    inside = tmp_path / "lib" / "studies" / "store" / "provenance.py"
    monkeypatch.setattr(provenance, "__file__", str(inside))
    (tmp_path / ".git").mkdir()
    provenance._revision.cache_clear()
    try:
        assert provenance._revision() == "unknown (not a git checkout)"
    finally:
        provenance._revision.cache_clear()


DRAWS = ("matplotlib", "studies.report")


def test_neither_listing_studies_nor_a_worker_process_imports_a_plotting_library() -> None:
    script = f"""
import sys
def drawing():
    return [name for name in {DRAWS!r} if name in sys.modules]
from click.testing import CliRunner
from studies.cli.commands import cli
assert CliRunner().invoke(cli, ["studies"]).exit_code == 0
assert drawing() == []
import cloudpickle, pickle
import studies.engine.workers.preload
from studies.model.outcome import RunSettings
from studies.registry import BUILT_IN, load
for name in BUILT_IN:
    study = load(name)
    pickle.loads(cloudpickle.dumps((RunSettings(study.measures), study.cases()[0])))
assert drawing() == []
from studies.report import style
assert drawing() == list({DRAWS!r})  # the check itself can fail
"""
    done = python(script)
    assert done.returncode == 0, done.stderr
