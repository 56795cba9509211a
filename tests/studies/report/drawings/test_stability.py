import numpy as np
import xarray as xr

from studies.reference.hard_cases import CASES
from tests.studies.report.drawings.drawn import findings, rows

RIGHT, EXPLAINED, WRONG, NOT = range(4)
SOLVERS = ["preconditioned CG", "Polonsky-Keer"]


def hard(cases: list[str]) -> xr.Dataset:
    """Three cases of which the first is solved, the second has no answer, and the third is once wrong; others
    are solved alike. Two paddings and two solvers; the last combination applies to the first case alone.
    """
    count = len(cases)
    axes = ("case", "padding", "solver")
    verdict = np.full((count, 2, 2), RIGHT)
    verdict[1] = EXPLAINED
    verdict[2, 0, 1] = WRONG
    verdict[1:, 1, 1] = NOT
    error = np.full((count, 2, 2), 2e-9)
    error[0] = [[4e-10, 0.0], [3e-9, 7e-9]]
    stated = np.full((count, 2, 2), 8e-9)
    stated[0] = [[4e-9, 1e-9], [6e-9, 1e-8]]
    status = np.zeros((count, 2, 2), dtype=int)
    status[1] = [[1, 2], [1, 0]]
    iterations = np.full((count, 2, 2), 20)
    iterations[1] = [[11, 12], [13, 99]]
    return xr.Dataset(
        {
            "verdict": (axes, verdict),
            "pressure_error": (axes, error),
            "stated_error": (axes, stated),
            "solver_status": (axes, status, {"flag_meanings": "converged at_edge no_answer"}),
            "iterations": (axes, iterations),
        },
        coords={"case": cases, "padding": ["zero", "exact"], "solver": SOLVERS},
    )


THREE = list(CASES)[:3]


def test_the_table_counts_the_solves_of_each_group_and_has_its_largest_errors() -> None:
    table = [(row[0], *row[2:]) for row in rows("stability", hard([*THREE, "faint load"]))]
    assert table == [
        ("discretisation", "3", "6", "3", "1", "7e-09", "1e-08"),
        ("load", "1", "3", "0", "0", "2e-09", "8e-09"),
    ]
    explained = hard([THREE[0], "faint load", THREE[1]])
    assert rows("stability", explained)[1][2:] == ("1", "0", "3", "0", "none", "none")
    # every family is explained
    assert all(row[1] for row in rows("stability", hard(list(CASES))))


def test_the_finding_is_of_all_cases_and_says_how_near_errors_come_to_the_stated() -> None:
    assert not findings("stability", hard(THREE))
    every = hard(list(CASES))
    [said] = findings("stability", every)
    assert said.startswith("Some hard cases end neither")
    count = len(CASES)
    assert f"{count} difficult contacts were solved with 2 paddings and 2 solvers" in said
    # four of the first, two of the third, three of each other
    assert f": {4 + 2 + 3 * (count - 3)} solves have an error within" in said
    assert "3 end with a status that explains" in said
    assert f"Those with a status in the place of an answer: {THREE[1]} (3)." in said
    assert f"and 1 do neither ({THREE[2]})" in said
    # 2 over 8 of nearly all; 7 over 10 of the last of the first case
    assert "The median error is 25 % of the stated error, the largest 70 %" in said
    every["verdict"] = every["verdict"].where(every["verdict"] != WRONG, RIGHT)
    [said] = findings("stability", every)
    assert said.startswith("Hard cases end with an error within the stated one")
