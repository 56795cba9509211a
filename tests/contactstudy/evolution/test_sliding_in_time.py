from dataclasses import replace
from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs
from tests.conftest import STEEL

EXACT = cs.ExactPeriodicity()
RADIUS, LOAD = 0.01, 1e5
RIGID = cs.HalfSpace(float("inf"), 0.3)
HISTORY = cs.LoadHistory((0.0, 1.0), (LOAD / 2, LOAD))
SCENE = cs.Scene(HISTORY, (STEEL, STEEL), (cs.Cylinder(RADIUS),), friction=cs.Sliding(0.25))
GRID = cs.Grid((64, 1), (6e-4, 1e-3))
RUBBER = cs.ViscoelasticHalfSpace(1e11, 0.5, ((1e11, 0.5),))


def solved(scene: cs.Scene, grid: cs.Grid = GRID, times: tuple[float, ...] = (0.0, 0.5, 1.0)) -> cs.Evolution:
    found = cs.solve(scene, grid, EXACT, times=times)
    assert isinstance(found, cs.Evolution)
    return found


@pytest.mark.parametrize(
    "changes",
    [
        {}, {"wear": cs.Wear(1e-15, 0.1)}, {"solids": (RUBBER, RIGID)},
        {"solids": (cs.ElasticPlasticHalfSpace(210e9, 0.3, 1e12), STEEL)},
    ],
    ids=["history", "wear", "creep", "yield stress that nothing reaches"],
)  # fmt: skip
def test_between_like_bodies_shear_is_the_coefficient_times_an_unchanged_pressure(
    changes: dict[str, object],
) -> None:
    scene = replace(SCENE, **changes)
    found, plain = solved(scene), solved(replace(scene, friction=None))
    np.testing.assert_allclose(found.pressure, plain.pressure, atol=1e-6 * plain.pressure.max())
    for frame in found.frames:
        np.testing.assert_array_equal(frame.shear, [0.25 * frame.pressure, 0 * frame.pressure])
        assert frame.quantities["traction_coefficient"].value == pytest.approx(0.25)


def test_between_unlike_bodies_each_instant_is_the_contact_at_rest() -> None:
    scene = replace(SCENE, solids=(STEEL, RIGID), outputs=(cs.SubsurfaceStress(depths=(5e-5,)),))
    found = solved(scene)
    stress = found.to_dataset()["von_mises"]
    for number, time in enumerate((0.0, 0.5, 1.0)):
        load = cs.LineLoad(HISTORY.at(time))
        rest = cs.solve(replace(scene, load=load), GRID, EXACT)
        worst = np.abs(found.frames[number].pressure - rest.pressure).max()
        assert worst < 1e-6 * rest.pressure.max()
        np.testing.assert_allclose(stress[number], rest.derived["von_mises"].values, rtol=1e-5)


def yielding(
    fraction: float, index: int, friction: cs.Sliding | None, cells: int = 60, ratio: float = 0.6093
) -> cs.Evolution:
    """A steel cylinder whose largest von Mises stress is a `fraction` of the yield stress of one body."""
    stress = 5e8
    modulus = STEEL.youngs_modulus / (1 - 0.3**2) / 2
    # 0.6093 p0 at a coefficient of 0.25: McEwen's stress, maximised
    peak = fraction * stress / ratio
    half_width = 2 * peak * RADIUS / modulus
    solids: list[cs.HalfSpace | cs.ElasticPlasticHalfSpace] = [STEEL, STEEL]
    solids[index] = cs.ElasticPlasticHalfSpace(210e9, 0.3, stress, 1e10)
    load = cs.LoadHistory((0.0, 1.0), (0.8 * pi * half_width * peak / 2, pi * half_width * peak / 2))
    scene = replace(SCENE, load=load, solids=(solids[0], solids[1]), friction=friction)
    grid = cs.Grid((cells, 1), (3 * half_width, half_width))
    steps = cs.TimeSteps((0.0, 1.0), error_estimator="none")
    found = cs.solve(scene, grid, EXACT, times=steps)
    assert isinstance(found, cs.Evolution)
    return found


@pytest.mark.parametrize(
    ("index", "coefficient", "ratio", "x", "z"),
    [(0, 0.25, 0.6093, 0.676, 0.489), (1, 0.25, 0.6093, -0.676, 0.489), (0, 0.35, 0.7397, 0.33, 0.0)],
    ids=["ahead of the axis of the first body", "behind it in the second", "at the surface, from 0.263 on"],
)  # fmt: skip
def test_sliding_bodies_yield_first_where_the_closed_form_says(
    index: int, coefficient: float, ratio: float, x: float, z: float
) -> None:
    """The place in half-widths, and the largest von Mises stress over the peak pressure there."""
    friction = cs.Sliding(coefficient)
    before = yielding(0.97, index, friction, ratio=ratio).to_dataset()
    assert before["equivalent_plastic_strain"].max() == 0
    data = yielding(1.05, index, friction, ratio=ratio).to_dataset()
    strain = data["equivalent_plastic_strain"].isel(time=-1, y=0)
    assert strain.max() > 0
    worst = strain.where(strain == strain.max(), drop=True)
    half_width = data["x"].max().item() / 1.5 * 60 / 59
    assert worst["x"].item() / half_width == pytest.approx(x, abs=0.06 if z else 0.1)
    if z:
        assert worst["z"].item() / half_width == pytest.approx(z, abs=0.06)
    else:
        assert worst["z"].item() == data["z"].values[0]


@pytest.mark.parametrize("hardening", [0.0, 2e9])
def test_friction_beyond_yield_in_shear_needs_a_body_that_hardens(hardening: float) -> None:
    """The stress xz at the surface is the friction; of a perfectly plastic body it is at most Y over the root of 3."""
    solid = cs.ElasticPlasticHalfSpace(210e9, 0.3, 5e8, hardening)
    peaks = np.array([0.95, 1.1]) * 5e8 / 3**0.5 / 0.5  # Hertz's, whose friction is so many times that limit
    modulus = 210e9 / (1 - 0.3**2) / 2
    loads = pi * RADIUS * peaks**2 / modulus
    scene = replace(
        SCENE,
        load=cs.LoadHistory((0.0, 1.0), tuple(loads.tolist())),
        solids=(solid, STEEL),
        friction=cs.Sliding(0.5),
    )
    grid = cs.Grid((40, 1), (8 * RADIUS * peaks[1] / modulus, 1e-3))
    found = cs.solve(scene, grid, EXACT, times=cs.TimeSteps((0.0, 1.0), error_estimator="none"))
    assert found.frames[0].status is cs.Status.CONVERGED
    assert (found.frames[1].status is cs.Status.CONVERGED) == (hardening > 0)
    if not hardening:
        assert found.status is cs.Status.SHEAR_BEYOND_YIELD
        assert found.error.l1.total == inf
