"""Forecast of what cases will cost: the seconds that their plans give."""

from collections.abc import Sequence
from contextlib import suppress

import contactstudy as cs
from studies.model.case import Computation

MAX_PLANNED = 16  # cases that are planned at most, evenly spaced


def planned_seconds(cases: Sequence[Computation]) -> float | None:
    """Return the seconds of all cases, one after the other on one thread; None where a case has no plan.

    Of many cases a few are planned, evenly spaced; a padding other than that of the plan is not accounted for.
    """
    chosen = cases[:: -(-len(cases) // MAX_PLANNED) or 1]
    with suppress(Exception):  # a study's own computation is anything
        planned = [cs.plan(case.scene, grid=case.grid).seconds for case in chosen]  # type: ignore[attr-defined]
        return sum(planned) * len(cases) / max(len(planned), 1)
    return None
