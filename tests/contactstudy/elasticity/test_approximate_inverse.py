import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import fields
from contactstudy.domain.fields import Array
from contactstudy.elasticity import convolution
from contactstudy.elasticity.approximate_inverse import (
    ELONGATED,
    BlockExtension,
    ExactInverse,
    SpectralInverse,
)

CASES = [
    ((16, 16), 1.0),
    ((13, 10), 1.0),
    ((12, 7), 30.0),
    ((9, 16), 0.02),
    ((25, 1), 1e3),
    ((2, 1), 1.0),
]


@pytest.fixture(autouse=True)
def no_exact_inverse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(convolution, "FEW", 0)


def island(shape: tuple[int, int], fraction: float = 0.3) -> Array:
    contact = (np.random.default_rng(5).random(shape) < fraction).astype(float)
    contact[0, 0] = 1
    return contact


def inverse(shape: tuple[int, int], elongation: float) -> SpectralInverse:
    """On a grid of cells so many times as long as wide, periodic along both axes."""
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    extent = shape[0] * 1.0, shape[1] * elongation
    found = cs.convolution(1.0, cs.Grid(shape, extent), both, datum=1.0).approximate_inverse()
    assert isinstance(found, SpectralInverse)
    return found


@pytest.fixture(params=["array operations", "blocks"])
def blocks(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whether grids that have blocks of 2 x 2 cells are extended by way of them."""
    if request.param == "blocks":
        pytest.importorskip("numba")
        monkeypatch.setattr(fields, "LARGE", 1)
    return bool(request.param == "blocks")


def by_blocks(shape: tuple[int, int], elongation: float) -> bool:
    return shape[0] % 4 == shape[1] % 4 == 0 and 1 / ELONGATED < elongation < ELONGATED


@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_what_is_known_in_the_contact_stays(
    shape: tuple[int, int],
    elongation: float,
    blocks: bool,  # noqa: FBT001
) -> None:
    contact = island(shape)
    known = np.random.default_rng(6).standard_normal(shape) * contact
    extension = inverse(shape, elongation).extension(contact)
    assert isinstance(extension, BlockExtension) == (blocks and by_blocks(shape, elongation))
    extended = extension(known)
    np.testing.assert_array_equal(extended * contact, known)
    # elsewhere stand means of it
    assert known.min() <= extended.min()
    assert extended.max() <= known.max()


@pytest.mark.usefixtures("blocks")
@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_a_rigid_shift_is_the_same_everywhere(shape: tuple[int, int], elongation: float) -> None:
    contact = island(shape)
    extended = inverse(shape, elongation).extension(contact)(contact)
    # the smallest weights are some roundings of a transform
    np.testing.assert_allclose(extended, 1, rtol=1e-12)


@pytest.mark.usefixtures("blocks")
@pytest.mark.parametrize(("shape", "elongation"), CASES, ids=str)
def test_the_transposed_map_is_the_transpose(shape: tuple[int, int], elongation: float) -> None:
    contact = island(shape)
    extension = inverse(shape, elongation).extension(contact)
    known, pressure = np.random.default_rng(7).standard_normal((2, *shape))
    extended = extension(known * contact)
    gathered = extension.transposed(pressure.copy())
    np.testing.assert_array_equal(gathered * (1 - contact), 0)
    work = np.abs(pressure).sum() * np.abs(known).max()
    difference = np.vdot(extended, pressure) - np.vdot(known, gathered)
    assert abs(difference) < 1e-15 * pressure.size * work


def stiffness_ratios(cells: int, contact: Array, seen: Array) -> Array:
    """Eigenvalues of the approximate inverse times the operator, both on pressures without a resultant."""
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    operator = cs.convolution(1.0, cs.Grid((cells, cells), (1.0, 1.0)), both, datum=1.0)
    extension = operator.approximate_inverse().extension(seen)
    where = contact > 0
    compliance, stiffness = [], []
    for unit in np.eye(where.size)[where.ravel()].reshape(-1, cells, cells):
        compliance.append(operator(unit)[where])
        stiffness.append(extension.pressure(extension(unit))[where])
    count = len(compliance)
    balanced = np.linalg.svd(np.ones((1, count)))[2][1:].T
    first, second = (balanced.T @ np.array(each) @ balanced for each in (stiffness, compliance))
    return np.sort(np.linalg.eigvals(first @ second).real)


@pytest.mark.whole
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


def test_one_row_of_few_cells_is_solved_for_the_pressure_of_its_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Whatever the datum: a constant in the operator is felt by the resultant alone."""
    monkeypatch.undo()
    contact = island((24, 1), 0.5)
    cells = contact[:, 0] > 0
    known = np.random.default_rng(6).standard_normal((24, 1)) * contact
    for datum in (1e-3, 1.0, 1e3):
        operator = cs.convolution(
            2.0, cs.Grid((24, 1), (24.0, 5.0)), cs.ExactPeriodicity(), datum=datum
        )
        inverse = operator.approximate_inverse()
        assert isinstance(inverse, ExactInverse)
        extension = inverse.extension(contact)
        extended = extension(known)
        np.testing.assert_allclose(extended * contact, known, atol=1e-11)
        closing = extension.pressure(extended)
        np.testing.assert_array_equal(closing[~cells], 0)
        # it makes that displacement but for a shift of all cells
        shift = operator(closing) - extended
        np.testing.assert_allclose(shift, shift.mean(), rtol=0, atol=1e-11)


def test_a_contact_of_all_cells_is_extended_by_nothing() -> None:
    found = inverse((8, 6), 1.0)
    known = np.random.default_rng(6).standard_normal((8, 6))
    extension = found.extension(np.ones((8, 6)))
    np.testing.assert_array_equal(extension(known), known)
    np.testing.assert_array_equal(extension.pressure(known), found.pressure(known))
    assert found.work == 2 * 48
