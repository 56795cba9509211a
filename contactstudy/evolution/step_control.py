"""How long the next step is, for an error."""

from dataclasses import dataclass

from contactstudy.domain.checks import InvalidInput, positive

# The first march may let the difference of two marches grow by this share of the error in a pair of steps.
SHARE = 0.5
# Change a step's length by no more than these factors, and aim a little short of what is allowed.
SHRINK, GROW, AIM = 0.2, 2.0, 0.9
# What a pair adds to the difference grows with its length to this power, all of it with the one below.
ORDER = 2
# The first pair of steps after a jump, over the whole time: too long ones are rejected.
FIRST = 1e-2
# An error should be so many times the solver's tolerance, or it would be the solver's.
ABOVE_TOLERANCE = 100


@dataclass(frozen=True)
class StepControl:
    """Steps for a relative L1 ``error`` of the pressure, by what a pair of them ``adds`` to it at the most.

    How much of it an evolution forgets cannot be known beforehand: where the sum gets too large, the march starts
    again with a :meth:`stricter` control.
    """

    error: float
    adds: float

    @classmethod
    def of(cls, error: float, tolerance: float) -> "StepControl":
        """For a first march; :class:`~contactstudy.InvalidInput` for an error that steps alone cannot meet."""
        remedy = "give a relative error above 0 and below 1, such as 1e-3"
        if positive("evolve.error", error, remedy) >= 1:
            raise InvalidInput(f"evolve.error is {error!r}: {remedy}.")
        if error < ABOVE_TOLERANCE * tolerance:
            raise InvalidInput(
                f"evolve.error is {error!r}: give {ABOVE_TOLERANCE} times evolve.tolerance or more, or a "
                "smaller tolerance."
            )
        return cls(error, SHARE * error)

    def accepts(self, added: float) -> bool:
        """Whether a pair of steps that has ``added`` so much is good."""
        return added <= self.adds

    def factor(self, added: float) -> float:
        """How much longer the next pair may be."""
        if added <= 0:
            return GROW
        longer: float = (self.adds / added) ** (1 / ORDER)
        return min(max(AIM * longer, SHRINK), GROW)

    def stricter(self, found: float) -> "StepControl":
        """After a march whose error was ``found``, above the one allowed."""
        shorter = min(AIM * self.error / found, 0.7) ** (ORDER / (ORDER - 1))
        return StepControl(self.error, self.adds * shorter)
