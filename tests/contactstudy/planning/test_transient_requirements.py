import tracemalloc
from dataclasses import replace
from math import cosh, pi

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.evolution import evolution_answer
from contactstudy.evolution.evolve import evolve
from contactstudy.evolution.steady_rolling import solve_rolling
from contactstudy.planning.plan import plan_grid
from contactstudy.planning.transient_requirements import expected_plastic_zone
from tests.conftest import STEEL, LineContact
from tests.contactstudy.evolution.creeping import LOAD, SOLID, by_steps, rolling_cylinder

ONE = cs.LineLoad(1.0)


def test_a_plan_is_wide_enough_for_the_end_and_keeps_to_its_error() -> None:
    """The half-width after two times is known; both errors are those of the integration itself."""
    history = cs.LoadHistory((0.0, 2.0), (LOAD, LOAD))
    scene = rolling_cylinder(SOLID, history)
    plan = cs.plan(scene, error=1e-2)
    assert plan.grid.extent[0] > 2 * 0.1516
    found = evolve(scene, plan.grid, plan.padding, times=[0.0, 1.0, 2.0], error=1e-2)
    assert evolution_answer(found).status is cs.Status.CONVERGED
    assert by_steps(found) <= 1e-2
    # the estimate is a bound, the plan's error is not
    assert max(replace(frame.estimate.l1, steps=None).total for frame in found.frames) <= 2e-2


@pytest.mark.parametrize(
    ("friction", "load", "scar"),
    [
        # of another program, Q / (mu P) = 0.6
        (cs.Fretting(0.3, (0.0, 0.18, -0.18), times=(0.0, 1.0, 2.0)), ONE, 1.2214),
        # Q / (mu P) = 0.9 at the smallest load, between the instants of the forces; sinh(4.5) / 4.5 = 10
        (cs.Fretting(0.3, (0.054, 0.054), times=(0.0, 1.0)), cs.SineLoad(0.6, 0.4, 1.0), 0.1**0.5 * cosh(2.25)),
        # a^3 = 1.5 R k s P of 200 half cycles, beyond Hertz's
        pytest.param(
            cs.Fretting(0.3, displacements=(3.0, -3.0), times=(0.0, 100.0), period=1.0),
            ONE,
            (1.5 * pi / 4 * 1e-2 * 200 * 6) ** (1 / 3),
            marks=pytest.mark.whole,
        ),
    ],
)
def test_a_plan_makes_room_for_the_wear_of_fretting(
    friction: cs.Fretting, load: cs.LineLoad | cs.SineLoad, scar: float
) -> None:
    """In units of Hertz's half-width, modulus and load."""
    body = cs.HalfSpace(2 * (1 - 0.3**2), 0.3)
    wear = cs.Wear(1e-2, speed=0.0)
    shapes = (cs.Cylinder(pi / 4),)
    scene = cs.Scene(load, (body, body), shapes, friction=friction, wear=wear)
    assert scene.hertz is not None
    assert scene.hertz.half_width == pytest.approx(1.0)
    for times in (None, (0.0, friction.times[-1])):
        assert plan_grid(scene, error=0.1, times=times).grid.extent[0] / 2 > scar


def test_a_plan_makes_room_for_a_worn_ball_along_both_axes() -> None:
    """An elongated one, whose cap ``pi a^3 b / (4 R)`` is four times that of the elastic contact."""
    shapes = (cs.Ellipsoid(0.01, 0.03),)
    elastic = cs.Scene(cs.TotalLoad(50.0), (STEEL, STEEL), shapes)
    a, b = elastic.ellipse.semi_axes  # type: ignore[union-attr]
    worn = 4 * pi * a**3 * b / 4 / 0.01
    scene = replace(elastic, wear=cs.Wear(worn / 50.0, 1.0))
    planned = plan_grid(scene, error=0.2, times=(0.0, 1.0))
    assert planned.warnings == ()
    times = (0.0, *np.geomspace(1e-3, 1.0, 4))
    found = evolve(scene, planned.grid, planned.padding, times=times)
    assert found.frames[-1].status is cs.Status.CONVERGED
    short = replace(planned.grid, extent=(planned.grid.extent[0], 3 * b))
    assert "Grid.extent[1] is" in " ".join(plan_grid(scene, grid=short, times=(0.0, 1.0)).warnings)


