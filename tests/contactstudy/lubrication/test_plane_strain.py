from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.answers.lubricated_contact import film_answer
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.pseudo_time import FilmControls
from contactstudy.lubrication.steady_film import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, STEEL, by_moes, grid, in_moes_units, with_motion

# M, L, film on the axis and smallest film: 1200 graded cells, extrapolated, to 2e-4 of the film
REFERENCE = (
    (1, 0, 3.2597, 3.0428),
    (20, 0, 1.4202, 1.1245),
    (20, 5, 3.5040, 2.6345),
    (20, 10, 5.2744, 3.9741),
    (100, 10, 4.3709, 3.2733),
    pytest.param(1000, 5, 2.0726, 1.5470, marks=pytest.mark.whole),
)


@pytest.mark.cases(1)
@pytest.mark.parametrize(("load", "viscosity", "central", "smallest"), REFERENCE)
def test_the_film_is_that_of_graded_cells_within_its_bound(
    load: float, viscosity: float, central: float, smallest: float
) -> None:
    contact = cs.solve(by_moes(load, viscosity), error=2e-2)
    error = contact.error
    for film, parts, expected in (
        (contact.central_film, error.central_film, central),
        (contact.minimum_film, error.minimum_film, smallest),
    ):
        assert parts.total < 4e-2
        assert in_moes_units(contact, film) == pytest.approx(expected, rel=parts.total + 2e-4)
    # a fit of films, not of rigid cylinders
    assert load < 20 or cs.analytic.moes_film(load, viscosity) == pytest.approx(central, rel=0.05)


def test_every_operating_point_converges_carries_its_load_and_loses_no_lubricant() -> None:
    for load, viscosity in product((1, 10, 100, 1000), (0, 1, 5, 20)):
        contact = solve_lubricated(by_moes(load, viscosity), grid(100, 4.5))
        assert contact.status is not cs.Status.FILM_NOT_CONVERGED, (load, viscosity)
        assert contact.flux_spread < 1e-6, (load, viscosity)
        assert contact.load_per_length == pytest.approx(1e5, rel=1e-7)
        # no cell has both pressure and void
        assert (contact.film_fraction[contact.pressure > 0] == 1).all()
        assert ((contact.film_fraction > 0) & (contact.film_fraction <= 1)).all()


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("load", "speed", "central", "smallest", "friction"),
    [
        (2e4, 1.0, 361.4e-9, 316.7e-9, 0.0015),
        (1e5, 1.0, 309.3e-9, 264.3e-9, 0.0210),
        (1e5, 0.1, 61.36e-9, 52.40e-9, 0.0161),
    ],
)
def test_steel_in_mineral_oil_has_the_film_and_friction_of_the_reference(
    load: float, speed: float, central: float, smallest: float, friction: float
) -> None:
    oil = cs.Lubricant(0.04, 2e-8, cs.Roelands(0.6), shear=cs.Eyring(5e6))
    scene = replace(DRY, load=cs.LineLoad(load), lubrication=cs.Lubrication(oil, speed, slide_roll_ratio=0.1))
    contact = cs.solve(scene, error=1e-2)
    assert contact.status is cs.Status.CONVERGED
    # the reference has the shorter inlet of its own, so twice that of ours, and its last digit
    error = contact.error
    assert contact.central_film == pytest.approx(central, rel=2 * error.central_film.total + 2e-4)
    assert contact.minimum_film == pytest.approx(smallest, rel=2 * error.minimum_film.total + 2e-4)
    assert contact.friction == pytest.approx(friction, rel=2 * error.friction_coefficient.total, abs=5e-5)


