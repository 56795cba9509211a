"""Control of the step length by the error that a pair of steps adds."""

from dataclasses import dataclass

from contactstudy.domain.checks import InvalidInput, checked_relative_error

# In the first integration, a pair of steps may add this fraction of the allowed error to the difference of two
# integrations.
INITIAL_TOLERANCE_FRACTION = 0.5
# Smallest and largest factor on the length of a step, and the fraction of the allowed length that is aimed at.
MIN_FACTOR, MAX_FACTOR, SAFETY = 0.2, 2.0, 0.9
# The error increment of a pair grows with its length to this power; that of all pairs, to this power minus 1.
ORDER = 2
# Duration of the first pair of steps over that of the integration: if it is too long, it is rejected.
INITIAL_STEP = 1e-2
# Steps of an integration that starts again, over those before, at most.
MAX_RESTART_FACTOR = 0.7
# The least ratio of the error to the solver's tolerance, so that the solver's error does not count.
MIN_ERROR_OVER_TOLERANCE = 100


@dataclass(frozen=True)
class StepControl:
    """Control of the step length by the error increment: by how much a pair of steps raises the error estimate.

    How far later steps damp that error is not known in advance: if the accumulated error exceeds the allowed one, the
    integration restarts with a :meth:`stricter` control.

    Attributes
    ----------
    error
        Allowed relative L1 time-discretisation error.
    local_tolerance
        Allowed error increment of a pair of steps.
    """

    error: float
    local_tolerance: float

    @classmethod
    def for_error(cls, error: float, tolerance: float) -> "StepControl":
        """Return the control of a first integration.

        Parameters
        ----------
        error
            Allowed relative L1 time-discretisation error.
        tolerance
            Tolerance of the solver.

        Raises
        ------
        InvalidInput
            If the error is not between 0 and 1, or too close to the tolerance for steps to meet it.
        """
        error = checked_relative_error("TimeSteps.error", error)
        if error < MIN_ERROR_OVER_TOLERANCE * tolerance:
            raise InvalidInput(
                f"solve.error or TimeSteps.error leaves {error!r} to the steps in time: give at least "
                f"{MIN_ERROR_OVER_TOLERANCE} times the tolerance of the contacts, or a smaller tolerance."
            )
        return cls(error, INITIAL_TOLERANCE_FRACTION * error)

    def accepts(self, error_increment: float) -> bool:
        """Return whether a pair of steps with this `error_increment` is short enough."""
        return error_increment <= self.local_tolerance

    def factor(self, error_increment: float) -> float:
        """Return the factor on the length of the next pair, after one with this `error_increment`."""
        if error_increment <= 0:
            return MAX_FACTOR
        longer: float = (self.local_tolerance / error_increment) ** (1 / ORDER)
        return min(max(SAFETY * longer, MIN_FACTOR), MAX_FACTOR)

    def stricter(self, excessive_error: float) -> "StepControl":
        """Return the control of the next integration, after one whose error is above the allowed one."""
        shorter = min(SAFETY * self.error / excessive_error, MAX_RESTART_FACTOR) ** (
            ORDER / (ORDER - 1)
        )
        return StepControl(self.error, self.local_tolerance * shorter)
