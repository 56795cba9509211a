"""Each compiled pass of an iteration does what its sentence says, on pressures at and between their limits."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import fields as rows
from contactstudy.domain.device import using
from contactstudy.problem.constraint import violation
from contactstudy.problem.passes import _rows as compiled

pytest.importorskip("numba")
fused: Any = import_module("contactstudy.domain.compiled")

SHAPES = [(6, 9), (5, 4), (1, 7), (8, 1)]
LIMITS = [np.inf, 0.9]
# Sums of some dozen products of numbers of size one.
NEAR = {"rtol": 1e-14, "atol": 1e-14}

pytestmark = pytest.mark.parametrize("shape", SHAPES, ids=str)


def fields(shape: tuple[int, int], count: int) -> list[np.ndarray]:
    return list(np.random.default_rng(7).standard_normal((count, *shape)))


def pressures(shape: tuple[int, int], most: float) -> np.ndarray:
    """Some without pressure, and some at the limit."""
    found = np.random.default_rng(8).exponential(size=shape) * (np.arange(shape[1]) % 3 > 0)
    return np.minimum(found, most)


def free_cells(pressure: np.ndarray, most: float) -> np.ndarray:
    return ((pressure > 0) & (pressure < most)) * 1.0


def summed(kernel: Any, *arguments: Any, results: int) -> np.ndarray:
    """Of three threads, which share the rows of small fields too."""
    with using(cs.Cpu(3)):
        return compiled(kernel, *arguments, results=results).sum(axis=1)


@pytest.fixture(autouse=True)
def small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "PART", 4)


@pytest.mark.parametrize("most", LIMITS)
def test_the_level_is_of_free_cells(shape: tuple[int, int], most: float) -> None:
    undeformed, moved = fields(shape, 2)
    pressure = pressures(shape, most)
    free = free_cells(pressure, most)
    found = summed(fused.level, undeformed, moved, pressure, most, results=2)
    np.testing.assert_allclose(found, [((undeformed + moved) * free).sum(), free.sum()], **NEAR)


@pytest.mark.parametrize("most", LIMITS)
def test_a_gap_is_measured_as_it_is_made(shape: tuple[int, int], most: float) -> None:
    undeformed, moved = fields(shape, 2)
    pressure = pressures(shape, most)
    free = free_cells(pressure, most)
    height = np.empty(shape)
    with using(cs.Cpu(3)):
        found = compiled(fused.measured, undeformed, moved, pressure, 0.3, most, height, results=5)
    np.testing.assert_allclose(height, undeformed + moved - 0.3, **NEAR)
    sums = pressure.sum(), (pressure * abs(height) * free).sum(), (pressure * free).sum()
    np.testing.assert_allclose(found[:3].sum(axis=1), sums, **NEAR)
    assert found[3].max() == violation(pressure, height, free).max()
    assert found[4].max() == abs(moved).max()


@pytest.mark.parametrize("most", LIMITS)
@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_the_contact_is_of_free_cells(shape: tuple[int, int], most: float, real: type) -> None:
    pressure, (height,) = pressures(shape, most), fields(shape, 1)
    cells, unlevel = np.empty(shape, real), np.empty(shape, real)
    compiled(fused.contact, pressure, height, most, cells, unlevel)
    np.testing.assert_array_equal(cells, free_cells(pressure, most))
    np.testing.assert_array_equal(unlevel, (height * cells).astype(real))


@pytest.mark.parametrize("most", LIMITS)
def test_cells_join_that_will_penetrate_or_open_at_the_limit(
    shape: tuple[int, int], most: float
) -> None:
    pressure, (height, whole) = pressures(shape, most), fields(shape, 2)
    expected = height - 0.4 * whole
    wrong = ((pressure == 0) & (expected < 0)) | ((pressure >= most) & (expected > 0))
    contact = free_cells(pressure, most)
    cells, unlevel = contact.copy(), contact * height
    fields_of = pressure, height, whole, 0.4, most, cells, unlevel
    assert summed(fused.joined, *fields_of, results=1) == wrong.sum()
    np.testing.assert_array_equal(cells, np.maximum(contact, wrong))
    np.testing.assert_array_equal(unlevel, cells * height)


def test_sums_of_a_direction(shape: tuple[int, int]) -> None:
    gap, closing, before, after, moved_before, moved_after = fields(shape, 6)
    cells = free_cells(pressures(shape, np.inf), np.inf)
    fields_of = gap, closing, cells, before, after, moved_before, moved_after
    found = summed(fused.products, *fields_of, results=7)
    step, response = before - after, moved_before - moved_after
    expected = [
        cells.sum(),
        closing.sum(),
        (gap * closing).sum(),
        (closing * response).sum(),
        (cells * response).sum(),
        (gap * cells * step).sum(),
        (cells * step).sum(),
    ]
    np.testing.assert_allclose(found, expected, **NEAR)
    found = summed(fused.totals, cells, closing, results=2)
    np.testing.assert_allclose(found, expected[:2], **NEAR)


@pytest.mark.parametrize("most", LIMITS)
@pytest.mark.parametrize("kept", [0.0, 0.6])
def test_a_trial_goes_along_the_direction(shape: tuple[int, int], most: float, kept: float) -> None:
    pressure, (height, closing, before) = pressures(shape, most), fields(shape, 3)
    cells = free_cells(pressure, most)
    trial = before.copy() if kept else np.full(shape, np.nan)
    fields_of = pressure, height, closing, cells, 0.2, kept, 0.7, most, trial
    with using(cs.Cpu(3)):
        found = compiled(fused.trial, *fields_of, results=5)
    way = (0.2 - closing + (kept * (before - pressure) if kept else 0)) * cells
    ahead = pressure + 0.7 * way
    np.testing.assert_allclose(trial, np.maximum(ahead, 0), **NEAR)
    expected = [
        np.count_nonzero((ahead < 0) | (ahead > most)),
        trial.sum(),
        np.count_nonzero(trial),
        0.7 * (height * way).sum(),
    ]
    np.testing.assert_allclose(found[:4].sum(axis=1), expected, **NEAR)
    assert found[4].max() == trial.max()


def test_a_pressure_is_lowered(shape: tuple[int, int]) -> None:
    trial, pressure, height = fields(shape, 3)
    lower = np.maximum(trial - 0.1, 0)
    found = summed(fused.lowered, trial, 0.1, results=2)
    np.testing.assert_allclose(found, [lower.sum(), (lower > 0).sum()], **NEAR)
    found = summed(fused.lower, trial, 0.1, 1.5, pressure, height, results=1)
    np.testing.assert_allclose(trial, 1.5 * lower, **NEAR)
    np.testing.assert_allclose(found, (height * (trial - pressure)).sum(), **NEAR)


def test_the_work_of_a_step(shape: tuple[int, int]) -> None:
    trial, pressure, height, ahead, moved = fields(shape, 5)
    found = summed(fused.slope, trial, pressure, height, results=1)
    np.testing.assert_allclose(found, (height * (trial - pressure)).sum(), **NEAR)
    found = summed(fused.curvature, trial, pressure, ahead, moved, results=1)
    np.testing.assert_allclose(found, ((trial - pressure) * (ahead - moved)).sum(), **NEAR)


@pytest.mark.parametrize("most", LIMITS)
@pytest.mark.parametrize("taken", [0.8, 2.5])
def test_an_advance_leads_to_a_share_of_the_step(
    shape: tuple[int, int], most: float, taken: float
) -> None:
    pressure, (step, ahead, moved) = pressures(shape, most), fields(shape, 3)
    trial = np.clip(pressure + step, 0, most)
    beyond = pressure + taken * (trial - pressure)
    count = summed(fused.beyond, trial, pressure, taken, most, results=1)
    assert count == np.count_nonzero((beyond < 0) | (beyond > most))
    expected = moved + taken * (ahead - moved)
    compiled(fused.advance, trial, pressure, ahead, moved, taken, most)
    np.testing.assert_allclose(trial, np.clip(beyond, 0, most), **NEAR)
    np.testing.assert_allclose(ahead, expected, **NEAR)


def test_waves_are_scaled(shape: tuple[int, int]) -> None:
    real, imaginary, factors = fields(shape, 3)
    waves = real + 1j * imaginary
    fused.scale(waves, factors)
    np.testing.assert_array_equal(waves, (real * factors) + 1j * (imaginary * factors))