def test_laws_and_coatings_without_their_effect_are_the_simpler_ones() -> None:
    simple = by_moes(20, 5)
    laws = {"viscosity_law": cs.Roelands(exponent=1.0), "density": cs.DowsonHigginson(0.0)}
    coated = replace(simple, solids=(cs.CoatedHalfSpace(STEEL, 1e-5, STEEL), STEEL))
    plain, by_laws, same = (
        solve_lubricated(scene, grid(100, 4.5)) for scene in (simple, by_moes(20, 5, **laws), coated)
    )
    assert by_laws.film == pytest.approx(plain.film, rel=1e-12)
    assert by_laws.pressure == pytest.approx(plain.pressure, rel=1e-9, abs=1.0)
    assert same.film == pytest.approx(plain.film, rel=1e-6)


def test_a_film_that_is_not_resolved_has_its_status() -> None:
    coarse = solve_lubricated(by_moes(1000, 0), grid(100, 4.5))
    assert coarse.status is cs.Status.FILM_BELOW_CELL
    stopped = solve_lubricated(by_moes(20, 5), grid(100, 4.5), controls=FilmControls(max_iterations=2))
    assert stopped.status is cs.Status.FILM_NOT_CONVERGED


def test_limiting_shear_begins_at_a_stress_at_ambient_pressure_and_grows_with_pressure() -> None:
    law = cs.LimitingShear(0.05, ambient=2e6)
    contact = solve_lubricated(by_moes(20, 10, shear=law), grid(200, 4.5))
    assert (contact.shear <= 2e6 + 0.05 * contact.pressure).all()
    assert 0.02 < contact.friction < 0.05 + 2e6 / (np.pi / 4 * DRY.hertz.peak_pressure)
    rates = np.array([1e4, 1e9])
    assert law.stress(rates, np.array([0.0, 1e8])) == pytest.approx([1e4, 7e6], rel=1e-4)


def test_power_is_lost_in_pure_rolling_too() -> None:
    scene = by_moes(20, 5)
    rolling = with_motion(scene, slide_roll_ratio=0.0)
    sliding, still = (solve_lubricated(motion, grid(200, 4.5)) for motion in (scene, rolling))
    assert still.friction == 0
    assert still.power_loss > 0
    assert film_answer(still).quantities["friction_coefficient"].bound == 0
    assert sliding.sliding_speed == pytest.approx(0.1 * sliding.mean_speed)
    slid = sliding.friction * 1e5 * sliding.sliding_speed
    assert sliding.power_loss == pytest.approx(still.power_loss + slid, rel=1e-6)


@pytest.mark.parametrize(("load", "viscosity"), [(4.5, 25.0), (70.7, 14.1)])
def test_rolling_resistance_is_that_of_biboulet_and_houpert(load: float, viscosity: float) -> None:
    """Theirs of a surface, Part 1 (2010), eqs. 40 to 42: between rigid and elastic cylinders."""
    scene = by_moes(load, viscosity, viscosity_law=cs.Roelands(0.6))
    contact = cs.solve(with_motion(scene, slide_roll_ratio=0.0), error=5e-2)
    modulus = 210e9 / (1 - 0.3**2)
    per_length = 1e5 / (modulus * 0.01)
    speed = (per_length / load) ** 2
    rigid = 1.42 * np.sqrt(speed * per_length)
    force = rigid / (1 + (1.4 / 1.45 * np.sqrt(load)) ** 10) ** 0.1 * modulus * 0.01
    assert contact.power_loss / contact.mean_speed == pytest.approx(2 * force, rel=0.1)


def test_the_share_of_a_thin_film_is_that_of_the_cells_below_it() -> None:
    contact = solve_lubricated(by_moes(20, 5), grid(200, 4.5))
    # one side of a width of nine half-widths, over the two of Hertz's contact
    film = np.where(contact.grid.x < 0, 1e-7, 3e-7)[:, None]
    halved = replace(contact, film=film, pressure=np.where(film < 2e-7, 1e6, 3e6))
    assert halved.thinner_than(2e-7) == pytest.approx((2.25, 0.25))


