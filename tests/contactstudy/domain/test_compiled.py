import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import fields
from contactstudy.domain.device import using
from tests.conftest import LineContact
from tests.contactstudy.domain.test_devices import BOTH, agree
from tests.contactstudy.solvers.test_preconditioned_cg import problem


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """For fields of any size; without numba there is nothing to test."""
    pytest.importorskip("numba")
    monkeypatch.setattr(fields, "MIN_COMPILED_CELLS", 1)


def rough(cells: tuple[int, int], hardness: float | None, line_contact: LineContact) -> cs.Problem:
    posed = problem(line_contact, cells, "30 %", BOTH)
    if hardness is None:
        return posed
    limit = cs.HardnessLimited(hardness * line_contact.hertz.peak_pressure)
    return replace(posed, constraint=limit)


@pytest.mark.parametrize("hardness", [None, 0.8])
@pytest.mark.parametrize("cells", [(64, 64), (37, 51)], ids=str)
def test_a_rough_contact_is_the_same(
    cells: tuple[int, int],
    hardness: float | None,
    line_contact: LineContact,
    request: pytest.FixtureRequest,
) -> None:
    posed = rough(cells, hardness, line_contact)
    ours = cs.solve(posed, tolerance=1e-10)
    request.getfixturevalue("compiled")
    other = cs.solve(posed, tolerance=1e-10, device=cs.Cpu(2))
    agree(ours, other, 1e-10)
    assert other.status is ours.status


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("hardness", [None, 0.8])
def test_sums_do_not_depend_on_the_number_of_threads(
    hardness: float | None, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fields, "CELLS_PER_THREAD", 256)
    bare = rough((37, 51), hardness, line_contact).bare()
    pressure = bare.clip_and_scale(np.random.default_rng(1).exponential(size=(37, 51)))
    moved = bare.operator(pressure)
    found = []
    for threads in (1, 2, 3):
        with using(cs.Cpu(threads)):
            gap = bare.gap(pressure, moved)
            found.append((gap.approach, bare.residual(pressure, gap)))
    assert found[0] == found[1] == found[2]


@pytest.mark.usefixtures("compiled")
def test_heights_that_are_not_finite_are_seen(line_contact: LineContact) -> None:
    posed = problem(line_contact, 32, "smooth", BOTH)
    posed.undeformed_gap[3, 4] = np.nan
    assert cs.solve(posed).status is cs.Status.NOT_FINITE


# Compiles a sum of fields of the type that is named, and reports what it returns and whether its code was on disk. The
# index of the code on disk is old by the time that a process writes it.
SUM_OF_FIELDS = """
import sys
from time import sleep
import numpy as np
from numba.core.caching import IndexDataCacheFile
from contactstudy.domain.compiled import exact

def read_slowly(self, read=IndexDataCacheFile._load_index):
    index = read(self)
    sleep(1.0 if sys.argv[2:] else 0.0)
    return index

IndexDataCacheFile._load_index = read_slowly

@exact
def total(field):
    sum_of_cells = 0.0
    for i in range(field.shape[0]):
        sum_of_cells += field[i]
    return sum_of_cells

print(total(np.ones(3, sys.argv[1])), total.stats.cache_hits.total())
"""


@pytest.mark.whole
def test_processes_that_compile_for_two_precisions_at_once_leave_each_its_code(
    tmp_path: Path,
) -> None:
    pytest.importorskip("numba")
    script = tmp_path / "sum_of_fields.py"
    script.write_text(SUM_OF_FIELDS, encoding="utf-8")

    def run(*words: str) -> subprocess.Popen[str]:
        command = (sys.executable, str(script), *words)
        return subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def printed(processes: Sequence[subprocess.Popen[str]]) -> list[str]:
        return ["".join(process.communicate()) for process in processes]

    precisions = ("float32", "float64")
    assert printed([run(name, "slowly") for name in precisions]) == ["3.0 0\n"] * 2
    assert printed([run(name) for name in precisions]) == ["3.0 1\n"] * 2
