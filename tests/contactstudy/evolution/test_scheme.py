"""Stages of steps by the conditions that give them their order and their damping."""

from math import exp

import pytest

from contactstudy.evolution.steps import Scheme


def grown(scheme: Scheme, z: float) -> float:
    """One step of y' = z y of unit duration: of each stage a fraction is explicit, the rest implicit."""
    y = 1.0
    for fraction, explicit in scheme.stages:
        y *= (1 + fraction * explicit * z) / (1 - fraction * (1 - explicit) * z)
    return y


@pytest.mark.parametrize("scheme", list(Scheme))
def test_stages_fill_the_step(scheme: Scheme) -> None:
    shares = [fraction for fraction, _ in scheme.stages]
    assert sum(shares) == pytest.approx(1)
    # none goes back in time
    assert min(shares) > 0


@pytest.mark.parametrize(
    ("scheme", "order"), [(Scheme.TWO_STAGE, 2), (Scheme.IMPLICIT, 1), (Scheme.EXPLICIT, 1)]
)
def test_the_error_of_a_step_falls_with_one_power_more_than_its_order(
    scheme: Scheme, order: int
) -> None:
    wrong = [abs(grown(scheme, -z) - exp(-z)) for z in (0.02, 0.01)]
    # the next term is a fraction z of it
    assert wrong[0] / wrong[1] == pytest.approx(2 ** (order + 1), rel=0.05)


def test_the_two_stages_damp_stiff_changes_entirely_and_explicit_steps_do_not() -> None:
    assert abs(grown(Scheme.TWO_STAGE, -1e9)) < 1e-6
    assert abs(grown(Scheme.IMPLICIT, -1e9)) < 1e-6
    assert grown(Scheme.EXPLICIT, -3.0) == pytest.approx(-2)
