"""The verdict on hard cases by a reference, with every padding."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import NamedTuple

import contactstudy as cs
from contactstudy.domain.fields import Array
from studies.definitions import hard_cases
from studies.definitions.hard_cases import UNFINISHED, stated_error
from studies.reference.line_contact import relative_l1

FREE, EXACT = cs.ZeroPadding(), cs.ExactPeriodicity()
PADDINGS: dict[str, cs.Padding | cs.Paddings] = {
    "zero": FREE,
    "duplicated": cs.DuplicatedPadding(),
    "superposed": cs.Superposition(2),
    "circular": cs.CircularSuperposition(2),
    "exact": EXACT,
    "exact on both": (EXACT, EXACT),
    "circular on both": (cs.CircularSuperposition(1), cs.DuplicatedPadding()),
}


class Verdict(Enum):
    """On an answer: its error is within the stated one; a status explains why there is none; or neither."""

    WITHIN_STATED_ERROR = 0
    EXPLAINED_BY_STATUS = 1
    WRONG = 2
    NOT_APPLICABLE = 3


class Judgement(NamedTuple):
    """Verdict on an answer, its relative L1 error, and the one that the program states; infinite without an answer."""

    verdict: Verdict
    error: float = inf
    stated: float = inf


@dataclass(frozen=True)
class HardCase(hard_cases.HardCase):
    """A hard case with the names of the paddings to which it applies."""

    paddings: tuple[str, ...] = tuple(PADDINGS)

    def judge(
        self, solution: cs.Contact, padding: str, reference: Callable[[], tuple[Array, float]]
    ) -> Judgement:
        """The verdict by a pressure (x, y) [Pa] and a bound on its own relative L1 error.

        The stated error is that by the residual in ``solution.error``.
        """
        if padding not in self.paddings:
            return Judgement(Verdict.NOT_APPLICABLE)
        expected = self.expects(solution, PADDINGS[padding])
        if solution.status in UNFINISHED:
            return Judgement(Verdict.EXPLAINED_BY_STATUS if expected else Verdict.WRONG)
        pressure, of_reference = reference()
        error, stated = relative_l1(solution.pressure, pressure), stated_error(solution)
        right = expected and error <= stated + of_reference and self.is_useful(stated)
        return Judgement(Verdict.WITHIN_STATED_ERROR if right else Verdict.WRONG, error, stated)
