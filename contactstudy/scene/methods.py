"""Methods by which scenes are solved: what a scene names decides on one, which takes some keywords of a solve."""

from dataclasses import dataclass

from contactstudy.scene.loads.load_history import ChangingLoad
from contactstudy.scene.solids.bodies import SceneContext, creeps, yields


@dataclass(frozen=True)
class Method:
    """Method by which the scenes of a kind are solved.

    Parameters
    ----------
    kind
        The kind, as messages call it.
    keywords
        Keywords of :func:`~contactstudy.solve` and settings of :class:`~contactstudy.TimeSteps` that it uses, beside
        those that all methods use: an error, a period, progress, and a tolerance.
    """

    kind: str
    keywords: tuple[str, ...]

    @property
    def takes_times(self) -> bool:
        """True if it solves for several instants."""
        return "times" in self.keywords


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


def method_of(scene: SceneContext) -> Method:
    """Return the method by which a scene is solved: the first in the table below whose condition the scene meets."""
    film, wears = scene.lubrication is not None, scene.wear is not None
    changes = scene.time_dependent_field is not None
    keeps_states = any(creeps(solid) or yields(solid) for solid in scene.solids)
    wears_evenly = scene.has_tractive_rolling or getattr(scene.wear, "circumference", None) is not None
    rolls_at_speed = scene.rolling_speed is not None
    methods = (
        (film and wears, FILM_WEAR),
        (film and changes, FILM_IN_TIME),
        (film, FILM),
        (wears and (rolls_at_speed or wears_evenly), STEADY_WEAR),
        (rolls_at_speed and isinstance(scene.load, ChangingLoad), QUASI_STATIC),
        (rolls_at_speed, STEADY_ROLLING),
        (scene.rolling is not None, PASSES),
        (changes and (scene.has_tractive_rolling or (scene.adhesion is not None and not keeps_states)), QUASI_STATIC),
        (changes, TIME_DEPENDENT),
        (True, STATIC),
    )
    return next(method for applies, method in methods if applies)
