"""Effects that are refused beside each other, grids and times that are refused for a scene, and how the sentence begins.

``*`` stands for any words.
"""

from collections.abc import Callable
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder
from tests.contactstudy.evolution.test_roll_repeatedly import scene as yielding_cylinder
from tests.contactstudy.lubrication.scenes import by_moes
from tests.contactstudy.lubrication.scenes import grid as film_grid
from tests.contactstudy.scene.shapes.test_shapes import Own
from tests.contactstudy.test_refused_values import (
    COATED,
    EXACT,
    FREE,
    OIL,
    RIGID,
    SMOOTH,
    YIELDING,
    refused,
)

CYLINDER, HISTORY = SMOOTH.shapes[0], cs.LoadHistory((0.0, 1.0), (1e5, 2e5))
CREEPING = cs.ViscoelasticHalfSpace(1e11, 0.3, ((1e11, 0.5),))
WAVY = cs.MovingShape(cs.Waviness(1e-8, across=1e-4))
WEARS = cs.Wear(1e-15, 0.1, circumference=0.06)
SLIP, FRETS = cs.PartialSlip(0.3, 1e4), cs.Fretting(0.3, (0.0, 1e4), times=(0.0, 1.0))
SPINS = cs.TractiveRolling(0.3, longitudinal=0.0, spin=5.0)
DRIVEN = replace(SMOOTH, friction=cs.TractiveRolling(0.3, longitudinal=1e-3))
WORN = replace(SMOOTH, rolling=cs.Rolling(1.0), wear=WEARS)

ENDED = cs.FreeFaces(STEEL, 0.01)
SOFT = cs.HalfSpace(1e6, 0.5)
ADHERING = replace(SMOOTH, load=cs.LineLoad(2.0), solids=(SOFT, RIGID), adhesion=cs.Adhesion(work=0.05))
RANGED = replace(ADHERING, adhesion=cs.Adhesion(work=0.05, range=2e-6))
BARE = replace(ADHERING, adhesion=None)
RUBBERY = cs.ViscoelasticHalfSpace(1e6, 0.5, ((1e6, 1.0),))
WIDE = cs.Grid((64, 1), (1.5e-3, 1.0))

FILM = by_moes(20, 5)
SPEEDS = cs.SpeedHistory((0, 1), (1.0, 2.0))

HELD = rolling_cylinder(SOLID, cs.LoadHistory((0.0, 1.0), (LOAD, LOAD)))
ROLLING, PASSES = rolling_cylinder(SOLID, rolling=cs.Rolling(0.1)), yielding_cylinder(2.3)
UNIT, COARSE = cs.Grid((16, 1), (0.6, 1.0)), cs.Grid((24, 1), (4.8, 1.0))


def oiled(**changes: Any) -> dict[str, Any]:
    """A film of the scene that moves otherwise."""
    return {"lubrication": replace(FILM.lubrication, **changes)}


