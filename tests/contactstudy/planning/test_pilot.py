"""What small solutions say of a larger solve: their sizes, the parts of the error along each axis, and the seconds."""

from dataclasses import replace

import numpy as np

import contactstudy as cs
from contactstudy.planning.grid_requirements import requirements_of
from contactstudy.planning.grid_search import forecast
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
