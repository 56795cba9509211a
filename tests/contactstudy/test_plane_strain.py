"""Where nothing varies along the length, many cells along it have the answer of one."""

from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL
from tests.contactstudy.evolution.test_plastic import half_width, pressed
from tests.contactstudy.lubrication.scenes import by_moes
from tests.contactstudy.lubrication.test_mixed import mixed

LINE = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),))
A = LINE.hertz.half_width
FILM = by_moes(20, 5)
PLASTIC = ("pressure", "residual_stress", "plastic_strain", "residual_displacement")
# a scene, its cells across and their size, the cells along; what is compared, to the tolerance of the solve
SCENES: dict[str, tuple[cs.Scene, int, float, int, tuple[str, ...], float, dict[str, Any]]] = {
    "coating": (
        replace(LINE, solids=(cs.CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 2e-6, STEEL), STEEL)),
        128, 2.4 * A / 128, 48, ("pressure",), 1e-9, {"tolerance": 1e-12},
    ),
    "sliding of unlike bodies": (
        replace(LINE, solids=(cs.HalfSpace(1e9, 0.0), cs.HalfSpace(inf, 0.3)), friction=cs.Sliding(0.6)),
        64, 0.6 * A, 24, ("pressure",), 1e-8, {"tolerance": 1e-11},
    ),
    "tractive rolling": (
        replace(LINE, friction=cs.TractiveRolling(0.3, longitudinal=0.4 * 0.3 * A / 0.01)),
        64, 2.4 * A / 64, 8, ("pressure", "shear_x"), 1e-6, {"tolerance": 1e-9},
    ),
    "yielding": (
        pressed(2.5, hardening=0.02), 18, half_width(2.5) / 6, 5, PLASTIC, 1e-6,
        {"times": cs.TimeSteps((1.0, 2.0), error_estimator="none"), "tolerance": 1e-7},
    ),
    # iterations stop at the rounding of a film that is a small difference of large heights
    "film": (FILM, 96, 9 * A / 96, 8, ("film", "pressure", "shear"), 1e-9, {"tolerance": 1e-12}),
    "ridges that touch": (mixed(0.06, 0.06), 160, 6 * A / 160, 8, ("pressure", "shear"), 1e-6, {"tolerance": 1e-7}),
}  # fmt: skip


@pytest.mark.cases(len(SCENES))
@pytest.mark.parametrize("name", SCENES)
def test_many_cells_along_have_the_answer_of_one(name: str) -> None:
    scene, across, cell, along, fields, within, named = SCENES[name]
    one, many = (
        cs.solve(scene, cs.Grid((across, n), (across * cell, A)), cs.ExactPeriodicity(), **named) for n in (1, along)
    )
    assert many.status is one.status
    assert not one.status.is_failure
    for field in fields:
        wanted, found = (answer.to_dataset()[field].values for answer in (one, many))
        assert np.abs(wanted).max() > 0
        np.testing.assert_allclose(found, np.repeat(wanted, along, axis=-1), rtol=0, atol=within * np.abs(wanted).max())
