"""Films far from the middle of the range: light and heavy loads, short and coarse grids, and errors that are true."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from tests.contactstudy.lubrication.scenes import DRY, STEEL, by_moes, grid, in_moes_units

assert DRY.hertz is not None
A = DRY.hertz.half_width
OIL = cs.Lubricant(0.04, 2e-8)


def at(load: float, speed: float) -> cs.Scene:
    """Steel cylinders in mineral oil."""
    motion = cs.Lubrication(OIL, speed, slide_roll_ratio=0.1)
    return cs.Scene(cs.LineLoad(load), (STEEL, STEEL), (cs.Cylinder(0.01),), lubrication=motion)


@pytest.mark.cases(1)
@pytest.mark.parametrize("load", [0.1, 0.01, 0.001])
def test_the_lightest_loads_have_the_film_of_martin(load: float) -> None:
    contact = cs.solve_lubricated(by_moes(load, 0), error=1e-2)
    assert contact.status is cs.FilmStatus.CONVERGED
    assert contact.error is not None
    # rigid cylinders, an endless inlet: h0 = 2.447484 / M
    film = in_moes_units(contact, contact.central_film) * load
    bound = contact.error.central_film.total + 0.1 * load
    assert film == pytest.approx(2.447484, rel=bound)


@pytest.mark.whole
def test_a_load_of_ten_newtons_per_metre_has_a_film_by_error() -> None:
    contact = cs.solve_lubricated(at(10.0, 1.0), error=1e-2)
    assert contact.status is cs.FilmStatus.CONVERGED
    assert contact.error is not None
    assert contact.error.central_film.total <= 1e-2
    assert contact.load_per_length == pytest.approx(10, rel=1e-6)


def test_a_grid_narrower_than_the_contact_is_refused_with_the_width_to_give() -> None:
    heavy = at(2e6, 0.01)
    assert heavy.hertz is not None
    with pytest.raises(cs.InvalidInput, match=r"Grid\.extent\[0\] is .* too narrow"):
        cs.solve_lubricated(heavy, cs.Grid((400, 1), (1.5 * heavy.hertz.half_width, 1e-3)))
    contact = cs.solve_lubricated(heavy, cs.Grid((400, 1), (3 * heavy.hertz.half_width, 1e-3)))
    assert contact.status is not cs.FilmStatus.NOT_CONVERGED


def test_few_cells_have_no_error_and_say_why() -> None:
    contact = cs.solve_lubricated(at(1e5, 1.0), grid(24, 5.0), error=1e-2)
    assert contact.error is not None
    assert contact.error == cs.film_error(contact)
    assert contact.error.central_film.total == np.inf
    assert "24 cells" in contact.error.reason


def test_a_total_load_is_spread_over_the_period_of_the_grid() -> None:
    scene = replace(at(1.0, 1.0), load=cs.TotalLoad(100.0, length=1e-3))
    contact = cs.solve_lubricated(scene, cs.Grid((100, 1), (10 * A, 2e-3)))
    assert contact.load_per_length == pytest.approx(5e4, rel=1e-7)


def test_a_film_starts_from_one_on_another_grid() -> None:
    scene = by_moes(20, 5)
    coarse = cs.solve_lubricated(scene, grid(100, 4.5))
    cold, warm = (
        cs.solve_lubricated(scene, grid(300, 6.0), start=start) for start in (None, coarse)
    )
    assert warm.film == pytest.approx(cold.film, rel=1e-6)
    with pytest.raises(cs.InvalidInput, match="cells along the length"):
        cs.solve_lubricated(scene, grid(64, 3.0, 16), start=replace(coarse, grid=grid(64, 3.0, 8)))


@pytest.mark.parametrize("seed", [1, 2])
def test_a_rough_film_under_a_coat_converges(seed: int) -> None:
    heights = cs.Roughness(4e-8, hurst=0.8, roll_off=A, cut_off=A / 2, seed=seed, extent=(6 * A, A))
    coat = cs.CoatedHalfSpace(cs.HalfSpace(20e9, 0.3), 2e-5, STEEL)
    scene = replace(by_moes(20, 5, heights), solids=(coat, STEEL))
    contact = cs.solve_lubricated(scene, grid(96, 3.0, 32), tolerance=1e-6)
    assert contact.status is cs.FilmStatus.CONVERGED
    assert contact.flux_spread < 1e-6


@pytest.mark.whole
def test_a_longer_inlet_has_the_same_random_surface() -> None:
    heights = cs.Roughness(3e-8, hurst=0.8, roll_off=A, cut_off=A / 2, seed=1)
    of_grid, fixed = (
        cs.film_error(cs.solve_lubricated(by_moes(20, 5, one), grid(64, 3.0, 16), tolerance=1e-6))
        for one in (heights, replace(heights, extent=(6 * A, A)))
    )
    assert of_grid.central_film.inlet == pytest.approx(fixed.central_film.inlet, rel=1e-3)


def test_friction_that_hangs_on_a_spike_has_no_error_unless_its_stress_is_limited() -> None:
    newtonian, eyring = (
        cs.solve_lubricated(by_moes(6.5, 7.5, shear=shear), error=2e-2).error
        for shear in (cs.Newtonian(), cs.Eyring(5e6))
    )
    assert newtonian is not None
    assert eyring is not None
    assert newtonian.friction.total == np.inf
    assert "of the friction" in newtonian.reason
    assert np.isfinite(eyring.friction.total)


@pytest.mark.cases(2)
@pytest.mark.parametrize(
    ("load", "viscosity"),
    10 ** np.random.default_rng(7).uniform((0.3, 0.0), (2.0, 1.0), (10, 2)),
)
def test_errors_are_no_larger_than_their_estimates(load: float, viscosity: float) -> None:
    contact = cs.solve_lubricated(by_moes(load, viscosity), error=2e-2)
    cells, (width, period) = contact.grid.cells, contact.grid.extent
    # cells of half the width, twice the inlet
    fine = cs.solve_lubricated(
        by_moes(load, viscosity), cs.Grid((4 * cells[0], 1), (2 * width, period)), start=contact
    )
    assert fine.status is cs.FilmStatus.CONVERGED
    error = contact.error
    assert error is not None
    assert error.central_film.total + error.minimum_film.total < 4e-2
    for name in ("central_film", "minimum_film", "friction"):
        bound = getattr(error, name).total
        assert getattr(contact, name) == pytest.approx(getattr(fine, name), rel=bound), name
