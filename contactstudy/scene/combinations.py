"""What the effects of a scene decide together: the method that solves it, and the pairs that it cannot combine.

Both are tables. Their words are those of :func:`named_by`: a slot of the scene that is not empty, such as
``Scene.wear``; the class that stands in it, such as ``TractiveRolling``; a field of that, unless it is None, 0
or empty, such as ``Wear.circumference``; and conditions on several of them, such as ``a change in time``. What composes
through the gap, the operator, the constraint, the traction or a state has no line here.
"""

from dataclasses import dataclass
from math import inf
from typing import Any

from contactstudy.domain.validation import InvalidInput
from contactstudy.scene import loads
from contactstudy.scene.solids.bodies import creeps, yields


@dataclass(frozen=True)
class Method:
    """Method by which the scenes of a kind are solved.

    Parameters
    ----------
    kind
        The kind, as messages call it.
    keywords
        Keywords of :func:`~contactstudy.solve` and settings of :class:`~contactstudy.TimeSteps` that it uses, of which
        ``error`` is one, beside those that all methods use: an error of the answer, a period, progress, a tolerance.
    """

    kind: str
    keywords: tuple[str, ...]

    @property
    def takes_times(self) -> bool:
        """True if it solves for several instants."""
        return "times" in self.keywords


# Settings of :class:`~contactstudy.SolveOptions` that most methods use.
OPTIONS = "max_iterations", "solver", "precision"
STATIC = Method("a static contact", ("start", "device", *OPTIONS))
STEADY_ROLLING = Method("a contact that rolls", OPTIONS)
PASSES = Method("a contact that rolls in passes", OPTIONS)
QUASI_STATIC = Method("a load history with adhesion or rolling", ("times", *OPTIONS))
TIME_DEPENDENT = Method(
    "a scene that changes in time", ("times", "folder", "error", "scheme", "error_estimator", *OPTIONS)
)
STEADY_WEAR = Method("a contact that rolls and wears", ("times", "error", *OPTIONS))
FILM = Method("a steady film", ("start", "max_iterations"))
FILM_IN_TIME = Method("a film that changes in time", ("times", "error", "step"))
FILM_WEAR = Method("a film that wears", ("times", "error", "max_iterations"))

# The method of a scene stands in the first row all of whose words it names.
METHODS: tuple[tuple[tuple[str, ...], Method], ...] = (
    (("Scene.lubrication", "Scene.wear"), FILM_WEAR),
    (("Scene.lubrication", "a change in time"), FILM_IN_TIME),
    (("Scene.lubrication",), FILM),
    (("Wear.circumference",), STEADY_WEAR),
    (("rolling at a speed", "Scene.load that changes"), QUASI_STATIC),
    (("rolling at a speed",), STEADY_ROLLING),
    (("Scene.rolling",), PASSES),
    (("Scene.solids that creep", "a change in time"), TIME_DEPENDENT),
    (("Scene.solids that yield", "a change in time"), TIME_DEPENDENT),
    (("TractiveRolling", "a change in time"), QUASI_STATIC),
    (("Scene.adhesion", "a change in time"), QUASI_STATIC),
    (("a change in time",), TIME_DEPENDENT),
    ((), STATIC),
)

