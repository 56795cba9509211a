"""The stiffness of a contact by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from studies.scene_study.measures import RESIDUAL, normal_stiffness


class Dense:
    """An operator that is a matrix over six cells."""

    # cells as unlike as these are not solved in one step
    matrix = 1.0 + np.diag([1.0, 3.0, 10.0, 2.0, 30.0, 6.0])

    def __call__(self, pressure: np.ndarray) -> np.ndarray:
        return (self.matrix @ pressure.ravel()).reshape(pressure.shape)

    def approximate_inverse(self) -> Any:
        return SimpleNamespace(extension=Extension)


class Extension:
    """One that knows of no other cells."""

    def __init__(self, contact: np.ndarray) -> None:
        self.contact = contact

    def __call__(self, displacement: np.ndarray) -> np.ndarray:
        return displacement

    def pressure(self, extended: np.ndarray) -> np.ndarray:
        return np.asarray(self.contact * extended / 4)


@pytest.mark.parametrize("touching", [[2], [0, 5], [0, 1, 2, 4], [0, 1, 2, 3, 4, 5]])
def test_stiffness_is_what_moves_the_cells_in_contact_alike(touching: list[int]) -> None:
    """The sum of the pressures that move all of them by one, by a dense solve."""
    pressure = np.zeros((3, 2))
    pressure.ravel()[touching] = 1 + np.arange(len(touching))
    problem = SimpleNamespace(
        constraint=SimpleNamespace(free=lambda given: np.where(given > 0, 1.0, 0.0)),
        operator=Dense(),
        grid=cs.Grid((3, 2), (6.0, 5.0)),
    )
    solution: Any = SimpleNamespace(problem=problem, pressure=pressure)
    inside = Dense.matrix[np.ix_(touching, touching)]
    carried = np.linalg.solve(inside, np.ones(len(touching))).sum()
    # cells of 5 m^2, over 5 m of length; the energy errs by the square of what the iteration leaves, times how
    # much softer than the mean a cell is, 30 over 8.7
    error = 4 * RESIDUAL**2
    wanted = carried * 5 / 5
    assert normal_stiffness(solution) == pytest.approx(wanted, rel=error)
    longer = SimpleNamespace(**(vars(problem) | {"grid": cs.Grid((3, 2), (12.0, 7.0))}))
    solution = SimpleNamespace(problem=longer, pressure=pressure)
    # cells of 4 m by 3.5 m over 7 m
    assert normal_stiffness(solution) == pytest.approx(carried * 14 / 7, rel=error)
    none: Any = SimpleNamespace(problem=problem, pressure=0 * pressure)
    assert np.isnan(normal_stiffness(none))


OWN = 0.5
PROBLEM: Any = SimpleNamespace(operator=SimpleNamespace(self_compliance=OWN))
