"""What a scene names changes a number, is refused, or is named as left out: scenes of each method, with a part more."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene import methods
from contactstudy.solving import SOLVED_BY
from tests.conftest import STEEL

EXACT = cs.ExactPeriodicity()
CYLINDER = cs.Cylinder(radius=0.01)
GROWING = cs.LoadHistory((0.0, 1.0), (1e5, 2e5))
CREEPING = cs.ViscoelasticHalfSpace(1e11, 0.3, ((1e11, 0.5),))
YIELDING = cs.ElasticPlasticHalfSpace(210e9, 0.3, 3.5e8, 1e10)
COATED = cs.CoatedHalfSpace(cs.HalfSpace(300e9, 0.25), 2e-5, STEEL)
ATTRACTION = cs.Adhesion(work=5.0, range=2e-7)
OIL = cs.Lubrication(cs.Lubricant(0.1, 1e-8), mean_speed=10.0)
WAVES = cs.Waviness(1e-7, across=1e-4, along=2e-4)
TURNING = cs.Wear(1e-13, 0.1, circumference=0.06)

Fields = Mapping[str, Any]
PLAIN: Fields = {"load": cs.LineLoad(1e5), "solids": (STEEL, STEEL), "shapes": (CYLINDER,)}
# Scenes solved by each method, and a contact with each law of friction.
SCENES: dict[str, tuple[methods.Method, Fields]] = {
    "static": (methods.STATIC, {}),
    "adhesive": (methods.STATIC, {"adhesion": ATTRACTION}),
    "sliding": (methods.STATIC, {"friction": cs.Sliding(0.2)}),
    "tractive rolling": (methods.STATIC, {"friction": cs.TractiveRolling(0.3, longitudinal=1e-3)}),
    "rolling": (
        methods.STEADY_ROLLING,
        {"solids": (CREEPING, STEEL), "rolling": cs.Rolling(1e-4)},
    ),
    "passes": (
        methods.PASSES,
        {"solids": (YIELDING, STEEL), "rolling": cs.Rolling(passes=1, distance=1e-4)},
    ),
    "adhesive history": (methods.QUASI_STATIC, {"load": GROWING, "adhesion": ATTRACTION}),
    "creep": (methods.TIME_DEPENDENT, {"solids": (CREEPING, STEEL)}),
    "fretting": (
        methods.TIME_DEPENDENT,
        {"friction": cs.Fretting(0.3, (0.0, 1e4, -1e4), times=(0.0, 0.5, 1.0))},
    ),
    "wear of a roller": (methods.STEADY_WEAR, {"rolling": cs.Rolling(1.0), "wear": TURNING}),
    "film": (methods.FILM, {"load": cs.LineLoad(1e4), "lubrication": OIL}),
    "film in time": (
        methods.FILM_IN_TIME,
        {"load": cs.LoadHistory((0.0, 1e-4), (1e4, 1.5e4)), "lubrication": OIL},
    ),
    "wear in a film": (
        methods.FILM_WEAR,
        {
            "load": cs.LineLoad(1e4),
            "lubrication": replace(OIL, mean_speed=0.5, boundary=cs.Boundary(5e-9)),
            "wear": replace(TURNING, speed=0.0),
        },
    ),
}
HEIGHTS = 1e-7 * np.outer(np.sin(0.7 * np.arange(64)), np.cos(np.pi / 4 * np.arange(8)))
# Parts to name beside those of a scene: what a scene has already in that field is left as it is.
PARTS: dict[str, Fields] = {
    "load history": {"load": GROWING},
    "hardness": {"hardness": 6e8},
    "other material": {"solids": (cs.HalfSpace(100e9, 0.35),)},
    "coating": {"solids": (COATED,)},
    "creep": {"solids": (CREEPING,)},
    "yielding": {"solids": (YIELDING,)},
    "free faces": {"solids": (cs.FreeFaces(STEEL, 1e-3),)},
    "stress": {"outputs": (cs.SubsurfaceStress(depths=(5e-5,)),)},
    "wear": {"wear": cs.Wear(1e-13, 0.1)},
    "wear of a roller": {"wear": TURNING},
    "rolling": {"rolling": cs.Rolling(1.0)},
    "sliding": {"friction": cs.Sliding(0.2)},
    "partial slip": {"friction": cs.PartialSlip(0.3, 1e3)},
    "tractive rolling": {"friction": cs.TractiveRolling(0.3, longitudinal=1e-3)},
    "film": {"lubrication": OIL},
    "adhesion": {"adhesion": ATTRACTION},
    "waves": {"shapes": (WAVES,)},
    "dimples between the cells": {"shapes": (cs.Texture(cs.Dimple(1e-7, 2e-5), (2e-4, 2e-4)),)},
    "measured surface": {"shapes": (cs.MeasuredSurface(HEIGHTS, (2.5e-3, 4e-4)),)},
    "heights that move": {"shapes": (cs.MovingShape(WAVES),)},
    "tilt": {"shapes": (cs.Tilt(1e-4),)},
    "crown": {"shapes": (cs.Crown(1.0, 4e-4),)},
    "length": {"shapes": (cs.FiniteLength(3e-4),)},
    "rounded ends": {"shapes": (cs.EndRelief(4e-4, 2e-4, end_radius=1e-2),)},
    "profile by points": {"shapes": (cs.ProfilePoints((0.0, 1e-4, 2e-4), (0.0, 1e-8, 1e-7)),)},
}
# What warnings say of a part that is left out.
SAID = re.compile("do not resolve|stand still|left out")


def with_part(fields: Fields, part: Fields) -> dict[str, Any] | None:
    """Fields of a scene with a part more; None where it has another one in that field."""
    fields = {**PLAIN, **fields}
    for name, value in part.items():
        if name == "shapes":
            value = (*fields["shapes"], *value)
        elif name == "solids":
            value = (fields["solids"][0], *value)
        elif fields.get(name, PLAIN.get(name)) != PLAIN.get(name):
            return None
        fields[name] = value
    return fields


def answered(fields: Fields) -> tuple[dict[str, float], tuple[str, ...]]:
    """Numbers by name, and warnings, of a scene on few cells."""
    scene = cs.Scene(**fields)
    padding: Any = EXACT
    if isinstance(scene.friction, cs.TractiveRolling):
        padding = (cs.ZeroPadding(), EXACT)
    if scene.free_length < np.inf:
        padding = cs.ZeroPadding()
    times: Any = None
    if scene.method is methods.FILM_IN_TIME:
        times = cs.TimeSteps((0.0, 1e-5), step=5e-6)
    elif scene.method.takes_times:
        times = (0.0, max((history.end for history in scene.histories), default=1.0))
    cells, width = (24, 4), 1.2e-3
    if scene.lubrication is not None:
        cells = 32, 4
    if scene.method is methods.PASSES:
        cells = 24, 1
    answer = cs.solve(scene, cs.Grid(cells, (width, 4e-4)), padding, times=times)
    numbers = {name: number.value for name, number in answer.quantities.items()}
    return numbers, answer.error.warnings


def test_scenes_of_all_methods_are_tried() -> None:
    assert {method for method, _ in SCENES.values()} == set(SOLVED_BY)


@pytest.mark.cases(4)
@pytest.mark.parametrize("name", SCENES)
def test_what_a_scene_names_changes_a_number_is_refused_or_is_named_as_left_out(name: str) -> None:
    method, fields = SCENES[name]
    assert cs.Scene(**{**PLAIN, **fields}).method is method
    before, _ = answered({**PLAIN, **fields})
    assert before
    silent = []
    for part, more in PARTS.items():
        if (named := with_part(fields, more)) is None:
            continue
        try:
            numbers, warnings = answered(named)
        except cs.InvalidInput:
            continue
        changed = any(value != before.get(key) for key, value in numbers.items())
        if not changed and not any(map(SAID.search, warnings)):
            silent.append(part)
    assert silent == []
