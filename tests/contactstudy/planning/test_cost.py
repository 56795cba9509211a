from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.planning.cost import padded_points
from contactstudy.planning.forecast import forecast_of_grid
from contactstudy.planning.grid_requirements import grid_requirements
from tests.conftest import LineContact


@pytest.mark.parametrize(
    "padding",
    [
        cs.ExactPeriodicity(),
        cs.Superposition(1),
        (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
        (cs.ExactPeriodicity(), cs.ZeroPadding()),
    ],
    ids=repr,
)
@pytest.mark.parametrize("cells", [(64, 32), (67, 31), (128, 1)], ids=str)
def test_points_are_those_of_the_operator(
    cells: tuple[int, int], padding: cs.Padding | tuple[cs.Padding, cs.Padding]
) -> None:
    grid = cs.Grid(cells, (1.0, 1.0))
    assert padded_points(grid, padding) == cs.convolution(1.0, grid, padding, 1.0).transform_size


def test_a_crowned_roller_needs_cells_across_and_few_along(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    length = 60 * a
    shapes = (
        *line_contact.scene.shapes,
        cs.Crown.of_drop(2 * a**2 / line_contact.hertz.radius, length),
    )
    scene = replace(line_contact.scene, shapes=(*shapes, cs.FiniteLength(length)))
    requirements = grid_requirements(scene)
    grid = cs.Grid((32, 64), (4 * a, length))
    found = forecast_of_grid(scene, requirements, grid)
    assert found.errors[0] > 3 * found.errors[1]
    # against the same on four times as many cells either way
    fine = cs.solve(
        scene.problem(cs.Grid((128, 256), grid.extent), requirements.padding()), tolerance=1e-6
    )
    means = fine.pressure.reshape(32, 4, 64, 4).mean(axis=(1, 3))
    pressure = cs.solve(scene.problem(grid, requirements.padding())).pressure
    assert found.error / 4 <= np.abs(pressure - means).sum() / means.sum() <= found.error
