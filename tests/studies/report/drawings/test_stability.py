import numpy as np
import xarray as xr

from studies.definitions.hard_cases import CASES
from tests.studies.report.drawings.drawn import findings, rows

RIGHT, EXPLAINED, WRONG = range(3)


def hard(cases: list[str]) -> xr.Dataset:
    """The first case is solved, the second has no answer, the third is once wrong; others are solved alike."""
    axes, shape = ("case", "padding"), (len(cases), 2)
    verdict = np.full(shape, RIGHT)
    verdict[1] = EXPLAINED
    verdict[2, 0] = WRONG
    difference, stated = np.full(shape, 2e-9), np.full(shape, 8e-9)
    difference[0], stated[0] = [4e-10, 7e-9], [4e-9, 1e-8]
    data = {
        "verdict": (axes, verdict), "pressure_difference_l1": (axes, difference), "stated_error": (axes, stated),
        "case_status": (axes, np.ones(shape)),
    }  # fmt: skip
    return xr.Dataset(data, {"case": cases, "padding": ["zero", "exact"]})


def test_the_table_counts_the_answers_of_each_case_and_has_its_largest_errors() -> None:
    assert rows("stability", hard(["a", "b", "c"])) == [
        ("a", "2", "0", "0", "7e-09", "1e-08"),
        ("b", "0", "2", "0", "none", "none"),
        ("c", "1", "0", "1", "2e-09", "8e-09"),
    ]


def test_the_finding_is_of_all_cases_and_says_which_are_wrong() -> None:
    assert not findings("stability", hard(list(CASES)[:3]))
    every = hard(list(CASES))
    [said] = findings("stability", every)
    assert said.startswith("Not all hard cases end")
    count = len(CASES)
    assert f"{count} difficult contacts were solved with 2 paddings, each by two solvers" in said
    # two of the first and of each other, one of the third
    assert f": {2 * (count - 1) - 1} pairs of answers differ" in said
    assert "2 end with a status that explains" in said
    assert f"and 1 do neither ({list(CASES)[2]})" in said
    # 2 over 8 of nearly all
    assert "The median difference is 25 % of the stated errors" in said
    every["verdict"] = every["verdict"].where(every["verdict"] != WRONG, RIGHT)
    [said] = findings("stability", every)
    assert said.startswith("All hard cases end with the same answer by two solvers")
