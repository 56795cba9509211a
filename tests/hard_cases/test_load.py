from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions.hard_cases import FLAT
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
