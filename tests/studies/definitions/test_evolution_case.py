"""A march as a case of a study."""

import inspect

import contactstudy as cs
from studies.model.case import EvolutionCase
from studies.reference.line_contact import SCENE


def test_a_march_is_solved_to_what_marches_are_unless_told_otherwise() -> None:
    case = EvolutionCase(SCENE, cs.Grid((8, 1), (1e-3, 1e-3)), cs.ExactPeriodicity(), (0.0, 1.0))
    options = inspect.signature(cs.evolve).parameters["options"].default
    assert case.tolerance == options.tolerance == 1e-8
    assert cs.Scheme[case.scheme] is cs.Scheme.IMPLICIT
    assert case.error is None
