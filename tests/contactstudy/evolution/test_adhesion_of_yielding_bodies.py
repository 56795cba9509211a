"""Adhesion of a body that yields, in units of E* and of the radius of a cylinder of 1 mm."""

from dataclasses import replace
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.contactstudy.evolution.creeping import EXACT, RIGID

NU, MODULUS, RADIUS, WORK = 0.3, 2e11, 1e-3, 1.0
YOUNG = MODULUS * (1 - NU**2)
YIELD, HARDENING = 1.2e8, 0.02 * YOUNG
BODY, ELASTIC = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD, HARDENING), cs.HalfSpace(YOUNG, NU)
# Load of the line contact of Johnson, Kendall & Roberts [N/m], and the half-width under it by Hertz.
UNIT = (pi * MODULUS * WORK**2 * RADIUS) ** (1 / 3)
WIDTH = np.sqrt(8 * UNIT * RADIUS / (pi * MODULUS))
TIMES = (0.0, 0.25, 0.5, 0.75, 1.0)


def scene(solid: Any, work: float = WORK) -> cs.Scene:
    """Pressed to twice the unit of load in 1 s, then pulled by as much in 1 s more; a largest attraction of 2.5e8 Pa."""
    load = cs.LoadHistory((0.0, 1.0, 2.0), (0.05 * UNIT, 2 * UNIT, -2 * UNIT))
    return cs.Scene(load, (solid, RIGID), (cs.Cylinder(RADIUS),), adhesion=cs.Adhesion(work, range=4e-9))


@cache
def solved(scene: cs.Scene, times: tuple[float, ...] = TIMES) -> cs.Evolution:
    yields = isinstance(scene.solids[0], cs.ElasticPlasticHalfSpace)
    steps = cs.TimeSteps(times, error_estimator="none") if yields else times
    return cs.solve(scene, cs.Grid((64, 1), (6 * WIDTH, 1e-3)), EXACT, times=steps)


def test_a_vanishing_work_of_adhesion_leaves_the_contact_that_yields() -> None:
    """What the attraction changes is proportional to it."""
    load = cs.LoadHistory((0.0, 1.0), (0.05 * UNIT, 2 * UNIT))
    plain = solved(replace(scene(BODY), load=load, adhesion=None)).pressure[-1]
    changes = [np.abs(solved(scene(BODY, work)).pressure[-1] - plain).max() / plain.max() for work in (1e-3, 1e-4)]
    assert changes[1] < 2e-3
    assert changes[0] / changes[1] == pytest.approx(10, rel=0.1)


def test_pressure_and_attraction_are_in_equilibrium_and_keep_to_the_yield_surface() -> None:
    found = solved(scene(BODY))
    assert found.status is cs.Status.CONVERGED
    last, attraction = found.frames[-1], found.frames[-1].adhesion.attraction
    law = scene(BODY).adhesion.cohesive(MODULUS, 1.0)
    assert np.abs(attraction - law.traction(last.gap)).sum() < 1e-4 * attraction.sum()
    assert last.load_per_length == pytest.approx(2 * UNIT, rel=1e-6)
    (operator,) = found.trajectory.coupled.operators
    state = found.trajectory.frames[-1].coupled_state
    stress = operator.stress_of_pressure(last.pressure - attraction)
    stress -= operator.negative_residual_stress(state["plastic0"][:-1])
    fraction = np.sqrt(1.5 * (stress**2).sum(axis=0)) / (YIELD + HARDENING * state["plastic0"][-1])
    assert np.all(fraction < 1 + 1e-4)
    # cells that flow in this step are at their limit
    assert np.count_nonzero(fraction > 1 - 1e-4) > 20


@pytest.mark.whole
def test_a_body_that_has_yielded_holds_on_to_a_pull_that_takes_an_elastic_one_off() -> None:
    times = (*TIMES, 1.4, 1.6, 1.7, 1.74, 1.76, 1.8, 1.84, 1.88, 1.92, 2.0)
    yielding, elastic = (solved(scene(solid), times).quantities["pull_off"].value / UNIT for solid in (BODY, ELASTIC))
    assert yielding > 1.05 * elastic > 1


def test_stress_below_bodies_that_adhere_is_that_of_pressure_and_attraction() -> None:
    """Without a load both add up to nothing, and far below there is no stress."""
    deep = 50 * WIDTH
    adhesion = replace(scene(ELASTIC).adhesion, branch="from full contact")
    stress = (cs.SubsurfaceStress((1e-6, deep)),)
    held = replace(scene(ELASTIC), load=cs.LineLoad(0.0), adhesion=adhesion, outputs=stress)
    found = cs.solve(held, cs.Grid((128, 1), (6 * WIDTH, 1e-3)), EXACT)
    of_pressure = 2 * found.pressure.sum() * found.grid.cell_size[0] / (pi * deep)
    assert np.abs(found.derived["stress"].values[2, 1]).max() < 1e-3 * of_pressure
