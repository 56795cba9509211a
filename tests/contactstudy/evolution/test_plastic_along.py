from math import inf

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.evolution.integration.evolve import evolve
from contactstudy.evolution.states.plastic import PlasticState
from contactstudy.evolution.trajectory import Trajectory
from tests.contactstudy.evolution.test_plastic import (
    EXACT,
    NU,
    RADIUS,
    YIELD,
    YOUNG,
    half_width,
    load,
)

TIMES = (1.0, 2.0)


def pressed(*more: cs.Shape, times_yield: float = 2.5) -> cs.Scene:
    """A rigid cylinder pressed on a body and unloaded, in 1 s each."""
    body = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD, 0.02 * YOUNG)
    shapes = cs.Cylinder(RADIUS), *more
    return cs.Scene(
        cs.LoadHistory((0.0, *TIMES), (0.0, load(times_yield), 0.0)),
        (body, cs.HalfSpace(inf, 0)),
        shapes,
    )


def evolved(scene: cs.Scene, cells: tuple[int, int], period: float) -> Trajectory:
    """With cells of a sixth of the half-width, along a ``period`` in half-widths."""
    a = half_width(2.5)
    grid = cs.Grid(cells, (cells[0] * a / 6, period * a))
    return evolve(
        scene,
        grid,
        EXACT,
        times=TIMES,
        options=cs.SolveOptions(1e-7),
        error_estimator=cs.ErrorEstimator.NONE,
    )


@pytest.mark.whole
def test_a_wavy_cylinder_keeps_to_the_yield_surface_wherever_its_waves_begin() -> None:
    a = half_width(2.5)
    height = 0.3 * a**2 / (2 * RADIUS)
    found = {}
    for cells in (0, 3):
        waves = cs.Waviness(height, across=2.4 * a, along=2 * a, phase=-2 * np.pi * cells / 8)
        evolution = evolved(pressed(waves), (18, 8), 2.0)
        assert evolution.status is cs.Status.CONVERGED
        found[cells] = evolution_answer(evolution).to_dataset()
    loaded = found[3].isel(time=0)
    assert isinstance(evolution.coupled, PlasticState)
    (operator,) = evolution.coupled.operators
    state = evolution.frames[0].coupled_state
    stress = operator.stress_of_pressure(evolution.pressure[0])
    stress -= operator.negative_residual_stress(state["strain0"])
    von_mises = np.sqrt(1.5 * (stress**2).sum(axis=0))
    equivalent = loaded["equivalent_plastic_strain"].values[:, operator.volume.rows]
    limit = YIELD + 0.02 * YOUNG * equivalent
    assert np.all(von_mises < limit * (1 + 1e-6))
    flowing = equivalent > 1e-3 * YIELD / YOUNG
    assert np.abs(von_mises / limit - 1)[flowing].max() < 1e-6
    # it varies along, and shear along takes part
    along = equivalent.max(axis=(0, 1))
    assert along.max() > 1.05 * along.min() > 0
    strain = loaded["plastic_strain"]
    assert np.abs(strain.sel(component=["xx", "yy", "zz"]).sum("component")).max() < 1e-15
    assert np.abs(strain.sel(component=["xy", "yz"])).max() > 0.05 * np.abs(strain).max()
    for name in ("pressure", "plastic_strain", "residual_displacement"):
        moved = found[0][name].roll(y=3).values
        assert np.abs(found[3][name].values - moved).max() < 1e-6 * np.abs(moved).max()
