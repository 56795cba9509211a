"""Passes over the fields of an iteration, by hand, and by compiled loops that are told what they find."""

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import fields
from contactstudy.domain.device import using
from contactstudy.problem.passes import FAR, ArrayPasses, CompiledPasses, TrialSums, _rows
from tests.contactstudy.solvers.kernels import Kernels, limited

PRESSURE = np.array([[1.0, 2.0], [0.5, 0.0], [3.0, 1.5]])
TRIAL = np.array([[2.0, 1.0], [0.75, 0.25], [1.0, 0.0]])
MOVED = np.array([[0.5, 4.0], [1.0, 2.0], [0.25, 0.0]])
AHEAD = np.array([[2.5, 3.0], [1.5, 2.25], [0.75, 1.0]])
HEIGHT = np.array([[0.5, -1.0], [2.0, 4.0], [0.25, 0.5]])
STEP, RESPONSE = TRIAL - PRESSURE, AHEAD - MOVED
# Of a pressure with two cells that are free below a limit of 3.
BEARING = np.array([[0.0, 2.0], [0.5, 0.0], [3.0, 0.0]])
CONTACT = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])


def test_slope_and_curvature_are_works_of_the_step() -> None:
    passes = limited(3.0).passes
    # steps of 1, -1, 0.25, 0.25, -2, and -1.5
    assert passes.slope(TRIAL, PRESSURE, HEIGHT) == 0.5 + 1 + 0.5 + 1 - 0.5 - 0.75
    # that change the displacement by 2, -1, 0.5, 0.25, 0.5 and 1
    assert passes.curvature(TRIAL, PRESSURE, AHEAD, MOVED) == 2 + 1 + 0.125 + 0.0625 - 1 - 1.5


@pytest.mark.parametrize(("factor", "meets"), [(1.0, False), (1.01, True)])
def test_a_limit_is_met_beyond_it(factor: float, meets: bool) -> None:  # noqa: FBT001
    assert limited(3.0).passes.meets_a_limit(TRIAL, PRESSURE, factor) == meets
    higher = PRESSURE + 0.5 * np.eye(3, 2)
    assert limited(1.5).passes.meets_a_limit(higher, PRESSURE, 0.0)
    lower_limit = limited(3.5).passes
    assert not lower_limit.meets_a_limit(np.maximum(higher, TRIAL), PRESSURE, 1.0)
    assert lower_limit.meets_a_limit(PRESSURE + np.eye(3, 2), PRESSURE, 3.0)


@pytest.mark.parametrize("share", [0.5, 2.0])
def test_an_advance_leads_to_a_share_of_the_step(share: float) -> None:
    trial, pressure, ahead, moved = (one.copy() for one in (TRIAL, PRESSURE, AHEAD, MOVED))
    limited(2.5).passes.advance(trial, pressure, ahead, moved, share)
    np.testing.assert_array_equal(trial, np.clip(PRESSURE + share * STEP, 0, 2.5))
    np.testing.assert_array_equal(ahead, MOVED + share * RESPONSE)
    np.testing.assert_array_equal(pressure, PRESSURE)
    np.testing.assert_array_equal(moved, MOVED)


def test_cells_that_bear_below_the_limit_have_their_gap_and_others_none() -> None:
    cells, unlevel = limited(3.0).passes.contact(BEARING, HEIGHT, np.float32)
    assert cells.dtype == unlevel.dtype == np.float32
    np.testing.assert_array_equal(cells, CONTACT)
    np.testing.assert_array_equal(unlevel, [[0, -1], [2, 0], [0, 0]])


@pytest.mark.parametrize(
    ("length", "joined"), [(0.25, ()), (0.5, ((2, 1),)), (1.0, ((0, 0), (2, 1)))]
)
def test_cells_join_that_would_penetrate_after_a_step(
    length: float, joined: tuple[tuple[int, int], ...]
) -> None:
    extended = np.array([[0.75, 5.0], [5.0, -1.0], [5.0, 1.5]])
    cells, unlevel = CONTACT.copy(), CONTACT * HEIGHT
    found = limited(3.0).passes.joined(BEARING, HEIGHT, extended, length, cells, unlevel)
    assert found == bool(joined)
    expected = CONTACT.copy()
    for cell in joined:
        expected[cell] = 1
    np.testing.assert_array_equal(cells, expected)
    np.testing.assert_array_equal(unlevel, expected * HEIGHT)


