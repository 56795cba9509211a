"""What the drawing of hard cases plots and says of numbers that are written here."""

import numpy as np
import pytest
import xarray as xr

from studies.definitions.stability import VERDICTS
from studies.reference.hard_cases import CASES
from tests.studies.report.drawings.drawn import caption, findings, labelled, panels, rows

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


def test_every_error_stands_in_the_row_of_its_case_beside_the_largest_stated() -> None:
    [ax] = panels("stability", hard(THREE))
    shown = labelled(ax)
    # a row for each case, a solver a little above and the other a little below it; an error of zero at 1e-17
    nan = np.nan
    own = shown["error, preconditioned CG"]
    np.testing.assert_allclose(own[0], [4e-10, 3e-9, nan, nan, 2e-9, 2e-9])
    assert own[1] == pytest.approx([-0.15, -0.15, 0.85, 0.85, 1.85, 1.85])
    other = shown["error, Polonsky-Keer"]
    np.testing.assert_allclose(other[0], [1e-17, 7e-9, nan, nan, nan, nan])
    assert other[1] == pytest.approx([0.15, 0.15, 1.15, 1.15, 2.15, 2.15])
    stated = shown["largest error stated"]
    np.testing.assert_allclose(stated[0], [1e-8, nan, 8e-9])
    assert stated[1].tolist() == [0, 1, 2]
    # the case without an answer says how it ended
    [text] = ax.texts
    assert text.get_position() == (1e-16, 1)
    assert text.get_text() == "at edge, no answer; up to 13 iterations"
    assert ax.get_ylim() == (2.5, -0.5)


def test_the_caption_counts_the_solves_by_their_verdict() -> None:
    text = caption("stability", hard(THREE))
    assert "3 hard cases (distance), each with 2 paddings and 2 solvers" in text
    assert "6 solves have an error within the stated one, 3 ended with a status" in text
    assert "and 1 did neither" in text


def test_the_table_has_the_largest_error_of_the_right_ones_and_the_worst_verdict() -> None:
    first, second, third = rows("stability", hard(THREE))
    assert first == (
        THREE[0], CASES[THREE[0]].hard, "converged; up to 20 iterations", "7e-09", "1e-08",
        "within stated error",
    )  # fmt: skip
    assert second[2:] == (
        "at edge, no answer; up to 13 iterations", "none", "none", "explained by status"
    )  # fmt: skip
    assert third[3:] == ("2e-09", "8e-09", "wrong")


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
    assert "and 1 do neither" in said
    # 2 over 8 of nearly all; 7 over 10 of the last of the first case
    assert "The median error is 25 % of the stated error, the largest 70 %" in said
    every["verdict"] = every["verdict"].where(every["verdict"] != WRONG, RIGHT)
    [said] = findings("stability", every)
    assert said.startswith("Hard cases end with an error within the stated one")
    assert len(VERDICTS) == 4
