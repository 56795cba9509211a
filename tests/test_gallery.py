import runpy
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

GALLERY = sorted((Path(__file__).parent.parent / "examples" / "gallery").glob("plot_*.py"))


@pytest.mark.whole
@pytest.mark.parametrize("example", GALLERY, ids=lambda path: path.stem)
def test_an_example_runs_and_its_number_holds(example: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plt, "show", lambda: None)
    with plt.rc_context():
        runpy.run_path(str(example), run_name="__main__")
    plt.close("all")
    assert not list(tmp_path.iterdir())
