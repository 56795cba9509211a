import pytest

from studies.definitions.hard_cases import SOLVERS
from tests.hard_cases.cases import CASES
from tests.hard_cases.judged import ends_well


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("name", "padding"),
    [(name, padding) for name, case in CASES.items() for padding in case.paddings],
)
def test_a_hard_case_ends_well(name: str, padding: str, solver: str) -> None:
    ends_well(name, padding, solver)
