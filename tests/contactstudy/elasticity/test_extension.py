import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.devices import rows
from contactstudy.domain.devices.arrays import Array
from contactstudy.domain.devices.device import using
from contactstudy.elasticity.extension import Extension

CASES = [
    ((16, 16), 1.0),
    ((13, 10), 1.0),
    ((12, 7), 30.0),
    ((9, 16), 0.02),
    ((25, 1), 1e3),
    ((2, 1), 1.0),
]


def island(shape: tuple[int, int], share: float = 0.3) -> Array:
    contact = (np.random.default_rng(5).random(shape) < share).astype(float)
    contact[0, 0] = 1
    return contact


@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_what_is_known_in_the_contact_stays(shape: tuple[int, int], elongation: float) -> None:
    contact = island(shape)
    known = np.random.default_rng(6).standard_normal(shape) * contact
    extended = Extension(contact, elongation)(known)
    np.testing.assert_array_equal(extended * contact, known)
    # elsewhere stand means of it
    assert known.min() <= extended.min()
    assert extended.max() <= known.max()


@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_a_rigid_shift_is_the_same_everywhere(shape: tuple[int, int], elongation: float) -> None:
    contact = island(shape)
    np.testing.assert_allclose(Extension(contact, elongation)(contact), 1, rtol=1e-14)


@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_the_transposed_map_is_the_transpose(shape: tuple[int, int], elongation: float) -> None:
    contact = island(shape)
    extension = Extension(contact, elongation)
    known, pressure = np.random.default_rng(7).standard_normal((2, *shape))
    gathered = extension.transposed(pressure.copy())
    np.testing.assert_array_equal(gathered * (1 - contact), 0)
    work = np.abs(pressure).sum() * np.abs(known).max()
    difference = np.vdot(extension(known * contact), pressure) - np.vdot(known, gathered)
    assert abs(difference) < 1e-15 * pressure.size * work


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_blocks_of_rows_give_what_the_whole_gives(
    shape: tuple[int, int], elongation: float, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    contact = island(shape)
    known, pressure = np.random.default_rng(7).standard_normal((2, *shape))
    known *= contact
    whole = Extension(contact, elongation)
    expected = whole(known), whole.transposed(pressure.copy())
    monkeypatch.setattr(rows, "BLOCK", 8)
    with using(cs.Cpu(threads)):
        extension = Extension(contact, elongation)
        np.testing.assert_array_equal(extension(known), expected[0])
        np.testing.assert_array_equal(extension.transposed(pressure.copy()), expected[1])


def stiffness_ratios(cells: int, contact: Array, seen: Array) -> Array:
    """Eigenvalues of the approximate inverse times the operator, both on pressures without a resultant."""
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    operator = cs.convolution(1.0, cs.Grid((cells, cells), (1.0, 1.0)), both, datum=1.0)
    invert = operator.approximate_inverse()
    where = contact > 0
    compliance, stiffness = [], []
    for unit in np.eye(where.size)[where.ravel()].reshape(-1, cells, cells):
        compliance.append(operator(unit)[where])
        stiffness.append(invert(unit, seen)[where])
    count = len(compliance)
    balanced = np.linalg.svd(np.ones((1, count)))[2][1:].T
    first, second = (balanced.T @ np.array(each) @ balanced for each in (stiffness, compliance))
    return np.sort(np.linalg.eigvals(first @ second).real)


def test_a_contact_in_pieces_is_not_taken_for_softer_nor_much_stiffer_than_it_is() -> None:
    """The extension's energy is not below the least, and within a small factor whatever the cells."""
    largest = []
    for cells in (8, 16, 32):
        contact = island((cells, cells), 0.5)
        ratios = stiffness_ratios(cells, contact, contact)
        assert ratios[0] > 1 - 1e-9
        largest.append(ratios[-1])
        # with zeros outside, the longest wave seems as stiff as the shortest
        zeros = stiffness_ratios(cells, contact, np.ones_like(contact))
        assert zeros[-1] > cells / 10
    assert max(largest) < 1.3