def test_rolling_makes_room_for_half_as_much_again() -> None:
    scene = rolling_cylinder(SOLID, rolling=cs.Rolling(0.1))
    plan = cs.plan(scene, error={"pressure": 1e-2})
    # of half as much room again, which a grid that is given may do without
    for part, is_wide_enough in ((0.75, True), (0.5, False)):
        given = replace(plan.grid, extent=(part * plan.grid.extent[0], plan.grid.length))
        assert (plan_grid(scene, grid=given).warnings == ()) is is_wide_enough
    # cells as fine as those of an elastic contact at rest, of which there are 24
    rest = replace(scene, rolling=None, solids=(cs.HalfSpace(1.0, 0.0), scene.solids[1]))
    fine = cs.plan(rest, error={"pressure": 1e-2}).grid.cell_size[0]
    assert plan.grid.cell_size[0] == pytest.approx(fine, rel=1 / 24)
    found = solve_rolling(scene, plan.grid, plan.padding)
    assert found.solution.status is cs.Status.CONVERGED


def test_what_is_expected_to_yield_holds_what_yields_and_not_much_more() -> None:
    """At four times the yield stress; of 64 cells in ten half-widths, whole ones yield, in about as many layers."""
    elastic = cs.Scene(cs.LineLoad(1e6), (STEEL, cs.HalfSpace(np.inf, 0.0)), (cs.Cylinder(0.01),))
    body = cs.ElasticPlasticHalfSpace(210e9, 0.3, elastic.hertz.peak_pressure / 4, 2e9)
    history = cs.LoadHistory((0.0, 1.0), (0.0, 1e6))
    scene = replace(elastic, load=history, solids=(body, elastic.solids[1]))
    grid = cs.Grid((64, 1), (10 * elastic.hertz.half_width, elastic.hertz.half_width))
    found = evolve(scene, grid, cs.ExactPeriodicity(), times=np.linspace(0, 1, 5))
    yielded = (found.frames[-1].coupled_state["plastic0"][-1] > 0).any(axis=(0, 2))
    half_extent = yielded.sum() * grid.cell_size[0] / 2
    assert half_extent < expected_plastic_zone(scene).half_extent < 1.5 * half_extent
    taken = found.frames[-1].coupled_state["plastic0"][-1].shape[0]
    assert 0.7 < expected_plastic_zone(scene).volume(grid).shape[0] / taken < 1.4


def test_a_rough_contact_under_a_growing_load_fits_on_its_grid(line_contact: LineContact) -> None:
    a, radius = line_contact.hertz.half_width, line_contact.hertz.radius
    rough = cs.Roughness(0.1 * a**2 / (2 * radius), hurst=0.8, roll_off=a, cut_off=a / 4, seed=3)
    largest = line_contact.with_shapes(rough)
    load = largest.largest_load
    history = replace(largest, load=cs.LoadHistory((0.0, 1.0), (load / 2, load)), wear=cs.Wear(1e-20, 1.0))
    planned = plan_grid(history, error=0.2)
    at_rest = replace(planned.scene, load=largest.load, wear=None)
    assert cs.solve(at_rest, planned.grid, planned.padding).status is cs.Status.CONVERGED


def test_the_memory_of_a_plan_grows_with_the_branches_of_a_body_as_that_of_its_solve() -> None:
    """A fluid keeps what it has flowed in place of the branch that a solid has more."""
    grid, times = cs.Grid((128, 64), (0.9, 1.0)), cs.TimeSteps((0.0, 0.5, 1.0), error_estimator="none")

    def creeping(stiffness: float, branches: int) -> tuple[cs.Scene, int]:
        terms = tuple((0.6 / branches, 0.1 * 3.0**number) for number in range(branches))
        body = cs.ViscoelasticHalfSpace(stiffness, 0.0, terms)
        scene = rolling_cylinder(body, cs.LoadHistory((0.0, 1.0), (LOAD, LOAD)))
        return scene, plan_grid(scene, grid=grid).bytes

    def taken(scene: cs.Scene) -> int:
        tracemalloc.start()
        cs.solve(scene, grid, cs.ExactPeriodicity(), times=times)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return peak

    (few, planned_few), (many, planned_many) = (creeping(0.4, branches) for branches in (2, 12))
    taken(few)  # what is imported and kept for later solves is not counted
    assert planned_many - planned_few == pytest.approx(taken(many) - taken(few), rel=0.25)
    assert [creeping(0.0, branches)[1] for branches in (2, 12)] == [planned_few, planned_many]
