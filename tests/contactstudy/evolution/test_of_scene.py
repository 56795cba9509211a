"""Which memories a scene asks for."""

from dataclasses import replace
from math import pi

import pytest

import contactstudy as cs
from contactstudy.evolution.evolve import memories
from contactstudy.evolution.memory import CreepMemory, WearMemory
from tests.conftest import STEEL, LineContact

RUBBER = cs.ViscoelasticHalfSpace(1e6, 0.3, ((2e6, 1.0),))


def test_each_body_that_creeps_has_one_and_then_the_wear(line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, solids=(RUBBER, RUBBER), wear=cs.Wear(1e-12, 2.0))
    first, second, worn = memories(scene, 0.5)
    assert isinstance(first, CreepMemory)
    assert isinstance(second, CreepMemory)
    assert isinstance(worn, WearMemory)
    assert worn.rate == pytest.approx(2e-12)
    # compliance over pi, as coefficients are for pi E* times a displacement
    assert first.creep(0.0) == pytest.approx(RUBBER.creep(0.0) / pi)
    assert first.coefficients.datum == 0.5  # type: ignore[attr-defined]


def test_what_does_not_creep_or_wear_has_none(line_contact: LineContact) -> None:
    assert memories(line_contact.scene, 0.5) == ()
    still = replace(line_contact.scene, wear=cs.Wear(1e-12, 0.0))
    assert memories(still, 0.5) == ()
    glassy = cs.ViscoelasticHalfSpace(1e6, 0.3)
    assert memories(replace(line_contact.scene, solids=(glassy, STEEL)), 0.5) == ()
