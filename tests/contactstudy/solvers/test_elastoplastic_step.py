"""A step in load of bodies that yield, and the linear equations in it, beside dense algebra."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.solvers.plasticity.elastoplastic_step import solve_elastoplastic_step
from contactstudy.solvers.plasticity.yielding_bodies import (
    SQRT_TWO_THIRDS,
    Hardening,
    YieldingBodies,
)

GRID = cs.Grid((6, 1), (12.0, 3.0))


class Local:
    """A body whose strain takes ``fraction`` of 2 G from its own cell's stress; pressure is borne in one direction."""

    def __init__(self, first: int, last: int, edges: tuple[float, ...], young: float) -> None:
        self.volume, self.moduli = Volume(GRID, first, last, edges), Moduli(young, 0.25)
        self.takes = 0.5 * 2 * self.moduli.shear

    @property
    def self_blocks(self) -> np.ndarray:
        return np.tile(self.takes * np.eye(3), (self.volume.shape[0], 1, 1))

    def stress_of_pressure(self, pressure: np.ndarray) -> np.ndarray:
        below = np.broadcast_to(pressure[self.volume.rows], self.volume.shape)
        depth = np.array([1.0, 0.5, 0.25])[: self.volume.shape[0], None, None]
        return np.stack([0.6 * below * depth, -0.8 * below * depth, 0 * below])

    def stress_of_strain(self, strain: np.ndarray) -> np.ndarray:
        return self.takes * strain

    def residual_displacement(self, strain: np.ndarray) -> np.ndarray:
        found = np.zeros(GRID.cells)
        found[self.volume.rows] = strain.sum(axis=(0, 1))
        return found


FIRST, SECOND = Local(1, 4, (0.0, 1.0, 3.0), 200.0), Local(2, 4, (0.0, 2.0), 100.0)

BODIES = YieldingBodies((FIRST, SECOND), (Hardening(3.0, 20.0, 10.0), Hardening(2.0, 0.0, 0.0)))  # type: ignore[arg-type]

PRESSURE = np.array([0, 4.0, 6.0, 1.0, 0, 0])[:, None]


def contact(_: np.ndarray) -> Any:
    problem = SimpleNamespace(undeformed_gap=np.zeros(GRID.cells))
    return SimpleNamespace(pressure=PRESSURE, displacement=np.zeros(GRID.cells), problem=problem)


def stepped(tolerance: float, before: np.ndarray | None = None, around: Any = None) -> Any:
    start = np.zeros((3, 8)) if before is None else before
    return solve_elastoplastic_step(
        BODIES, contact, lambda _: None, start, np.zeros(8), tolerance, around
    )


# |stress| of each cell: two layers of three cells, then two cells; 2 G is 160 and 80
SIZE = np.array([4, 6, 1, 2, 3, 0.5, 6, 1])

LIMIT = SQRT_TWO_THIRDS * np.array([3.0] * 6 + [2.0] * 2)

TWICE_SHEAR = np.array([160.0] * 6 + [80.0] * 2)

SLOPE = np.array([20.0] * 6 + [0.0] * 2)

FLOW = np.maximum(SIZE - LIMIT, 0) / (0.5 * TWICE_SHEAR + SLOPE)


def test_each_cell_flows_until_its_stress_is_on_the_yield_surface() -> None:
    found = stepped(1e-12)
    direction = np.array([0.6, -0.8, 0.0])[:, None]
    np.testing.assert_allclose(found.strain, FLOW * direction, atol=1e-12)
    np.testing.assert_allclose(found.flow, SQRT_TWO_THIRDS * FLOW, atol=1e-12)
    assert found.residual <= 1e-12
    # linear hardening along a straight path: one step of Newton, and one solution of the contact for it
    assert found.iterations == 1
    assert len(found.contacts) == 2


def test_what_is_elastic_takes_no_iteration_and_keeps_its_strain() -> None:
    before = 1e-9 * np.ones((3, 8)) * (SIZE < 1.5)
    quiet = solve_elastoplastic_step(
        YieldingBodies(BODIES.operators, (Hardening(1e3, 0, 0), Hardening(1e3, 0, 0))),
        contact, lambda _: None, before, np.zeros(8), 1e-12,
    )  # fmt: skip
    assert (quiet.iterations, quiet.residual) == (0, 0.0)
    np.testing.assert_array_equal(quiet.strain, before)


def test_stress_from_outside_adds_to_that_of_the_pressure() -> None:
    around = np.zeros((3, 8))
    around[:, 2] = np.array([0.6, -0.8, 0.0]) * 5
    found = stepped(1e-12, around=around)
    wanted = (6 - LIMIT[2]) / (0.5 * 160 + 20)
    assert found.flow[2] == pytest.approx(SQRT_TWO_THIRDS * wanted)
    assert np.delete(found.flow, 2) == pytest.approx(np.delete(SQRT_TWO_THIRDS * FLOW, 2))
