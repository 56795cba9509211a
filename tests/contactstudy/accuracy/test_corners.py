from dataclasses import replace
from math import log
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.hidden_heights import HiddenHeights
from tests.conftest import LineContact

BOTH = cs.ExactPeriodicity(), cs.ExactPeriodicity()


def test_a_corner_raises_pressure_by_its_slope_at_each_halving(line_contact: LineContact) -> None:
    """By ``E* / (2 pi) slope ln 2`` of cells, whose waves of alternating pressure are stiffer than E* by pi / (4 G).

    These are waves of 4 / (pi n), n odd, each with a compliance of 2 dx / (pi n E*): G is Catalan's 1 - 1/9 + 1/25 ...
    """
    problem = line_contact.scene.problem(line_contact.grid((16, 1), 1.0), BOTH)
    pressure = np.zeros((16, 1))
    pressure[6:10] = 1e9

    def corner_rise(place: float) -> float:
        """Under two flanks of a slope of 1e-3 that meet at a `place` [m]."""
        kink: Any = SimpleNamespace(gap=lambda grid: 1e-3 * np.abs(grid.x - place)[:, None], has_length_scales=True)
        posed = replace(problem, source=kink)
        return HiddenHeights.from_problem(posed).effect_under(posed, pressure).corner_rise

    rise = line_contact.scene.contact_modulus / (8 * 0.915965594177219) * 2e-3 * log(2)
    assert corner_rise(0.0) == pytest.approx(rise / 1e9, rel=1e-6)
    # where nothing bears it does not count
    assert corner_rise(5 * problem.grid.cell_size[0]) == 0
