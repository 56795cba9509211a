import pickle
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs
from contactstudy.elasticity import transforms as available
from contactstudy.elasticity.transforms import SciPy, Transforms

KINDS = [SciPy(), *([available.Ducc()] if find_spec("ducc0") else [])]

SIZES = [
    ((8, 6), (16, 6)),
    ((8, 6), (16, 12)),
    ((7, 5), (14, 10)),
    ((5, 1), (10, 1)),
    ((9, 7), (9, 7)),
]


@pytest.mark.parametrize("transforms", KINDS, ids=lambda kind: type(kind).__name__)
@pytest.mark.parametrize(("cells", "padded"), SIZES)
def test_transforms_are_those_of_the_whole_padded_field(
    cells: tuple[int, int], padded: tuple[int, int], transforms: Transforms
) -> None:
    field = np.random.default_rng(3).standard_normal(cells)
    kept = field.copy()
    whole = np.zeros(padded)
    whole[: cells[0], : cells[1]] = field
    work = np.full((padded[0], padded[1] // 2 + 1), np.nan, dtype=complex)
    waves = transforms.forward(field, padded, work)
    assert_allclose(waves, np.fft.rfft2(whole), rtol=0, atol=1e-13)
    assert (field == kept).all()
    assert_allclose(transforms.backward(waves, cells, padded), field, rtol=0, atol=1e-14)


def test_an_operator_serves_several_threads_and_travels() -> None:
    grid = cs.Grid(cells=(64, 48), extent=(1.0, 0.7))
    operator = cs.convolution(1.0, grid, cs.ExactPeriodicity(), datum=1.0)
    fields = np.random.default_rng(4).random((40, 64, 48))
    alone = [operator(field) for field in fields]
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(operator, fields))
    elsewhere = pickle.loads(pickle.dumps(operator))
    for one, other, field in zip(alone, together, fields, strict=True):
        assert (one == other).all()
        assert (elsewhere(field) == one).all()
