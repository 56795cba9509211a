from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL
from tests.contactstudy.evolution.creeping import EXACT, RIGID

RADIUS, LOAD = 0.01, 1e5
HISTORY = cs.LoadHistory((0.0, 1.0), (LOAD / 2, LOAD))
SCENE = cs.Scene(HISTORY, (STEEL, STEEL), (cs.Cylinder(RADIUS),), friction=cs.Sliding(0.25))
GRID, TIMES = cs.Grid((64, 1), (6e-4, 1e-3)), (0.0, 0.5, 1.0)
MODULUS = SCENE.contact_modulus


@pytest.mark.parametrize(
    "changes",
    [
        {"wear": cs.Wear(1e-15, 0.1)},
        {"solids": (cs.ViscoelasticHalfSpace(1e11, 0.5, ((1e11, 0.5),)), RIGID)},
        {"solids": (cs.ElasticPlasticHalfSpace(210e9, 0.3, 1e12), STEEL)},
    ],
    ids=["wear", "creep", "yield stress that nothing reaches"],
)
def test_between_like_bodies_shear_is_the_coefficient_times_an_unchanged_pressure(changes: dict[str, Any]) -> None:
    scene = replace(SCENE, **changes)
    found, plain = (cs.solve(one, GRID, EXACT, times=TIMES) for one in (scene, replace(scene, friction=None)))
    np.testing.assert_allclose(found.pressure, plain.pressure, atol=1e-6 * plain.pressure.max())
    for frame in found.frames:
        np.testing.assert_array_equal(frame.shear, [0.25 * frame.pressure, 0 * frame.pressure])
        assert frame.quantities["traction_coefficient"].value == pytest.approx(0.25)


def test_between_unlike_bodies_each_instant_is_the_contact_at_rest() -> None:
    scene = replace(SCENE, solids=(STEEL, RIGID), outputs=(cs.SubsurfaceStress(depths=(5e-5,)),))
    found = cs.solve(scene, GRID, EXACT, times=TIMES)
    stress = found.to_dataset()["von_mises"]
    for number, frame in enumerate(found.frames):
        rest = cs.solve(replace(scene, load=cs.LineLoad(HISTORY.at(TIMES[number]))), GRID, EXACT)
        np.testing.assert_allclose(frame.pressure, rest.pressure, atol=1e-6 * rest.pressure.max())
        np.testing.assert_allclose(stress[number], rest.derived["von_mises"].values, rtol=1e-5)


def pressed(
    peaks: tuple[float, float], coefficient: float, hardening: float, index: int = 0, cells: int = 60
) -> cs.Evolution:
    """Steel slides on a steel that yields at 500 MPa, from one peak pressure of Hertz to another one."""
    half_width = 2 * peaks[1] * RADIUS / MODULUS
    solids: list[Any] = [STEEL, STEEL]
    solids[index] = cs.ElasticPlasticHalfSpace(210e9, 0.3, 5e8, hardening)
    load = cs.LoadHistory((0.0, 1.0), tuple(pi * RADIUS * peak**2 / MODULUS for peak in peaks))
    scene = replace(SCENE, load=load, solids=tuple(solids), friction=cs.Sliding(coefficient))
    steps = cs.TimeSteps((0.0, 1.0), error_estimator="none")
    return cs.solve(scene, cs.Grid((cells, 1), (3 * half_width, half_width)), EXACT, times=steps)


@pytest.mark.parametrize(
    ("index", "coefficient", "ratio", "x", "z"),
    [(0, 0.25, 0.6093, 0.676, 0.489), (1, 0.25, 0.6093, -0.676, 0.489), (0, 0.35, 0.7397, 0.33, 0.025)],
    ids=["ahead of the axis of the first body", "behind it in the second", "at the surface, from 0.263 on"],
)
def test_sliding_bodies_yield_first_where_the_closed_form_says(
    index: int, coefficient: float, ratio: float, x: float, z: float
) -> None:
    """The place in half-widths, and the largest von Mises stress over the peak pressure there, of McEwen's stress."""
    peak = 5e8 / ratio
    before, after = (pressed((0.87 * peak, up * peak), coefficient, 1e10, index).to_dataset() for up in (0.97, 1.05))
    assert before["equivalent_plastic_strain"].max() == 0
    strain = after["equivalent_plastic_strain"].isel(time=-1, y=0)
    worst = strain.where(strain == strain.max(), drop=True)
    half_width = 2 * 1.05 * peak * RADIUS / MODULUS
    assert worst["x"].item() / half_width == pytest.approx(x, abs=0.1)
    assert worst["z"].item() / half_width == pytest.approx(z, abs=0.04)  # layers are 0.05 thick


@pytest.mark.parametrize("hardening", [0.0, 2e9])
def test_friction_beyond_yield_in_shear_needs_a_body_that_hardens(hardening: float) -> None:
    """The stress xz at the surface is the friction; of a perfectly plastic body it is at most Y over the root of 3."""
    limit = 5e8 / 3**0.5 / 0.5  # peak pressure whose friction is at it
    found = pressed((0.95 * limit, 1.1 * limit), 0.5, hardening, cells=30)
    assert found.frames[0].status is cs.Status.CONVERGED
    assert found.status is (cs.Status.CONVERGED if hardening else cs.Status.SHEAR_BEYOND_YIELD)
