import os
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from importlib.util import find_spec

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.domain.device import using
from contactstudy.elasticity.transforms import Ducc, Transforms

KINDS = [Transforms(), *([Ducc()] if find_spec("ducc0") else [])]
SIZES = [((8, 6), (16, 6)), ((7, 5), (14, 10)), ((5, 1), (10, 1)), ((9, 7), (9, 7))]


@pytest.mark.cases(100)
@pytest.mark.parametrize("transforms", KINDS, ids=lambda kind: type(kind).__name__)
@pytest.mark.parametrize(("cells", "padded"), SIZES)
@pytest.mark.parametrize(("real", "threads"), [(np.float64, 1), (np.float32, 2)])
def test_transforms_are_those_of_the_whole_padded_field(
    cells: tuple[int, int], padded: tuple[int, int], transforms: Transforms, real: type[np.floating], threads: int
) -> None:
    field = np.random.default_rng(3).standard_normal(cells).astype(real)
    rounding = 50 * np.finfo(real).eps
    kept = field.copy()
    whole = np.zeros(padded)
    whole[: cells[0], : cells[1]] = field
    work = np.full((padded[0], padded[1] // 2 + 1), np.nan, dtype=np.result_type(real, 1j))
    with using(cs.Cpu(threads)):
        waves = transforms.forward(field, padded, work)
        # of sums of up to 192 numbers of size one
        assert_allclose(waves, np.fft.rfft2(whole), rtol=0, atol=10 * rounding)
        assert (field == kept).all()
        back = transforms.backward(waves, cells, padded)
    assert back.dtype == real
    assert_allclose(back, field, rtol=0, atol=rounding)


@pytest.mark.whole
@pytest.mark.skipif(not find_spec("ducc0"), reason="ducc0 is not installed")
def test_a_solve_has_the_threads_it_asks_for_whatever_the_environment_allows() -> None:
    """Where ducc0 itself would take one, and say nothing."""
    code = """
import ducc0, os, contactstudy as cs, numpy as np
from contactstudy.domain.device import using
operator = cs.convolution(1.0, cs.Grid((512, 384), (1.0, 0.7)), cs.ExactPeriodicity(), datum=1.0)
operator(np.ones((512, 384)))
assert ducc0.misc.thread_pool_size() == 1
with using(cs.Cpu(2)):
    operator(np.ones((512, 384)))
assert ducc0.misc.thread_pool_size() == os.cpu_count()
"""
    if not hasattr(import_module("ducc0").misc, "resize_thread_pool"):
        pytest.skip("this ducc0 cannot")
    allowed = os.environ | {"OMP_NUM_THREADS": "1", "DUCC0_NUM_THREADS": "1"}
    subprocess.run([sys.executable, "-c", code], env=allowed, check=True)


def test_an_operator_serves_several_threads_and_travels() -> None:
    grid = cs.Grid(cells=(64, 48), extent=(1.0, 0.7))
    operator = cs.convolution(1.0, grid, cs.ExactPeriodicity(), datum=1.0)
    fields = np.random.default_rng(4).random((40, 64, 48))
    alone = [operator(field) for field in fields]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(operator, fields))
    elsewhere = pickle.loads(pickle.dumps(operator))
    np.testing.assert_array_equal(together, alone)
    np.testing.assert_array_equal([elsewhere(field) for field in fields], alone)
