import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import grid as fields
from contactstudy.domain.device import using
from contactstudy.problem.field_operations import ArrayOperations, operations_for
from tests.conftest import LineContact
from tests.contactstudy.domain.test_devices import BOTH, agree, rough


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """For fields of any size; without numba there is nothing to test."""
    pytest.importorskip("numba")
    monkeypatch.setattr(fields, "MIN_COMPILED_CELLS", 1)


@pytest.mark.parametrize("hardness", [None, 0.8])
def test_a_rough_contact_is_the_same(
    hardness: float | None, line_contact: LineContact, request: pytest.FixtureRequest
) -> None:
    posed = rough(line_contact, (64, 64), BOTH, hardness)
    ours = cs.solve(posed, tolerance=1e-10)
    request.getfixturevalue("compiled")
    other = cs.solve(posed, tolerance=1e-10, device=cs.Cpu(2))
    agree(ours, other, 1e-10)
    assert other.status is ours.status


@pytest.mark.usefixtures("compiled")
def test_sums_do_not_depend_on_the_number_of_threads(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fields, "CELLS_PER_THREAD", 256)
    bare = rough(line_contact, (37, 51), BOTH, 0.8).bare()
    pressure = bare.clip_and_scale(np.random.default_rng(1).exponential(size=(37, 51)))
    moved = bare.operator(pressure)
    found = []
    for threads in (1, 2, 3):
        with using(cs.Cpu(threads)):
            gap = bare.gap(pressure, moved)
            found.append((gap.approach, bare.residual(pressure, gap)))
    assert found[0] == found[1] == found[2]


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("shape", [(12, 7), (7, 12)])
def test_a_part_of_a_step_is_taken_and_cut_off_in_every_cell(shape: tuple[int, int]) -> None:
    """A step that is another in some cells is mended by later ones, which cost a solve twice its iterations."""
    constraint = cs.Constraint(0.9)
    found = []
    for operations in (ArrayOperations(constraint, shape), operations_for(constraint, shape)):
        trial, pressure, moved, displacement = np.random.default_rng(1).uniform(size=(4, *shape))
        crosses = [operations.crosses_a_limit(trial, pressure, factor) for factor in (0.0, 1.2)]
        operations.take_fraction(trial, pressure, moved, displacement, 1.2)
        found.append((trial, moved, crosses))
    assert type(operations) is not ArrayOperations
    for ours, other in zip(*found, strict=True):
        np.testing.assert_allclose(ours, other, rtol=1e-14, atol=1e-15)


# Compiles a sum of numbers of one precision, with an index of the code on disk that is as many seconds old as is asked
# for, and prints the sum and how often its code was on disk.
SUM = """
import sys, time
import numpy as np
from numba.core.caching import IndexDataCacheFile
from contactstudy.domain.loops.compiled import exact

def read_slowly(self, read=IndexDataCacheFile._load_index):
    index = read(self)
    time.sleep(float(sys.argv[2]))
    return index

IndexDataCacheFile._load_index = read_slowly

@exact
def total(numbers):
    return numbers[0] + numbers[1]

print(total(np.ones(2, sys.argv[1])), total.stats.cache_hits.total())
"""


@pytest.mark.whole
def test_processes_that_compile_for_two_precisions_at_once_leave_each_its_code(tmp_path: Path) -> None:
    pytest.importorskip("numba")
    script = tmp_path / "sum.py"
    script.write_text(SUM, encoding="utf-8")
    for seconds, printed in (("1", "2.0 0\n"), ("0", "2.0 1\n")):
        running = [
            subprocess.Popen([sys.executable, script, precision, seconds], stdout=subprocess.PIPE, text=True)
            for precision in ("float32", "float64")
        ]
        assert [one.communicate()[0] for one in running] == [printed] * 2
