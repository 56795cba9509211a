import numpy as np
import pytest
import xarray as xr

from contactstudy.analytic import moes_film
from contactstudy.lubrication.posed_film import lubricated_scales
from studies.definitions.lubrication import case_at, measures
from tests.studies.report.drawings.drawn import findings

POINT = {"load": 20.0, "viscosity": 5.0, "rms": 0.0, "cavitation": "elrod-adams", "grid": 128}


def test_a_scene_has_the_load_and_viscosity_of_its_point() -> None:
    case = case_at(POINT)
    scales = lubricated_scales(case.scene)
    assert scales.load_parameter == pytest.approx(20, rel=1e-12)
    assert scales.viscosity_parameter == pytest.approx(5, rel=1e-12)


def test_films_are_in_the_unit_of_moes() -> None:
    case = case_at(POINT | {"grid": 400})
    found = measures(case, case.run())
    # reference solutions on graded cells, with a longer inlet: 3.504
    assert float(found["central_film"]) == pytest.approx(3.504, rel=5e-3)
    over = float(found["film_at_zero_gradient"]) / moes_film(20, 5)
    assert float(found["film_over_moes"]) == pytest.approx(over)
    assert float(found["converged"]) == 1
    assert float(found["resolved"]) == 1


def test_a_rough_point_has_a_thinner_film_than_a_smooth_one() -> None:
    case = case_at(POINT | {"rms": 0.2, "grid": 64})
    assert case.grid.cells == (64, 32)
    smooth = case_at(POINT | {"grid": 64})
    rough, plain = (measures(part, part.run()) for part in (case, smooth))
    assert float(rough["converged"]) == 1
    assert float(rough["minimum_film"]) < float(plain["minimum_film"])


def test_the_finding_says_how_many_films_do_not_converge() -> None:
    axes = ("load", "viscosity", "rms", "cavitation", "grid")
    names = ("converged", "resolved", "film_over_moes", "iterations", "flux_spread")
    films = xr.Dataset(
        {name: (axes, np.ones((4, 1, 1, 1, 1))) for name in names}, coords={"rms": [0.0]}
    )
    assert findings("lubrication", films)[0].startswith("Smooth films converge from a cold start")
    films["converged"][0] = 0
    assert findings("lubrication", films)[0].startswith("1 of 4 films do not converge")
