"""What holds of every contact, over random scenes: 40 of each property, or HARD_EXAMPLES of them."""

import os
from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import contactstudy as cs
from contactstudy.accuracy.residual_errors import residual_errors
from contactstudy.domain.grid import across_and_along
from studies.definitions.hard_case import PADDINGS, SOLVERS, grid, noise, with_heights
from studies.reference.line_contact import SCENE, relative_l1
from tests.hard_cases.dense_solver import answer

EXAMPLES = settings(max_examples=int(os.environ.get("HARD_EXAMPLES", "40")))
TOLERANCE = 1e-10


@st.composite
def problems(draw: st.DrawFn) -> tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings]:
    """Rough or smooth cylinders, soft or hard, narrow to wide, short to long."""
    cells = draw(st.tuples(st.integers(2, 16), st.integers(1, 8)))
    width = 10 ** draw(st.floats(-0.5, 2.0))
    longer = 10 ** draw(st.floats(-1.0, 1.0))  # a cell's length over its width
    on = grid(cells, width, longer * width / cells[0] * cells[1])
    rms = draw(st.sampled_from([0.0, 1e-3, 0.1, 1.0, 30.0]))
    scene = with_heights(rms * noise(cells, draw(st.integers(0, 2**20))))
    if draw(st.booleans()):
        mean = SCENE.load.per_length / on.extent[0]
        scene = replace(scene, hardness=mean * 10 ** draw(st.floats(0.01, 2.0)))
    return scene, on, PADDINGS[draw(st.sampled_from(sorted(PADDINGS)))]


solvers = st.sampled_from(list(SOLVERS.values()))


@EXAMPLES
@given(problems())
def test_the_pressure_is_within_its_stated_error(
    posed: tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings],
) -> None:
    scene, on, padding = posed
    solution = cs.solve(scene.problem(on, padding), tolerance=TOLERANCE)
    unit = solution.problem.scales.pressure
    dense = answer(scene, on, across_and_along(padding), solution)
    error = relative_l1(solution.pressure / unit, dense.pressure)
    assert error <= residual_errors(solution).l1 + dense.error


@EXAMPLES
@given(problems(), solvers)
def test_conditions_of_contact_hold(
    posed: tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings], solver: cs.Solver
) -> None:
    scene, on, padding = posed
    solution = cs.solve(scene.problem(on, padding), tolerance=TOLERANCE, solver=solver)
    if solution.status is cs.Status.STALLED:
        assert isinstance(solver, cs.PolonskyKeer)  # the reference may, and says so
        return
    pressure, gap = solution.pressure, solution.gap / solution.problem.scales.gap
    # the gap in metres has lost what is small beside the heights
    slack = TOLERANCE + 1e-15 * np.abs(solution.problem.undeformed_gap).max() / (
        solution.problem.scales.gap
    )
    assert pressure.min() >= 0
    assert pressure.max() <= scene.hardness
    assert abs(pressure.sum() * on.cell_area / (scene.load.per_length * on.length) - 1) < 1e-9
    assert (gap[pressure == 0] >= -slack).all()
    assert (gap[pressure == scene.hardness] <= slack).all()
    free = np.where(pressure < scene.hardness, pressure, 0.0)
    assert (free * np.abs(gap)).sum() <= slack * pressure.sum()


@EXAMPLES
@given(problems(), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_pressure_scales_with_the_modulus_and_not_with_lengths(
    posed: tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings], stiffer: float, larger: float
) -> None:
    """Moduli, load and hardness by one factor, all lengths by another (and the load with them)."""
    scene, on, padding = posed
    first = cs.solve(scene.problem(on, padding), tolerance=TOLERANCE)
    solid = replace(scene.solids[0], youngs_modulus=scene.solids[0].youngs_modulus * stiffer)
    cylinder, rough = scene.shapes
    other = replace(
        scene,
        load=cs.LineLoad(scene.load.per_length * stiffer * larger),
        solids=(solid, solid),
        shapes=(cs.Cylinder(cylinder.radius * larger), cs.MeasuredSurface(rough.heights * larger)),
        hardness=scene.hardness * stiffer,
    )
    on_larger = cs.Grid(on.cells, (on.extent[0] * larger, on.extent[1] * larger))
    second = cs.solve(other.problem(on_larger, padding), tolerance=TOLERANCE)
    dense = answer(scene, on, across_and_along(padding), first)
    difference = relative_l1(second.pressure / stiffer, first.pressure)
    # both are as far from the one answer as they may be
    stated = sum(residual_errors(solution).l1 for solution in (first, second))
    assert difference <= stated + dense.error


@EXAMPLES
@given(problems(), st.floats(1.01, 10.0))
def test_more_load_is_never_less_contact(
    posed: tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings], more: float
) -> None:
    scene, on, padding = posed
    scene = replace(scene, hardness=float("inf"))
    pressed = replace(scene, load=cs.LineLoad(scene.load.per_length * more))
    light, heavy = (cs.solve(s.problem(on, padding), tolerance=TOLERANCE) for s in (scene, pressed))
    dense = answer(scene, on, across_and_along(padding), light)
    touching = dense.pressure > 1e-6 * dense.pressure.max()
    assert (heavy.pressure[touching] > 0).all()


@EXAMPLES
@given(problems(), st.sampled_from([(0,), (1,), (0, 1)]))
def test_a_mirrored_contact_has_a_mirrored_pressure(
    posed: tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings], axes: tuple[int, ...]
) -> None:
    scene, on, padding = posed
    cylinder, rough = scene.shapes
    flipped = cs.MeasuredSurface(np.flip(rough.heights, axes))
    first = cs.solve(scene.problem(on, padding), tolerance=TOLERANCE)
    second = cs.solve(
        replace(scene, shapes=(cylinder, flipped)).problem(on, padding), tolerance=TOLERANCE
    )
    dense = answer(scene, on, across_and_along(padding), first)
    difference = relative_l1(np.flip(second.pressure, axes), first.pressure)
    stated = sum(residual_errors(solution).l1 for solution in (first, second))
    assert difference <= stated + dense.error
