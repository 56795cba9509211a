from dataclasses import replace
from math import log, pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.discretisation.subcell import SubgridEffect, SubgridHeights, _modulus
from tests.conftest import LineContact


def subcell(problem: cs.Problem, pressure: np.ndarray, confidence: float) -> SubgridEffect | None:
    heights = SubgridHeights.from_problem(problem, confidence)
    return None if heights is None else heights.effect_under(problem, pressure)


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


def test_a_corner_raises_pressure_by_its_slope_at_each_halving(line_contact: LineContact) -> None:
    problem = line_contact.scene.problem(line_contact.grid((16, 1), 1.0), EXACT)
    pressure = np.zeros((16, 1))
    pressure[6:10] = 1e9
    kink: Any = SimpleNamespace(
        gap=lambda grid: 1e-3 * np.abs(grid.x)[:, None], has_length_scales=True
    )
    found = subcell(replace(problem, source=kink), pressure, 0.95)
    rise = _modulus(problem, 0) * 2e-3 / (2 * pi) * log(2)
    assert found.corner_rise == pytest.approx(rise / 1e9)
    # where nothing bears it does not count
    aside: Any = SimpleNamespace(
        gap=lambda grid: 1e-3 * np.abs(grid.x - 5 * problem.grid.cell_size[0])[:, None],
        has_length_scales=True,
    )
    elsewhere = subcell(replace(problem, source=aside), pressure, 0.95)
    assert elsewhere.corner_rise == 0
