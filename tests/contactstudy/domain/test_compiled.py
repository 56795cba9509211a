"""Passes compiled by numba give what array operations give."""

import sys
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import fields
from contactstudy.domain.device import using
from contactstudy.domain.fields import compiled_loops
from contactstudy.problem.passes import ArrayPasses, passes_for
from tests.conftest import LineContact
from tests.contactstudy.domain.test_devices import BOTH, STRICT, agree
from tests.contactstudy.solvers.test_preconditioned_cg import problem


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """For fields of any size; without numba there is nothing to test."""
    pytest.importorskip("numba")
    monkeypatch.setattr(fields, "LARGE", 1)


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
    other = cs.solve(posed, tolerance=1e-10, on=cs.Cpu(2))
    agree(ours, other, 1e-10)
    assert other.status is ours.status


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("hardness", [None, 0.8])
def test_sums_do_not_depend_on_the_number_of_threads(
    hardness: float | None, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fields, "PART", 256)
    bare = rough((37, 51), hardness, line_contact).bare()
    pressure = bare.make_admissible(np.random.default_rng(1).exponential(size=(37, 51)))
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


def test_small_fields_do_not_load_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fields, "_loops", lambda: pytest.fail("loaded"))
    assert compiled_loops((fields.LARGE // 8 - 1, 8)) is None


def test_fields_of_so_many_cells_and_no_fewer_are_worked_on_by_compiled_loops(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(fields, "_loops", lambda: "loops")
    assert compiled_loops((fields.LARGE // 8, 8)) == "loops"
    with using(STRICT):
        assert compiled_loops((fields.LARGE // 8, 8)) is None


@pytest.mark.parametrize(("along", "compiled"), [(1, False), (3, False), (4, True)])
def test_rows_of_few_cells_are_left_to_array_operations(
    along: int,
    compiled: bool,  # noqa: FBT001
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A compiled loop would begin a row more often than it has cells to work on."""
    monkeypatch.setattr(fields, "_loops", lambda: "loops")
    assert compiled_loops((fields.LARGE, along)) == ("loops" if compiled else None)


def test_a_constraint_of_one_s_own_is_left_to_array_operations(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(fields, "LARGE", 1)
    own: Any = SimpleNamespace(capacity=lambda cells: cells)
    assert isinstance(passes_for(own, (64, 64)), ArrayPasses)


def test_without_the_compiler_array_operations_do_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)  # type: ignore[arg-type]
    fields._loops.cache_clear()
    assert compiled_loops((fields.LARGE // 8, 8)) is None
    fields._loops.cache_clear()
