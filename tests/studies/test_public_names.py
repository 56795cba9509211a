from pathlib import Path

import pytest

import studies
from studies.store import provenance
from tests.studies.conftest import python


def test_every_public_name_is_there() -> None:
    for name in studies.__all__:
        assert getattr(studies, name) is not None, name
    assert set(studies.__all__) <= set(dir(studies))
    with pytest.raises(AttributeError, match="no attribute"):
        _ = studies.Axes


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


@pytest.mark.whole
def test_neither_listing_studies_nor_a_worker_process_imports_a_plotting_library() -> None:
    script = """
import pickle, sys
import cloudpickle
from click.testing import CliRunner
import studies.engine.serving
from studies.cli.commands import cli
from studies.model.outcome import RunSettings
from studies.registry import load
assert CliRunner().invoke(cli, ["studies"]).exit_code == 0
for name in ("padding", "stability", "coating"):
    study = load(name)
    pickle.loads(cloudpickle.dumps((RunSettings(study.measures), study.cases()[0])))
assert not {"matplotlib", "studies.report"} & set(sys.modules)
from studies.report import plots
assert {"matplotlib", "studies.report"} <= set(sys.modules)
"""
    done = python(script)
    assert done.returncode == 0, done.stderr
