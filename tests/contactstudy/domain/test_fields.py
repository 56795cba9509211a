import threading

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import device
from contactstudy.domain import fields as rows
from contactstudy.domain.device import Library, using
from contactstudy.domain.fields import (
    in_blocks,
    in_parts,
    inner,
    mean_over,
    product,
    total,
)

SHAPES = [(1, 1), (7, 3), (64, 64), (1001, 1), (2, 500)]


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "BLOCK", 64)
    monkeypatch.setattr(rows, "PART", 64)


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_blocks_cover_all_rows_once_and_in_order(shape: tuple[int, int], threads: int) -> None:
    field = np.arange(shape[0])[:, None] + np.zeros(shape)
    with using(cs.Cpu(threads)):
        blocks = in_blocks(lambda block: block[:, 0], field)
    assert [row for block in blocks for row in block] == [*range(shape[0])]
    assert all(block[0] % 2 == 0 for block in blocks)


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_sums_are_the_same_to_the_last_bit_on_any_number_of_threads(shape: tuple[int, int]) -> None:
    a, b = np.random.default_rng(1).standard_normal((2, *shape))
    sums = set()
    for threads in (1, 2, 3):
        with using(cs.Cpu(threads)):
            sums.add((inner(a, b), total(a)))
    assert len(sums) == 1
    # rounding of as many products
    assert sums.pop()[0] == pytest.approx((a * b).sum(), abs=a.size * 1e-15)


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_parts_cover_all_rows_once(shape: tuple[int, int], threads: int) -> None:
    parts: list[slice] = []
    with using(cs.Cpu(threads)):
        in_parts(parts.append, shape)
    parts.sort(key=lambda part: part.start)
    assert [row for part in parts for row in range(part.start, part.stop)] == [*range(shape[0])]
    assert all(part.start % 2 == 0 for part in parts)
    # a thread has many cells or none, and no part waits for another
    assert len(parts) <= min(threads, max(1, shape[0] * shape[1] // 64))


def test_large_fields_have_a_part_for_each_thread_and_the_first_is_largest() -> None:
    parts: list[slice] = []
    with using(cs.Cpu(3)):
        in_parts(parts.append, (99, 9))
    assert max(part.stop - part.start for part in parts if part.start == 0) == 36
    assert sorted(part.stop - part.start for part in parts) == [29, 34, 36]


@pytest.mark.parametrize("cell", [None, (0, 0), (98, 8)])
def test_fields_are_equal_unless_a_cell_differs(cell: tuple[int, int] | None) -> None:
    first = np.random.default_rng(1).random((99, 9))
    second = first.copy()
    if cell:
        second[cell] += 1
    assert rows.equal(first, second) == (cell is None)


def test_what_a_part_raises_is_raised() -> None:
    def refuse(part: slice) -> None:
        if part.start > 0:
            raise ZeroDivisionError

    with using(cs.Cpu(2)), pytest.raises(ZeroDivisionError):
        in_parts(refuse, (100, 9))


def test_blocks_of_blocks_wait_for_no_thread() -> None:
    """A block that is itself worked through in blocks must not need a thread that waits for it."""
    with using(cs.Cpu(2)):
        field = np.zeros((99, 9))
        nested = in_blocks(lambda _: sum(in_blocks(len, field)), field)
    assert set(nested) == {99}


def test_what_a_block_raises_is_raised() -> None:
    def refuse(block: np.ndarray) -> None:
        if block[-1, 0] == 99:
            raise ZeroDivisionError

    with using(cs.Cpu(2)), pytest.raises(ZeroDivisionError):
        in_blocks(refuse, np.arange(100.0)[:, None] + np.zeros((100, 9)))


def test_one_thread_starts_no_other() -> None:
    names = in_blocks(lambda _: threading.current_thread().name, np.zeros((100, 9)))
    assert set(names) == {threading.current_thread().name}


def test_a_processor_has_one_thread_unless_told_and_a_library_s_arrays_are_left_to_it() -> None:
    assert cs.Cpu() == cs.Cpu(1)
    with using(cs.Cpu(3)):
        assert device.threads() == 3
    with using(Library(np)):  # type: ignore[arg-type]
        assert device.threads() == 1


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, None])
def test_no_thread_is_refused(threads: object) -> None:
    with pytest.raises(
        cs.InvalidInput, match=r"^Cpu\.threads is .*: give a whole number of threads"
    ):
        cs.Cpu(threads)  # type: ignore[arg-type]


A = np.array([[1.0, -2.0, 3.0], [0.5, 4.0, -1.0]])
B = np.array([[2.0, 5.0, -1.0], [8.0, 0.25, 3.0]])


def test_sums_are_over_all_cells() -> None:
    assert inner(A, B) == 2 - 10 - 3 + 4 + 1 - 3
    assert total(A) == 5.5
    # more cells than are summed at once
    many = np.arange(2048.0).reshape(32, 64)
    assert inner(many, many) == 2047 * 2048 * 4095 / 6
    assert total(many) == 2047 * 1024


def test_a_mean_is_over_the_cells_that_are_chosen() -> None:
    cells = np.array([[1.0, 0, 1], [0, 0, 1]])
    assert mean_over(cells, A * cells) == 1


def test_a_product_is_that_of_matrices() -> None:
    assert product(A, B.T) == pytest.approx(np.array([[-11, 16.5], [22, 2]]))
