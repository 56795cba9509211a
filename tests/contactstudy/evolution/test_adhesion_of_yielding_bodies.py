"""Adhesion of a body that yields, in units of E* and of the radius of a cylinder of 1 mm."""

from dataclasses import replace
from functools import cache
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.states.plastic import PlasticState

NU, MODULUS, RADIUS, WORK = 0.3, 2e11, 1e-3, 1.0
YOUNG = MODULUS * (1 - NU**2)
YIELD, HARDENING = 1.2e8, 0.02 * YOUNG
RIGID = cs.HalfSpace(inf, NU)
# Load of the line contact of Johnson, Kendall & Roberts [N/m].
UNIT = (pi * MODULUS * WORK**2 * RADIUS) ** (1 / 3)
# Largest attraction of 2.5e8 Pa.
RANGE = 4e-9
GRID = cs.Grid((64, 1), (6 * np.sqrt(8 * UNIT * RADIUS / (pi * MODULUS)), 1e-3))
TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)


def scene(
    solid: cs.HalfSpace | cs.ElasticPlasticHalfSpace,
    work: float = WORK,
    last: float = 1.0,
) -> cs.Scene:
    """Pressed to twice the unit of load in 1 s, then to a `last` load in 1 s more."""
    load = cs.LoadHistory((0.0, 1.0, 2.0), (0.05 * UNIT, 2 * UNIT, last * UNIT))
    adhesion = cs.Adhesion(work, range=RANGE) if work else None
    return cs.Scene(load, (solid, RIGID), (cs.Cylinder(RADIUS),), adhesion=adhesion)


@cache
def solved(scene: cs.Scene, times: tuple[float, ...]) -> cs.Evolution:
    by_steps = cs.TimeSteps(times, error_estimator="none")
    steps = times if isinstance(scene.solids[0], cs.HalfSpace) else by_steps
    found = cs.solve(scene, GRID, cs.ExactPeriodicity(), times=steps)
    assert isinstance(found, cs.Evolution)
    return found


BODY = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD, HARDENING)


def test_a_vanishing_work_of_adhesion_leaves_the_contact_that_yields() -> None:
    """What the attraction changes is proportional to it."""
    plain = solved(scene(BODY, 0.0), TIMES).pressure[-1]
    changes = [
        np.abs(solved(scene(BODY, work), TIMES).pressure[-1] - plain).max() / plain.max() for work in (1e-3, 1e-4)
    ]
    assert changes[1] < 2e-3
    assert changes[0] / changes[1] == pytest.approx(10, rel=0.1)


def test_pressure_and_attraction_are_in_equilibrium_and_keep_to_the_yield_surface() -> None:
    found = solved(scene(BODY), TIMES)
    assert found.status is cs.Status.CONVERGED
    last = found.frames[-1]
    assert last.adhesion is not None
    law = cs.Adhesion(WORK, range=RANGE).cohesive(MODULUS, 1.0)
    attraction = last.adhesion.attraction
    assert np.abs(attraction - law.traction(last.gap)).sum() < 1e-4 * attraction.sum()
    assert last.load_per_length == pytest.approx(2 * UNIT, rel=1e-6)
    assert found.trajectory is not None
    plastic = found.trajectory.coupled
    assert isinstance(plastic, PlasticState)
    (operator,) = plastic.operators
    state = found.trajectory.frames[-1].coupled_state
    stress = operator.stress_of_pressure(last.pressure - attraction)
    stress -= operator.negative_residual_stress(state["strain0"])
    von_mises = np.sqrt(1.5 * (stress**2).sum(axis=0))
    limit = YIELD + HARDENING * state["equivalent0"]
    assert np.all(von_mises < limit * (1 + 1e-4))
    # cells that flow in this step are at their limit
    assert np.count_nonzero(von_mises > limit * (1 - 1e-4)) > 20


@pytest.mark.whole
def test_a_body_that_has_yielded_holds_on_to_a_pull_that_takes_an_elastic_one_off() -> None:
    pulls = (1.0, 1.4, 1.6, 1.7, 1.74, 1.76, 1.8, 1.84, 1.88, 1.92, 2.0)
    times = (*TIMES, *pulls[1:])
    yielding, elastic = (solved(scene(solid, last=-2.0), times) for solid in (BODY, cs.HalfSpace(YOUNG, NU)))
    forces = [found.quantities["pull_off"].value / UNIT for found in (yielding, elastic)]
    assert forces[0] > 1.05 * forces[1] > 1
    dent = yielding.quantities["dent_depth"]
    assert dent.value > 1e-9
    assert dent.bound == inf


def test_stress_below_bodies_that_adhere_is_that_of_pressure_and_attraction() -> None:
    """Without a load both add up to nothing, and far below there is no stress."""
    deep = 50 * np.sqrt(8 * UNIT * RADIUS / (pi * MODULUS))
    output = cs.SubsurfaceStress((1e-6, deep))
    held = replace(
        scene(cs.HalfSpace(YOUNG, NU)),
        load=cs.LineLoad(0.0),
        adhesion=cs.Adhesion(WORK, range=RANGE, branch="from full contact"),
        outputs=(output,),
    )
    grid = cs.Grid((128, 1), (6 * np.sqrt(8 * UNIT * RADIUS / (pi * MODULUS)), 1e-3))
    found = cs.solve(held, grid, cs.ExactPeriodicity())
    assert isinstance(found, cs.Contact)
    net = 2 * found.pressure.sum() * grid.cell_size[0] / (pi * deep)
    assert np.abs(found.derived["stress"].values[2, 1]).max() < 1e-3 * net
