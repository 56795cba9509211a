"""Every Python block of the README runs, in order, and says what its comments say."""

import re
from pathlib import Path

import pytest

from studies.study import load
from studies.sweep import run

README = (Path(__file__).parent.parent / "README.md").read_text()
SWEEP = re.search(r"contactstudy run padding --out (\S+) (.*)", README)


def test_readme_python_blocks_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert SWEEP is not None
    folder, words = SWEEP[1], SWEEP[2].split()
    axes = dict(zip((word[2:] for word in words[::2]), words[1::2], strict=True))
    run(load("padding").override(axes), Path(folder), workers=0, repeats=1)
    capsys.readouterr()
    blocks = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    for block in blocks:
        if "points =" in block:
            Path("radius.py").write_text(block)
            continue
        exec(compile(block, "README.md", "exec"), {})
    out = capsys.readouterr().out.splitlines()
    assert out[0] == "CONVERGED: the residual is below the tolerance."
    assert float(out[1]) == pytest.approx(1.0, abs=5e-4)
    assert (tmp_path / "outputs" / "contact.nc").is_file()
    own = load("radius.py").override({"radius": "0.01,0.02,0.04"})
    dataset = run(own, Path("outputs"), workers=0, repeats=1)
    assert own.figure(dataset)[0].name == "peak"
    peaks = dataset["peak_pressure"].values
    # the same grid in half-widths, and so the same error: the law holds to the solver's residual
    assert peaks[:-1] / peaks[1:] == pytest.approx([2**0.5] * 2, rel=1e-5)
