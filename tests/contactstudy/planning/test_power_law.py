"""Fits to values that follow a law exactly, or with a known scatter."""

import numpy as np
import pytest

from contactstudy.planning.cost import SPREAD, PowerLaw


def grid(*ranges: tuple[float, float]) -> np.ndarray:
    """Logarithms of a 5 x 5 ... grid of values."""
    axes = [np.log(np.geomspace(low, high, 5)) for low, high in ranges]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(ranges))


def test_an_exact_power_law_is_found() -> None:
    seen, asked = grid((10, 1e4), (1, 50)), np.log([[300.0, 7.0], [1e5, 100.0]])

    def law(u: np.ndarray) -> np.ndarray:
        return np.log(3e-6) + 1.3 * u[:, 0] + 0.6 * u[:, 1]

    found, deviation = PowerLaw.fit(seen, law(seen)).predict(asked)
    # 27 measurements, two of them assumed: the spread is their fraction of what is assumed of them
    assert deviation[0] < 1.5 * SPREAD * (2 / 27) ** 0.5
    assert np.abs(found - law(asked))[0] < deviation[0]
    assert np.abs(found - law(asked))[1] < 2 * deviation[1]


def test_the_spread_is_that_of_the_values() -> None:
    rng = np.random.default_rng(1)
    seen = np.repeat(grid((10, 1e4)), 40, axis=0)
    scatter = 0.3
    fitted = PowerLaw.fit(seen, seen[:, 0] + scatter * rng.standard_normal(len(seen)))
    assert fitted.spread == pytest.approx(scatter, rel=3 / (2 * len(seen)) ** 0.5)
