import numpy as np
import xarray as xr

from studies.definitions.hard_cases import CASES
from tests.studies.report.drawings.drawn import findings, rows

RIGHT, EXPLAINED, WRONG, NOT = range(4)


def hard(cases: list[str]) -> xr.Dataset:
    """The first case is solved, the second has no answer, the third is once wrong; others are solved alike."""
    axes, shape = ("case", "padding", "solver"), (len(cases), 2, 2)
    verdict = np.full(shape, RIGHT)
    verdict[1] = EXPLAINED
    verdict[2, 0, 1] = WRONG
    verdict[1:, 1, 1] = NOT
    error, stated = np.full(shape, 2e-9), np.full(shape, 8e-9)
    error[0], stated[0] = [[4e-10, 0.0], [3e-9, 7e-9]], [[4e-9, 1e-9], [6e-9, 1e-8]]
    data = {
        "verdict": (axes, verdict), "pressure_error_l1": (axes, error), "stated_error": (axes, stated),
        "case_status": (axes, np.ones(shape)),
    }  # fmt: skip
    coords = {"case": cases, "padding": ["zero", "exact"], "solver": ["one", "other"]}
    return xr.Dataset(data, coords)


def test_the_table_counts_the_solves_of_each_case_and_has_its_largest_errors() -> None:
    assert rows("stability", hard(["a", "b", "c"])) == [
        ("a", "4", "0", "0", "7e-09", "1e-08"),
        ("b", "0", "3", "0", "none", "none"),
        ("c", "2", "0", "1", "2e-09", "8e-09"),
    ]


def test_the_finding_is_of_all_cases_and_says_which_are_wrong() -> None:
    assert not findings("stability", hard(list(CASES)[:3]))
    every = hard(list(CASES))
    [said] = findings("stability", every)
    assert said.startswith("Not all hard cases end")
    count = len(CASES)
    assert f"{count} difficult contacts were solved with 2 paddings and 2 solvers" in said
    # four of the first, two of the third, three of each other
    assert f": {4 + 2 + 3 * (count - 3)} solves differ from those" in said
    assert "3 end with a status that explains" in said
    assert f"and 1 do neither ({list(CASES)[2]})" in said
    # 2 over 8 of nearly all
    assert "The median difference is 25 % of the stated error" in said
    every["verdict"] = every["verdict"].where(every["verdict"] != WRONG, RIGHT)
    [said] = findings("stability", every)
    assert said.startswith("All hard cases end with the same answer by two solvers")