# What is refused, beside what, and the reason with what to give instead.
REFUSED: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("Scene.load on a point contact", ("Scene.lubrication", "Scene.adhesion", "Scene.rolling"),
     "films, adhesion and rolling with hysteresis are of line contacts alone, leave it out, or give a Cylinder"),
    ("Scene.load is an Approach", ("Scene.hardness", "Scene.rolling", "Scene.lubrication", "a change in time"),
     "only a given load is supported there, give a LineLoad"),
    ("Scene.load is a PullOff", ("a change in time",),
     "a scene that changes has a history, give a LoadHistory that falls until contact is lost"),
    ("Scene.load is a PullOff", ("Scene.rolling",),
     "elastic bodies that roll part at the load at which they do at rest, leave rolling out"),
    # hardness, and bodies that yield
    ("Scene.hardness", ("Scene.load that falls", "a contact that rolls", "Scene.wear", "Scene.solids that creep"),
     "a hardness does not remember the dent where pressures fall, give an ElasticPlasticHalfSpace, or leave the "
     "hardness out"),
    ("Scene.hardness", ("Scene.solids that yield",),
     "yielding limits the pressure by itself, leave the hardness out, or give an elastic HalfSpace"),
    ("Scene.hardness", ("Scene.lubrication",),
     "the pressure of a lubricant follows from its flow, which a limit would interrupt, leave the hardness out, and "
     "compare the peak pressure with it"),
    ("Scene.rolling without passes", ("Scene.solids that yield",),
     "plastic strain has a history, give Rolling its passes, or leave rolling out"),
    ("Scene.outputs", ("passes over Scene.solids that yield",),
     "the residual stress is in the answer, leave the outputs out"),
    ("Scene.lubrication", ("Scene.solids that yield",),
     "plastic strain is computed in dry contacts only, give an elastic HalfSpace"),
    ("Scene.friction with stick", ("Scene.solids that yield",),
     "traction makes the body flow along its surface, which is not computed, give a HalfSpace or a CoatedHalfSpace"),
    # friction and rolling
    ("Scene.rolling", ("TractiveRolling",), "the law rolls at its own speed, leave rolling out"),
    ("Scene.rolling", ("Scene.friction in partial slip",),
     "material carries traction through a rolling contact, give TractiveRolling, which has a speed of its own"),
    ("Rolling.passes", ("Sliding", "Scene.wear"),
     "traction and wear of repeated rolling are not computed, leave one of them out"),
    ("Scene.friction in partial slip without times", ("a change in time",),
     "traction depends on the path of its forces, give Fretting.times [s] to its forces"),
    ("Fretting.displacements", ("Scene.load that changes",),
     "the traction locked in by a rising pressure follows from forces only, give Fretting.forces, or a LineLoad"),
    ("Scene.shapes that move with a body", ("Scene.rolling", "TractiveRolling"),
     "heights that travel through the contact make no steady state, give heights that are fixed in its frame"),
    ("Scene.friction in partial slip", ("Scene.solids that are elastically dissimilar",),
     "such bodies slip under the normal load alone, give bodies of one material, or Sliding"),
    ("Scene.friction in sliding of dissimilar bodies", ("Scene.solids that creep",),
     "creep of their coupling is not computed, give equal bodies, or an incompressible one on a rigid one"),
    ("Scene.friction in sliding of dissimilar bodies", ("Scene.rolling",),
     "both make the pressure asymmetric, which is not computed, give bodies of one material, or TractiveRolling"),
    # free faces
    ("Scene.lubrication", ("Scene.solids with free_faces",),
     "a film is computed as periodic along the length, leave it out, or leave free_faces out and give a Crown or a "
     "LundbergProfile"),
    ("Scene.solids with free_faces", ("Scene.solids that creep", "Scene.solids that yield", "Scene.rolling"),
     "faces of such bodies are not computed, leave one of them out, or end the contact by a FiniteLength"),
    ("Scene.solids with free_faces",
     ("Scene.friction with stick", "Scene.friction of unequal bodies", "friction and Scene.outputs"),
     "how faces change the response to tangential traction is not computed, leave free_faces out, or end the contact by "
     "a FiniteLength"),
    # adhesion
    ("Scene.adhesion", ("Scene.wear",),
     "Archard's law does not say how much the attraction wears, leave one of them out"),
    ("Scene.adhesion", ("Scene.lubrication",),
     "a film keeps the surfaces out of each other's reach, leave one of them out"),
    ("Scene.adhesion", ("Rolling.passes", "rolling of Scene.solids that creep"),
     "such bodies part behind with more work than they join with ahead, which is not computed, give elastic bodies "
     "without passes, or leave one of them out"),
    ("Scene.adhesion", ("Fretting.times",), "the contact jumps, give forces without times"),
    ("Adhesion.range is None", ("Scene.friction", "Scene.solids that yield"),
     "in the limit of short ranges the attraction grows without limit as the cells get smaller, and with it friction "
     "and plastic strain, give Adhesion.range"),
    # wear
    ("Scene.wear", ("Scene.lubrication without a boundary film",),
     "the film keeps the bodies apart, so that nothing wears, give Lubrication.boundary, or leave wear out"),
    ("Wear.speed", ("Scene.lubrication", "TractiveRolling", "Fretting"),
     "the sliding follows from these, give a speed of 0 m/s"),
    ("Scene.wear of a body that turns or in a film",
     ("Scene.load that changes", "Fretting.times", "Scene.solids at rest that creep or yield"),
     "such wear is followed from one steady contact to the next, give a LineLoad, no times, and bodies that are elastic "
     "or roll"),
    # films
    ("Scene.lubrication", ("Scene.rolling",), "Lubrication.mean_speed moves the surfaces already, leave rolling out"),
    ("Scene.lubrication", ("Scene.friction",),
     "Lubricant.shear and the boundary film give the friction, leave Scene.friction out"),
    ("a change in time under a film", ("Scene.solids that creep", "Lubrication.boundary", "Lubrication.thermal"),
     "these are computed under a steady film only, leave one of them out"),
)  # fmt: skip


def method_of(scene: Any) -> Method:
    """Return the method by which a :class:`~contactstudy.Scene` is solved."""
    return next(method for words, method in METHODS if scene.named.issuperset(words))


def refuse_pairs(scene: Any) -> None:
    """Raise :class:`~contactstudy.InvalidInput` for two effects of a scene that cannot be combined."""
    for effect, others, reason in REFUSED:
        for other in others:
            if scene.named.issuperset((effect, other)):
                field = effect.removeprefix("Scene.")
                value = repr(getattr(scene, field, None))
                is_short = hasattr(scene, field) and len(value) < 60
                pair = f"{effect}{f' is {value}' * is_short} together with {other}"
                changing = f"{changing_field(scene)}, which changes in time"
                raise InvalidInput(f"{pair.replace('a change in time', changing)}: {reason}.")


