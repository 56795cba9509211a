from dataclasses import replace

import numpy as np

import contactstudy as cs
from tests.conftest import LineContact

GRID = cs.Grid(cells=(16, 8), extent=(1e-3, 5e-4))
WAVE = cs.Waviness(amplitude=1e-6, across=3e-4, along=2.5e-4, phase=0.3)


def test_a_wave_across_is_one_profile_along_the_length() -> None:
    wave = replace(WAVE, along=np.inf)
    assert wave.gap(GRID).shape == (16, 1)
    expected = 1e-6 * np.cos(2 * np.pi * GRID.x / 3e-4 + 0.3)
    np.testing.assert_allclose(wave.gap(GRID)[:, 0], expected, rtol=0, atol=1e-20)


def test_a_wave_along_is_the_same_all_across() -> None:
    gap = replace(WAVE, across=np.inf).gap(GRID)
    expected = 1e-6 * np.cos(2 * np.pi * GRID.y / 2.5e-4 + 0.3)
    np.testing.assert_allclose(gap, np.broadcast_to(expected, (16, 8)), rtol=0, atol=1e-20)


def test_no_amplitude_is_the_scene_without_waves(line_contact: LineContact) -> None:
    grid = line_contact.grid((16, 8), 1.0)
    flat = cs.Waviness(amplitude=0.0, along=grid.period / 2)
    assert flat.gap(grid).shape == (16, 1)
    wavy = replace(line_contact.scene, shapes=(*line_contact.scene.shapes, flat))
    solutions = [
        cs.solve(scene.problem(grid, cs.ExactPeriodicity())) for scene in (line_contact.scene, wavy)
    ]
    np.testing.assert_array_equal(solutions[0].pressure, solutions[1].pressure)
