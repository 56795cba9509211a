"""What a march says of its frames, of numbers that are written here."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

import contactstudy as cs
from contactstudy.evolution.evolution import Frame, Trajectory

# Cells of 2 m by 3 m.
GRID = cs.Grid((4, 1), (8.0, 3.0))
FIRST = Frame(
    time=0.5, load=3.0, pressure=np.array([0, 7.0, 0, 0])[:, None], gap=np.zeros((4, 1)),
    approach=0.25, fields={}, status=cs.Status.CONVERGED, residual=2e-9, step_error=0.03, grid_error=0.004,
    steps=2, iterations=10, convolutions=12.5,
)  # fmt: skip
FRAMES = (
    FIRST,
    replace(
        FIRST, time=1.5, load=5.0, pressure=np.array([0, 4.0, 9.0, 2.0])[:, None],
        gap=np.ones((4, 1)), status=cs.Status.STALLED, residual=8e-9, step_error=0.07, grid_error=0.009,
    ),
    replace(FIRST, time=2.5, steps=3, iterations=20, convolutions=30.0, residual=5e-9),
    replace(
        FIRST, time=4.0, load=6.0, pressure=np.array([0, 3.0, 5.0, 0])[:, None], approach=0.125,
        step_error=0.05, grid_error=0.006,
    ),
)  # fmt: skip


def evolution(*frames: Frame) -> Trajectory:
    return Trajectory(SimpleNamespace(grid=GRID), frames, 7, 1, None)  # type: ignore[arg-type]


FOUR = evolution(*FRAMES)


def test_each_instant_has_its_numbers_and_the_worst_of_them_is_said() -> None:
    assert FOUR.times.tolist() == [0.5, 1.5, 2.5, 4.0]
    assert FOUR.loads.tolist() == [3, 5, 3, 6]
    assert FOUR.peak_pressure.tolist() == [7, 9, 7, 5]
    assert FOUR.contact_area.tolist() == [6, 18, 6, 12]
    assert FOUR.pressure[1, :, 0].tolist() == [0, 4, 9, 2]
    assert FOUR.gap[:, 0, 0].tolist() == [0, 1, 0, 0]
    assert (FOUR.residual, FOUR.step_error, FOUR.grid_error) == (8e-9, 0.07, 0.009)
    assert (FOUR.steps, FOUR.iterations, FOUR.convolutions) == (9, 50, 67.5)
    assert FOUR.status is cs.Status.STALLED