def test_compiled_loops_are_asked_with_the_limit_of_a_cell() -> None:
    """Of three rows."""
    kernels = Kernels(slope=(0.5,), curvature=(0.25,), beyond=(0.0,), joined=(0.0,))
    passes = limited(2.5, kernels).passes
    assert passes.slope(TRIAL, PRESSURE, HEIGHT) == 1.5
    assert passes.curvature(TRIAL, PRESSURE, AHEAD, MOVED) == 0.75
    assert not passes.meets_a_limit(TRIAL, PRESSURE, 2.0)
    assert kernels.asked["beyond"][2:4] == (2.0, 2.5)
    kernels.results["beyond"] = (1.0,)
    assert passes.meets_a_limit(TRIAL, PRESSURE, 2.0)
    passes.advance(TRIAL, PRESSURE, AHEAD, MOVED, 0.5)
    assert kernels.asked["advance"][4:] == (0.5, 2.5)
    cells, unlevel = passes.contact(BEARING, HEIGHT, np.float64)
    assert kernels.asked["contact"][2] == 2.5
    assert cells.shape == unlevel.shape == (3, 2)
    assert not passes.joined(BEARING, HEIGHT, AHEAD, 0.5, cells, unlevel)
    assert kernels.asked["joined"][3:5] == (0.5, 2.5)
    kernels.results["joined"] = (1.0,)
    assert passes.joined(BEARING, HEIGHT, AHEAD, 0.5, cells, unlevel)


def test_large_fields_are_preconditioned_in_single_precision_where_heights_allow_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    small, given = np.array([[0.0, 1.0]]), ArrayPasses(cs.Compressive())
    assert given.preconditioner(small) is None
    monkeypatch.setattr("contactstudy.problem.passes.LARGE", 2)
    for passes in (given, CompiledPasses(cs.Compressive(), Kernels())):
        assert passes.preconditioner(small) is cs.Precision.SINGLE
        assert passes.preconditioner(np.array([[-3 * FAR, 0.9 * FAR]])) is cs.Precision.SINGLE
        for far in ((0.0, FAR), (-2 * FAR, -FAR), (0.0, np.nan)):
            assert passes.preconditioner(np.array([far])) is None


def test_a_trial_is_levelled_by_the_sums_of_all_rows() -> None:
    """Two rows bear 5 Pa in three cells, which a third of 1 Pa less leaves 2 Pa in as many: twice that."""
    kernels = Kernels(lowered=(1.0, 1.5), lower=(0.25,), slope=(0.5,))
    passes, load = CompiledPasses(cs.Compressive(), kernels), cs.PrescribedLoad(4.0)
    found = TrialSums(cut=True, load=5.0, slope=np.nan, bearing=3.0, largest=3.0)
    trial, fields_of = np.ones((2, 3)), (np.ones((2, 3)), load, np.ones((2, 3)), np.zeros((2, 3)))
    assert passes.levelled(trial, found, *fields_of) == 0.5
    assert kernels.asked["lowered"][1] == pytest.approx(1 / 3)
    assert kernels.asked["lower"][1:3] == pytest.approx((1 / 3, 2.0))
    # one alone that bears more than the load
    kernels.asked.clear()
    assert passes.levelled(trial, found._replace(largest=4.5), *fields_of) == 1.0
    assert list(kernels.asked) == ["slope"]


def test_a_compiled_loop_finds_something_in_each_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """In parts, and only of its fields: numbers are passed on."""
    monkeypatch.setattr(fields, "PART", 64)

    def kernel(field: np.ndarray, factor: float, out: np.ndarray, found: np.ndarray) -> None:
        out[...] = factor * field
        found[:, 0], found[:, 1] = field.sum(axis=1), field.max(axis=1)

    field, out = np.random.default_rng(2).standard_normal((99, 9)), np.empty((99, 9))
    with using(cs.Cpu(3)):
        sums, largest = _rows(kernel, field, 2.0, out, results=2)
    np.testing.assert_array_equal(out, 2 * field)
    np.testing.assert_array_equal(sums, field.sum(axis=1))
    np.testing.assert_array_equal(largest, field.max(axis=1))
