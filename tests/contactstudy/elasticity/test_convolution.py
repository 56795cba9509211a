import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactstudy as cs

ALONG = [
    cs.ZeroPadding(), cs.DuplicatedPadding(), cs.Superposition(2), cs.CircularSuperposition(2), cs.ExactPeriodicity(),
]  # fmt: skip
BOTH = [
    (cs.ExactPeriodicity(), cs.ZeroPadding()), (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
    (cs.CircularSuperposition(1), cs.Superposition(2)), (cs.DuplicatedPadding(), cs.ExactPeriodicity()),
    (cs.CircularSuperposition(0), cs.CircularSuperposition(0)),
]  # fmt: skip
PADDINGS: list[cs.Padding | cs.Paddings] = [*ALONG, *BOTH]
CELLS = [(8, 6), (7, 5), (16, 1), (3, 13)]


@pytest.mark.parametrize("padding", PADDINGS, ids=str)
@pytest.mark.parametrize("cells", CELLS, ids=str)
def test_operator_is_symmetric(cells: tuple[int, int], padding: cs.Padding | cs.Paddings) -> None:
    a, b = np.random.default_rng(1).standard_normal((2, *cells))
    apply = cs.convolution(2.0, cs.Grid(cells, (1.0, 0.7)), padding, datum=1.0)
    scale = np.abs(apply(np.abs(a))).max() * np.abs(b).sum()
    assert abs(np.vdot(b, apply(a)) - np.vdot(a, apply(b))) < 1e-15 * a.size * scale


@pytest.mark.parametrize("across", ALONG, ids=str)
@pytest.mark.parametrize("along", ALONG, ids=str)
def test_axes_choose_by_themselves(across: cs.Padding, along: cs.Padding) -> None:
    a = np.random.default_rng(1).standard_normal((6, 5))
    grid, turned = cs.Grid((6, 5), (1.0, 0.7)), cs.Grid((5, 6), (0.7, 1.0))
    straight = cs.convolution(2.0, grid, (across, along), datum=1.0)(a)
    sideways = cs.convolution(2.0, turned, (along, across), datum=1.0)(a.T).T
    assert_allclose(straight, sideways, rtol=0, atol=4e-15 * np.abs(straight).max())


def test_one_cell_along_the_length_is_plane_strain() -> None:
    """The line load's logarithm, averaged over a strip (Johnson 1985, sect. 2.3)."""
    nx, dx = 9, 0.25
    grid = cs.Grid(cells=(nx, 1), extent=(nx * dx, 3.0))
    apply = cs.convolution(2.0, grid, cs.ExactPeriodicity(), datum=0.5)
    unit = np.zeros((nx, 1))
    unit[2] = 1.0
    edges = (grid.x[:, None] - grid.x[2]) + np.array([0.5, -0.5]) * dx
    primitive = edges * np.log(np.abs(edges) / 0.5) - edges
    expected = -2 / (np.pi * 2.0) * (primitive[:, 0] - primitive[:, 1])
    assert_allclose(apply(unit)[:, 0], expected, rtol=0, atol=1e-15)


def test_a_datum_shifts_the_displacement_alone() -> None:
    """Of infinitely many images along y, by the line load over pi E*, for each image across."""
    pressure = np.random.default_rng(1).standard_normal((8, 6))
    load = pressure.mean()  # over a width of 1
    for across, images in ((cs.ZeroPadding(), 1), (cs.CircularSuperposition(1), 3)):
        near, far = (
            cs.convolution(2.0, cs.Grid((8, 6), (1.0, 0.7)), (across, cs.ExactPeriodicity()), datum)
            for datum in (1.0, 3.0)
        )
        shift = images * 2 * load * np.log(3.0) / (np.pi * 2.0)
        assert_allclose(far(pressure) - near(pressure), shift, rtol=1e-11)
