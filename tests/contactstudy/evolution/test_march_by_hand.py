"""The problem at the end of a step, of what memories that are written here add to it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.coefficients import Displacement
from contactstudy.elasticity.convolution import superposed
from contactstudy.elasticity.viscoelastic import Trailing
from contactstudy.evolution import march as marching
from contactstudy.evolution.march import Instant, LoweredContact, March, lowered, solved_or_unloaded
from contactstudy.evolution.memory import Contribution, Step
from contactstudy.evolution.steps import Scheme
from contactstudy.problem.constraint import PrescribedLoad
from contactstudy.scene.bodies import response
from contactstudy.solvers.solve import SolveOptions
from tests.conftest import LineContact

LOAD = cs.LoadHistory((0.0, 10.0), (0.0, 1e5))
STEP = Step(2.0, 4.0, (2e4, 4e4), 3e4)
GENERATOR = np.random.default_rng(2)
BEFORE, PRESSURE, LIFT, STRAIN = GENERATOR.random((4, 8, 2))


class Keeps:
    """Adds what it is told to, and keeps the pressures at the ends of a step."""

    has_stages = False

    def __init__(self, contribution: Contribution) -> None:
        self.adds = contribution

    def contribution(self, state: Any, pressure: np.ndarray, step: Step) -> Contribution:
        assert state == {"kept": "before"}
        assert pressure is BEFORE
        return self.adds

    def advance(self, state: Any, before: np.ndarray, after: np.ndarray, step: Step) -> Any:
        return {"kept": (before, after)}


def begun(count: int) -> Instant:
    return Instant(2.0, 2e4, BEFORE, ({"kept": "before"},) * count)


class Solving(SolveOptions):
    """Gives a pressure back."""

    def solved(self, problem: Any, start: Any = None, on: Any = None) -> Any:
        return replace(
            marching.unloaded(problem), pressure=PRESSURE, note=f"from {start is BEFORE}"
        )


OPTIONS = SolveOptions(1e-6, 77, cs.PolonskyKeer(), cs.Precision.SINGLE)
GIVING = Solving(1e-6, 77, cs.PolonskyKeer(), cs.Precision.SINGLE)


def march(problem: cs.Problem, contact: LineContact, *adds: Contribution) -> March:
    weights = response(contact.scene.solids, problem.scales.length)
    kept: Any = tuple(Keeps(one) for one in adds)
    return March(problem, LOAD, weights, kept, None, Scheme.IMPLICIT, GIVING)


@pytest.fixture
def problem(line_contact: LineContact) -> cs.Problem:
    return line_contact.scene.problem(line_contact.grid((8, 2), 0.7), cs.ExactPeriodicity())


def test_what_memories_add_adds_up(problem: cs.Problem, line_contact: LineContact) -> None:
    ((kind, weight),) = response(line_contact.scene.solids, problem.scales.length).items()
    first = Contribution(gap=LIFT, compliance={kind: 0.5 * weight}, local_compliance=3e-18)
    second = Contribution(
        gap=2 * LIFT, strained={kind: STRAIN}, compliance={kind: weight}, local_compliance=4e-18
    )
    third = Contribution(strained={kind: 2 * STRAIN})
    ours = march(problem, line_contact, first, second, third)
    found = ours._problem_at_end(begun(3), STEP)
    moved = problem.operator(3 * STRAIN) / weight
    np.testing.assert_allclose(found.undeformed_gap, problem.undeformed_gap + 3 * LIFT + moved)
    softer = 2.5 * problem.operator(PRESSURE) + 7e-18 * PRESSURE
    np.testing.assert_allclose(found.operator(PRESSURE), softer, rtol=1e-12)
    grid = problem.grid
    assert found.resultant == PrescribedLoad(4e4 * grid.period / grid.cell_area)
    assert found.scales == ours._scales(4e4, 2.5)
    # without a load there is no contact to be as wide as
    still = ours._problem_at_end(begun(3), replace(STEP, loads=(2e4, 0.0)))
    assert still.scales == problem.scales


def test_a_cell_s_own_displacement_adds_to_an_operator_that_stays(
    problem: cs.Problem, line_contact: LineContact
) -> None:
    found = march(problem, line_contact, Contribution(local_compliance=5e-16))._problem_at_end(
        begun(1), STEP
    )
    moved = problem.operator(PRESSURE) + 5e-16 * PRESSURE
    np.testing.assert_allclose(found.operator(PRESSURE), moved, rtol=1e-12)
    np.testing.assert_array_equal(found.undeformed_gap, problem.undeformed_gap)
    same = march(problem, line_contact, Contribution())._problem_at_end(begun(1), STEP)
    assert same.operator is problem.operator


def test_each_kind_of_coefficients_has_its_own_unit_operator(
    problem: cs.Problem, line_contact: LineContact
) -> None:
    still = Displacement(0.7)
    kinds = {still: 2.0, Trailing(still, 0.3, 1): 3.0}
    ours = replace(march(problem, line_contact), weights=kinds)
    paddings = problem.paddings
    assert paddings is not None
    for kind in kinds:
        alone = superposed({kind: 1.0}, problem.grid, paddings)(PRESSURE)
        np.testing.assert_allclose(ours._units[kind](PRESSURE), alone, rtol=1e-12)


def test_a_stage_ends_with_its_pressure_and_what_each_memory_keeps(
    problem: cs.Problem, line_contact: LineContact
) -> None:
    ours = march(problem, line_contact, Contribution(), Contribution())
    after, (solution,) = ours._stage(begun(2), STEP)
    assert (after.time, after.load) == (4.0, 4e4)
    assert after.pressure is PRESSURE
    assert solution.note == "from True"
    assert [state["kept"] for state in after.states] == [(BEFORE, PRESSURE)] * 2  # type: ignore[comparison-overlap]


def test_a_march_begins_without_load_and_pressure(
    problem: cs.Problem, line_contact: LineContact
) -> None:
    class Begins:
        has_stages = False

        def start(self, shape: tuple[int, int]) -> Any:
            return {"shape": shape}

    memory: Any = Begins()
    begun = replace(march(problem, line_contact), memories=(memory,)).start(2.5)
    assert (begun.time, begun.load, begun.states) == (2.5, 0, ({"shape": (8, 2)},))
    np.testing.assert_array_equal(begun.pressure, np.zeros((8, 2)))


def test_what_is_joint_is_found_with_the_contact_and_kept_last(
    problem: cs.Problem, line_contact: LineContact
) -> None:
    class Joint:
        has_stages = False

        def settled(self, state: Any, posed: Any, contact: Any, tolerance: float) -> Any:
            assert state == "joint"
            assert tolerance == 1e-6
            assert contact.last is BEFORE
            return contact(LIFT), "settled"

    joint: Any = Joint()
    ours = replace(march(problem, line_contact, Contribution(), Contribution()), joint=joint)
    states: Any = (*begun(2).states, "joint")
    after, _ = ours._stage(replace(begun(2), states=states), STEP)
    assert after.states[-1] == "settled"  # type: ignore[comparison-overlap]
    assert len(after.states) == 3
    assert after.pressure is PRESSURE


def test_a_contact_over_a_lowered_surface_goes_on_from_its_last_pressure(
    problem: cs.Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[cs.SolveOptions, Any, Any]] = []

    def solve(options: cs.SolveOptions, posed: Any, start: Any) -> Any:
        asked.append((options, posed, start))
        return replace(marching.unloaded(posed), pressure=PRESSURE)

    monkeypatch.setattr(cs.SolveOptions, "solved", solve)
    contact = LoweredContact(problem, OPTIONS, np.zeros((8, 2)))
    contact(LIFT)
    contact(2 * LIFT)
    gaps = [posed.undeformed_gap - problem.undeformed_gap for _, posed, _ in asked]
    np.testing.assert_allclose(gaps, [LIFT, 2 * LIFT], atol=1e-15)
    # nothing is no pressure to go on from
    assert [start is PRESSURE for *_, start in asked] == [False, True]
    assert asked[1][0] == replace(OPTIONS, tolerance=1e-6 * marching.CLOSER)
    solved_or_unloaded(OPTIONS, problem)
    assert asked[2][0] == OPTIONS
    # without a load nothing is solved
    free = replace(problem, resultant=PrescribedLoad(0.0))
    assert not solved_or_unloaded(OPTIONS, free).pressure.any()
    assert len(asked) == 3
    light = replace(problem, resultant=PrescribedLoad(0.5))
    solved_or_unloaded(OPTIONS, light)
    assert len(asked) == 4
    np.testing.assert_array_equal(
        lowered(problem, LIFT).undeformed_gap, problem.undeformed_gap + LIFT
    )
