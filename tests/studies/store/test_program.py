"""What makes a stored case unusable, each edit in processes of their own, as a user makes it."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from contactstudy import InvalidInput
from studies.store import program

STUDY = '''"""Numbers."""
from dataclasses import dataclass
import helper, tomllib
import kinds
from studies import Axis, Study
LOAD = 3.0
@dataclass(frozen=True)
class Number:
    number: int
    load: float = 0.0
    of: object = None
    def prepare(self): return self.number
    def run(self, prepared): return helper.factor() * prepared
    def record(self, result): return {}
def case_at(point):
    return Number(point["number"], LOAD, kinds.made())
def measures(case, result):
    with open("table.toml", "rb") as file:
        return {"value": result * tomllib.load(file)["scale"]}
AXES = (Axis("number", (1, 2), "a number"),)
study = Study("numbers_here", "Numbers.", AXES, case_at, measures, "none", depends=("table.toml",))
'''
HELPER = "import far\nfrom deep.inner import exact\ndef factor(): return far.FACTOR\n"
FILES = {
    "kinds.py": "LOAD = __builtins__['__imp' + 'ort__']\ndef made(): return LOAD('kind').Kind()\n",
    "kind.py": "from dataclasses import dataclass\n@dataclass(frozen=True)\nclass Kind: pass\n",
    "numbers_here.py": STUDY, "helper.py": HELPER, "far.py": "FACTOR = 2\n", "table.toml": "scale = 10\n",
    "deep/__init__.py": "", "deep/inner.py": "import distributed_here\nexact = 1\n",
    "site/distributed_here.py": "", "site/distributed_here-1.0.dist-info/METADATA":
    "Metadata-Version: 2.1\nName: distributed_here\nVersion: 1.0\n",
    "site/distributed_here-1.0.dist-info/RECORD": "distributed_here.py,,\n",
}  # fmt: skip
SCRIPT = """
import sys
from pathlib import Path
from studies import load, run
from contactstudy import InvalidInput
from studies.store import program
program.INSTALLED += (str(Path("site").absolute()) + "/",)
from studies.engine.options import RunOptions
study = load("numbers_here.py")
exec(sys.argv[2])
dataset = run(study, Path("out"), options=RunOptions(workers=int(sys.argv[1])))
print(dataset["value"].values.tolist())
"""


class Work:
    """A folder with a study and what it imports."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name, text in FILES.items():
            (folder / name).parent.mkdir(exist_ok=True, parents=True)
            (folder / name).write_text(text)

    def edit(self, name: str, old: str, new: str) -> None:
        text = (self.folder / name).read_text(encoding="utf-8")
        assert old in text
        (self.folder / name).write_text(text.replace(old, new), encoding="utf-8")

    def run(self, workers: int = 0, then: str = "") -> str:
        """What a run says, and its values in the last line; `then` is done between the load and the run."""
        paths = map(str, (self.folder, self.folder / "site", program.ROOT))
        done = subprocess.run(
            [sys.executable, "-c", SCRIPT, str(workers), then], cwd=self.folder, capture_output=True, text=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(paths), "PYTHONDONTWRITEBYTECODE": "1"},
        )  # fmt: skip
        return done.stdout + done.stderr

    @property
    def stored(self) -> int:
        return (self.folder / "out" / "cases.jsonl").read_text(encoding="utf-8").count('"status":')


@pytest.fixture
def work(tmp_path: Path) -> Work:
    return Work(tmp_path)


@pytest.mark.whole
def test_an_edit_of_anything_that_computes_is_named_and_nothing_stale_is_used(work: Work) -> None:
    assert work.run().endswith("[20, 40]\n")
    assert "2 cases are stored, 0 to compute" in work.run()
    for name, old, new, said, values in (
        ("far.py", "2", "3", "since far changed", "[30, 60]"),
        ("kind.py", "pass", "a = 1", "since kind changed", "[30, 60]"),
        ("table.toml", "10", "20", "since table.toml changed", "[60, 120]"),
        ("numbers_here.py", "result *", "2 * result *", "since numbers_here.py, the study's", "[120, 240]"),
        ("site/distributed_here-1.0.dist-info/METADATA", "n: 1.0", "n: 1.1",
         "since distributed_here 1.0 -> 1.1 changed", "[120, 240]"),
        ("numbers_here.py", "LOAD = 3.0", "LOAD = 4.0", "the case at {'number': 1} was another", "[120, 240]"),
    ):  # fmt: skip
        work.edit(name, old, new)
        text = work.run()
        assert said in text, (name, text)
        assert text.endswith(f"{values}\n"), (name, text)
    # three of the edits change results
    kept = {path.name for path in (work.folder / "out").glob("*.before*.nc")}
    assert kept == {f"numbers_here.before{number}.nc" for number in ("", 1, 2)}


@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", [1, 0])
def test_a_module_that_a_case_imports_first_is_refused_with_the_remedy(work: Work, workers: int) -> None:
    work.edit("helper.py", "import far\n", "")
    work.edit("numbers_here.py", "return helper.", "import far; helper.far = far; return helper.")
    text = work.run(workers)
    assert "far was imported while a case was computed: import it at the top" in text
    assert work.stored == 0


@pytest.mark.cases(1)
@pytest.mark.parametrize("workers", [1, 0])
def test_a_file_that_changes_while_cases_are_computed_ends_the_run(work: Work, workers: int) -> None:
    work.edit("helper.py", "():", "():\n    open(__file__, 'a').write('# more')\n   ")
    text = work.run(workers)
    assert "helper changed since the run was started: what was computed with it is not" in text
    assert work.stored == 0


@pytest.mark.cases(1)
@pytest.mark.parametrize(("file", "changed"), [("far.py", "far"), ("table.toml", "table.toml")])
def test_a_file_that_has_changed_since_it_was_loaded_is_refused(work: Work, file: str, changed: str) -> None:
    text = work.run(then=f"open({file!r}, 'a').write('# more')")
    assert f"{changed} changed since this program loaded it: start the program" in text


def test_a_worker_with_another_program_or_files_changed_since_it_loaded_them_is_refused_by_name(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = program.own_digests()
    program.Program(right, {}).check()
    others = {"studies/model/case.py": "0", "numpy": "1.0", "tamaas": "9.0", "studies/more.py": "1"}
    refusal = r"^numpy, studies/model/case.py, studies/more.py, tamaas on worker tcp://a:1 is not what the run"
    with pytest.raises(InvalidInput, match=refusal):
        program.Program({**right, **others}, {}).check("worker tcp://a:1")
    monkeypatch.setattr(program, "LOADED", 0.0)
    with pytest.raises(InvalidInput, match=r"^contactstudy/.* on worker tcp://a:1 is not what the"):
        program.Program(right, {}).check("worker tcp://a:1")
