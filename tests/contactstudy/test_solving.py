"""What `solve` reports, and the keywords that it takes for each kind of scene."""

from dataclasses import replace

import pytest

import contactstudy as cs
from tests.contactstudy.evolution.creeping import SOLID, rolling_cylinder
from tests.contactstudy.evolution.test_roll_repeatedly import scene as yielding_cylinder
from tests.contactstudy.lubrication import scenes as films

EXACT = cs.ExactPeriodicity()
# A scene of each kind that a method of its own solves at one instant, with its grid.
KINDS = {
    "static": (films.DRY, films.grid(24, 1.2)),
    "rolling": (
        rolling_cylinder(SOLID, rolling=cs.Rolling(speed=0.1)),
        cs.Grid((24, 1), (0.6, 1.0)),
    ),
    "passes": (
        replace(yielding_cylinder(2.2), rolling=cs.Rolling(passes=2, distance=0.4)),
        cs.Grid((24, 1), (4.8, 1.0)),
    ),
    "film": (films.by_moes(20, 2), films.grid(64, 3.0)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_solve_reports_its_progress(kind: str) -> None:
    seen: list[cs.Progress] = []
    cs.solve(*KINDS[kind], EXACT, progress=seen.append)
    fractions = [progress.fraction for progress in seen]
    assert 0 <= min(fractions) < 1
    assert fractions[-1] == 1
    assert all(progress.text for progress in seen)
