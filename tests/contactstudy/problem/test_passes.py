"""Passes over the fields of an iteration: compiled loops do what array operations do, but for rounding."""

from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import fields
from contactstudy.domain.device import using
from contactstudy.problem.constraint import Compressive, Constraint, HardnessLimited, PrescribedLoad
from contactstudy.problem.passes import ArrayPasses, CompiledPasses, Direction, passes_for

SHAPES = [(6, 9), (8, 5)]
CONSTRAINTS = [Compressive(), HardnessLimited(0.9)]
# Sums of some dozen products of numbers of size one.
NEAR = {"rtol": 1e-14, "atol": 1e-14}


@pytest.fixture(params=SHAPES, ids=str)
def given(request: pytest.FixtureRequest) -> list[np.ndarray]:
    """Six fields; the first is a pressure, some cells of which bear none and some at least 0.9."""
    values = np.random.default_rng(7).standard_normal((6, *request.param))
    values[0] = np.minimum(np.abs(values[0]) * (np.arange(request.param[1]) % 3 > 0), 0.9)
    return list(values)


@pytest.fixture(params=CONSTRAINTS, ids=str)
def both(
    request: pytest.FixtureRequest, given: list[np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> tuple[ArrayPasses, CompiledPasses]:
    """Both kinds of passes, with the rows of small fields in parts for several threads."""
    pytest.importorskip("numba")
    monkeypatch.setattr(fields, "LARGE", 1)
    monkeypatch.setattr(fields, "PART", 4)
    compiled = passes_for(request.param, given[0].shape)
    assert isinstance(compiled, CompiledPasses)
    return ArrayPasses(request.param), compiled


def agree(both: tuple[Any, Any], name: str, *arguments: Any) -> Any:
    """Call a pass of both on copies, compare results and overwritten fields, and return what the arrays found."""
    found = []
    for passes in both:
        copies = [one.copy() if isinstance(one, np.ndarray) else one for one in arguments]
        with using(cs.Cpu(3)):
            result = getattr(passes, name)(*copies)
        found.append((result, [one for one in copies if isinstance(one, np.ndarray)]))
    (one, one_fields), (other, other_fields) = found
    for field, same in zip(one_fields, other_fields, strict=True):
        np.testing.assert_allclose(same, field, **NEAR)
    return one, other


def test_gap_and_residual(both: tuple[Any, Any], given: list[np.ndarray]) -> None:
    pressure, undeformed, moved = given[:3]
    for approach in (None, 0.3):
        one, other = agree(both, "gap", undeformed, moved, pressure, 0 * moved, approach)
        np.testing.assert_allclose(other.height, one.height, **NEAR)
        assert other.approach == pytest.approx(one.approach, rel=1e-13)
        measured = both[0].constraint.residual(pressure, one, pressure.sum())
        assert other.measured == pytest.approx(measured, rel=1e-13)
        assert other.load == pytest.approx(pressure.sum())
        assert other.farthest == np.abs(moved).max()


@pytest.mark.parametrize("real", [np.float64, np.float32])
def test_the_active_set(both: tuple[Any, Any], given: list[np.ndarray], real: type) -> None:
    pressure, height, extended = given[:3]
    one, other = agree(both, "contact", pressure, height, real)
    for field, same in zip(one, other, strict=True):
        assert field.dtype == same.dtype == real
        np.testing.assert_array_equal(same, field)
    arguments = pressure, height, extended, 0.4, *(field.astype(float) for field in one)
    one, other = agree(both, "enter", *arguments)
    assert one == other


def test_sums_of_a_direction(both: tuple[Any, Any], given: list[np.ndarray]) -> None:
    pressure, height, residual, before, moved_before, moved = given
    active = both[0].constraint.free(pressure)
    for name, arguments in (
        ("totals", (active, residual)),
        ("products", (height, residual, active, before, pressure, moved_before, moved)),
    ):
        one, other = agree(both, name, *arguments)
        np.testing.assert_allclose(other, one, **NEAR)


@pytest.mark.parametrize("conjugate", [0.0, 0.6])
def test_a_trial_projected_to_the_load(
    both: tuple[Any, Any], given: list[np.ndarray], conjugate: float
) -> None:
    """Compiled passes cut tension off at once, arrays with the projection."""
    pressure, height, residual, before = given[:4]
    constraint: Constraint = both[0].constraint
    active = constraint.free(pressure)
    direction = Direction(residual, active, 0.2, conjugate)
    found = []
    for passes in both:
        trial = before.copy() if conjugate else np.full(before.shape, np.nan)
        with using(cs.Cpu(3)):
            sums = passes.trial(pressure, height, direction, 0.7, trial)
            load = PrescribedLoad(0.5 * float(pressure.sum()))
            slope = passes.project_to_load(trial, sums, active, load, pressure, height)
        assert trial.sum() == pytest.approx(load.total)
        assert slope == pytest.approx((height * (trial - pressure)).sum())
        found.append((trial, sums.cut, sums.slope))
    np.testing.assert_allclose(found[1][0], found[0][0], rtol=1e-12, atol=1e-13)
    assert found[0][1] == found[1][1]
    assert found[1][2] == pytest.approx(found[0][2], rel=1e-12)


@pytest.mark.parametrize("fraction", [0.8, 2.5])
def test_a_line_search(both: tuple[Any, Any], given: list[np.ndarray], fraction: float) -> None:
    pressure, step, height, ahead, moved = given[:5]
    trial = np.clip(pressure + step, 0, both[0].constraint.capacity(1))
    for name, arguments in (
        ("slope", (trial, pressure, height)),
        ("curvature", (trial, pressure, ahead, moved)),
        ("meets_a_limit", (trial, pressure, fraction)),
        ("shorten", (trial, pressure, ahead, moved, fraction)),
    ):
        one, other = agree(both, name, *arguments)
        assert (one is None) == (other is None)
        if one is not None:
            assert other == pytest.approx(one, rel=1e-13)