@pytest.mark.whole
def test_slower_films_go_over_into_the_dry_contact() -> None:
    """At M = 1e5 a cold start fails, and the film is followed from higher speeds down."""
    cells = grid(400, 3.0)
    dry = cs.solve(DRY.problem(cells, cs.ExactPeriodicity())).pressure
    distances = []
    for load in (1e3, 1e4, 1e5):
        contact = solve_lubricated(by_moes(load, 0), cells)
        assert contact.status is not cs.Status.FILM_NOT_CONVERGED
        distances.append(float(np.abs(contact.pressure - dry).sum() / dry.sum()))
    # a hundredth of the speed each: the film falls by a factor of 4 or more, and so does its distance
    for thick, thin in pairwise(distances):
        assert thin < thick / 4


@pytest.mark.parametrize("height", [0.5, 3.0])
def test_plain_cavitation_makes_lubricant_where_the_film_forms_again_and_is_the_same_where_it_forms_once(
    height: float,
) -> None:
    """Waves across of a height over the smooth film at M = 20, L = 0, which by Moes is 1.443."""
    scene, cells = by_moes(20, 0), grid(400, 4.0)
    film = 1.443 / in_moes_units(solve_lubricated(scene, grid(64, 4.0)), 1.0)
    scene = by_moes(20, 0, cs.Waviness(height * film, across=DRY.hertz.half_width / 2))
    both = solve_lubricated(scene, cells)
    full = solve_lubricated(with_motion(scene, cavitation=cs.ReynoldsCavitation()), cells)
    assert both.flux_spread < 1e-6
    assert (full.film_fraction == 1).all()
    bearing = np.flatnonzero(both.pressure > 0)
    forms_again = (both.pressure[bearing[0] : bearing[-1]] == 0).any()
    assert forms_again == (height > 1) == (full.flux_spread > 1)
    if not forms_again:
        assert full.pressure == pytest.approx(both.pressure, rel=1e-5, abs=10.0)
        assert full.flow == pytest.approx(both.flow, rel=1e-6)


def thickness_of_flow(contact: FilmSolution) -> float:
    return contact.flow / contact.mean_speed


@pytest.mark.parametrize(("load", "viscosity"), [(20, 0), (100, 10)])
def test_the_flow_is_the_smaller_of_supply_and_flooded_flow(load: float, viscosity: float) -> None:
    scene = by_moes(load, viscosity)
    flooded = thickness_of_flow(solve_lubricated(scene, grid(240, 4.5)))
    for fraction in (5.0, 0.5, 0.2):
        contact = solve_lubricated(with_motion(scene, supply=fraction * flooded), grid(240, 4.5))
        assert contact.status is not cs.Status.FILM_NOT_CONVERGED
        assert thickness_of_flow(contact) == pytest.approx(min(fraction, 1.0) * flooded, rel=1e-4)


# supply over the flooded flow: front over the half-width at M = 20, L = 5, on cells of 0.00625, from another program
FRONTS = ((0.9, -1.391), (0.65, -1.128), (0.3, -1.022))


@pytest.mark.parametrize(("fraction", "front"), FRONTS)
def test_the_meniscus_is_where_the_reference_has_it(fraction: float, front: float) -> None:
    scene, cells = by_moes(20, 5), grid(480, 4.5)
    flooded = thickness_of_flow(solve_lubricated(scene, cells))
    contact = solve_lubricated(with_motion(scene, supply=fraction * flooded), cells)
    # two cells of this grid and of that one; the flow has an error by its cells of 0.2 %, and the front at 0.9 moves by
    # ten times as much
    width = DRY.hertz.half_width
    assert contact.meniscus / width == pytest.approx(front, abs=2 * cells.cell_size[0] / width)


def test_a_starved_film_is_not_said_to_have_too_short_a_grid() -> None:
    scene, cells = by_moes(2, 0), grid(200, 1.8)
    flooded = solve_lubricated(scene, cells)
    starved = solve_lubricated(with_motion(scene, supply=0.3 * thickness_of_flow(flooded)), cells)
    assert flooded.status is cs.Status.STARVED_INLET
    assert starved.status is cs.Status.CONVERGED
