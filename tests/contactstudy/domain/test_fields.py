import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import device
from contactstudy.domain import fields as rows
from contactstudy.domain.device import Library, using
from contactstudy.domain.fields import (
    in_blocks,
    inner,
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


@pytest.mark.parametrize("cell", [None, (0, 0), (98, 8)])
def test_fields_are_equal_unless_a_cell_differs(cell: tuple[int, int] | None) -> None:
    first = np.random.default_rng(1).random((99, 9))
    second = first.copy()
    if cell:
        second[cell] += 1
    assert rows.equal(first, second) == (cell is None)


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


def test_a_processor_has_one_thread_unless_told_and_a_library_s_arrays_are_left_to_it() -> None:
    assert cs.Cpu() == cs.Cpu(1)
    with using(cs.Cpu(3)):
        assert device.threads() == 3
    with using(Library(np)):  # type: ignore[arg-type]
        assert device.threads() == 1


@pytest.mark.parametrize("threads", [0, -1, 1.5, True, None])
def test_no_thread_is_refused(threads: object) -> None:
    with pytest.raises(
        cs.InvalidInput, match=r"^Cpu\.threads is .*: it must be a whole number of at least 1"
    ):
        cs.Cpu(threads)  # type: ignore[arg-type]
