"""The cells that will bear, by hand, and by compiled passes that are told what they find."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.problem.constraint import Gap
from contactstudy.solvers import preconditioned_cg as closing
from contactstudy.solvers.preconditioned_cg import FAR, _contact, _held, _join, preconditioning
from tests.contactstudy.solvers.kernels import Kernels, limited

PRESSURE = np.array([[0.0, 2.0], [0.5, 0.0], [3.0, 0.0]])
GAP = Gap(np.array([[0.5, -1.0], [2.0, 4.0], [0.25, 0.5]]), 0.0)
CELLS = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])


def test_cells_that_bear_below_the_limit_have_their_gap_and_others_none() -> None:
    cells, unlevel = _contact(limited(3.0), PRESSURE, GAP, np.float32)
    assert cells.dtype == unlevel.dtype == np.float32
    np.testing.assert_array_equal(cells, CELLS)
    np.testing.assert_array_equal(unlevel, [[0, -1], [2, 0], [0, 0]])
    out = np.empty((3, 2))
    assert _held(GAP, CELLS, out) is out
    np.testing.assert_array_equal(out, [[0, -1], [2, 0], [0, 0]])


@pytest.mark.parametrize(
    ("length", "joined"), [(0.25, ()), (0.5, ((2, 1),)), (1.0, ((0, 0), (2, 1)))]
)
def test_cells_join_that_would_penetrate_after_a_step(
    length: float, joined: tuple[tuple[int, int], ...]
) -> None:
    whole = np.array([[0.75, 5.0], [5.0, -1.0], [5.0, 1.5]])
    cells = CELLS.copy()
    assert _join(limited(3.0), PRESSURE, GAP, length, cells, whole) == bool(joined)
    expected = CELLS.copy()
    for cell in joined:
        expected[cell] = 1
    np.testing.assert_array_equal(cells, expected)


def test_compiled_passes_are_asked_with_the_limit_of_a_cell(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kernels = Kernels(joined=(0.0,))
    monkeypatch.setattr(closing, "fused", lambda: kernels)
    problem, whole = limited(3.0), np.zeros((3, 2))
    cells, unlevel = _contact(problem, PRESSURE, GAP, np.float64)
    assert kernels.asked["contact"][2] == 3
    assert cells.shape == unlevel.shape == (3, 2)
    assert not _join(problem, PRESSURE, GAP, 0.5, cells, whole)
    assert kernels.asked["joined"][3:5] == (0.5, 3.0)
    kernels.results["joined"] = (1.0,)
    assert _join(problem, PRESSURE, GAP, 0.5, cells, whole)
    assert _held(GAP, CELLS, whole) is whole
    assert "product" in kernels.asked


def test_passes_precondition_in_single_precision_heights_that_are_no_strangers_to_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def of(*heights: float) -> Any:
        return preconditioning(SimpleNamespace(undeformed_gap=np.array([heights])))  # type: ignore[arg-type]

    assert of(0.0, 1.0) is None
    monkeypatch.setattr(closing, "fused", lambda: "passes")
    assert of(0.0, 1.0) is cs.Precision.SINGLE
    assert of(-3 * FAR, 0.9 * FAR) is cs.Precision.SINGLE
    for heights in ((0.0, FAR), (-2 * FAR, -FAR), (0.0, np.nan)):
        assert of(*heights) is None
