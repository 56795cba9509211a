"""Continuation in speed: where no start leads to a film, one at a higher speed is followed down to it."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

from contactstudy.lubrication.posed_film import PosedFilm
from contactstudy.lubrication.pseudo_time import FilmIteration


@dataclass(frozen=True)
class SpeedSteps:
    """Factor of each increase of the speed, the number of increases at most, and the least factor of a decrease."""

    factor: float
    max_increases: int
    min_factor: float


def from_higher_speeds(
    posed: PosedFilm,
    steps: SpeedSteps,
    tolerance: float,
    cold: Callable[[PosedFilm], FilmIteration],
    warm: Callable[[PosedFilm, FilmIteration], FilmIteration],
) -> FilmIteration | None:
    """Return the film that comes down from the first higher speed where a ``cold`` start converges.

    Each lower speed is started ``warm``; a step down that fails is tried with the root of its factor. None where no
    higher speed converges, or the factor is below the least.
    """
    resistance = faster = posed.equation.resistance
    for _ in range(steps.max_increases):
        faster *= steps.factor
        last = cold(posed.at(faster))
        if last.converged(tolerance):
            break
    else:
        return None
    factor = steps.factor
    while faster > resistance:
        # avoid a tiny last step
        slower = faster / factor if faster / factor > resistance * steps.min_factor else resistance
        trial = warm(posed.at(slower), last)
        if trial.converged(tolerance):
            last, faster = trial, slower
        else:
            factor = sqrt(factor)
            if factor <= steps.min_factor:
                return None
    return last