BESIDE: list[tuple[str, cs.Scene, dict[str, Any]]] = [
    # friction
    ("PartialSlip.tangential", SMOOTH, {"friction": cs.PartialSlip(0.3, 3e4)}),
    ("*elastically dissimilar", SMOOTH, {"friction": SLIP, "solids": (STEEL, RIGID)}),
    (
        "*elastically dissimilar", SMOOTH,
        {"friction": SLIP, "solids": (cs.CoatedHalfSpace(STEEL, 1e-6, RIGID), STEEL)},
    ),
    ("Scene.adhesion is given for a point contact, *: films, adhesion *, leave it out", SMOOTH, {
        "load": cs.TotalLoad(1.0), "shapes": (cs.Sphere(0.01),), "adhesion": cs.Adhesion(0.05),
    }),
    ("TotalLoad.length is 0.02, *: leave it out", SMOOTH, {
        "load": cs.TotalLoad(1e3, 0.02), "shapes": (CYLINDER, cs.FiniteLength(0.01)),
    }),
    ("Scene.friction", SMOOTH, {"friction": 0.3}),
    ("Scene.friction", SMOOTH, {"friction": cs.Sliding}),
    # equal at first, until one has crept
    *((said, SMOOTH, {"friction": friction, "solids": (CREEPING, cs.HalfSpace(2e11, 0.3))}) for said, friction in (
        ("*one creeps: creep of their coupling", cs.Sliding(0.3)), ("*elastically dissimilar", FRETS),
    )),
    (
        "*or TractiveRolling", SMOOTH,
        {"friction": cs.Sliding(0.3), "rolling": cs.Rolling(1.0), "solids": (STEEL, RIGID)},
    ),
    ("*has 2 passes together with Sliding", SMOOTH, {"friction": cs.Sliding(0.3), "rolling": cs.Rolling(passes=2)}),
    # tractive rolling
    ("*rolls by * of its widths", DRIVEN, {"load": cs.SineLoad(1e5, 1e4, 1e4)}),
    (
        "TractiveRolling.tangential", DRIVEN,
        {"load": cs.SineLoad(1e5, 5e4, 1.0), "friction": cs.TractiveRolling(0.3, tangential=0.18e5)},
    ),
    ("TractiveRolling.tangential", DRIVEN, {"friction": cs.TractiveRolling(0.3, tangential=0.3e5)}),
    ("Scene.rolling", DRIVEN, {"rolling": cs.Rolling(1.0)}),
    ("*grows from pass to pass", DRIVEN, {"solids": (YIELDING, STEEL)}),
    *(("TractiveRolling.spin is 5.0 in a contact without end", DRIVEN, {"friction": SPINS, "shapes": shapes})
      for shapes in ((CYLINDER,), (CYLINDER, cs.Waviness(1e-8, across=1e9, along=1e-4)))),
    ("*travel through the contact", DRIVEN, {"shapes": (CYLINDER, WAVY)}),
    # fretting
    ("Fretting.forces", SMOOTH, {"friction": cs.Fretting(0.3, (1e4, -3e4))}),
    ("*dissimilar", SMOOTH, {"friction": cs.Fretting(0.3, (1e4,)), "solids": (STEEL, cs.HalfSpace(1.0, 0.1))}),
    (
        "Scene.wear changes in time together with Fretting*give Fretting.times", SMOOTH,
        {"friction": cs.Fretting(0.3, (1e4,)), "wear": cs.Wear(1.0, 1.0)},
    ),
    ("*a speed of 0 m/s", SMOOTH, {"friction": FRETS, "wear": cs.Wear(1.0, 1.0)}),
    (
        "Fretting.forces are *N/mm at * s, where friction transmits", SMOOTH,
        {"friction": cs.Fretting(0.3, (0.0, 4e4), times=(0.0, 1.0))},
    ),
    (
        "*give Fretting.forces", SMOOTH,
        {"friction": cs.Fretting(0.3, displacements=(0.0, 1e-7), times=(0.0, 1.0)), "load": HISTORY},
    ),
    ("*flow along its surface", SMOOTH, {"friction": FRETS, "solids": (YIELDING, YIELDING)}),
    # bulk stress
    *(("*Scene.solids[1], a CoatedHalfSpace", SMOOTH, {"friction": law, "solids": (COATED, COATED)}) for law in (
        cs.PartialSlip(0.3, 1e4, bulk_stress=1e7, bulk_body=1),
        cs.Fretting(0.3, (1e4,), bulk_stresses=(1e7,), bulk_body=1),
    )),
    # free faces
    *((said, SMOOTH, {"solids": (ENDED, STEEL)} | changes) for said, changes in (
        ("Scene.shapes[1] is FiniteLength*leave it out", {"shapes": (CYLINDER, cs.FiniteLength(0.012))}),
        ("*yields together with free_faces", {"solids": (ENDED, YIELDING)}),
        ("*creeps together with free_faces", {"solids": (ENDED, CREEPING)}),
        ("Scene.lubrication is given together with free_faces", oiled()),
        ("Scene.friction is a Sliding together with free_faces", {"friction": cs.Sliding(0.1)}),
        ("Scene.solids[0]*how its faces change*without free_faces", {"friction": SLIP, "solids": (ENDED, ENDED)}),
        ("Scene.outputs are given together with friction and free_faces", {
            "solids": (ENDED, ENDED), "friction": cs.Sliding(0.1), "outputs": (cs.SubsurfaceStress(),),
        }),
        ("Scene.rolling is given together with free_faces", {"rolling": cs.Rolling(1.0)}),
        ("HalfSpace.free_faces is 400*the faces load each other", {"solids": (cs.FreeFaces(STEEL, 4e-4), STEEL)}),
    )),
    # a hardness, which does not remember
    *((f"Scene.hardness is 1000000000.0 together with *{said}*give an ElasticPlasticHalfSpace", SMOOTH,
       {"hardness": 1e9} | changes) for said, changes in (
        ("falls", {"load": cs.LoadHistory((0.0, 1.0, 2.0), (1e5, 2e5, 1.9e5))}),
        ("falls", {"load": cs.SineLoad(1e5, 1e4, frequency=1.0)}),
        ("rolls", {"rolling": cs.Rolling(1.0)}),
        ("rolls", {"solids": (CREEPING, STEEL), "rolling": cs.Rolling(1.0)}),
        ("creeps", {"solids": (CREEPING, STEEL)}),
        ("Scene.wear", {"wear": cs.Wear(1e-17, 1.0)}),
    )),
    # bodies that yield
    ("Scene.hardness is 1000000000.0", SMOOTH, {"solids": (YIELDING, RIGID), "hardness": 1e9}),
    ("Scene.rolling is Rolling", SMOOTH, {"solids": (YIELDING, RIGID), "rolling": cs.Rolling(1.0)}),
    (
        "Scene.outputs are * together with passes over a body that yields", SMOOTH,
        {"solids": (YIELDING, RIGID), "rolling": cs.Rolling(passes=1), "outputs": (cs.SubsurfaceStress(),)},
    ),
    # wear of bodies that turn
    ("Wear.speed is 0, * nothing wears", WORN, {"wear": replace(WEARS, speed=0.0)}),
    ("Wear.speed is 0, * nothing wears", SMOOTH, {"friction": cs.Sliding(0.1), "wear": cs.Wear(1e-15, 0.0)}),
    ("*circumference is None, * turns by Scene.rolling", WORN, {"wear": cs.Wear(1e-15, 0.1)}),
    *(("*does not turn: leave it out", WORN, {"rolling": rolling, "friction": cs.Sliding(0.1, standing=0)})
      for rolling in (None, WORN.rolling)),
    ("*turns by Scene.friction", WORN, {"friction": cs.Sliding(0.1, standing=1), "wear": cs.Wear(1e-15, 0.1)}),
    ("Scene.solids changes in time * turns", WORN, {"rolling": None, "solids": (CREEPING, RIGID)}),
    ("Scene.friction changes in time * turns", WORN, {
        "rolling": None, "friction": FRETS, "wear": replace(WEARS, speed=0.0),
    }),
    ("*give a LineLoad", WORN, {"load": HISTORY}),
    ("*gives the sliding: give a speed of 0 m/s", WORN, {"rolling": None, "friction": DRIVEN.friction}),
    (
        "*so that nothing wears, give Lubrication.boundary", WORN,
        {"rolling": None, "lubrication": cs.Lubrication(OIL, 1.0)},
    ),
    # adhesion
    ("Adhesion.range is None together with Scene.friction", ADHERING, {"friction": cs.Sliding(0.1)}),
    ("Scene.wear is Wear", ADHERING, {"wear": cs.Wear(1e-17, 1.0)}),
    (
        "Scene.rolling is Rolling* together with Adhesion, and not steady rolling of elastic", ADHERING,
        {"rolling": cs.Rolling(1.0), "solids": (RUBBERY, RIGID)},
    ),
    (
        "Scene.friction is TractiveRolling* together with Adhesion, and not steady rolling of", ADHERING,
        {"friction": DRIVEN.friction, "solids": (RUBBERY, RIGID)},
    ),
    ("*give elastic bodies without passes", ADHERING, {"rolling": cs.Rolling(passes=1)}),
    (
        "Scene.load is a PullOff together with Scene.rolling", ADHERING,
        {"rolling": cs.Rolling(1.0), "load": cs.PullOff(1.0)},
    ),
    ("Adhesion.range is None together with a body that yields", ADHERING, {"solids": (YIELDING, RIGID)}),
    ("*PullOff together with *solids* has a history", RANGED, {"solids": (YIELDING, RIGID), "load": cs.PullOff(1.0)}),
    ("*give forces without times", RANGED, {"friction": cs.Fretting(0.3, (0.0, 0.1), times=(0.0, 1.0))}),
    ("LineLoad.per_length is -1.0: give a load per length above 0", BARE, {"load": cs.LineLoad(-1.0)}),
    ("*[1] is -1.0: give a load per length of at least 0", BARE, {"load": cs.LoadHistory((0.0, 1.0), (1.0, -1.0))}),
    ("* is -1.0: give a load above 0", BARE, {"load": cs.TotalLoad(-1.0, 1.0)}),
    ("Scene.load is a PullOff without adhesion", BARE, {"load": cs.PullOff(1.0)}),
    *((f"Scene.load is an Approach together with Scene.{name}", BARE, {"load": cs.Approach(1e-6), name: effect})
      for name, effect in {"hardness": 1e6, "wear": cs.Wear(1e-17, 1.0), "rolling": cs.Rolling(1.0)}.items()),
    # films
    ("Scene.rolling is not supported", FILM, {"rolling": cs.Rolling(1.0)}),
    ("Scene.friction is not supported", FILM, {"friction": cs.Sliding(0.1)}),
    ("Scene.hardness is not supported", FILM, {"hardness": 2e9}),
    ("*give a Lubrication, or None", FILM, {"lubrication": OIL}),
    ("Scene.load * creep is supported under a steady film only", FILM, {"solids": (CREEPING, STEEL), "load": HISTORY}),
    *((f"*steady film only, and *{said} changes in time", FILM, oiled(**effect, **motion) | changes)
      for effect in ({"boundary": cs.Boundary(5e-9)}, {"thermal": cs.FilmHeat()})
      for said, motion, changes in (
          ("Scene.load", {}, {"load": HISTORY}), ("mean_speed", {"mean_speed": SPEEDS}, {}),
          ("Scene.shapes[0]", {}, {"shapes": (WAVY, CYLINDER)}),
      )),
    (
        "Scene.solids[1] * plastic strain * dry contacts only", FILM,
        oiled(slide_roll_ratio=-2.0) | {"solids": (STEEL, YIELDING)},
    ),
]  # fmt: skip


