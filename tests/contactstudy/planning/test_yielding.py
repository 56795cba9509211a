"""What a plan says of bodies that yield, by the measured laws that its source states."""

from dataclasses import replace

import pytest

import contactstudy as cs
from contactstudy.planning.transient_requirements import yielding
from tests.conftest import STEEL, LineContact


def test_the_body_that_yields_first_counts_and_both_take_memory(
    line_contact: LineContact,
) -> None:
    highest = line_contact.hertz.peak_pressure
    soft, hard = (
        cs.ElasticPlasticHalfSpace(STEEL.youngs_modulus, STEEL.poisson_ratio, highest / ratio, 1e9)
        for ratio in (3.0, 2.0)
    )
    found = yielding(replace(line_contact.scene, solids=(hard, soft)))
    assert found is not None
    assert found.ratio == pytest.approx(3)
    assert found.half_width == pytest.approx(line_contact.hertz.half_width)
    assert found.bodies == 2
    one = yielding(replace(line_contact.scene, solids=(STEEL, hard)))
    assert one is not None
    assert (round(one.ratio, 9), one.bodies) == (2, 1)
    assert yielding(line_contact.scene) is None
    assert "2 times the lowest yield stress" in one.reason(line_contact.grid(64, 2.4, 6.0))
