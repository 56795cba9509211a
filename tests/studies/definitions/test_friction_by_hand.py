"""What the study of friction asks of a solver and takes from it, of answers that are written here."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.friction import PartialSlip
from contactstudy.scene.stress import HalfSpaceStress
from contactstudy.solvers.friction import Superposed
from studies.definitions import friction
from studies.reference.line_contact import HERTZ
from studies.registry import load

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
LOAD = HERTZ.load_per_length


@pytest.fixture
def case() -> friction.Rough:
    found = load("friction").scene_at({"poisson_ratio": 0.3, "grid": 32, "rough_grid": 16})
    assert isinstance(found, friction.Rough)
    return found


def test_stress_is_the_highest_of_all_depths_for_each_coefficient(
    case: friction.Rough, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pressed: 0.6 p_H 0.7 deep. Full sliding adds 2 p_H at the surface, where pressure leaves 0.12."""
    seen: dict[str, Any] = {}
    pressed, sheared = (np.zeros((len(friction.DEPTHS), 4, 3)) for _ in range(2))
    pressed[8, 2, 1], pressed[0, 3, 2] = 0.6 * P_H, 0.12 * P_H
    sheared[0, 3, 2] = 2 * P_H

    class Below:
        def __init__(self, *given: Any) -> None:
            seen["given"] = given

        def __call__(self, pressure: np.ndarray) -> np.ndarray:
            return pressed * pressure.sum()

        def under(self, shear: np.ndarray) -> Any:
            seen["shear"] = shear
            return lambda pressure: (pressed + sheared) * pressure.sum()

    monkeypatch.setattr(friction, "StressBelow", Below)
    monkeypatch.setattr(friction, "von_mises", np.abs)
    pressure = np.array([[0.25], [0.75]])
    highest, depth = friction._stress(case, pressure)
    assert highest == pytest.approx([0.6, 0.6, 0.6, 0.62, 0.72, 0.92])
    assert depth == [0.7, 0.7, 0.7, 1e-6, 1e-6, 1e-6]
    grid, paddings, ratio, depths = seen["given"]
    assert (grid, paddings) == (case.grid, (cs.ZeroPadding(), cs.ExactPeriodicity()))
    assert ratio == HalfSpaceStress(0.3)
    assert depths == pytest.approx([z * A for z in friction.DEPTHS])
    # sliding across the cylinder
    np.testing.assert_array_equal(seen["shear"], [pressure, 0 * pressure])


@dataclass(frozen=True)
class Posed:
    """In the place of a problem."""

    scene: cs.Scene
    grid: cs.Grid
    padding: object
    friction: object = None


@pytest.fixture
def unsolved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cs.Scene, "problem", lambda *given: Posed(*given))


@pytest.mark.usefixtures("unsolved")
def test_a_sphere_has_the_cylinder_s_half_width_for_a_radius(
    case: friction.Rough, monkeypatch: pytest.MonkeyPatch
) -> None:
    posed: list[Posed] = []

    def solve(problem: Posed, **_: object) -> SimpleNamespace:
        posed.append(problem)
        pressure = np.zeros((16, 16))
        pressure[4:9, 4:9] = 1e9
        return SimpleNamespace(stick=pressure[:, :7] > 0, pressure=pressure)

    monkeypatch.setattr(cs, "solve", solve)
    # 15 of 25 cells
    assert friction._sphere(case, 0.25) == pytest.approx((15 / 25) ** 0.5)
    [problem] = posed
    assert problem.grid.cells == (16, 16)
    assert problem.grid.extent == pytest.approx((2.5 * A, 2.5 * A))
    assert problem.padding == (cs.ZeroPadding(), cs.ZeroPadding())
    scene = problem.scene
    assert scene.shapes == (cs.Sphere(HERTZ.radius),)
    assert scene.solids == case.scene.solids
    force = scene.load.largest * 2.5 * A
    ball = cs.analytic.HertzPoint(force, HERTZ.radius, case.scene.contact_modulus)
    assert ball.contact_radius == pytest.approx(A)
    slip = scene.friction
    assert isinstance(slip, PartialSlip)
    assert slip.coefficient == 0.3
    assert slip.tangential == pytest.approx(0.25 * 0.3 * scene.load.largest)


