"""Passes compiled by numba give what array operations give."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import device
from contactstudy.domain import fields as rows
from contactstudy.domain.device import fused, using
from tests.conftest import LineContact
from tests.contactstudy.domain.test_devices import BOTH, STRICT, agree, extended
from tests.contactstudy.solvers.test_preconditioned_cg import problem


@pytest.fixture
def compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """For fields of any size; without numba there is nothing to test."""
    pytest.importorskip("numba")
    monkeypatch.setattr(device, "LARGE", 1)


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize("shape", [(16, 16), (13, 10), (10, 13), (25, 1), (1, 6)], ids=str)
@pytest.mark.parametrize("elongation", [1.0, 0.02, 30.0])
def test_an_extension_is_the_same(
    shape: tuple[int, int], elongation: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = extended(shape, elongation, cs.Cpu())
    monkeypatch.setattr(rows, "PART", 8)
    with using(cs.Cpu(2), 1):
        assert fused() is not None
        found = extended(shape, elongation, cs.Cpu())
    for one, two in zip(found, expected, strict=True):
        # sums of at most so many terms of size one
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-15 * two.size)


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
    monkeypatch.setattr(rows, "PART", 256)
    bare = rough((37, 51), hardness, line_contact).bare()
    pressure = bare.admit(np.random.default_rng(1).exponential(size=(37, 51)))
    moved = bare.operator(pressure)
    found = []
    for threads in (1, 2, 3):
        with using(cs.Cpu(threads), 1):
            gap = bare.gap(pressure, moved)
            found.append((gap.approach, bare.residual(pressure, gap)))
    assert found[0] == found[1] == found[2]


@pytest.mark.usefixtures("compiled")
def test_heights_that_are_not_finite_are_seen(line_contact: LineContact) -> None:
    posed = problem(line_contact, 32, "smooth", BOTH)
    posed.undeformed_gap[3, 4] = np.nan
    assert cs.solve(posed).status is cs.Status.NOT_FINITE


def test_small_fields_do_not_load_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(device, "_compiled", lambda: pytest.fail("loaded"))
    with using(cs.Cpu(), device.LARGE - 1):
        assert fused() is None


def test_fields_of_so_many_cells_and_no_fewer_are_worked_on_by_compiled_passes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(device, "_compiled", lambda: "passes")
    with using(cs.Cpu(), device.LARGE):
        assert fused() == "passes"
    with using(STRICT, device.LARGE):
        assert fused() is None


@pytest.mark.parametrize(("along", "times"), [(1, 0), (3, 0), (4, 1)])
def test_rows_of_few_cells_are_left_to_array_operations(
    along: int, times: int, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A compiled pass would begin a row more often than it has cells to work on."""
    monkeypatch.setattr(device, "LARGE", 1)
    asked: list[bool] = []
    monkeypatch.setattr(device, "_compiled", lambda: asked.append(True))
    cs.solve(problem(line_contact, (64, along), "smooth"))
    assert len(asked) == times


def test_without_the_compiler_array_operations_do_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numba", None)  # type: ignore[arg-type]
    device._compiled.cache_clear()
    with using(cs.Cpu(), device.LARGE):
        assert fused() is None
    device._compiled.cache_clear()
