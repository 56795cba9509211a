"""What holds of every contact, over random scenes: 40 of each property, or HARD_EXAMPLES of them."""

import os
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import contactstudy as cs
from contactstudy.accuracy.error_terms import residual_errors
from contactstudy.domain.grid import across_and_along
from studies.definitions.hard_cases import SOLVERS, grid, noise, with_heights
from studies.reference.line_contact import SCENE, relative_l1
from tests.hard_cases.cases import PADDINGS
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
def test_the_pressure_is_within_its_stated_error(posed: tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings]) -> None:
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
    slack = TOLERANCE + 1e-15 * np.abs(solution.problem.undeformed_gap).max() / (solution.problem.scales.gap)
    assert pressure.min() >= 0
    assert pressure.max() <= scene.hardness
    assert abs(pressure.sum() * on.cell_area / (scene.load.per_length * on.length) - 1) < 1e-9
    assert (gap[pressure == 0] >= -slack).all()
    assert (gap[pressure == scene.hardness] <= slack).all()
    free = np.where(pressure < scene.hardness, pressure, 0.0)
    assert (free * np.abs(gap)).sum() <= slack * pressure.sum()


Posed = tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings]


def is_as_stated(posed: Posed, other: Posed, back: Callable[[np.ndarray], np.ndarray]) -> bool:
    """Whether the pressure of another contact, taken back, is the first one: both are as far from it as they state."""
    first, second = (cs.solve(scene.problem(on, padding), tolerance=TOLERANCE) for scene, on, padding in (posed, other))
    scene, on, padding = posed
    dense = answer(scene, on, across_and_along(padding), first)
    stated = sum(residual_errors(solution).l1 for solution in (first, second))
    return relative_l1(back(second.pressure), first.pressure) <= stated + dense.error


@EXAMPLES
@given(problems(), st.floats(-9, 9), st.floats(-9, 9))
def test_pressure_scales_with_the_modulus_and_not_with_lengths(posed: Posed, stiffer: float, larger: float) -> None:
    """Moduli, load and hardness by one power of ten, all lengths by another (and the load with them)."""
    scene, on, padding = posed
    pascal, metre = 10.0**stiffer, 10.0**larger
    solid = replace(scene.solids[0], youngs_modulus=scene.solids[0].youngs_modulus * pascal)
    cylinder, rough = scene.shapes
    other = replace(
        scene,
        load=cs.LineLoad(scene.load.per_length * pascal * metre),
        solids=(solid, solid),
        shapes=(cs.Cylinder(cylinder.radius * metre), cs.MeasuredSurface(rough.heights * metre)),
        hardness=scene.hardness * pascal,
    )
    on_larger = cs.Grid(on.cells, (on.extent[0] * metre, on.extent[1] * metre))
    assert is_as_stated(posed, (other, on_larger, padding), lambda pressure: pressure / pascal)


def halved(pressure: np.ndarray) -> np.ndarray:
    return pressure.reshape(len(pressure), 2, -1).mean(axis=1)


# Heights, and how the pressure of a contact with them is that without.
FORMS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray], np.ndarray]]] = {
    "mirrored across": (np.flipud, np.flipud),
    "mirrored along": (np.fliplr, np.fliplr),
    "moved by whole cells": (lambda h: np.roll(h, 3, 1), lambda p: np.roll(p, -3, 1)),
    "twice the period": (lambda h: np.tile(h, 2), halved),
}


@pytest.mark.parametrize("form", FORMS)
@EXAMPLES
@given(posed=problems())
def test_an_equivalent_contact_has_the_equivalent_pressure(posed: Posed, form: str) -> None:
    """A window that does not move with the point knows where the period begins, and any window where it ends."""
    scene, on, padding = posed
    along = across_and_along(padding)[1]
    assume(along.wraps or form != "moved by whole cells")
    assume(along.window is None or form != "twice the period")
    there, back = FORMS[form]
    cylinder, rough = scene.shapes
    heights = there(rough.heights)
    on_form = cs.Grid(heights.shape, (on.extent[0], on.extent[1] * heights.shape[1] / on.cells[1]))
    other = replace(scene, shapes=(cylinder, cs.MeasuredSurface(heights)))
    assert is_as_stated(posed, (other, on_form, padding), back)
