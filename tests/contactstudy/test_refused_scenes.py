"""Effects that are refused beside each other, and grids and times for a scene, and how the sentence begins.

Pairs of effects stand in ``scene/test_pairs_of_effects.py``. ``*`` is any words.
"""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL
from tests.contactstudy.test_refused_values import COATED, EXACT, FREE, OIL, RIGID, SMOOTH, YIELDING, refused, smooth

CYLINDER, HISTORY = SMOOTH.shapes[0], cs.LoadHistory((0.0, 1.0), (1e5, 2e5))
CREEPING = cs.ViscoelasticHalfSpace(1e11, 0.3, ((1e11, 0.5),))
FLUID = cs.ViscoelasticHalfSpace(0.0, 0.3, ((1e11, 0.5),))
WAVES = cs.Waviness(1e-8, across=1e-4)
WEARS, TURNS = cs.Wear(1e-15, 0.1), cs.Wear(1e-15, 0.1, circumference=0.06)
ROLLS, PASSES = cs.Rolling(1.0), cs.Rolling(passes=1, distance=1e-4)
SLIP, FRETS = cs.PartialSlip(0.3, 1e4), cs.Fretting(0.3, (0.0, 1e4), times=(0.0, 1.0))
DRIVEN = cs.TractiveRolling(0.3, longitudinal=1e-3)
SPINS = cs.TractiveRolling(0.3, longitudinal=0.0, spin=5.0)
SOFT, ENDED = cs.HalfSpace(1e6, 0.5), cs.FreeFaces(STEEL, 0.01)
ADHESION = cs.Adhesion(work=0.05)
RANGED = replace(ADHESION, range=2e-6)
BELOW = (cs.SubsurfaceStress(),)
FILM = cs.Lubrication(OIL, 1.0)
UNIT, SQUARE = cs.Grid((16, 1), (4e-4, 1e-3)), cs.Grid((16, 16), (3e-4, 3e-4))
OILED = smooth(lubrication=FILM)
WIDE = cs.Grid((64, 1), (18 * SMOOTH.hertz.half_width, 1e-3))


def adhesive(adhesion: cs.Adhesion = RANGED, **changed: Any) -> cs.Scene:
    return smooth(**{"load": cs.LineLoad(2.0), "solids": (SOFT, RIGID), "adhesion": adhesion} | changed)


def oiled(moved: dict[str, Any], **changed: Any) -> cs.Scene:
    """The smooth contact with a film that moves, or is, otherwise."""
    return smooth(lubrication=replace(FILM, **moved), **changed)


