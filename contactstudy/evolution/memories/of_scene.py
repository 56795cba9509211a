"""Which memories a scene asks for."""

from collections.abc import Callable
from math import pi

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Precision
from contactstudy.elasticity.coefficients import Displacement
from contactstudy.evolution.memories.creep import CreepMemory
from contactstudy.evolution.memories.memory import JointMemory, Memory
from contactstudy.evolution.memories.wear import WearMemory
from contactstudy.problem.problem import Problem
from contactstudy.scene.inelastic import ViscoelasticHalfSpace
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution


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


def joint_memory(
    scene: Scene, problem: Problem, solved: Callable[[Problem], Solution], precision: Precision
) -> JointMemory | None:
    """That of bodies that yield, from the elastic ``problem`` of the largest load; None without any.

    Raises :class:`~contactstudy.InvalidInput` for a padding on which plastic strain has no operator.
    """
    if not any(getattr(body, "yields", False) for body in scene.solids):
        return None
    # here, for those who name such a body
    from contactstudy.evolution.memories.plastic import PlasticMemory, YieldingBody

    paddings = problem.paddings
    assert paddings is not None
    across, along = paddings
    if not problem.open_edges or along.window is not None:
        raise InvalidInput(
            f"evolve.padding is {across!r} across and {along!r} along: plastic strain is known below a surface "
            "that goes on across and repeats along, give ExactPeriodicity()."
        )
    return PlasticMemory(YieldingBody.all_of(scene), solved(problem), precision)
