"""Forecast of what a run will cost: the seconds that the plans of its cases give."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import contactstudy as cs
from studies.model.case import Computation

MAX_PLANNED = 16  # cases that are planned at most, evenly spaced


@dataclass(frozen=True)
class Forecast:
    """Expected cost of a run.

    Attributes
    ----------
    cases
        Number of cases to compute.
    runs
        Number of timed runs to take.
    seconds
        Seconds of all cases, one after the other on one thread, as their plans give them; None where a case has no plan.
    """

    cases: int
    runs: int
    seconds: float | None

    def __str__(self) -> str:
        if self.seconds is None:
            text = "how long is not known: its cases are no scenes on a grid, and have no plan"
        else:
            text = f"about {self.seconds:.2g} s to compute (shared by the workers)"
            if self.runs:
                text += f", {self.seconds * self.runs / max(self.cases, 1):.2g} s to time"
        return text


def forecast(cases: Sequence[Computation], runs: int, scale: float = 1.0) -> Forecast:
    """Return the expected cost of a run.

    Of many cases a few are planned, evenly spaced; a padding other than that of the plan is not accounted for.

    Parameters
    ----------
    cases
        The cases to compute.
    runs
        Number of timed runs to take.
    scale
        Ratio of the cases of the run to these.
    """
    chosen = cases[:: -(-len(cases) // MAX_PLANNED) or 1]
    seconds: float | None = 0.0 if not cases else None
    with suppress(Exception):  # a study's own computation is anything
        planned = [cs.plan(case.scene, grid=case.grid).seconds for case in chosen]  # type: ignore[attr-defined]
        seconds = sum(planned) * len(cases) / len(planned) * scale
    return Forecast(round(scale * len(cases)), round(scale * runs), seconds)
