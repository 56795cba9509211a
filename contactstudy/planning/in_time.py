"""What a scene that changes in time asks of a grid and of its steps."""

from dataclasses import dataclass, replace
from math import inf, log10, pi, sqrt

import numpy as np

from contactstudy.planning.grid_requirements import ROOM
from contactstudy.planning.yielding import Yielding, yielding
from contactstudy.scene.bodies import Body, sudden
from contactstudy.scene.inelastic import ViscoelasticHalfSpace
from contactstudy.scene.load import ChangingLoad, LineLoad
from contactstudy.scene.scene import Scene

# Solves of a march, with its companion and what is rejected, for an error of 1: of a held load, by the power CREEP_RATE
# and for each decade of relaxation times; of wear, which is of first order, by the number of times the contact
# doubles its width. Measured on a cylinder; within a factor of some three.
CREEP, CREEP_RATE = 7.0, 0.37
WEAR, WEAR_RATE = 1.2, 1.0
# Passes of a steadily rolling contact; as many as these times the ratio of its compliances to 1e-6.
PASSES = 8


@dataclass(frozen=True)
class Extremes:
    """The ``narrow`` scene that needs the finest cells, the ``width`` [m] that holds the widest contact.

    ``steps`` are solves, ``fields`` what is kept between them beside one solve, ``reasons`` a sentence each.
    ``plastic`` is what bodies that yield ask.
    """

    narrow: Scene
    width: float
    steps: int
    fields: int
    reasons: tuple[str, ...]
    plastic: Yielding | None = None


def extremes(scene: Scene, error: float) -> Extremes:
    """Those of ``scene`` up to the end of its load, marched with steps for ``error``."""
    load = LineLoad(scene.load.largest)
    narrow = replace(scene, load=load, solids=sudden(scene.solids), wear=None, rolling=None)
    bodies = [b for b in scene.solids if isinstance(b, ViscoelasticHalfSpace) and b.creeps]
    end = scene.load.end - scene.load.start if isinstance(scene.load, ChangingLoad) else 0.0
    softest = sum(_softest(body, end) for body in scene.solids)
    hertz = narrow.hertz
    half_width = 0.0
    reasons = []
    if hertz is not None:
        half_width = sqrt(4 * load.per_length * hertz.radius * softest / pi)
    fields = 2 * sum(len(body.creep.terms) + bool(body.creep.fluidity) for body in bodies) + 8
    if scene.rolling is not None:
        ratio = softest * narrow.contact_modulus
        passes = round(PASSES * (1 + ratio))
        reasons.append(f"rolling: some {passes} passes until the lagged part settles.")
        return Extremes(narrow, 2 * ROOM * half_width * 1.5, passes, 4 * PASSES, tuple(reasons))
    steps = 1.0
    plastic = yielding(scene)
    if plastic is not None:
        steps += plastic.steps(error)
        half_width = max(half_width, plastic.reach / ROOM)
    if bodies:
        times = [time for body in bodies for _, time in body.creep.terms] or [end or 1.0]
        decades = 1 + log10(max(times) / min(times))
        steps += CREEP * decades * error**-CREEP_RATE
    if scene.wear is not None and hertz is not None and end:
        worn = 1.5 * hertz.radius * scene.wear.rate * load.per_length * end
        wider = float(np.cbrt(half_width**3 + worn))
        steps += WEAR * (1 + log10(wider / half_width) / log10(2)) * error**-WEAR_RATE
        half_width = wider
    reasons.append(
        f"time: some {steps:.2g} solves for an error of {error:.1g} by the steps, with those that "
        "estimate it, if evolve(error=...) chooses them."
    )
    return Extremes(narrow, 2 * ROOM * half_width, round(steps), fields, tuple(reasons), plastic)


def _softest(body: Body, end: float) -> float:
    """The largest compliance [1/Pa] of ``body``, of a fluid that at the ``end`` [s]."""
    if not isinstance(body, ViscoelasticHalfSpace):
        return body.compliance
    relaxed = body.creep.equilibrium
    return relaxed if relaxed < inf else float(body.creep(end))
