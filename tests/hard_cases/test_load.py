from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import FLAT, grid
from studies.reference.line_contact import HERTZ_HEIGHT
from tests.hard_cases.cases import CASES
from tests.hard_cases.hard_case import PADDINGS
from tests.hard_cases.judged import ends_well


@pytest.mark.parametrize("padding", ["zero", "exact", "exact on both"])
def test_a_flattened_cylinder_is_a_flat(padding: str) -> None:
    """What 1e30 N/m leaves of the curvature is less than rounding."""
    heavy = ends_well("shape flattened", padding, "preconditioned CG")
    case = CASES["shape flattened"]
    flat = case.solve(
        replace(FLAT, load=case.scene.load).problem(case.grid, PADDINGS[padding]),
        cs.PreconditionedCG(),
    )
    # two residuals of 1e-10 of other gap scales, times the condition of 24 cells across
    np.testing.assert_allclose(
        heavy.pressure, flat.pressure, rtol=0, atol=1e-7 * flat.pressure.max()
    )


@pytest.mark.parametrize("solver", [cs.PreconditionedCG(), cs.PolonskyKeer()], ids=str)
def test_full_contact_is_westergaard(solver: cs.Solver) -> None:
    """``p = mean + pi E* amplitude / wavelength cos``, of which a cell's mean takes off sinc squared."""
    scene = CASES["full contact"].scene
    on = grid((4, 32))
    both = cs.ExactPeriodicity(), cs.ExactPeriodicity()
    solution = cs.solve(scene.problem(on, both), tolerance=1e-13, solver=solver)
    mean = scene.load.per_length / on.extent[0]
    wave = np.pi * scene.contact_modulus * 1e-3 * HERTZ_HEIGHT / on.length
    expected = mean + wave * np.cos(2 * np.pi * on.y / on.length)
    error = np.abs(solution.pressure - expected).max() / wave
    assert error < (np.pi / 32) ** 2
