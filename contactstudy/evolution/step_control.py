"""How long the next step is, for an error."""

from dataclasses import dataclass

from contactstudy.domain.checks import InvalidInput, positive

# Aim at this share of the error that is allowed, and change a step's length by no more than these factors.
AIM, SHRINK, GROW = 0.5, 0.2, 2.0
# The error of a pair of steps grows at least like its length to this power.
ORDER = 1.0
# The first pair of steps after a jump, over what is left until the end: too long ones are rejected.
FIRST = 1e-2
# Halving a step that does not lower the error by this factor is of no use: the error is older than the step.
USEFUL = 0.9


@dataclass(frozen=True)
class StepControl:
    """Steps for a relative L1 ``error`` of the pressure, by the difference of two marches."""

    error: float

    def __post_init__(self) -> None:
        remedy = "give a relative error above 0 and below 1, such as 1e-3"
        if positive("evolve.error", self.error, remedy) >= 1:
            raise InvalidInput(f"evolve.error is {self.error!r}: {remedy}.")

    def accepts(self, found: float, rejected: float) -> bool:
        """Whether a pair of steps with the error ``found`` is good, after one ``rejected`` for a longer pair."""
        return found <= self.error or found > USEFUL * rejected

    def factor(self, found: float) -> float:
        """How much longer the next pair of steps may be."""
        if found <= 0:
            return GROW
        return min(max((AIM * self.error / found) ** (1 / ORDER), SHRINK), GROW)
