"""Bodies that yield: reference numbers, limits, histories."""

from math import inf, pi

import numpy as np
import pytest

import contactstudy as cs

EXACT = cs.ExactPeriodicity()
YOUNG, NU, YIELD = 210e9, 0.3, 1e9
RADIUS = 0.01
RIGID = cs.HalfSpace(inf, 0.0)
# Over the yield stress, the peak pressure of Hertz at which a body yields first, at z = 0.704292 a.
FIRST_YIELD = 1.793670


def half_width(times_yield: float) -> float:
    """Of Hertz's contact [m] whose peak pressure is so many times the yield stress."""
    return 2 * RADIUS * times_yield * YIELD * (1 - NU**2) / YOUNG


def load(times_yield: float) -> float:
    """[N/m]"""
    return pi / 2 * times_yield * YIELD * half_width(times_yield)


def pressed(
    times_yield: float,
    *,
    hardening: float = 0.1,
    kinematic: float = 0.0,
    yield_stress: float = YIELD,
) -> cs.Scene:
    """A rigid cylinder pressed on a body and lifted, in 1 s each; hardening moduli over Young's."""
    body = cs.ElasticPlasticHalfSpace(YOUNG, NU, yield_stress, hardening * YOUNG, kinematic * YOUNG)
    history = cs.LoadHistory((0.0, 1.0, 2.0), (0.0, load(times_yield), 0.0))
    return cs.Scene(history, (body, RIGID), (cs.Cylinder(RADIUS),))


def grid_of(times_yield: float, cell: float, width: float = 3.2) -> cs.Grid:
    """Lengths over the half-width of Hertz."""
    a = half_width(times_yield)
    cells = round(width / cell)
    return cs.Grid((cells, 1), (cells * cell * a, a))


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Of components (xx, yy, zz, yz, xz, xy) in front."""
    xx, yy, zz, yz, xz, xy = stress
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    return np.sqrt(normal + 3 * (yz**2 + xz**2 + xy**2))


def test_a_body_yields_first_where_von_mises_says() -> None:
    """At 1.79367 Y: stress in means over cells is less by a share of the cell squared."""
    errors = []
    for cell in (0.2, 0.1):
        grid = grid_of(1.5, cell)
        found = cs.evolve(pressed(1.5), grid, EXACT, times=(1,), step_error=cs.StepError.NONE)
        stress = found.to_dataset()["stress"].isel(time=0, y=0)
        share = von_mises(stress.values).max() / YIELD
        errors.append(1.5 / share / FIRST_YIELD - 1)
        layer = np.unravel_index(von_mises(stress.values).argmax(), stress.shape[1:])[0]
        assert stress["z"][layer] / half_width(1.5) == pytest.approx(0.704, abs=cell)
        for step, yields in ((-1e-3, False), (1e-3, True)):
            scene = pressed(1.5 / share * (1 + step))
            found = cs.evolve(scene, grid_of(1.5 / share, cell), EXACT, times=(0, 1))
            assert found.to_dataset()["plastic_strain"].any() == yields
    assert 0 < errors[1] < 5e-3
    # a quarter, but for where the highest stress lies in its cell
    assert 2 < errors[0] / errors[1] < 8
