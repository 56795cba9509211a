import numpy as np
import pytest

import contactstudy as cs
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from tests.contactstudy.lubrication.scenes import DRY, by_moes, grid, in_moes_units, with_motion

A = DRY.hertz.half_width


def plain(scene: cs.Scene) -> cs.Scene:
    return with_motion(scene, cavitation=cs.ReynoldsCavitation())


def wavy(height: float, along: float = np.inf) -> cs.Scene:
    """Waves across of a ``height`` over the smooth film, at M = 20, L = 0, where Moes' film is 1.443."""
    film = 1.443 / in_moes_units(solve_lubricated(by_moes(20, 0), grid(64, 4.0)), 1.0)
    return by_moes(20, 0, cs.Waviness(height * film, across=A / 2, along=along))


def test_both_agree_where_the_film_forms_once() -> None:
    for scene in (by_moes(20, 5), by_moes(5, 0), wavy(0.5)):
        both = solve_lubricated(scene, grid(200, 5.0))
        full = solve_lubricated(plain(scene), grid(200, 5.0))
        assert full.pressure == pytest.approx(both.pressure, rel=1e-5, abs=10.0)
        assert full.flow == pytest.approx(both.flow, rel=1e-6)
        assert full.flux_spread < 1e-6
        assert (full.film_fraction == 1).all()


@pytest.mark.parametrize(("cells", "along"), [((400, 1), np.inf), pytest.param((96, 16), A, marks=pytest.mark.whole)])
def test_plain_cavitation_makes_lubricant_where_the_film_forms_again(cells: tuple[int, int], along: float) -> None:
    scene, where = wavy(3.0, along), grid(cells[0], 4.0, cells[1])
    conserving, full = (solve_lubricated(one, where, tolerance=1e-7) for one in (scene, plain(scene)))
    bearing = np.flatnonzero((conserving.pressure > 0).any(axis=1))
    assert (conserving.pressure[bearing[0] : bearing[-1]] == 0).any()
    assert conserving.flux_spread < 1e-6
    assert full.flux_spread > 1
    assert full.film_fraction.min() == 1
