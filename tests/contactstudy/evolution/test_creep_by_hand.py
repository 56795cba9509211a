"""What a body that creeps keeps in one step, of numbers that are written here."""

import numpy as np
import pytest

from contactstudy.elasticity.coefficients import Displacement
from contactstudy.elasticity.viscoelastic import Creep
from contactstudy.evolution.state_variables import CreepState, Step, delay_weights

STILL = Displacement(0.7)
SOLID = CreepState(Creep(1.0, ((2.0, 0.5),)), STILL)
BEFORE, AFTER = np.array([[1.0, 5.0]]), np.array([[3.0, 2.0]])
STATE = {
    "delayed0": np.array([[0.5, 0.25]]),
    "delayed1": np.array([[0.125, 4.0]]),
    "impulse": np.array([[6.0, 7.0]]),
}
# Of 1.5 s: three times the one relaxation time and 3/8 of the other.
STEP = Step(2.0, 3.5, (1.0, 3.0), 2.0)
FAST, SLOW = delay_weights(3.0), delay_weights(0.375)


def test_a_delayed_pressure_follows_its_equation() -> None:
    """``c' = (p - c) / lambda`` by a thousand steps of the midpoint rule, whose error falls as their square."""
    count, duration = 1000, 1.5
    delayed = STATE["delayed0"]
    for n in range(count):
        p = BEFORE + (AFTER - BEFORE) * (n + 0.5) / count
        step = duration / count / 0.5
        delayed = (delayed * (1 - step / 2) + step * p) / (1 + step / 2)
    found = SOLID.update(STATE, BEFORE, AFTER, STEP)["delayed0"]
    np.testing.assert_allclose(found, delayed, rtol=10 * count**-2)


@pytest.mark.parametrize("ratio", [2e-4, 9.9e-4])
def test_the_weights_of_a_short_step_are_their_series_to_its_fourth_term(ratio: float) -> None:
    exact = ratio / 2 - ratio**2 / 6 + ratio**3 / 24 - ratio**4 / 120
    assert delay_weights(ratio)[2] == pytest.approx(exact, rel=ratio**3)
