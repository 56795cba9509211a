import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.convolution import BoussinesqCoefficients, Coefficients, general_convolutions
from contactstudy.elasticity.tangential import CerrutiCoefficients
from contactstudy.elasticity.viscoelastic import RetardedCoefficients, creep_from_relaxation

CASES = {
    "one term": (1.0, ((2.0, 0.7),)),
    "two terms": (0.3, ((0.5, 0.4), (0.2, 3.0))),
    "five terms over twelve decades": (2.0, ((5.0, 1e-7), (3.0, 1e-4), (1.0, 0.3), (0.1, 20.0), (7.0, 1e5))),
    "a weak term": (1.0, ((1e-9, 1.0), (1.0, 2.0))),
    "close times": (1.0, ((1.0, 1.0), (1.0, 1.0 + 1e-9), (1.0, 1.1))),
    "a soft equilibrium": (1e-9, ((1.0, 1.0), (2.0, 10.0))),
    "Maxwell's fluid": (0.0, ((2.0, 3.0),)),
    "a fluid of three terms": (0.0, ((2.0, 3.0), (1.0, 0.01), (0.5, 400.0))),
    "equal times": (1.0, ((2.0, 0.7), (1.0, 0.7))),
}


@pytest.mark.parametrize("name", CASES)
def test_creep_times_relaxation_is_one_in_laplace_space(name: str) -> None:
    """``E(s) J(s) = 1`` for both times s: each factor is a sum of few terms, so to some machine epsilons."""
    equilibrium, relaxation = CASES[name]
    computed = creep_from_relaxation(equilibrium, relaxation)
    for s in np.geomspace(1e-8, 1e9, 40):
        stiffness = equilibrium + sum(modulus * s / (s + 1 / time) for modulus, time in relaxation)
        compliance = computed.instantaneous + computed.fluidity / s
        compliance += sum(size / (1 + s * time) for size, time in computed.terms)
        assert stiffness * compliance == pytest.approx(1, rel=1e-13)


@pytest.mark.parametrize("length", [0.01, 20.0])
@pytest.mark.parametrize(
    ("name", "inner"),
    [(name, BoussinesqCoefficients(1.0)) for name in ("cell", "row", "lattice")]
    + [("row", CerrutiCoefficients("xy", 1.0))],
)
def test_trailing_coefficients_are_their_integral(name: str, inner: Coefficients, length: float) -> None:
    """By differences: ``V - length dV/dx = K`` for what trails, at distances where K is smooth."""
    dx, dy, period, width = 0.01, 0.3, 0.9, 1.0
    x, y = np.arange(41) * dx, np.array([0.0, 0.3])
    more = {"cell": (), "row": (period,), "lattice": (width, period)}[name]
    even, odd = (
        getattr(RetardedCoefficients(inner, length, sign), name)(x[:, None], y, dx, dy, *more) for sign in (1, -1)
    )
    exact = getattr(inner, name)(x[:, None], y, dx, dy, *more)
    # of a few cells as of many
    few = getattr(RetardedCoefficients(inner, length, 1), name)(x[:2, None], y, dx, dy, *more)
    np.testing.assert_allclose(few, even[:2], atol=1e-12 * np.abs(even).max())

    def slope(values: np.ndarray) -> np.ndarray:
        """Of sixth order, in the middle of the points."""
        near, next_to, farthest = (values[3 + n : -3 + n or None] - values[3 - n : -3 - n] for n in (1, 2, 3))
        return (45 * near - 9 * next_to + farthest) / (60 * dx)

    for total, sign in ((even + odd, 1), (even - odd, -1)):
        # V(-x) is the same forwards: its slope has the other sign
        left = total[3:-3] - sign * length * slope(total)
        far = slice(12, None)
        behind = exact if sign == 1 else inner.parity[0] * exact
        np.testing.assert_allclose(left[far], behind[3:-3][far], atol=3e-6 * np.abs(exact).max())


def test_an_odd_trail_is_odd_in_every_padding() -> None:
    """The map that is lagged: antisymmetric, so a pressure does no work on its own lagged displacement."""
    generator, exact = np.random.default_rng(0), cs.ExactPeriodicity()
    grid = cs.Grid((24, 12), (1.0, 0.6))
    odd = {RetardedCoefficients(BoussinesqCoefficients(0.1), 0.2, -1): 1.0}
    zero = cs.ZeroPadding()
    for padding in ((zero, zero), exact, (exact, exact), (cs.CircularSuperposition(1), exact), (exact, zero)):
        (lagged,) = general_convolutions([odd], grid, padding)
        pressure, other = generator.random((2, 24, 12))
        scale = np.abs(lagged(pressure)).max() * other.sum()
        assert abs((lagged(pressure) * other + lagged(other) * pressure).sum()) < 1e-11 * scale
