"""Which memories a scene asks for."""

from math import pi

from contactstudy.elasticity.coefficients import Displacement
from contactstudy.evolution.memories.creep import CreepMemory
from contactstudy.evolution.memories.memory import Memory
from contactstudy.evolution.memories.wear import WearMemory
from contactstudy.scene.bodies.viscoelastic import ViscoelasticHalfSpace
from contactstudy.scene.scene import Scene


def memories(scene: Scene, datum: float) -> tuple[Memory, ...]:
    """Those of its bodies, then that of its wear; ``datum`` [m] as in a body's ``response``."""
    found: list[Memory] = [
        CreepMemory(body.creep.times(1 / pi), Displacement(datum))
        for body in scene.solids
        if isinstance(body, ViscoelasticHalfSpace) and body.creeps
    ]
    if scene.wear is not None and scene.wear.rate > 0:
        found.append(WearMemory(scene.wear.rate))
    return tuple(found)
