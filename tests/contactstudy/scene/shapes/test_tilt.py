from dataclasses import replace
from math import atan, pi, tan

import numpy as np
import pytest
from scipy import optimize

import contactstudy as cs

STEEL = cs.HalfSpace(206e9, 0.3)
RADIUS, LENGTH, LOAD = 5e-3, 10e-3, 1500.0
GRID = cs.Grid((48, 200), (0.6e-3, LENGTH))


def solved(*shapes: cs.Shape) -> cs.Solution:
    """A roller of `LENGTH` under `LOAD`, whose ends are the grid's."""
    scene = cs.Scene(cs.TotalLoad(LOAD, LENGTH), (STEEL, STEEL), (cs.Cylinder(RADIUS), *shapes))
    return cs.solve(scene.problem(GRID, (cs.ZeroPadding(), cs.ZeroPadding())), tolerance=1e-9)


def test_the_gap_opens_towards_larger_y() -> None:
    assert cs.Tilt(0.01).gap(GRID) == pytest.approx(tan(0.01) * GRID.y[None])


def test_a_tilted_crown_is_the_crown_beside_the_middle() -> None:
    """``y^2 / (2 R) + y t`` is the parabola about ``-R t``, less a constant."""
    crown, cells = cs.Crown(0.3), 10
    straight = solved(crown).pressure
    tilted = solved(crown, cs.Tilt(atan(cells * GRID.cell_size[1] / crown.radius))).pressure
    shifted = np.roll(straight, -cells, axis=1)
    np.testing.assert_allclose(tilted, shifted, rtol=0, atol=1e-7 * straight.max())


@pytest.mark.parametrize("angle", [2e-4, 5e-4])
def test_a_profiled_roller_follows_the_slices_of_palmgren(angle: float) -> None:
    """Slices under ``d = 3.84e-5 q^0.9 L^0.1`` (N, mm; Palmgren 1959) miss the peak by 2 % where no end bears."""
    profile = cs.LundbergProfile.iso_16281(2 * RADIUS, LENGTH)
    tilted = solved(profile, cs.Tilt(angle))
    drop = 1e3 * (profile.gap(GRID) + cs.Tilt(angle).gap(GRID))[0]  # mm
    stiffness = 3.84e-5 ** (-10 / 9) * (1e3 * LENGTH) ** (-1 / 9)

    def loads(approach: float) -> np.ndarray:
        return np.asarray(stiffness * np.clip(approach - drop, 0, None) ** (10 / 9))  # N/mm

    def excess(approach: float) -> float:
        return float(loads(approach).mean()) * 1e3 * LENGTH - LOAD

    per_length = 1e3 * loads(float(optimize.brentq(excess, -1.0, 1.0)))
    modulus = STEEL.youngs_modulus / (2 * (1 - STEEL.poisson_ratio**2))
    slices = np.sqrt(per_length * modulus / (pi * RADIUS))
    assert tilted.pressure.max() == pytest.approx(slices.max(), rel=0.02)
    place = GRID.y[[tilted.pressure.max(axis=0).argmax(), slices.argmax()]]
    assert place[0] == pytest.approx(place[1], abs=LENGTH / 20)


def test_a_tilted_roller_is_planned_over_its_own_length() -> None:
    profile = cs.LundbergProfile.iso_16281(2 * RADIUS, LENGTH)
    shapes = (cs.Cylinder(RADIUS), profile, cs.Tilt(5e-4))
    scene = cs.Scene(cs.TotalLoad(LOAD), (STEEL, STEEL), shapes)
    planned = cs.plan(scene, error=0.05)
    assert planned.grid.length == LENGTH
    assert planned.padding == (cs.ZeroPadding(), cs.ZeroPadding())
    endless = replace(scene, load=cs.LineLoad(1e5), shapes=(cs.Cylinder(RADIUS), cs.Tilt(5e-4)))
    with pytest.raises(cs.InvalidInput, match="a roller without a length"):
        cs.plan(endless)
