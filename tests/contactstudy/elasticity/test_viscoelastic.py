import numpy as np
import pytest

from contactstudy.elasticity.viscoelastic import Creep, creep_from_relaxation

CASES = {
    "one term": (1.0, ((2.0, 0.7),)),
    "two terms": (0.3, ((0.5, 0.4), (0.2, 3.0))),
    "five terms over twelve decades": (
        2.0,
        ((5.0, 1e-7), (3.0, 1e-4), (1.0, 0.3), (0.1, 20.0), (7.0, 1e5)),
    ),
    "a weak term": (1.0, ((1e-9, 1.0), (1.0, 2.0))),
    "close times": (1.0, ((1.0, 1.0), (1.0, 1.0 + 1e-9), (1.0, 1.1))),
    "a soft equilibrium": (1e-9, ((1.0, 1.0), (2.0, 10.0))),
    "Maxwell's fluid": (0.0, ((2.0, 3.0),)),
    "a fluid of three terms": (0.0, ((2.0, 3.0), (1.0, 0.01), (0.5, 400.0))),
}


@pytest.mark.parametrize("name", CASES)
def test_creep_times_relaxation_is_one_in_laplace_space(name: str) -> None:
    """``E(s) J(s) = 1`` for both times s: each factor is a sum of few terms, so to some machine epsilons."""
    equilibrium, relaxation = CASES[name]
    found = creep_from_relaxation(equilibrium, relaxation)
    for s in np.geomspace(1e-8, 1e9, 40):
        stiffness = equilibrium + sum(one * s / (s + 1 / time) for one, time in relaxation)
        compliance = found.instantaneous + found.fluidity / s
        compliance += sum(size / (1 + s * time) for size, time in found.terms)
        assert stiffness * compliance == pytest.approx(1, rel=1e-13)


def test_a_maxwell_fluid_flows() -> None:
    assert creep_from_relaxation(0.0, ((2.0, 3.0),)) == Creep(0.5, (), 1 / 6)


def test_terms_of_equal_times_are_one_term() -> None:
    twice = creep_from_relaxation(1.0, ((2.0, 0.7), (1.0, 0.7)))
    assert twice == creep_from_relaxation(1.0, ((3.0, 0.7),))
