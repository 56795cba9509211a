"""What a scene names changes a number, is refused, or is named as left out; and the page of all pairs of effects.

``python -m tests.contactstudy.scene.test_pairs_of_effects`` writes the page of the documentation anew.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.answer import Answer
from contactstudy.scene import combinations as methods
from contactstudy.solving import PROBLEM, SOLVED_BY
from tests.conftest import STEEL

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "pairs-of-effects.md"
HEAD = """# Which effects work together

A scene names its effects. Each pair of effects is tried on a small scene: `+` is a pair that is computed, a number is a
pair that is refused, with the message of this number below. Bodies that yield roll in passes (`Rolling(passes=...)`),
bodies that creep roll at a speed. Partial slip is `Fretting` with times; with adhesion it is a cycle without times
(`Fretting.cycle`). Wear of a contact that rolls is that of a body that turns (`Wear(circumference=...)`), wear with a
film that of the asperities on its boundary film. This page is written by the test that tries the
pairs.

"""

Fields = Mapping[str, Any]
CYLINDER = cs.Cylinder(radius=0.01)
PLAIN: Fields = {"load": cs.LineLoad(1e5), "solids": (STEEL, STEEL), "shapes": (CYLINDER,)}
CREEPING = cs.ViscoelasticHalfSpace(1e11, 0.3, ((1e11, 0.5),))
YIELDING = cs.ElasticPlasticHalfSpace(210e9, 0.3, 3.5e8, 1e10)
OIL = cs.Lubrication(cs.Lubricant(0.1, 1e-8), mean_speed=10.0)
MIXED = {"lubrication": replace(OIL, mean_speed=0.5, boundary=cs.Boundary(5e-9))}
FRETTING = {"friction": cs.Fretting(0.3, (0.0, 1e4, -1e4), times=(0.0, 0.5, 1.0))}
PASSES = {"rolling": cs.Rolling(passes=1, distance=1e-4)}
TURNING = cs.Wear(1e-13, 0.1, circumference=0.06)
WAVES = cs.Waviness(1e-7, across=1e-4, along=2e-4)
HEIGHTS = 1e-7 * np.outer(np.sin(0.7 * np.arange(64)), np.cos(np.pi / 4 * np.arange(8)))

# Fields that an effect adds to a scene, and bodies in place of steel ones.
EFFECTS: dict[str, Fields] = {
    "load history": {"load": cs.LoadHistory((0.0, 1.0), (1e5, 2e5))},
    "hardness": {"hardness": 6e8},
    "coating": {"solids": (cs.CoatedHalfSpace(cs.HalfSpace(300e9, 0.25), 2e-5, STEEL),) * 2},
    "creep": {"solids": (CREEPING,) * 2},
    "yielding": {"solids": (YIELDING, STEEL)},
    "stress": {"outputs": (cs.SubsurfaceStress(depths=(5e-5,)),)},
    "wear": {"wear": cs.Wear(1e-13, 0.1)},
    "rolling": {"rolling": cs.Rolling(1.0)},
    "sliding": {"friction": cs.Sliding(0.2)},
    "partial slip": FRETTING,
    "tractive rolling": {"friction": cs.TractiveRolling(0.3, longitudinal=1e-3)},
    "film": {"lubrication": OIL},
    "adhesion": {"adhesion": cs.Adhesion(work=5.0, range=2e-7)},
    "roughness": {"shapes": (WAVES,)},
    "finite length": {"shapes": (cs.FiniteLength(3e-4),)},
    "free faces": {"solids": (cs.FreeFaces(STEEL, 1e-3),) * 2},
}
# Parts to name beside those of a scene: what a scene has already in that field is left as it is.
PARTS = EFFECTS | {
    "partial slip": {"friction": cs.PartialSlip(0.3, 1e3)},
    "other material": {"solids": (cs.HalfSpace(100e9, 0.35),)},
    "wear of a roller": {"wear": TURNING},
    "dimples between the cells": {"shapes": (cs.Texture(cs.Dimple(1e-7, 2e-5), (2e-4, 2e-4)),)},
    "measured surface": {"shapes": (cs.MeasuredSurface(HEIGHTS, (2.5e-3, 4e-4)),)},
    "heights that move": {"shapes": (cs.MovingShape(WAVES),)},
    "tilt": {"shapes": (cs.Tilt(1e-4),)},
    "crown": {"shapes": (cs.Crown(1.0, 4e-4),)},
    "rounded ends": {"shapes": (cs.EndRelief(4e-4, 2e-4, end_radius=1e-2),)},
    "profile by points": {"shapes": (cs.ProfilePoints((0.0, 1e-4, 2e-4), (0.0, 1e-8, 1e-7)),)},
}
# What warnings say of a part that is left out.
SAID = re.compile("do not resolve|stand still|left out")
# Scenes solved by each method, and a contact with each law of friction.
SCENES: dict[str, tuple[methods.Method, Fields]] = {
    "static": (methods.STATIC, {}),
    "adhesive": (methods.STATIC, EFFECTS["adhesion"]),
    "sliding": (methods.STATIC, EFFECTS["sliding"]),
    "tractive rolling": (methods.STATIC, EFFECTS["tractive rolling"]),
    "rolling": (methods.STEADY_ROLLING, {"solids": (CREEPING, STEEL), "rolling": cs.Rolling(1e-4)}),
    "passes": (methods.PASSES, {**EFFECTS["yielding"], **PASSES}),
    "adhesive history": (methods.QUASI_STATIC, {**EFFECTS["load history"], **EFFECTS["adhesion"]}),
    "creep": (methods.TIME_DEPENDENT, {"solids": (CREEPING, STEEL)}),
    "fretting": (methods.TIME_DEPENDENT, FRETTING),
    "wear of a roller": (methods.STEADY_WEAR, {"rolling": cs.Rolling(1.0), "wear": TURNING}),
    "film": (methods.FILM, {"load": cs.LineLoad(1e4), "lubrication": OIL}),
    "film in time": (
        methods.FILM_IN_TIME, {"load": cs.LoadHistory((0.0, 1e-4), (1e4, 1.5e4)), "lubrication": OIL},
    ),
    "wear in a film": (methods.FILM_WEAR, {"load": cs.LineLoad(1e4), **MIXED, "wear": replace(TURNING, speed=0.0)}),
}  # fmt: skip
# Pairs that take other values than their effects alone.
TOGETHER: dict[frozenset[str], Fields] = {
    frozenset(("adhesion", "partial slip")): {"friction": cs.Fretting.cycle(0.3, 1e4)},
    frozenset(("wear", "partial slip")): {"wear": cs.Wear(1e-15, 0.0)},
    frozenset(("wear", "rolling")): {"wear": TURNING},
    frozenset(("wear", "tractive rolling")): {"wear": replace(TURNING, speed=0.0)},
    frozenset(("wear", "film")): {"wear": replace(TURNING, speed=0.0), **MIXED},
    frozenset(("yielding", "rolling")): PASSES,
}


def answer(fields: Fields, rows: int) -> Answer:
    """The answer of a scene on few cells."""
    scene = cs.Scene(**{**PLAIN, **fields})
    cells, length, padding, times = (24, rows), 4e-4, cs.ExactPeriodicity(), None
    if isinstance(scene.friction, cs.TractiveRolling):
        padding = (cs.ZeroPadding(), cs.ExactPeriodicity())
    if scene.free_length < np.inf:
        length, padding = 1e-3, cs.ZeroPadding()
    if scene.lubrication is not None:
        cells = 32, rows
    if scene.method is methods.PASSES:
        cells = 24, 1
    if scene.method is methods.FILM_IN_TIME:
        times = cs.TimeSteps((0.0, 1e-5), step=5e-6)
    elif scene.method.takes_times:
        times = (0.0, max((history.end for history in scene.histories), default=1.0))
    found = cs.solve(scene, cs.Grid(cells, (1.2e-3, length)), padding, times=times)
    assert not found.status.is_failure
    return found


def with_part(fields: Fields, part: Fields) -> Fields | None:
    """Fields of a scene with a part more; None where it has another one in that field."""
    scene = {**PLAIN, **fields}
    (name, values), *_ = part.items()
    if name == "shapes":
        return {**scene, name: (*scene[name], *values)}
    if name == "solids":
        return {**scene, name: (scene[name][0], values[0])}
    return {**scene, **part} if scene.get(name, PLAIN.get(name)) == PLAIN.get(name) else None


def numbers_of(found: Answer) -> dict[str, float]:
    return {name: number.value for name, number in found.quantities.items()}


def test_scenes_of_all_methods_are_tried() -> None:
    assert {method for method, _ in SCENES.values()} == set(SOLVED_BY) - {PROBLEM}


@pytest.mark.cases(4)
@pytest.mark.parametrize("name", SCENES)
def test_what_a_scene_names_changes_a_number_is_refused_or_is_named_as_left_out(name: str) -> None:
    method, fields = SCENES[name]
    assert cs.Scene(**{**PLAIN, **fields}).method is method
    before, silent = numbers_of(answer(fields, 4)), []
    for part, more in PARTS.items():
        if (named := with_part(fields, more)) is None:
            continue
        try:
            found = answer(named, 4)
            numbers = numbers_of(found)
        except cs.InvalidInput:
            continue
        changed = any(value != before.get(name) for name, value in numbers.items())
        if not changed and not any(map(SAID.search, found.error.warnings)):
            silent.append(part)
    assert silent == []


@cache
def refusal(first: str, second: str) -> str:
    """The sentence by which a pair is refused; empty where it is computed."""
    one, other = EFFECTS[first], EFFECTS[second]
    if "friction" in one and "friction" in other:
        return "A contact has one law of friction."
    fields = {**PLAIN, **one, **other, **TOGETHER.get(frozenset((first, second)), {})}
    if "solids" in one and "solids" in other:
        fields["solids"] = one["solids"][0], other["solids"][0]
    fields["shapes"] = (CYLINDER, *one.get("shapes", ()), *other.get("shapes", ()))
    varies = len(fields["shapes"]) > 1 or "free faces" in (first, second)
    try:
        answer(fields, 2 if varies else 1)
    except cs.InvalidInput as refused:
        # without the value that the sentence names, which the page has no use for
        start, _, rest = str(refused).partition(" is ")
        value, between, reason = rest.partition(" together with ")
        return f"{start}{between}{reason}" if between and "(" in value else str(refused)
    return ""


def page() -> str:
    """The page: a table of all pairs, and the sentence of each that is refused."""
    names, reasons, rows = list(EFFECTS), dict[str, int](), []
    for number, first in enumerate(names):
        texts = [refusal(second, first) for second in names[:number]]
        cells = [str(reasons.setdefault(text, len(reasons) + 1)) if text else "+" for text in texts]
        rows.append(f"| {first} | " + " | ".join(cells + [""] * (len(names) - number)) + " |")
    pairs = [bool(refusal(*pair)) for pair in combinations(names, 2)]
    table = [f"| | {' | '.join(names)} |", "|---" * (len(names) + 1) + "|", *rows]
    counted = f"{pairs.count(False)} of {len(pairs)} pairs are computed, {pairs.count(True)} are refused:"
    return HEAD + "\n".join([*table, "", counted, "", *(f"{n}. {text}" for text, n in reasons.items()), ""])


def test_the_page_has_the_pairs_that_are_computed_and_the_reasons_for_the_others() -> None:
    assert PAGE.read_text() == page()


if __name__ == "__main__":
    PAGE.write_text(page())