BESIDE: list[tuple[str, Callable[[], cs.Scene]]] = [
    # loads
    ("TotalLoad.length is 0.02, *: leave it out",
     lambda: smooth(load=cs.TotalLoad(1e3, 0.02), shapes=(CYLINDER, cs.FiniteLength(0.01)))),
    ("LoadHistory.per_length[1] is -1.0: give a load per length of at least 0",
     lambda: smooth(load=cs.LoadHistory((0.0, 1.0), (1.0, -1.0)))),
    ("Scene.load is an Approach together with Scene.hardness",
     lambda: smooth(load=cs.Approach(1e-6), hardness=1e9)),
    ("Scene.hardness is 1000000000.0 together with *falls*give an ElasticPlasticHalfSpace",
     lambda: smooth(hardness=1e9, load=cs.LoadHistory((0.0, 1.0, 2.0), (1e5, 2e5, 1.9e5)))),
    # friction
    ("Scene.friction", lambda: smooth(friction=cs.Sliding)),
    ("*elastically dissimilar", lambda: smooth(friction=SLIP, solids=(STEEL, RIGID))),
    ("*that creep: creep of their coupling",
     lambda: smooth(friction=cs.Sliding(0.3), solids=(CREEPING, cs.HalfSpace(2e11, 0.3)))),
    ("*or TractiveRolling", lambda: smooth(friction=cs.Sliding(0.3), rolling=ROLLS, solids=(STEEL, RIGID))),
    ("*rolls by * of its widths", lambda: smooth(friction=DRIVEN, load=cs.SineLoad(1e5, 1e4, 1e4))),
    ("TractiveRolling.tangential", lambda: smooth(
        load=cs.SineLoad(1e5, 5e4, 1.0), friction=cs.TractiveRolling(0.3, tangential=0.18e5))),
    ("TractiveRolling.spin is 5.0 in a contact without end",
     lambda: smooth(friction=SPINS, shapes=(CYLINDER, replace(WAVES, along=1e-4)))),
    ("*travel through the contact", lambda: smooth(friction=DRIVEN, shapes=(CYLINDER, cs.MovingShape(WAVES)))),
    ("PartialSlip.tangential is 30 N/mm: friction transmits less than 30 N/mm",
     lambda: smooth(friction=cs.PartialSlip(0.3, 3e4))),
    ("Fretting.forces[1]", lambda: smooth(friction=cs.Fretting(0.3, (1e4, -3e4)))),
    ("*give Fretting.forces", lambda: smooth(
        friction=cs.Fretting(0.3, displacements=(0.0, 1e-7), times=(0.0, 1.0)), load=HISTORY)),
    ("Scene.friction in partial slip * Scene.wear, which changes in time*give Fretting.times",
     lambda: smooth(friction=cs.Fretting(0.3, (1e4,)), wear=WEARS)),
    ("*Scene.solids[1], a CoatedHalfSpace", lambda: smooth(
        friction=cs.PartialSlip(0.3, 1e4, bulk_stress=1e7, bulk_body=1), solids=(COATED, COATED))),
    # free faces
    ("Scene.solids with free_faces together with Scene.friction of unequal",
     lambda: smooth(friction=cs.Sliding(0.1), solids=(ENDED, STEEL))),
    ("Scene.solids with free_faces together with friction and Scene.outputs",
     lambda: smooth(solids=(ENDED, ENDED), friction=cs.Sliding(0.1), outputs=BELOW)),
    ("HalfSpace.free_faces is 400*the faces load each other",
     lambda: smooth(solids=(cs.FreeFaces(STEEL, 4e-4), STEEL))),
    # bodies that yield
    ("Scene.rolling without passes together with Scene.solids that yield",
     lambda: smooth(solids=(YIELDING, RIGID), rolling=ROLLS)),
    ("Scene.outputs is * together with passes over Scene.solids that yield",
     lambda: smooth(solids=(YIELDING, RIGID), rolling=PASSES, outputs=BELOW)),
    # wear
    ("Rolling.passes together with Scene.wear", lambda: smooth(rolling=PASSES, wear=WEARS)),
    ("Wear.speed is 0, * nothing wears", lambda: smooth(friction=cs.Sliding(0.1), wear=replace(WEARS, speed=0.0))),
    ("Wear.speed together with Fretting*a speed of 0 m/s", lambda: smooth(friction=FRETS, wear=WEARS)),
    ("Wear.speed together with TractiveRolling*a speed of 0 m/s", lambda: smooth(friction=DRIVEN, wear=TURNS)),
    ("*circumference is None, * turns by Scene.rolling", lambda: smooth(rolling=ROLLS, wear=WEARS)),
    ("*does not turn: leave it out", lambda: smooth(friction=cs.Sliding(0.1, standing=0), wear=TURNS)),
    ("Scene.wear of a body that turns * Scene.load that changes*give a LineLoad",
     lambda: smooth(load=HISTORY, rolling=ROLLS, wear=TURNS)),
    ("*so that nothing wears, give Lubrication.boundary", lambda: oiled({}, wear=TURNS)),
    # adhesion
    ("Adhesion.range is None together with Scene.friction", lambda: adhesive(ADHESION, friction=cs.Sliding(0.1))),
    ("Adhesion.range is None together with Scene.solids that yield",
     lambda: adhesive(ADHESION, solids=(YIELDING, RIGID))),
    ("Scene.adhesion* together with rolling of Scene.solids that creep",
     lambda: adhesive(solids=(CREEPING, RIGID), rolling=ROLLS)),
    ("Scene.adhesion* Fretting.times* give forces without times",
     lambda: adhesive(friction=cs.Fretting(0.3, (0.0, 0.1), times=(0.0, 1.0)))),
    ("Scene.load on a point contact together with Scene.adhesion: films, adhesion *, leave it out",
     lambda: adhesive(load=cs.TotalLoad(1.0), shapes=(cs.Sphere(0.01),))),
    ("Scene.load is a PullOff without adhesion", lambda: smooth(load=cs.PullOff(1.0))),
    ("*PullOff together with *solids* has a history",
     lambda: adhesive(solids=(YIELDING, RIGID), load=cs.PullOff(1.0))),
    # films
    ("*give a Lubrication, or None", lambda: smooth(lubrication=OIL)),
    ("Scene.load, which changes in time under a film together with Scene.solids that creep",
     lambda: oiled({}, solids=(CREEPING, STEEL), load=HISTORY)),
    ("Scene.load, which changes * Lubrication.boundary* steady film only",
     lambda: oiled({"boundary": cs.Boundary(5e-9)}, load=HISTORY)),
]  # fmt: skip


