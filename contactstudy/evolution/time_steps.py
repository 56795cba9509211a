"""Steps in time as a user names them: instants to record, stages of a step, and the estimate of their error."""

from math import sqrt
from typing import Annotated, Any, Literal

from numpy.typing import ArrayLike

from contactstudy.domain.validation import BELOW_ONE, FINITE, InvalidInput, Number, Seconds, at_least, validated
from contactstudy.scene.loads import ChangingLoad, Times

# Recorded instants where neither they nor their number are named.
DEFAULT_INSTANTS = 41
# gamma of the L-stable two-stage SDIRK scheme of order 2.
SDIRK_GAMMA = 1 - 1 / sqrt(2)

Scheme = Literal["two_stage", "implicit", "explicit"]
# Stages of a step of sliding wear in the order of time: for each its fraction of the duration, and the fraction of the
# stage that is explicit.
STAGES: dict[Scheme, tuple[tuple[float, float], ...]] = {
    "two_stage": ((SDIRK_GAMMA, 0.0), (1 - SDIRK_GAMMA, (1 - 2 * SDIRK_GAMMA) / (1 - SDIRK_GAMMA))),
    "implicit": ((1.0, 0.0),),
    "explicit": ((1.0, 1.0),),
}
ErrorEstimator = Literal["step_doubling", "none"]


@validated
class TimeSteps:
    """Instants to record of a scene that changes in time, and how steps between them are taken.

    Parameters
    ----------
    times
        The instants [s], which do not decrease; None for evenly spaced ones. A time given twice is recorded before and
        after a jump of the load; films and wear in rolling refuse it.
    end
        Last instant [s]; None for the last one that a history of load, speed or friction names.
    instants
        Number of instants, evenly spaced but for those moved to where a history has a kink or turns.
    error
        Largest relative time-discretisation error, in L1, of the pressure and in fretting of the tangential traction.
        Where a contact wears in steady or tractive rolling or on a film, it is the largest change of the pressure by
        the correction of a step; of other films, the largest error of their thickness in one step; films over bodies
        that yield refuse it. None takes a fraction of the error requested of the solve. Without that, there is one step
        from each instant to the next, and to each kink of the load or quarter of its period, or two where the next one
        differs in length; steady wear and films take 1e-3.
    scheme
        How sliding wear, ``Wear(speed=...)`` of a dry contact that does not roll, is stepped; other wear has a method of
        its own, and creep is exact for a pressure that is linear in each stage. "implicit" is backward Euler, of first
        order, L-stable, with one solve a step; "two_stage" is of second order, L-stable, with two solves (Alexander
        1977, SIAM J. Numer. Anal. 14, sect. 3); "explicit", for comparison, is forward Euler, unstable in plane strain
        for steps [s] beyond 2 lambda / (k v), with the wear rate per pressure k v [m/(Pa s)] and the
        :func:`~contactstudy.evolution.states.state_variables.least_eigenvalue` lambda. Each keeps the wear volume.
    error_estimator
        How the time-discretisation error is estimated of a dry contact that keeps creep, sliding wear, plastic strain
        or a tangential traction from one instant to the next: by "step_doubling", a second integration with steps twice
        as long, at half the cost of the first; or "none", one step from each instant or kink of the load to the next,
        with an infinite error.
    step
        Largest length [s] of a step of a film, in place of an error.

    Raises
    ------
    InvalidInput
        If an `error` is given beside the estimator ``"none"`` or a `step`, or `times` beside `end` or `instants`.
    """

    times: Times | None = None
    end: Annotated[Seconds, FINITE] | None = None
    instants: Annotated[int, at_least(2)] = DEFAULT_INSTANTS
    error: Annotated[Number, BELOW_ONE] | None = None
    scheme: Scheme = "implicit"
    error_estimator: ErrorEstimator = "step_doubling"
    step: Seconds | None = None

    def check_together(self) -> None:
        """Check that what decides on the instants and on the steps is given once."""
        if self.error is not None and self.error_estimator == "none":
            raise InvalidInput(
                f"TimeSteps.error_estimator is 'none' beside an error of {self.error!r}, by whose estimate steps are "
                "chosen: leave one of them out."
            )
        if self.times == ():
            raise InvalidInput("TimeSteps.times is empty: give one instant [s] or more, or leave it out.")
        if self.error is not None and self.step is not None:
            raise InvalidInput("TimeSteps has a step and an error: leave one of them out.")
        for name, default in (("end", None), ("instants", DEFAULT_INSTANTS)):
            if self.times is not None and (value := getattr(self, name)) != default:
                raise InvalidInput(
                    f"TimeSteps.{name} is {value!r} beside times, which name all instants: leave one of them out."
                )

    @classmethod
    def of(cls, times: "ArrayLike | TimeSteps | None") -> "TimeSteps":
        """Return `times` as time steps: as they are, or from instants to record [s]."""
        return times if isinstance(times, cls) else cls(times)  # type: ignore[arg-type]

    @property
    def last(self) -> float | None:
        """Last instant [s] that is named; None where the end of a history decides."""
        return self.end if self.times is None else max(self.times)

    def instants_of(self, *histories: Any) -> ArrayLike:
        """Return the instants [s] to record.

        They are `times`, if these are given, else evenly spaced up to `end`, or up to the last end of the `histories`.
        Without a `step`, the nearest of the evenly spaced instants between the first and the last is moved to
        where a history has a kink or turns; of several of them, to that of the largest value.

        Raises
        ------
        InvalidInput
            If nothing says when the last instant is.
        """
        if self.times is not None:
            return self.times
        start = min((history.start for history in histories), default=0.0)
        last = max((history.end for history in histories), default=start)
        if self.end is None and last <= start:
            raise InvalidInput(
                "solve.times is None, and nothing in the scene has an end: give times [s]; "
                "in a file give time_steps.end or time_steps.times."
            )
        end = last if self.end is None else self.end
        count = self.instants
        instants = [start + (end - start) * n / (count - 1) for n in range(count)]
        spacing = (end - start) / (count - 1)
        if self.step is None and spacing and count > 2:
            # of kinks near one instant the last counts: that of the load, the first history, at its largest value
            for time in (time for history in reversed(histories) for time in kinks(history, end)):
                if start < time < end:
                    number = round((time - start) / spacing)
                    instants[min(max(number, 1), count - 2)] = time
        return instants


def kinks(history: Any, end: float) -> list[float]:
    """Return the times [s] up to `end` at which a history has a kink or turns, those of its largest values last."""
    times = getattr(history, "times", ())
    if isinstance(history, ChangingLoad):
        times = history.turning_points(end)
    return sorted(times, key=lambda time: abs(history.at(time)))
