"""Continuation in speed: where cold starts fail, a film is followed from a higher speed down."""

from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt

from contactstudy.lubrication.newton.pseudo_time import FilmIteration
from contactstudy.lubrication.posed_film import PosedFilm


@dataclass(frozen=True)
class SpeedSteps:
    """Factor of each step in speed, the most increases, and the least factor of a decrease."""

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
    """Return the film that is followed from the first higher speed where a ``cold`` start converges.

    Each lower speed has a ``warm`` start from the last; a step down that fails is tried again with the square root of
    its factor. None where no higher speed converges, or the factor falls below the least.
    """
    wanted = faster = posed.equation.speed_parameter
    for _ in range(steps.max_increases):
        faster *= steps.factor
        last = cold(posed.at(faster))
        if last.converged(tolerance):
            break
    else:
        return None
    factor = steps.factor
    while faster > wanted:
        slower = faster / factor
        if slower <= wanted * steps.min_factor:  # avoid a tiny last step
            slower = wanted
        trial = warm(posed.at(slower), last)
        if trial.converged(tolerance):
            last, faster = trial, slower
        else:
            factor = sqrt(factor)
            if factor <= steps.min_factor:
                return None
    return last
