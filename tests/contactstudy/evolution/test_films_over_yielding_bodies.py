from dataclasses import replace
from functools import cache
from math import inf

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.evolution.equilibrium.surface_depth import SurfaceDepth
from tests.conftest import STEEL

YIELD, HARDENING = 3.5e8, 1e10
BODY = cs.ElasticPlasticHalfSpace(STEEL.youngs_modulus, STEEL.poisson_ratio, YIELD, HARDENING)
GRID, EXACT = cs.Grid((96, 1), (1.2e-3, 1.0)), cs.ExactPeriodicity()
TIMES = (0.0, 1.0, 2.0)


def scene(first: object, second: object = STEEL, *, ratio: float = -2.0) -> cs.Scene:
    """A cylinder pressed to 850 MPa, if it is elastic, and relieved."""
    return cs.Scene(
        load=cs.LoadHistory(TIMES, (1e5, 2e5, 1e5)),
        solids=(first, second),  # type: ignore[arg-type]
        shapes=(cs.Cylinder(radius=0.01),),
        lubrication=cs.Lubrication(
            cs.Lubricant(0.04, 2e-8), mean_speed=1.0, slide_roll_ratio=ratio
        ),
    )


@cache
def solved(scene: cs.Scene, tolerance: float = 1e-8) -> cs.Evolution:
    found = cs.solve(scene, GRID, EXACT, times=TIMES, tolerance=tolerance)
    assert isinstance(found, cs.Evolution)
    return found


def test_a_body_that_nothing_makes_yield_has_the_film_of_an_elastic_one() -> None:
    never = solved(scene(replace(BODY, yield_stress=1e12)))
    dry = replace(scene(STEEL), load=cs.LineLoad(2e5))
    elastic = cs.solve(dry, GRID, EXACT)
    assert isinstance(elastic, cs.LubricatedContact)
    # films at a residual of 1e-8, which a smooth film has as its error to a hundred times
    np.testing.assert_allclose(never.frames[1].film, elastic.film, rtol=1e-5)
    assert never.quantities["dent_depth"].value == 0


def test_film_and_strain_are_in_equilibrium() -> None:
    """The film over the dent as a shape of an elastic body is the same; where the body flows it is at its limit."""
    found = solved(scene(BODY))
    assert found.status is cs.Status.CONVERGED
    loaded = found.frames[1]
    assert found.yielding_films is not None
    plastic, state = found.yielding_films.plastic, found.yielding_films.states[1]
    dent = plastic.fields(state)["residual_displacement"].values
    assert dent.max() > 0.05 * loaded.film.min()
    dented = replace(scene(STEEL), load=cs.LineLoad(2e5))
    again = cs.solve(
        replace(dented, shapes=(*dented.shapes, SurfaceDepth(dent, GRID))), GRID, EXACT
    )
    assert isinstance(again, cs.LubricatedContact)
    np.testing.assert_allclose(again.film, loaded.film, rtol=1e-5)
    (operator,) = plastic.operators
    stress = operator.stress_of_pressure(loaded.pressure) - operator.negative_residual_stress(
        state["strain0"]
    )
    von_mises = np.sqrt(1.5 * (stress**2).sum(axis=0))
    limit = YIELD + HARDENING * state["equivalent0"]
    assert np.all(von_mises < limit * (1 + 1e-5))
    assert np.count_nonzero(von_mises > limit * (1 - 1e-5)) > 20
    # less load leaves the strain as it is
    np.testing.assert_array_equal(found.yielding_films.states[2]["strain0"], state["strain0"])


def test_a_film_over_the_second_body_is_that_over_the_first_with_the_motion_exchanged() -> None:
    """The lubricant sees the sum of the surfaces and the mean of their speeds alone."""
    first, second = solved(scene(BODY)), solved(scene(STEEL, BODY, ratio=2.0))
    np.testing.assert_allclose(second.frames[1].film, first.frames[1].film, rtol=1e-6)


def test_a_film_over_a_body_that_yields_is_flattened_and_its_dent_is_recorded() -> None:
    found = solved(scene(BODY))
    elastic = solved(scene(replace(BODY, yield_stress=1e12)))
    peaks = [one.over_time("peak_pressure")[1] for one in (found, elastic)]
    assert peaks[0] < 0.95 * peaks[1]
    dent = found.quantities["dent_depth"]
    data = found.to_dataset()
    assert dent.value == float(data["residual_displacement"].isel(time=-1).max()) > 0
    assert 0 < dent.bound < inf
    assert data["equivalent_plastic_strain"].dims == ("time", "z", "x", "y")
    bound = found.frames[1].quantities["peak_pressure"]
    assert bound.bound == inf
    assert "not estimated" in bound.reason


def test_a_dent_is_that_of_the_largest_load_whether_it_is_recorded_or_not() -> None:
    missed = cs.solve(scene(BODY), GRID, EXACT, times=(0.0, 2.0), tolerance=1e-8)
    assert isinstance(missed, cs.Evolution)
    dents = (found.quantities["dent_depth"].value for found in (missed, solved(scene(BODY))))
    assert next(dents) == next(dents) > 0


@pytest.mark.whole
def test_a_total_load_on_a_crowned_roller_is_spread_over_the_length_of_the_grid() -> None:
    roller, never = cs.Crown(5.0, 2e-4), replace(BODY, yield_stress=1e12)
    pressed = replace(scene(never), load=cs.TotalLoad(40.0, 2e-4))
    crowned = replace(pressed, shapes=(*pressed.shapes, roller))
    found = cs.solve(crowned, cs.Grid((64, 4), (1.2e-3, 4e-4)), EXACT, times=(0.0, 1.0))
    assert found.frames[-1].load_per_length == pytest.approx(40.0 / 4e-4, rel=1e-6)


@pytest.mark.whole
def test_the_pressure_below_a_film_has_the_error_of_its_load_increments_and_no_step_has_one() -> (
    None
):
    """Beside increments of an eighth; the dataset says why the error of one step is infinite."""
    found = solved(scene(BODY))
    finer = cs.solve(scene(BODY), GRID, EXACT, times=np.linspace(0, 1, 9), tolerance=1e-8)
    reference, pressure = finer.pressure[-1], found.pressure[1]
    error = np.abs(pressure - reference).sum() / reference.sum()
    assert 0 < error < found.frames[1].error.l1.by_cause["steps"] < 1e-2
    step_error = found.to_dataset()["step_error"]
    assert step_error == inf
    assert step_error.attrs["comment"].startswith("No bound: the error of one step")
