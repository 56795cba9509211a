"""What heights do inside cells, of heights whose bends and peaks are known."""

from dataclasses import replace
from math import log, pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.subcell import (
    SampledHeights,
    SubgridEffect,
    SubgridHeights,
    _modulus,
)
from tests.conftest import LineContact

STEP, COUNT = 0.5, 12
CENTRES = (np.arange(COUNT) - (COUNT - 1) / 2) * STEP


def places(points: int) -> np.ndarray:
    """Points in all cells, evenly about each centre."""
    inside = (np.arange(points) + 0.5) / points - 0.5
    return (CENTRES[:, None] + inside * STEP).ravel()


def along(
    heights: Any, points: int = 4, *, wraps: bool = False
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    found = sampled(heights, points, wraps=wraps)
    return found.missed[:, 0], found.protrusion[:, 0], found.corner()[:, 0]


def subcell(problem: cs.Problem, pressure: np.ndarray, confidence: float) -> SubgridEffect | None:
    heights = SubgridHeights.from_problem(problem, confidence)
    return None if heights is None else heights.effect_under(problem, pressure)


def sampled(heights: Any, points: int, *, wraps: bool = False) -> SampledHeights:
    at_centres, inside = heights(CENTRES)[:, None], heights(places(points))[:, None]
    return SampledHeights.from_heights(at_centres, inside, STEP, wraps=wraps)


@pytest.mark.parametrize("aside", [0.0, 0.25, 0.4])
def test_a_kink_is_a_corner_of_both_its_slopes_wherever_it_is(aside: float) -> None:
    _, _, corner = along(lambda x: 0.3 * np.abs(x - aside))
    assert corner.max() == pytest.approx(0.6)
    assert np.count_nonzero(corner) <= 2
    # one that points into the body is none
    assert along(lambda x: -0.3 * np.abs(x - aside))[2].max() < 1e-12
    # and a curve takes off what it bends by itself
    _, _, both = along(lambda x: 0.3 * np.abs(x - aside) + 0.01 * x**2)
    assert both.max() == pytest.approx(0.6, rel=0.01)
    assert not along(lambda x: 0.01 * x**2)[2].any()


@pytest.mark.parametrize("power", [1.2, 1.5, 1.75])
def test_the_power_of_a_rounded_apex_is_told_by_its_bends(power: float) -> None:
    """All rises to come under ``|x|^n``: the bend of a cell at the apex, over what a halving leaves of it."""
    kinks = sampled(lambda x: np.abs(x) ** power, 48).kink()
    # from half a cell before the apex to as far behind
    bend = 2 * power * (STEP / 2) ** (power - 1)
    assert kinks.max() == pytest.approx(bend / (1 - 2 ** (1 - power)), rel=0.15)
    assert not sampled(np.square, 48).kink().any()


def test_the_modulus_is_that_of_a_half_space_to_what_its_cells_are_stiffer(
    line_contact: LineContact,
) -> None:
    """Cells of alternating pressure are waves of 4 / (pi n), n odd, each with a compliance of 2 dx / (pi n E*)."""
    problem = line_contact.scene.problem(line_contact.grid((64, 1), 1.0), (EXACT, EXACT))
    wanted = line_contact.scene.contact_modulus
    found = _modulus(problem, 0)
    # at the centres 1 - 1/9 + 1/25 ..., Catalan's number
    catalan = 0.915965594177219
    assert found == pytest.approx(wanted * pi / (4 * catalan), rel=1e-6)
    turned = line_contact.scene.problem(line_contact.grid((8, 64), 1.0), (EXACT, EXACT))
    assert _modulus(turned, 1) == pytest.approx(found, rel=0.02)


EXACT = cs.ExactPeriodicity()


def test_a_corner_raises_the_pressure_by_its_slope_at_each_halving(
    line_contact: LineContact,
) -> None:
    problem = line_contact.scene.problem(line_contact.grid((16, 1), 1.0), EXACT)
    pressure = np.zeros((16, 1))
    pressure[6:10] = 1e9
    kink: Any = SimpleNamespace(gap=lambda grid: 1e-3 * np.abs(grid.x)[:, None], names_scales=True)
    found = subcell(replace(problem, source=kink), pressure, 0.95)
    rise = _modulus(problem, 0) * 2e-3 / (2 * pi) * log(2)
    assert found.corner_rise == pytest.approx(rise / 1e9)
    # where nothing bears it does not count
    aside: Any = SimpleNamespace(
        gap=lambda grid: 1e-3 * np.abs(grid.x - 5 * problem.grid.cell[0])[:, None],
        names_scales=True,
    )
    elsewhere = subcell(replace(problem, source=aside), pressure, 0.95)
    assert elsewhere.corner_rise == 0
