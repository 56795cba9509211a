"""The verdict on an answer to a hard case by a dense matrix, with every padding."""

from enum import Enum
from math import inf
from typing import NamedTuple

import contactstudy as cs
from contactstudy.domain.grid import across_and_along
from studies.definitions.hard_cases import UNFINISHED, HardCase, stated_error
from studies.reference.line_contact import relative_l1
from tests.hard_cases.cases import PADDINGS
from tests.hard_cases.dense_solver import answer


class Verdict(Enum):
    """On an answer: its error is within the stated one; a status explains why there is none; or neither."""

    WITHIN_STATED_ERROR = 0
    EXPLAINED_BY_STATUS = 1
    WRONG = 2


class Judgement(NamedTuple):
    """Verdict on an answer, its relative L1 error, and the one that the program states; infinite without an answer."""

    verdict: Verdict
    error: float = inf
    stated: float = inf


def judged_by(case: HardCase, solution: cs.Contact, padding: str) -> Judgement:
    """The verdict by a dense matrix. The stated error is that by the residual in ``solution.error``."""
    expected = case.expects(solution, PADDINGS[padding])
    if solution.status in UNFINISHED:
        return Judgement(Verdict.EXPLAINED_BY_STATUS if expected else Verdict.WRONG)
    dense = answer(case.scene, case.grid, across_and_along(PADDINGS[padding]), solution)
    pressure = dense.pressure * solution.problem.scales.pressure
    error, stated = relative_l1(solution.pressure, pressure), stated_error(solution)
    right = expected and error <= stated + dense.error and case.is_useful(stated)
    return Judgement(Verdict.WITHIN_STATED_ERROR if right else Verdict.WRONG, error, stated)
