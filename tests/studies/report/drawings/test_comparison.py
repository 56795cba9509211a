"""The drawing of a comparison of settings, by hand."""

from math import inf

import pytest

from studies.report.drawings.comparison import sections
from studies.report.wording import alternatives_text, verdict_text
from tests.studies.advice.test_measuring import COPIED, EXACT, of, one

COARSE = one(EXACT, 32, 0.04, 1e-3)
FINE = one(EXACT, 64, 0.02, 4e-3)
OTHER = one(COPIED, 64, 0.025, 6e-3)


def test_the_verdict_names_setting_error_bound_and_time() -> None:
    measured = of(COARSE, FINE, OTHER, reference_bound=0.004)
    verdict = measured.verdict()
    assert verdict_text(measured, verdict) == (
        "Use exact periodicity, 64 x 64 cells, tolerance 1e-4: the L1 error of the pressure is 2.0\xa0% ± 0.40\xa0%, "
        "in 4 ms on one thread; 3.0\xa0% was requested."
    )
    assert alternatives_text(measured, verdict) == (
        "Slower by 15 rounds of timing: duplicated padding (1.5 times, 2 ms more). The next coarser grid, 32 x 32 "
        "cells, has an error of 4.0\xa0% in 0.25 times the time and misses the request."
    )


@pytest.mark.parametrize(
    ("cells", "bounded", "words"),
    [
        (64, True, "No grid is accurate enough with: duplicated padding (5.0\xa0%)."),
        (
            32,
            True,
            "Not timed on grids as fine, or without a bound: duplicated padding (5.0\xa0%).",
        ),
        (
            64,
            False,
            "Not timed on grids as fine, or without a bound: duplicated padding (5.0\xa0%).",
        ),
    ],
)
def test_a_padding_misses_the_request_only_where_it_was_timed_on_cells_as_fine(
    cells: int,
    bounded: bool,  # noqa: FBT001 (parametrised)
    words: str,
) -> None:
    measured = of(FINE, one(COPIED, cells, 0.05, bounded=bounded))
    assert alternatives_text(measured, measured.verdict()) == words


def test_a_coarser_grid_that_the_bound_of_the_reference_rules_out_says_so() -> None:
    measured = of(one(EXACT, 32, 0.028, 1e-3), FINE, reference_bound=0.004)
    assert alternatives_text(measured, measured.verdict()).endswith(
        "in 0.25 times the time, which meets the request only without the bound of the reference."
    )


def test_without_a_bound_the_nearest_setting_is_named_and_nothing_claimed() -> None:
    measured = of(FINE, reference_bound=inf)
    verdict = measured.verdict()
    text = verdict_text(measured, verdict)
    assert not sections(measured)[0].tables
    assert text.startswith("No setting can be shown to meet 3.0\xa0%")
    assert "64 x 64 cells" in text


def test_a_table_of_costs_lists_the_quickest_setting_of_each_error_that_is_reached() -> None:
    price, _, _ = sections(of(COARSE, FINE, OTHER, reference_bound=0.004))
    (table,) = price.tables
    shown = {row[0]: (row[2], row[5], row[6]) for row in table.rows}
    assert shown["10\xa0%"] == ("32 x 32 cells", "1 ms", "duplicated: 6 times")
    assert shown["3.0\xa0%"] == ("64 x 64 cells", "4 ms", "duplicated: 1.5 times")
    assert "1.0\xa0%" not in shown
    assert "2.0\xa0% ± 0.40\xa0%" in table.caption


def test_what_a_padding_alone_does_is_listed_with_its_sign() -> None:
    _, causes, _ = sections(of(FINE, OTHER))
    (table,) = causes.tables
    assert table.head == ("padding", "pressure in L1", "mean gap")
    assert table.rows == (("duplicated", "2.0\xa0%", "+10\xa0%"),)


@pytest.mark.parametrize("floor", [0.0, 0.004])
def test_the_page_says_what_errors_are_against(floor: float) -> None:
    *_, about = sections(of(FINE, reference_bound=floor))
    (finding,) = about.findings
    assert "96 x 96 cells" in finding.claim
    assert "Without a bound even there: peak pressure." in finding.measured
    assert "A note." in finding.measured