@pytest.mark.cases(len(BESIDE))
@pytest.mark.parametrize(("said", "scene", "changes"), BESIDE)
def test_effects_undefined_with_each_other_are_refused(said: str, scene: cs.Scene, changes: dict[str, Any]) -> None:
    refused(lambda: replace(scene, **changes), said)


def rolled(grid: cs.Grid = COARSE, padding: Any = EXACT, **changes: Any) -> object:
    rolling = cs.Rolling(passes=1, distance=0.4)
    return cs.solve(replace(PASSES, rolling=rolling, **changes), grid, padding)


def held(**times: Any) -> object:
    return cs.solve(HELD, UNIT, EXACT, times=cs.TimeSteps(**times))


SOLVES: list[tuple[str, Callable[[], object]]] = [
    ("Scene.friction has a bulk stress with images across", lambda: replace(
        SMOOTH, friction=cs.PartialSlip(0.3, 1e4, bulk_stress=1e7)
    ).problem(UNIT, (EXACT, EXACT))),
    ("*enter it again", lambda: DRIVEN.problem(cs.Grid((32, 1), (3e-4, 1e-3)), (EXACT, EXACT))),
    *((
        "TractiveRolling.spin is 5.0 in a contact without end",
        lambda end=end: replace(SMOOTH, friction=SPINS, shapes=(CYLINDER, end)).problem(UNIT, EXACT),
    ) for end in (cs.Crown(), cs.FiniteLength(2.0))),
    (
        "Approach.datum is 0.0001: give at least half",
        lambda: replace(ADHERING, load=cs.Approach(1e-6, datum=1e-4)).problem(WIDE, EXACT),
    ),
    *((
        "Scene.load is Approach*mean undeformed gap",
        lambda one=one: replace(BARE, shapes=(cs.Waviness(1e-6, across=1.5e-3),), load=cs.Approach(one)).problem(
            WIDE, (EXACT, EXACT)
        ),
    ) for one in (0.0, 3e-6)),
    # scenes that change
    ("Scene.solids[0] changes in time*: call contactstudy.solve", lambda: rolling_cylinder(SOLID).problem(UNIT, EXACT)),
    (
        "Scene.wear changes in time*: call contactstudy.solve",
        lambda: replace(SMOOTH, wear=cs.Wear(1e-15, 0.1)).problem(UNIT, EXACT),
    ),
    (
        "Scene.load changes in time*: call contactstudy.solve",
        lambda: replace(SMOOTH, load=HISTORY).problem(UNIT, EXACT),
    ),
    (
        "Scene.solids[0] changes in time*: call contactstudy.solve",
        lambda: replace(SMOOTH, solids=(YIELDING, RIGID)).problem(UNIT, EXACT),
    ),
    ("solve.padding is ExactPeriodicity() across", lambda: cs.solve(
        replace(SMOOTH, solids=(YIELDING, RIGID), load=HISTORY), UNIT, (EXACT, EXACT), times=(0, 1)
    )),
    ("*call contactstudy.solve", lambda: ROLLING.problem(UNIT, EXACT)),
    ("*call contactstudy.solve", lambda: FILM.problem(film_grid(100, 4.5), EXACT)),
    *((f"{said}", lambda one=one: held(times=one)) for said, one in (
        ("TimeSteps.times is empty", ()), ("solve.times[0] is -1", (-1.0, 1.0)), ("TimeSteps.times", "soon"),
        ("solve.times", (0.5, 0.25)), ("solve.times", (0.5, 0.5, 0.5)), ("solve.times", (-0.25,)),
        ("TimeSteps.times[1]", (0.5, nan)), ("TimeSteps.times[0]", ((0.5, 1.0), (1.5, 2.0))),
    )),
    *(("TimeSteps.error is", lambda one=one: held(times=(0.0, 1.0), error=one)) for one in (0.0, 1.0)),
    ("solve.error or TimeSteps.error leaves 1e-09", lambda: held(times=(0.0, 1.0), error=1e-9)),
    (
        "TimeSteps.error_estimator is 'none' beside an error of 0.01, *: leave one of them out.",
        lambda: held(times=(0.0, 1.0), error=1e-2, error_estimator="none"),
    ),
    ("FiniteLength.length is 0.001: give cells along", lambda: cs.solve(
        replace(SMOOTH, shapes=(CYLINDER, cs.FiniteLength(1e-3))), cs.Grid((16, 1), (1e-3, 2e-3)), FREE
    )),
    (
        "solve.times is None, and nothing in the scene has an end: give times",
        lambda: cs.solve(replace(HELD, load=cs.LoadHistory((0.5,), (LOAD,))), UNIT, EXACT),
    ),
    # keywords that a scene cannot use
    ("solve.period is given, *: leave it out.", lambda: cs.solve(SMOOTH.problem(UNIT, EXACT), period=1.0)),
    ("solve.times is given, *: leave it out.", lambda: cs.solve(SMOOTH, UNIT, EXACT, times=[0.0])),
    *((f"solve.{name} is ", lambda scene=scene, named={name: value}: cs.solve(scene, film_grid(64, 3.0), EXACT, **named))
      for scene, name, value in (
          (FILM, "solver", cs.PolonskyKeer()), (FILM, "precision", "single"), (FILM, "start", np.zeros((64, 1))),
          (replace(FILM, load=HISTORY), "max_iterations", 5),
      )),
    *((f"TimeSteps.{name} is *: leave it out.", lambda scene=scene, named={name: value}: cs.solve(
        scene, UNIT, EXACT, times=cs.TimeSteps(**named)
    )) for scene, name, value in (
        (HELD, "step", 1e-3), (replace(ROLLING, load=HELD.load), "error", 1e-2),
        (replace(ROLLING, load=HELD.load), "scheme", "explicit"),
    )),
    # rolling
    ("*is a fluid", lambda: cs.solve(
        replace(ROLLING, solids=(cs.ViscoelasticHalfSpace(0.0, 0.3, ((1.0, 1.0),)), RIGID)), UNIT, EXACT
    )),
    ("Scene.shapes[1] moves with a body together with Scene.rolling", lambda: cs.solve(
        replace(ROLLING, shapes=(cs.Cylinder(1.0), cs.MovingShape(cs.Waviness(1e-3, 0.1)))), UNIT, EXACT
    )),
    ("*give one body that yields", lambda: rolled(solids=(cs.HalfSpace(500.0, 0.3), RIGID))),
    (
        "*give one body that yields, * elastic or rigid HalfSpace",
        lambda: rolled(solids=(PASSES.solids[0], cs.ViscoelasticHalfSpace(500.0, 0.3, ((500.0, 1.0),)))),
    ),
    ("Scene.load changes in time", lambda: rolled(load=cs.SineLoad(1.0, 0.1, 1.0))),
    ("Grid.cells[1] is 2", lambda: rolled(cs.Grid((24, 2), (4.8, 1.0)))),
    ("*give padding=ExactPeriodicity", lambda: rolled(padding=(EXACT, EXACT))),
    # films
    *(("*a roller's sharp end", lambda period=period: cs.solve(
        replace(FILM, shapes=(CYLINDER, cs.FiniteLength(20 * FILM.hertz.half_width))),
        film_grid(64, 4.0, 32, period=period),
    )) for period in (20.0, 40.0)),
    ("*no inlet draws lubricant in", lambda: cs.solve(replace(FILM, shapes=()), film_grid(100, 4.5), EXACT)),
    ("*periodic along the length", lambda: cs.solve(FILM, film_grid(32, 4.5, 4), FREE)),
    ("*wider than half the contact: give 18", lambda: cs.solve(FILM, film_grid(12, 9.0))),
    *((said, lambda steps=steps: cs.solve(replace(FILM, load=HISTORY), film_grid(64, 4.5), times=cs.TimeSteps(**steps)))
      for said, steps in (
          ("*two or more, ascending", {"times": [0.0]}), ("*two or more, ascending", {"times": [1.0, 0.0]}),
          ("*leave one of them out", {"times": [0.0, 1e-3], "step": 1e-4, "error": 1e-3}),
      )),
    *((f"Scene.load is 0 at {said}", lambda load=load: cs.solve(
        replace(FILM, load=load), film_grid(64, 4.5), times=[0, 3]
    )) for load, said in (
        (cs.LoadHistory((0, 1), (0, 1e5)), "0 s"), (cs.LoadHistory((0, 1, 2), (1e5, 0, 1e5)), "1 s"),
        (cs.LoadHistory((0, 1, 1, 2), (1e5, 0, 1e5, 1e5)), "1 s"), (cs.SineLoad(1e5, 1e5, 1.0), "0.75 s"),
    )),
    *(("padding is *have no images, give ZeroPadding", lambda padding=padding: cs.solve(
        replace(SMOOTH, solids=(ENDED, STEEL)), cs.Grid((16, 16), (3e-4, 1e-2)), padding,
    )) for padding in (EXACT, (EXACT, FREE), cs.Superposition(2))),
    ("SubsurfaceStress.body is 0*a grid as long as the body", lambda: cs.solve(
        replace(SMOOTH, solids=(ENDED, STEEL), outputs=(cs.SubsurfaceStress(),)), cs.Grid((16, 16), (3e-4, 2e-2)), FREE,
    )),
    # plans
    ("*no curvature", lambda: cs.plan(replace(SMOOTH, shapes=()))),
    ("*without a length", lambda: cs.plan(replace(SMOOTH, shapes=(CYLINDER, cs.Crown(1.0))))),
    ("plan.error is 0", lambda: cs.plan(SMOOTH, error=0)),
    ("*has no length scales", lambda: cs.plan(replace(SMOOTH, shapes=(CYLINDER, Own(np.zeros))))),
    *((said, lambda scene=scene, named=named: cs.plan(scene, **named))
      for scene in (SMOOTH, replace(SMOOTH, adhesion=cs.Adhesion(0.05)), FILM)
      for said, named in (
          ("plan.period is *: leave it out", {"grid": cs.Grid((32, 1), (1e-3, 1e-3)), "period": 2e-3}),
          ("plan.times is given, *: leave it out", {"times": (0.0, 1.0)}),
      )),
    *(("Approach.datum is 1.0, and * axes", lambda paddings=paddings: cs.solve(
        replace(SMOOTH, load=cs.Approach(-1e-6, datum=1.0)), cs.Grid((16, 16), (3e-4, 3e-4)), paddings,
    )) for paddings in (FREE, (EXACT, EXACT))),
    ("TimeSteps.error_estimator is *: leave it out", lambda: cs.solve(
        replace(FILM, load=HISTORY), film_grid(64, 4.5), times=cs.TimeSteps(error_estimator="none"),
    )),
    (
        "TimeSteps.instants is 1",
        lambda: cs.plan(replace(FILM, load=HISTORY), times=cs.TimeSteps(instants=1)),
    ),
]  # fmt: skip


@pytest.mark.cases(len(SOLVES))
@pytest.mark.parametrize(("said", "make"), SOLVES)
def test_what_a_scene_cannot_be_solved_with_is_refused(said: str, make: Callable[[], object]) -> None:
    refused(make, said)
