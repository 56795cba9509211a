"""Error estimates under a coat."""

from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.scene.bodies import contact_modulus


@pytest.mark.parametrize(("ratio", "wide"), [(0.03, 8), (3, 100), (10, 100), (40, 1000)])
def test_the_bound_holds_under_soft_and_stiff_coats(ratio: float, wide: float) -> None:
    a = 1e-3
    coating = cs.HalfSpace(1e11, 0.3)
    body = cs.CoatedHalfSpace(coating, a / wide, cs.HalfSpace(1e11 / ratio, 0.3))
    load = pi * contact_modulus((body,), a) * a**2 / 4
    rigid = cs.HalfSpace(inf, 0.3)
    scene = cs.Scene(cs.LineLoad(load), (body, rigid), (cs.Cylinder(1.0),))

    def solved(cells: int) -> cs.Solution:
        grid = cs.Grid((cells, 1), (3.3 * a, 3.3 * a))
        return cs.solve(scene.problem(grid, cs.ExactPeriodicity()), tolerance=1e-9)

    fine, coarse = solved(6144).pressure[:, 0], solved(192)
    # the finer pressure at the coarser cells' centres
    true = fine.reshape(192, -1)[:, 15:17].mean(axis=1)
    estimate = error_estimate(coarse)
    assert np.abs(coarse.pressure[:, 0] - true).sum() <= estimate.l1.total * true.sum()
    stiff = ratio > 2
    assert stiff == any("times as stiff" in said for said in estimate.warnings)
