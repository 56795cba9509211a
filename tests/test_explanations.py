"""Numbers of the pages that explain the paddings, each computed again."""

import re
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy import bound, hidden_heights
from contactstudy.domain.grid import Grid
from studies.advice import trials, verdict
from studies.reference.line_contact import HERTZ, P_H, SCENE, WIDTH, A, hertz_means, relative_l1
from tests.accuracy.__main__ import ALL

PAGES = Path(__file__).parents[1] / "docs" / "explanation"
TIGHT = cs.SolveOptions(1e-9)


def said(page: str, pattern: str) -> list[float]:
    """The numbers in the groups of a pattern on a page, whose lines are joined."""
    text = " ".join((PAGES / f"{page}.md").read_text(encoding="utf-8").split())
    found = re.search(pattern, text)
    assert found, pattern
    return [float(number) for number in found.groups()]


def pressure(grid: Grid, padding: cs.Padding) -> np.ndarray:
    return cs.solve(SCENE.problem(grid, padding), options=TIGHT).pressure


def test_the_error_by_cells_is_between_the_factors_of_its_page() -> None:
    least, most = said("periodicity", r"factor \$c\$ is between ([\d.]+) and ([\d.]+)\.")
    [of_cell] = said("periodicity", r"at most \$([\d.]+) \\sqrt")
    factors, largest = [], []
    for cells_per_half_width in 40 + np.linspace(0, 1, 25):
        grid = cs.Grid((96, 1), (96 * A / cells_per_half_width, A))
        found = pressure(grid, cs.ExactPeriodicity())
        factors.append(relative_l1(found, hertz_means(HERTZ, grid)) * cells_per_half_width**1.5)
        error = np.abs(found - HERTZ.pressure(grid.x)[:, None]).max() / P_H
        largest.append(error * cells_per_half_width**0.5)
    assert least <= min(factors) < 1.1 * least
    assert 0.9 * most < max(factors) <= most
    assert 0.9 * of_cell < max(largest) <= 1.01 * of_cell
    # a grid that has the edge on a border of cells is the lucky one
    assert max(factors) / factors[0] == pytest.approx(5, abs=0.6)


def test_one_cell_along_has_the_error_of_its_page() -> None:
    [one] = said("periodicity", r"has an error of ([\d.]+) % in place of")
    found = pressure(cs.Grid((129, 1), (WIDTH * A, WIDTH * A)), cs.DuplicatedPadding())
    assert 100 * (found[64, 0] / P_H - 1) == pytest.approx(one, abs=0.05)


def test_a_window_over_three_periods_reaches_as_far_as_its_page_says() -> None:
    [images] = said("price", r"with n = 1 reaches as far as n = (\d+) over one")
    assert cs.CircularSuperposition(1).reach(3.0) == cs.CircularSuperposition(int(images)).reach(1)


def test_the_rules_of_a_verdict_have_the_numbers_of_their_page() -> None:
    [lower] = said("price", r"load that is (\d+) % lower")
    assert lower == pytest.approx(100 * (1 - trials.LOWER_LOAD))
    [copied] = said("price", r"\) then has (\d+) or is left out")
    assert copied == trials.CENTRED == said("periodicity", r"gives duplicated padding (\d+) cells along")[0]
    [tie] = said("price", r"within (\d+) % of the fastest is a tie")
    assert tie == pytest.approx(100 * (verdict.TIE - 1))


def test_a_window_fixed_to_the_domain_has_the_error_over_a_moving_one_of_its_page() -> None:
    numbers = said(
        "truncated-images",
        r"([\d.]+) times that of a moving window of the same n at \$L = 0\.6 a\$, ([\d.]+) times at "
        r"\$2\.4 a\$ and (\d+) times at \$9\.6 a\$, for n = 6",
    )
    for period, number in zip((0.6, 2.4, 9.6), numbers, strict=True):
        grid = cs.Grid((48, 48), (WIDTH * A, period * A))
        exact = pressure(grid, cs.ExactPeriodicity())
        fixed, moving = (
            relative_l1(pressure(grid, kind(6)), exact) for kind in (cs.Superposition, cs.CircularSuperposition)
        )
        assert fixed / moving == pytest.approx(number, rel=0.05)


def test_a_fixed_window_varies_along_the_length_as_its_page_says() -> None:
    [number] = said("truncated-images", r"by ([\d.]+) % of the peak pressure at n = 1 and by")
    side = WIDTH * A
    varying = np.ptp(pressure(cs.Grid((128, 128), (side, side)), cs.Superposition(1)), axis=1).max()
    assert 100 * varying / P_H == pytest.approx(number, rel=0.03)


def test_what_hidden_heights_add_to_a_bound_is_what_its_page_says() -> None:
    page = "error-estimates"
    rise = said(page, r"peak by up to ([\d.]+) times the pressure")[0]
    assert pytest.approx(rise, abs=0.01) == hidden_heights.PRESSURE_RISE
    assert pytest.approx(4 / 5) == bound.HIDDEN_ERROR
    two_cells, one_cell = said(page, r"takes ([\d.]+) times this where the wave is two cells long, and ([\d.]+) times")
    # Johnson (1985), eq. 13.7: a wave of amplitude h and length l is flattened by pi E* h / l
    assert (two_cells, one_cell) == pytest.approx((np.pi / 2, np.pi), abs=0.05)
    contacts = said(page, r"on about (\d+) contacts")[0]
    assert len(ALL) == pytest.approx(contacts, rel=0.1)