@pytest.mark.usefixtures("unsolved")
def test_a_superposition_misses_the_share_of_the_shear_that_two_solves_differ_by(
    case: friction.Rough, monkeypatch: pytest.MonkeyPatch
) -> None:
    posed: list[Posed] = []
    exact = np.array([[[4.0, -2.0]], [[1.0, -3.0]]])
    quick = np.array([[[3.0, -2.5]], [[1.0, -1.0]]])

    def solve(problem: Posed, **_: object) -> SimpleNamespace:
        posed.append(problem)
        return SimpleNamespace(shear=exact if len(posed) == 1 else quick)

    monkeypatch.setattr(cs, "solve", solve)
    # 1, 0.5 and 2 of 4, 2, 1 and 3; at most 3 aside of 4
    assert friction._superposition(case) == pytest.approx((3.5 / 10, 0.75))
    first, second = posed
    both = second.friction
    assert isinstance(both, Superposed)
    assert (both.coefficient, both.share) == (0.3, 0.5)
    assert replace(second, friction=None) == first
    assert first.grid.cells == (16, 16)
    assert first.grid.extent == pytest.approx((3.2 * A, 3.2 * A))
    assert first.padding == cs.ExactPeriodicity()
    rough: Any = first.scene.shapes[-1]
    assert rough.rms == pytest.approx(0.3 * A**2 / (2 * 0.01))
    assert (rough.roll_off, rough.cut_off) == pytest.approx((0.8 * A, 0.2 * A))
    assert rough.hurst == 0.8
    slip = first.scene.friction
    assert isinstance(slip, PartialSlip)
    assert slip.coefficient == 0.3
    # half of what friction bears
    assert slip.tangential == pytest.approx(0.5 * 0.3 * LOAD)


def test_what_sticks_is_half_the_width_of_its_cells_over_hertz_s(
    case: friction.Rough, monkeypatch: pytest.MonkeyPatch
) -> None:
    slips: list[PartialSlip] = []

    def solve(slip: PartialSlip) -> SimpleNamespace:
        slips.append(slip)
        return SimpleNamespace(stick=np.arange(32)[:, None] < 2 * len(slips))

    monkeypatch.setattr(friction.Rough, "prepare", lambda self: self.scene.friction)
    monkeypatch.setattr(cs, "solve", solve)
    monkeypatch.setattr(friction, "_stress", lambda *_: ([0.1] * 6, [0.2] * 6))
    monkeypatch.setattr(friction, "_sphere", lambda _, share: 3 * share)
    monkeypatch.setattr(friction, "_superposition", lambda _: (0.04, 0.07))
    solution: Any = SimpleNamespace(pressure=None)
    found = load("friction").measures(case, solution)
    # 2, 4, 6, 8 and 10 cells of a width of 2.6
    assert found["stick"].values == pytest.approx(np.arange(1, 6) * 2.6 / 32)
    assert found["stick_sphere"].values == pytest.approx(3 * found["share"].values)
    assert [slip.coefficient for slip in slips] == [0.3] * 5
    forces = [slip.tangential for slip in slips]
    assert forces == pytest.approx(0.3 * LOAD * np.array(friction.SHARES))
    assert (float(found["superposition_error"]), float(found["shear_aside"])) == (0.04, 0.07)


@pytest.mark.parametrize(
    ("axis", "value", "said"),
    [("grid", 31, "at least 32 cells"), ("rough_grid", 15, "at least 16 cells")],
)
def test_a_grid_that_shows_no_contact_is_refused(axis: str, value: int, said: str) -> None:
    point = {"poisson_ratio": 0.3, "grid": 32, "rough_grid": 16} | {axis: value}
    with pytest.raises(cs.InvalidInput, match=said):
        load("friction").scene_at(point)
