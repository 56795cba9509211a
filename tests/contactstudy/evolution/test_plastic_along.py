"""Bodies that yield, in scenes that vary along their length."""

from math import inf, pi

import numpy as np

import contactstudy as cs

EXACT = cs.ExactPeriodicity()
YOUNG, NU, YIELD, RADIUS = 210e9, 0.3, 1e9, 0.01
TIMES = (1.0, 2.0)


def half_width(times_yield: float) -> float:
    """Of Hertz's contact [m] whose peak pressure is so many times the yield stress."""
    return 2 * RADIUS * times_yield * YIELD * (1 - NU**2) / YOUNG


def pressed(*more: cs.Shape, times_yield: float = 2.5) -> cs.Scene:
    """A rigid cylinder pressed on a body and lifted, in 1 s each."""
    load = pi / 2 * times_yield * YIELD * half_width(times_yield)
    body = cs.ElasticPlasticHalfSpace(YOUNG, NU, YIELD, 0.02 * YOUNG)
    shapes = cs.Cylinder(RADIUS), *more
    return cs.Scene(
        cs.LoadHistory((0.0, *TIMES), (0.0, load, 0.0)), (body, cs.HalfSpace(inf, 0)), shapes
    )


def evolved(scene: cs.Scene, cells: tuple[int, int], period: float) -> cs.Evolution:
    """With cells of a sixth of the half-width, along a ``period`` in half-widths."""
    a = half_width(2.5)
    grid = cs.Grid(cells, (cells[0] * a / 6, period * a))
    return cs.evolve(scene, grid, EXACT, times=TIMES, tolerance=1e-7, step_error=cs.StepError.NONE)


def test_a_smooth_cylinder_is_in_plane_strain_in_any_number_of_cells() -> None:
    one, many = (evolved(pressed(), (18, along), 2.0).to_dataset() for along in (1, 5))
    for name, unit in (
        ("pressure", YIELD),
        ("residual_stress", YIELD),
        ("plastic_strain", YIELD / YOUNG),
        ("residual_displacement", half_width(2.5) * YIELD / YOUNG),
    ):
        wanted = one[name].isel(y=[0] * 5).values
        # both are solved to the tolerance, which errors of a contact's displacement exceed ten times
        assert np.abs(many[name].values - wanted).max() < 1e-6 * unit
        assert np.abs(wanted).max() > 0.1 * unit
