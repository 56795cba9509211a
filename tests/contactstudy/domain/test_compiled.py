from dataclasses import replace

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