@pytest.mark.cases(len(BESIDE))
@pytest.mark.parametrize(("said", "make"), BESIDE)
def test_effects_undefined_with_each_other_are_refused(said: str, make: Callable[[], cs.Scene]) -> None:
    refused(make, said)


def solve(scene: cs.Scene, grid: cs.Grid = UNIT, padding: Any = EXACT, **named: Any) -> object:
    return cs.solve(scene, grid, padding, **named)


def held(**times: Any) -> object:
    """A load that is held on a body that creeps."""
    history = cs.LoadHistory((0.0, 1.0), (1e5, 1e5))
    return solve(smooth(solids=(CREEPING, RIGID), load=history), times=cs.TimeSteps(**times))


def passing(grid: cs.Grid = UNIT, padding: Any = EXACT, **changed: Any) -> object:
    """Passes over a body that yields."""
    return solve(smooth(**{"solids": (YIELDING, RIGID), "rolling": PASSES} | changed), grid, padding)


SOLVES: list[tuple[str, Callable[[], object]]] = [
    ("Scene.friction has a bulk stress with images across",
     lambda: smooth(friction=cs.PartialSlip(0.3, 1e4, bulk_stress=1e7)).problem(UNIT, (EXACT, EXACT))),
    ("*enter it again", lambda: smooth(friction=DRIVEN).problem(UNIT, (EXACT, EXACT))),
    ("TractiveRolling.spin is 5.0 in a contact without end",
     lambda: smooth(friction=SPINS, shapes=(CYLINDER, cs.FiniteLength(2.0))).problem(UNIT, EXACT)),
    ("Approach.datum is 0.0001: give at least half",
     lambda: smooth(load=cs.Approach(1e-6, datum=1e-4)).problem(UNIT, EXACT)),
    ("Scene.load is Approach*mean undeformed gap",
     lambda: smooth(shapes=(replace(WAVES, along=1e-3),), load=cs.Approach(0.0)).problem(UNIT, (EXACT, EXACT))),
    ("FiniteLength.length is 0.001: give cells along",
     lambda: solve(smooth(shapes=(CYLINDER, cs.FiniteLength(1e-3))), cs.Grid((16, 1), (1e-3, 2e-3)), FREE)),
    ("padding is *have no images, give ZeroPadding",
     lambda: solve(smooth(solids=(ENDED, STEEL)), SQUARE, (EXACT, FREE))),
    ("SubsurfaceStress.body is 0*a grid as long as the body",
     lambda: solve(smooth(solids=(ENDED, STEEL), outputs=BELOW), cs.Grid((16, 16), (3e-4, 2e-2)), FREE)),
    # scenes that change
    ("Scene.solids[0] changes in time*: call contactstudy.solve",
     lambda: smooth(solids=(CREEPING, RIGID)).problem(UNIT, EXACT)),
    ("solve.padding is ExactPeriodicity() across",
     lambda: solve(smooth(solids=(YIELDING, RIGID), load=HISTORY), UNIT, (EXACT, EXACT), times=(0, 1))),
    ("solve.times[0] is -1", lambda: held(times=(-1.0, 1.0))),
    ("TimeSteps.times[0]", lambda: held(times=((0.5, 1.0), (1.5, 2.0)))),
    ("solve.times", lambda: held(times=(0.5, 0.25))),
    ("TimeSteps.error is", lambda: held(times=(0.0, 1.0), error=1.0)),
    ("solve.error or TimeSteps.error leaves 1e-09", lambda: held(times=(0.0, 1.0), error=1e-9)),
    ("TimeSteps.error_estimator is 'none' beside an error of 0.01, *: leave one of them out.",
     lambda: held(times=(0.0, 1.0), error=1e-2, error_estimator="none")),
    ("solve.times is None, and nothing in the scene has an end: give times",
     lambda: solve(smooth(solids=(CREEPING, RIGID)))),
    # keywords that a scene cannot use
    ("solve.period is given, *: leave it out.", lambda: cs.solve(SMOOTH.problem(UNIT, EXACT), period=1.0)),
    ("solve.precision is ", lambda: solve(OILED, WIDE, precision="single")),
    # rolling
    ("*is a fluid", lambda: solve(smooth(rolling=ROLLS, solids=(FLUID, RIGID)))),
    ("Scene.shapes that move with a body together with Scene.rolling",
     lambda: smooth(rolling=ROLLS, shapes=(CYLINDER, cs.MovingShape(WAVES)))),
    ("*give one body that yields, * elastic or rigid HalfSpace", lambda: passing(solids=(YIELDING, CREEPING))),
    ("Scene.load changes in time", lambda: passing(load=HISTORY)),
    ("Grid.cells[1] is 2", lambda: passing(cs.Grid((24, 2), UNIT.extent))),
    # films
    ("*no inlet draws lubricant in", lambda: solve(replace(OILED, shapes=()), WIDE)),
    ("*periodic along the length", lambda: solve(OILED, WIDE, FREE)),
    ("*wider than half the contact: give 18", lambda: solve(OILED, cs.Grid((12, 1), WIDE.extent))),
    ("*two or more, ascending", lambda: solve(oiled({}, load=HISTORY), WIDE, times=cs.TimeSteps([1.0, 0.0]))),
    ("Scene.load is 0 at 1 s",
     lambda: solve(oiled({}, load=cs.LoadHistory((0, 1, 1), (1e5, 0, 1e5))), WIDE, times=[0, 3])),
    # plans
    ("*without a length", lambda: cs.plan(smooth(shapes=(CYLINDER, cs.Crown(1.0))))),
    ("*has no length scales",
     lambda: cs.plan(smooth(shapes=(CYLINDER, SimpleNamespace(gap=lambda grid: np.zeros(grid.cells), curvature=0.0))))),
    ("plan.error is 0", lambda: cs.plan(SMOOTH, error=0)),
    ("plan.device is 2: give Cpu(threads=2) or Gpu()", lambda: cs.plan(SMOOTH, device=2)),
    ("plan.times is given, *: leave it out", lambda: cs.plan(OILED, times=(0.0, 1.0))),
    ("TimeSteps.instants is 1", lambda: cs.plan(oiled({}, load=HISTORY), times=cs.TimeSteps(instants=1))),
]  # fmt: skip


@pytest.mark.cases(len(SOLVES))
@pytest.mark.parametrize(("said", "make"), SOLVES)
def test_what_a_scene_cannot_be_solved_with_is_refused(said: str, make: Callable[[], object]) -> None:
    refused(make, said)