def named_by(scene: Any) -> frozenset[str]:
    """Return what a :class:`~contactstudy.Scene` names, in the words of the tables."""
    load, film, friction, solids = scene.load, scene.lubrication, scene.friction, scene.solids
    slots = "rolling", "friction", "lubrication", "adhesion", "wear"
    effects = {name: effect for name in slots if (effect := getattr(scene, name)) is not None}
    named = {f"Scene.{name}" for name in effects} | {type(effect).__name__ for effect in effects.values()}
    for effect in effects.values():
        fields = getattr(effect, "__dict__", {})
        named |= {f"{type(effect).__name__}.{name}" for name, value in fields.items() if value}
    has_rolling, tractive, has_passes = "Scene.rolling" in named, "TractiveRolling" in named, "Rolling.passes" in named
    creep, plastic = any(map(creeps, solids)), any(map(yields, solids))
    rolls, changes = has_rolling or (tractive and creep), changing_field(scene) is not None
    is_history, slips = isinstance(load, loads.ChangingLoad), not named.isdisjoint(("PartialSlip", "Fretting"))
    is_dissimilar = False
    if (slips or "Sliding" in named) and friction.coefficient > 0:
        from contactstudy.scene.friction import are_similar  # imported only where there is friction

        is_dissimilar = not are_similar(solids)
    # wear under a film is followed from one steady film to the next
    film_changes = film is not None and (not isinstance(film.mean_speed, float) or (changes and scene.wear is None))
    conditions = {
        "Scene.load on a point contact": scene.is_point_contact,
        "Scene.load is an Approach": isinstance(load, loads.Approach),
        "Scene.load is a PullOff": isinstance(load, loads.PullOff),
        "Scene.load that changes": is_history,
        "Scene.load that falls": isinstance(load, loads.PullOff) or (is_history and loads.falls(load)),
        "a change in time": changes,
        "a change in time under a film": film_changes,
        "Scene.hardness": scene.hardness < inf,
        "Scene.outputs": bool(scene.outputs),
        "Scene.solids that creep": creep,
        "Scene.solids that yield": plastic,
        "Scene.solids at rest that creep or yield": (creep or plastic) and film is None and not rolls,
        "Scene.solids that are elastically dissimilar": is_dissimilar,
        "Scene.solids with free_faces": scene.free_length < inf,
        "Scene.shapes that move with a body": any(hasattr(shape, "gap_after") for shape in scene.shapes),
        "Scene.rolling without passes": has_rolling and not has_passes,
        "passes over Scene.solids that yield": has_passes and plastic,
        "rolling of Scene.solids that creep": rolls and creep,
        "rolling at a speed": rolls and not has_passes,
        "a contact that rolls": has_rolling or tractive,
        "Scene.friction with stick": getattr(friction, "sticks", False),
        "Scene.friction of unequal bodies": friction is not None and solids[0] != solids[1],
        "friction and Scene.outputs": friction is not None and bool(scene.outputs),
        "Scene.friction in partial slip": slips,
        "Scene.friction in partial slip without times": slips and "Fretting.times" not in named,
        "Scene.friction in sliding of dissimilar bodies": is_dissimilar and not slips,
        "Adhesion.range is None": "Scene.adhesion" in named and "Adhesion.range" not in named,
        "Scene.lubrication without a boundary film": film is not None and film.boundary is None,
        "Scene.wear of a body that turns or in a film": "Wear.circumference" in named
        or {"Scene.wear", "Scene.lubrication"} <= named,
    }
    return frozenset(named | {condition for condition, is_met in conditions.items() if is_met})


def changing_field(scene: Any) -> str | None:
    """Return the first field of a scene that changes in time by itself, such as a body that creeps; None without one.

    A body that creeps does not change in time where it rolls, or passes through a film, since it has crept there. Shapes
    move with a body under a film alone: a dry scene is solved as they lie, and refused where it rolls.
    """
    film = scene.lubrication
    has_crept = film is not None or scene.rolls
    changing = {
        "Scene.load": isinstance(scene.load, loads.ChangingLoad),
        "Scene.wear": scene.wear is not None,
        "Scene.friction": getattr(scene.friction, "times", None) is not None,
    }
    for number, solid in enumerate(scene.solids):
        changing[f"Scene.solids[{number}]"] = yields(solid) or (creeps(solid) and not has_crept)
    if film is not None:
        changing["Scene.lubrication.mean_speed"] = not isinstance(film.mean_speed, float)
        for number, shape in enumerate(scene.shapes):
            changing[f"Scene.shapes[{number}]"] = hasattr(shape, "gap_after")
    return next((field for field, changes in changing.items() if changes), None)
