import pytest

import contactstudy as cs
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, by_moes, grid, with_motion

A = DRY.hertz.half_width


def supplied(scene: cs.Scene, layer: float | None) -> cs.Scene:
    return with_motion(scene, supply=layer)


def thickness_of_flow(contact: FilmSolution) -> float:
    return contact.flow / contact.mean_speed


@pytest.mark.parametrize(("load", "viscosity"), [(20, 5), (20, 0), (100, 10)])
def test_the_flow_is_the_smaller_of_supply_and_flooded_flow(load: float, viscosity: float) -> None:
    scene = by_moes(load, viscosity)
    flooded = thickness_of_flow(solve_lubricated(scene, grid(240, 4.5)))
    for fraction in (5.0, 0.5, 0.2):
        contact = solve_lubricated(supplied(scene, fraction * flooded), grid(240, 4.5))
        assert contact.status is not cs.Status.FILM_NOT_CONVERGED
        assert thickness_of_flow(contact) == pytest.approx(min(fraction, 1.0) * flooded, rel=1e-4)


# supply over the flooded flow: front over the half-width at M = 20, L = 5, on cells of 0.00625, from another program
FRONTS = ((0.9, -1.391), (0.65, -1.128), (0.3, -1.022))


@pytest.mark.parametrize(("fraction", "front"), FRONTS)
def test_the_meniscus_is_where_the_reference_has_it(fraction: float, front: float) -> None:
    scene, cells = by_moes(20, 5), grid(480, 4.5)
    flooded = thickness_of_flow(solve_lubricated(scene, cells))
    contact = solve_lubricated(supplied(scene, fraction * flooded), cells)
    # two cells of this grid and of that one; the flow has an error by its cells of 0.2 %, and the front at 0.9 moves by
    # ten times as much
    assert contact.meniscus / A == pytest.approx(front, abs=2 * cells.cell_size[0] / A)


def test_a_starved_film_is_not_said_to_have_too_short_a_grid() -> None:
    scene, cells = by_moes(2, 0), grid(200, 1.8)
    flooded = solve_lubricated(scene, cells)
    starved = solve_lubricated(supplied(scene, 0.3 * thickness_of_flow(flooded)), cells)
    assert flooded.status is cs.Status.STARVED_INLET
    assert starved.status is cs.Status.CONVERGED


def test_ridges_along_the_motion_are_starved_alike() -> None:
    scene = by_moes(20, 5, cs.Waviness(2e-8, across=float("inf"), along=A / 2))
    cells = grid(96, 3.0, 16)
    flooded = thickness_of_flow(solve_lubricated(scene, cells, tolerance=1e-7))
    contact = solve_lubricated(supplied(scene, 0.5 * flooded), cells, tolerance=1e-7)
    assert contact.status is not cs.Status.FILM_NOT_CONVERGED
    assert thickness_of_flow(contact) == pytest.approx(0.5 * flooded, rel=1e-4)
