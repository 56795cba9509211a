"""What is recorded of a contact, its stiffness by hand, and where a solve starts from."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.scene_study import measures as module
from studies.scene_study import scene_case
from studies.scene_study.measures import RESIDUAL, normal_stiffness
from studies.scene_study.scene_case import SceneCase, Solved
from tests.conftest import STEEL

GRID = cs.Grid((4, 5), (4 * 2e-5, 5 * 3e-5))
SCENE = cs.Scene(cs.LineLoad(2e4), (STEEL, STEEL), (cs.Cylinder(0.01),))
CASE = SceneCase(SCENE, GRID, cs.ExactPeriodicity())


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Numbers of a contact of these pressures, whose stiffness is 7 and whose errors nobody estimates."""
    monkeypatch.setattr(module, "normal_stiffness", lambda _: 7.0)
    monkeypatch.setattr(module, "error_estimates", lambda _: {})

    def of(pressure: np.ndarray, case: SceneCase = CASE, *outputs: Any) -> dict[str, float]:
        problem = SimpleNamespace(paddings=None, outputs=outputs, grid=GRID)
        gap = np.where(pressure > 0, 0.0, 4e-7)
        solution: Any = SimpleNamespace(
            pressure=pressure, gap=gap, mean_gap=gap.mean(), approach=3e-6, problem=problem
        )
        found = module.measures(case, Solved(solution, 0.25, 1e-4))
        return {name: float(one) for name, one in found.items()}

    return of


def test_area_and_pressures_are_those_of_the_cells_in_contact(recorded: Any) -> None:
    pressure = np.zeros(GRID.cells)
    pressure[1, 1:4] = [2e9, 3e9, 0.5]
    found = recorded(pressure)
    area = 3 * 2e-5 * 3e-5
    assert found["load"] == 2e4
    assert found["contact_area"] == pytest.approx(area)
    assert found["contact_share"] == pytest.approx(3 / 20)
    assert found["peak_pressure"] == 3e9
    # the load of the period on them
    assert found["mean_pressure"] == pytest.approx(2e4 * 15e-5 / area)
    assert found["mean_gap"] == pytest.approx(17 / 20 * 4e-7)
    assert (found["approach"], found["wall_time"], found["stiffness"]) == (3e-6, 0.25, 7)
    hertz = SCENE.hertz
    assert hertz is not None
    wanted = area / (2 * hertz.half_width * 15e-5)
    assert found["contact_area_over_hertz"] == pytest.approx(wanted)
    # two edges of 3e-5 m for each, and two of 2e-5 m for all
    assert found["contact_perimeter"] == pytest.approx(3 * 2 * 3e-5 + 2 * 2e-5)


def test_without_contact_there_is_no_mean_pressure_and_no_stiffness(recorded: Any) -> None:
    found = recorded(np.zeros(GRID.cells))
    assert found["contact_area"] == found["mean_pressure"] == 0
    assert "stiffness" not in found


def test_the_highest_stress_is_said_with_its_depth(recorded: Any) -> None:
    stress = np.arange(60.0).reshape(3, 4, 5)
    stress[1, 2, 3] = 100.0

    def fields(pressure: np.ndarray) -> dict[str, xr.Variable]:
        values = stress + pressure.max()
        return {
            "von_mises": xr.Variable(("z", "x", "y"), values),
            "z": xr.Variable("z", [0.1, 0.2, 0.4]),
        }

    other = SimpleNamespace(fields=lambda _: {"profile": None})
    found = recorded(np.full(GRID.cells, 5.0), CASE, other, SimpleNamespace(fields=fields))
    assert (found["von_mises_max"], found["von_mises_max_depth"]) == (105, 0.2)
    assert "von_mises_max" not in recorded(np.ones(GRID.cells), CASE, other)


class Dense:
    """An operator that is a matrix over six cells."""

    # cells as unlike as these are not levelled in one step
    matrix = 1.0 + np.diag([1.0, 3.0, 10.0, 2.0, 30.0, 6.0])

    def __call__(self, pressure: np.ndarray) -> np.ndarray:
        return (self.matrix @ pressure.ravel()).reshape(pressure.shape)

    def approximate_inverse(self) -> Any:
        return SimpleNamespace(extension=Extension)


class Extension:
    """One that knows of no other cells."""

    def __init__(self, contact: np.ndarray) -> None:
        self.contact = contact

    def __call__(self, displacement: np.ndarray) -> np.ndarray:
        return displacement

    def closing(self, extended: np.ndarray) -> np.ndarray:
        return np.asarray(self.contact * extended / 4)


