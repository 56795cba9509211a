"""Trials of coarse grids against a finer solution."""

from dataclasses import replace
from itertools import product
from math import inf, prod
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.coarser import change
from contactstudy.planning.grid_search import GridForecast
from contactstudy.planning.plan import needs_of
from contactstudy.planning.trials import FREE as FREE_CELLS
from contactstudy.planning.trials import _candidates, _difference, _expected, cheapest
from tests.conftest import LineContact

FREE = (cs.ZeroPadding(), cs.ZeroPadding())


def roller(contact: LineContact, drop: float, length: float) -> cs.Scene:
    """A roller of `length` half-widths whose ends drop by `drop` times what Hertz's contact flattens."""
    a = contact.hertz.half_width
    shapes: tuple[cs.Shape, ...] = (cs.FiniteLength(length * a),)
    if drop:
        flattened = a**2 / (2 * contact.hertz.radius)
        shapes += (cs.Crown.of_drop(drop * flattened, length * a),)
    return replace(contact.scene, shapes=(*contact.scene.shapes, *shapes))


@pytest.mark.parametrize(("drop", "length"), [(0.0, 12.0), (1.0, 40.0), (20.0, 20.0)])
def test_a_planned_roller_keeps_to_its_error_with_few_cells(
    drop: float, length: float, line_contact: LineContact
) -> None:
    scene, error = roller(line_contact, drop, length), 0.02
    plan = cs.plan(scene, error=error)
    assert any(reason.startswith("trials:") for reason in plan.reasons)
    nx, ny = plan.grid.cells
    finer = cs.Grid((8 * nx, 8 * ny), plan.grid.extent)
    fine = cs.solve(scene.problem(finer, plan.padding), tolerance=1e-5)

    def true_error(cells: tuple[int, int]) -> float:
        grid = cs.Grid(cells, plan.grid.extent)
        coarse = cs.solve(scene.problem(grid, plan.padding), tolerance=1e-5)
        return _difference(coarse, fine) if coarse.status is cs.Status.CONVERGED else inf

    assert true_error((nx, ny)) <= error
    # no grid of a third of its cells reaches the error
    counts = [6, 8, 11, 16, 22, 32, 45, 64]
    coarser = [
        cells for cells in product(counts, counts) if nx * ny / 8 < prod(cells) < nx * ny / 3
    ]
    assert coarser
    assert min(map(true_error, coarser)) > error


def test_a_trial_differs_as_on_the_same_width_though_it_is_narrower(
    line_contact: LineContact,
) -> None:
    scene, a = roller(line_contact, 2.0, 12.0), line_contact.hertz.half_width
    fine, same, narrow = (
        cs.solve(scene.problem(cs.Grid(cells, (width * a, 12 * a)), FREE), tolerance=1e-8)
        for cells, width in (((96, 96), 4.8), ((24, 24), 4.8), ((16, 24), 3.2))
    )
    assert _difference(same, fine) == pytest.approx(change(fine, same).l1, rel=1e-12)
    # cells of the same size and place, so the same pressure
    assert _difference(narrow, fine) == pytest.approx(_difference(same, fine), rel=1e-6)


def test_errors_of_trials_tell_which_axis_they_fall_along() -> None:
    """Forecast shares 2 and 1 hundredths, measured 1 (2 times 0.5) and 0: only the share across is real."""
    tried = [(0.02, 0.01, 0.01), (0.01, 0.04, 0.005), (0.04, 0.02, 0.02)]
    assert _expected(tried, 0.02, 0.01) == pytest.approx(0.01, rel=0.2)
    assert _expected(tried, 0.0, 0.1) < 0.3 * _expected(tried, 0.1, 0.0)
    # one trial says nothing of the axes: both shares are as much too large
    assert _expected([(0.02, 0.02, 0.01)], 0.0, 0.04) == pytest.approx(0.01, rel=1e-6)


def test_nothing_is_tried_where_a_law_holds_or_a_finer_grid_is_dear(
    line_contact: LineContact,
) -> None:
    a = line_contact.hertz.half_width

    def planned(cells: tuple[int, int], error: float) -> GridForecast:
        grid = cs.Grid(cells, (3.6 * a, 12 * a))
        return GridForecast(
            grid, (error, 0.0), (1.0, 1.0), (6, 6), cut_off=False, message="", seconds=1.0
        )

    for scene, forecast in (
        (line_contact.scene, planned((64, 1), 0.01)),
        (roller(line_contact, 1.0, 12.0), planned((512, 256), 0.01)),
        (roller(line_contact, 1.0, 12.0), planned((32, 32), 0.03)),  # out of reach
    ):
        assert cheapest(scene, needs_of(scene), forecast, 0.02) is forecast


def test_a_tried_grid_is_as_narrow_as_the_free_cells_beside_the_contact_allow() -> None:
    """By less than one cell of the reference on each side; a planned grid stays as it is."""
    fine = cs.Grid((100, 40), (10.0, 4.0))
    pressure = np.zeros(fine.cells)
    pressure[40:60] = 1.0
    width = 2.0
    reference: Any = SimpleNamespace(problem=SimpleNamespace(grid=fine), pressure=pressure)
    needs: Any = SimpleNamespace(roller=True, rough=False, finest=(1.0, 1.0))
    planned = GridForecast(
        cs.Grid((12, 8), (10.0, 4.0)),
        (0.0, 0.0),
        (1.0, 1.0),
        (6, 6),
        cut_off=False,
        message="",
        seconds=1.0,
    )
    tried = [one for one in _candidates(needs, planned, reference, 0.1) if one != planned.grid]
    assert {one.cells[0] for one in tried} > {6, 12}
    for one in tried:
        kept = 1 - FREE_CELLS / one.cells[0]
        assert one.extent[0] * kept >= width > (one.extent[0] - 2 * fine.cell[0]) * kept
    needs.rough = True
    assert {one.extent[0] for one in _candidates(needs, planned, reference, 0.1)} == {10.0}
