import re
from pathlib import Path

import pytest

import studies.accessor  # noqa: F401 (the accessor)
from tests.test_readme import BLOCK, SAID

PAGE = Path(__file__).parents[2] / "docs/how-to/interoperate.md"
BLOCKS = BLOCK.findall(PAGE.read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    names: dict[str, object] = {"folder": tmp_path_factory.mktemp("page")}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(names["folder"])
        exec(BLOCKS[0][1], names)
    return names


@pytest.mark.whole
@pytest.mark.filterwarnings("default")  # those of other libraries are theirs
@pytest.mark.parametrize("library", ["cf_xarray", "pint_xarray", "zarr", "hvplot"], ids=lambda name: name)
def test_the_block_of_a_library_prints_what_it_says(
    library: str, known: dict[str, object], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip(library)
    monkeypatch.chdir(known["folder"])
    (block,) = (
        text for kind, text in BLOCKS if kind == "py" and re.search(rf"^import {library}\b(?!\.units)", text, re.M)
    )
    exec(block, dict(known))
    assert capsys.readouterr().out.splitlines() == SAID.findall(block)
