"""What small solutions say of a larger solve: their sizes, the parts of the error along each axis, and the seconds."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.planning.cost import memory
from contactstudy.planning.grid_requirements import requirements_of
from contactstudy.planning.grid_search import affordable, forecast
from tests.conftest import LineContact

EXACT = cs.ExactPeriodicity()


def test_a_crowned_roller_needs_cells_across_and_hardly_any_along(
    line_contact: LineContact,
) -> None:
    a = line_contact.hertz.half_width
    length = 60 * a
    shapes = (
        *line_contact.scene.shapes,
        cs.Crown.of_drop(2 * a**2 / line_contact.hertz.radius, length),
    )
    scene = replace(line_contact.scene, shapes=(*shapes, cs.FiniteLength(length)))
    requirements = requirements_of(scene)
    grid = cs.Grid((32, 64), (4 * a, length))
    found = forecast(scene, requirements, grid)
    assert found.errors[0] > 3 * found.errors[1]
    # against the same on four times as many cells either way
    fine = cs.solve(
        scene.problem(cs.Grid((128, 256), grid.extent), requirements.padding()), tolerance=1e-6
    )
    means = fine.pressure.reshape(32, 4, 64, 4).mean(axis=(1, 3))
    pressure = cs.solve(scene.problem(grid, requirements.padding())).pressure
    assert found.error / 4 <= np.abs(pressure - means).sum() / means.sum() <= found.error


def test_a_grid_that_memory_does_not_hold_is_made_the_finest_that_it_holds() -> None:
    grid = cs.Grid((1024, 512), (1.0, 1.0))
    assert affordable(grid, EXACT, memory(grid, EXACT)) == grid
    most = memory(cs.Grid((512, 256), (1.0, 1.0)), EXACT)
    found = affordable(grid, EXACT, most)
    assert memory(found, EXACT) <= most
    # a hundredth is left for rounding, and a step more where that was not enough
    assert 0.95 * 512 <= found.cells[0] <= 512
    assert found.cells[0] / found.cells[1] == pytest.approx(2, rel=0.02)
    line = affordable(
        cs.Grid((4096, 1), (1.0, 1.0)), EXACT, memory(cs.Grid((1000, 1), (1, 1)), EXACT)
    )
    assert line.cells[1] == 1
    assert 0.95 * 1000 <= line.cells[0] <= 1000
    two = affordable(
        cs.Grid((4096, 2), (1.0, 1.0)), EXACT, memory(cs.Grid((1000, 2), (1, 1)), EXACT)
    )
    assert two.cells[1] == 2
    # two cells across are the fewest
    fewest = cs.Grid((2, 1), (1.0, 1.0))
    assert affordable(cs.Grid((8, 1), (1.0, 1.0)), EXACT, memory(fewest, EXACT)) == fewest
