"""Each pair of effects on a small scene: computed, or refused for a reason.

``python -m tests.contactstudy.scene.test_pairs_of_effects`` writes the page of the documentation anew.
"""

from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import contactstudy as cs
from tests.conftest import STEEL

PAGE = Path(__file__).parents[3] / "docs" / "reference" / "pairs-of-effects.md"
CYLINDER = cs.Cylinder(radius=0.01)
EFFECTS: dict[str, dict[str, Any]] = {
    "load history": {"load": cs.LoadHistory((0.0, 1.0), (1e5, 2e5))},
    "hardness": {"hardness": 6e8},
    "coating": {"solids": (cs.CoatedHalfSpace(cs.HalfSpace(300e9, 0.25), 2e-5, STEEL),) * 2},
    "creep": {"solids": (cs.ViscoelasticHalfSpace(1e11, 0.3, ((1e11, 0.5),)),) * 2},
    "yielding": {"solids": (cs.ElasticPlasticHalfSpace(210e9, 0.3, 3.5e8, 1e10), STEEL)},
    "stress": {"outputs": (cs.SubsurfaceStress(depths=(5e-5, 1e-4)),)},
    "wear": {"wear": cs.Wear(1e-15, 0.1)},
    "rolling": {"rolling": cs.Rolling(speed=1.0)},
    "sliding": {"friction": cs.Sliding(0.2)},
    "partial slip": {"friction": cs.Fretting(0.3, (0.0, 1e4, -1e4), times=(0.0, 0.5, 1.0))},
    "tractive rolling": {"friction": cs.TractiveRolling(0.3, longitudinal=1e-3)},
    "film": {"lubrication": cs.Lubrication(cs.Lubricant(0.04, 2e-8), mean_speed=1.0)},
    "adhesion": {"adhesion": cs.Adhesion(work=5.0)},
    "roughness": {"shapes": (CYLINDER, cs.Waviness(1e-7, across=1e-4, along=2e-4))},
    "finite length": {"shapes": (CYLINDER, cs.FiniteLength(3e-4))},
    "free faces": {"solids": (cs.FreeFaces(STEEL, 1e-3),) * 2},
}
SLOT = "A contact has one law of friction."
HEAD = """# Which effects work together

A scene names its effects. Each pair of effects is tried on a small scene: `+` is a pair that is computed, a number is a
pair that is refused, with the message of this number below. Bodies that yield roll in passes (`Rolling(passes=...)`),
bodies that creep roll at a speed. Partial slip is `Fretting` with times; with adhesion it is a cycle without times
(`Fretting.cycle`). Wear of a contact that rolls is that of a body that turns (`Wear(circumference=...)`), wear with a
film that of the asperities on its boundary film. This page is written by the test that tries the
pairs.

"""


def scene_with(first: str, second: str) -> dict[str, Any]:
    """Fields of a scene with two effects; where both are bodies, the first effect is on the first body."""
    one, other = EFFECTS[first], EFFECTS[second]
    fields: dict[str, Any] = {
        "load": cs.LineLoad(1e5),
        "solids": (STEEL, STEEL),
        "shapes": (CYLINDER,),
    }
    fields |= one | other
    if "solids" in one and "solids" in other:
        fields["solids"] = one["solids"][0], other["solids"][0]
    if "shapes" in one and "shapes" in other:
        fields["shapes"] = (*one["shapes"], *other["shapes"][1:])
    if "adhesion" in (first, second) and ("friction" in fields or "yielding" in (first, second)):
        fields["adhesion"] = cs.Adhesion(work=5.0, range=2e-7)
        if "partial slip" in (first, second):
            fields["friction"] = cs.Fretting.cycle(0.3, 1e4)
    if {first, second} == {"partial slip", "wear"}:
        fields["wear"] = cs.Wear(1e-15, 0.0)
    if {first, second} == {"wear", "rolling"}:
        fields["wear"] = cs.Wear(1e-15, 0.1, circumference=0.06)
    if {first, second} in ({"wear", "tractive rolling"}, {"wear", "film"}):
        fields["wear"] = cs.Wear(1e-15, 0.0, circumference=0.06)
    if {first, second} == {"wear", "film"}:
        layer = cs.Boundary(5e-9)
        fields["lubrication"] = replace(fields["lubrication"], boundary=layer)
    if {first, second} == {"yielding", "rolling"}:
        fields["rolling"] = cs.Rolling(passes=1, distance=1e-4)
    return fields


@cache
def refusal(first: str, second: str) -> str:
    """The sentence by which a pair is refused; empty where it is computed."""
    if "friction" in EFFECTS[first] and "friction" in EFFECTS[second]:
        return SLOT
    along = 2 if {"roughness", "finite length"} & {first, second} else 1
    padding: Any = cs.ExactPeriodicity()
    if "tractive rolling" in (first, second):
        padding = (cs.ZeroPadding(), cs.ExactPeriodicity())
    length = 4e-4
    if "free faces" in (first, second):
        along, length, padding = 2, 1e-3, cs.ZeroPadding()
    try:
        scene = cs.Scene(**scene_with(first, second))
        times = [0.0, 1.0] if scene.method.takes_times else None
        answer = cs.solve(scene, cs.Grid((24, along), (1.2e-3, length)), padding, times=times)
    except cs.InvalidInput as refused:
        return str(refused)
    assert not answer.status.is_failure
    return ""


def sentence(text: str) -> str:
    """A refusal without the value that it names, which the page has no use for."""
    start, _, rest = text.partition(" is ")
    value, between, reason = rest.partition(" together with ")
    return f"{start}{between}{reason}" if between and "(" in value else text


def page() -> str:
    """The page: a table of all pairs, and the sentence of each that is refused."""
    names = list(EFFECTS)
    reasons: list[str] = []
    rows = []
    for number, first in enumerate(names):
        cells = []
        for second in names[:number]:
            text = sentence(refusal(second, first))
            if text and text not in reasons:
                reasons.append(text)
            cells.append(str(reasons.index(text) + 1) if text else "+")
        rows.append(f"| {first} | " + " | ".join(cells + [""] * (len(names) - number)) + " |")
    refused = sum(bool(refusal(a, b)) for a, b in combinations(names, 2))
    of = len(names) * (len(names) - 1) // 2
    table = [f"| | {' | '.join(names)} |", "|---" * (len(names) + 1) + "|", *rows]
    listed = [f"{number}. {reason}" for number, reason in enumerate(reasons, 1)]
    counted = f"{of - refused} of {of} pairs are computed, {refused} are refused:"
    return HEAD + "\n".join([*table, "", counted, "", *listed, ""])


def test_the_page_has_the_pairs_that_are_computed_and_the_reasons_for_the_others() -> None:
    assert PAGE.read_text() == page()


if __name__ == "__main__":
    PAGE.write_text(page())
