"""Fits to values that follow a law exactly, or with a known scatter."""

import numpy as np
import pytest

from contactstudy.planning.cost import EXPONENT, SPREAD, PowerLaw


def grid(*ranges: tuple[float, float]) -> np.ndarray:
    """Logarithms of a 5 x 5 ... grid of values."""
    axes = [np.log(np.geomspace(low, high, 5)) for low, high in ranges]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(ranges))


def test_an_exact_power_law_is_found() -> None:
    seen, asked = grid((10, 1e4), (1, 50)), np.log([[300.0, 7.0], [1e5, 100.0]])

    def law(u: np.ndarray) -> np.ndarray:
        return np.log(3e-6) + 1.3 * u[:, 0] + 0.6 * u[:, 1]

    found, deviation = PowerLaw.fit(seen, law(seen)).predict(asked)
    # 27 measurements, two of them assumed: the spread is their share of what is assumed of them
    assert deviation[0] < 1.5 * SPREAD * (2 / 27) ** 0.5
    assert np.abs(found - law(asked))[0] < deviation[0]
    assert np.abs(found - law(asked))[1] < 2 * deviation[1]


def test_the_spread_is_that_of_the_values() -> None:
    rng = np.random.default_rng(1)
    seen = np.repeat(grid((10, 1e4)), 40, axis=0)
    scatter = 0.3
    fitted = PowerLaw.fit(seen, seen[:, 0] + scatter * rng.standard_normal(len(seen)))
    assert fitted.spread == pytest.approx(scatter, rel=3 / (2 * len(seen)) ** 0.5)


def test_a_prediction_far_from_what_was_measured_is_less_certain() -> None:
    seen = grid((10, 100))
    fitted = PowerLaw.fit(seen, 2 * seen[:, 0])
    _, deviation = fitted.predict(np.log([[30.0], [1e3], [1e5]]))
    assert deviation[0] < deviation[1] < deviation[2]


def test_what_did_not_vary_is_not_claimed_to_be_known() -> None:
    seen = np.log(np.full((20, 1), 50.0))
    _, (deviation,) = PowerLaw.fit(seen, np.zeros(20)).predict(np.log([[500.0]]))
    assert deviation > EXPONENT * np.log(10)


def ridge(terms: np.ndarray, values: np.ndarray, spread: float) -> np.ndarray:
    """Least squares over measurements and, as one more for each coefficient, what is assumed of it."""
    widths = np.array([10.0, 0.6, 0.6, 0.1, 0.1])
    rows = np.concatenate([terms / spread, np.diag(1 / widths)])
    return np.linalg.lstsq(rows, np.concatenate([values / spread, np.zeros(5)]))[0]


def test_a_fit_is_least_squares_with_priors_and_errors_are_those_of_what_was_left_out() -> None:
    """Each measurement is left out in fact, three times over; two more that are a quarter off are assumed."""
    rng = np.random.default_rng(4)
    seen = rng.normal(3.0, 1.0, (9, 2))
    values = 1 + 1.4 * seen[:, 0] - 0.3 * seen[:, 1] + 0.2 * rng.normal(size=9)
    centred, level = seen - seen.mean(axis=0), values - values.mean()
    terms = np.column_stack([np.ones(9), centred, centred**2])
    spread = np.log(1.25)
    for _ in range(3):
        errors = []
        for out in range(9):
            kept = np.arange(9) != out
            errors.append(level[out] - terms[out] @ ridge(terms[kept], level[kept], spread))
        spread = np.sqrt((np.sum(np.square(errors)) + 2 * np.log(1.25) ** 2) / (9 + 2))
    found = PowerLaw.fit(seen, values)
    assert found.spread == pytest.approx(spread)
    assert found.coefficients == pytest.approx(ridge(terms, level, spread))
    widths = np.array([10.0, 0.6, 0.6, 0.1, 0.1])
    covariance = np.linalg.inv(terms.T @ terms / spread**2 + np.diag(widths**-2.0))
    assert found.covariance == pytest.approx(covariance)
    (value,), (deviation,) = found.predict(np.array([[5.0, 1.0]]))
    far = np.array([5.0, 1.0]) - seen.mean(axis=0)
    row = np.array([1.0, *far, *far**2])
    assert value == pytest.approx(values.mean() + row @ found.coefficients)
    assert deviation == pytest.approx(np.sqrt(spread**2 + row @ covariance @ row))