@pytest.mark.parametrize("touching", [[2], [0, 5], [0, 1, 2, 4], [0, 1, 2, 3, 4, 5]])
def test_stiffness_is_what_moves_the_cells_in_contact_alike(touching: list[int]) -> None:
    """The sum of the pressures that move all of them by one, by a dense solve."""
    pressure = np.zeros((3, 2))
    pressure.ravel()[touching] = 1 + np.arange(len(touching))
    problem = SimpleNamespace(
        constraint=SimpleNamespace(free=lambda given: np.where(given > 0, 1.0, 0.0)),
        operator=Dense(),
        grid=cs.Grid((3, 2), (6.0, 5.0)),
    )
    solution: Any = SimpleNamespace(problem=problem, pressure=pressure)
    inside = Dense.matrix[np.ix_(touching, touching)]
    carried = np.linalg.solve(inside, np.ones(len(touching))).sum()
    # cells of 5 m^2, over 5 m of length; the energy errs by the square of what the iteration leaves, times how
    # much softer than the mean a cell is, 30 over 8.7
    error = 4 * RESIDUAL**2
    wanted = carried * 5 / 5
    assert normal_stiffness(solution) == pytest.approx(wanted, rel=error)
    longer = SimpleNamespace(**(vars(problem) | {"grid": cs.Grid((3, 2), (12.0, 7.0))}))
    solution = SimpleNamespace(problem=longer, pressure=pressure)
    # cells of 4 m by 3.5 m over 7 m
    assert normal_stiffness(solution) == pytest.approx(carried * 14 / 7, rel=error)
    none: Any = SimpleNamespace(problem=problem, pressure=0 * pressure)
    assert np.isnan(normal_stiffness(none))


OWN = 0.5
PROBLEM: Any = SimpleNamespace(operator=SimpleNamespace(self_compliance=OWN))


def seen(*contacts: tuple[float, list[float], list[float]]) -> scene_case._Last:
    last = scene_case._Last()
    for load, pressure, gap in contacts:
        solution: Any = SimpleNamespace(pressure=np.array(pressure), gap=np.array(gap))
        last.add(load, solution)
    return last


FIRST, SECOND = (10.0, [2.0, 0.0, 0.0], [0.0, 3.0, 9.0]), (20.0, [3.0, 1.0, 0.0], [0.0, 0.0, 6.0])


def test_a_solve_starts_from_what_is_known_in_proportion_to_the_load() -> None:
    assert seen().pressure_for(PROBLEM, 5.0) is None
    np.testing.assert_allclose(seen(SECOND).pressure_for(PROBLEM, 30.0), [4.5, 1.5, 0])
    # the same load again, or two of one load, tell no slope
    np.testing.assert_allclose(seen(FIRST, SECOND).pressure_for(PROBLEM, 20.0), [3, 1, 0])
    twice = seen((20.0, [9.0, 9.0, 9.0], [0.0] * 3), SECOND)
    np.testing.assert_allclose(twice.pressure_for(PROBLEM, 30.0), [4.5, 1.5, 0])


@pytest.mark.parametrize("step", [0.5, 1.0, 1.9, -0.5])
def test_two_loads_are_extrapolated_in_the_logarithm_with_a_share_of_the_gap(step: float) -> None:
    """Where a gap closes, the pressure is foreseen to rise from below zero."""
    last = seen((5.0, [9.0] * 3, [0.0] * 3), FIRST, SECOND)
    found = last.pressure_for(PROBLEM, 20.0 * 2.0**step)
    share = scene_case.SEED / OWN
    ends = [np.array(one[1]) - share * np.array(one[2]) for one in (FIRST, SECOND)]
    np.testing.assert_allclose(found, np.maximum(ends[1] + (ends[1] - ends[0]) * step, 0))


def test_farther_than_twice_the_step_before_nothing_is_extrapolated() -> None:
    for step in (2.1, -2.1):
        load = 20.0 * 2.0**step
        found = seen(FIRST, SECOND).pressure_for(PROBLEM, load)
        np.testing.assert_allclose(found, np.array([3, 1, 0]) * load / 20)
    # nor to no pressure at all
    falling = seen((40.0, [9.0, 9.0], [0.0] * 2), (20.0, [1.0, 2.0], [0.0] * 2))
    np.testing.assert_allclose(falling.pressure_for(PROBLEM, 10.0), [0.5, 1.0])


def test_heights_count_from_half_the_width_and_approaches_too_where_images_have_no_end() -> None:
    load = scene_case._at_half_width(CASE).largest
    hertz = cs.analytic.HertzLine(load, 0.01, SCENE.contact_modulus)
    assert hertz.half_width == pytest.approx(4e-5)
    flat = SceneCase(cs.Scene(cs.LineLoad(2e4), (STEEL, STEEL), ()), GRID, cs.ZeroPadding())
    assert scene_case._at_half_width(flat) == cs.LineLoad(1.0)
    assert CASE.datum == pytest.approx(4e-5)
    assert flat.datum is None
    both = SceneCase(SCENE, GRID, (cs.ExactPeriodicity(), cs.ExactPeriodicity()))
    assert both.datum is None


def test_seconds_are_of_set_up_and_solve_together(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter((10.0, 10.5, 20.0, 22.0))
    monkeypatch.setattr(scene_case, "perf_counter", lambda: next(clock))
    monkeypatch.setattr(scene_case, "_LAST", scene_case._Last())
    monkeypatch.setattr(cs, "solve", lambda *_, **__: SimpleNamespace(status=cs.Status.STALLED))
    prepared = CASE.prepare()
    assert prepared[1] == 0.5
    assert CASE.run(prepared).seconds == 2.5
