"""The balance of flow on cells, without a scene around it."""

from math import pi, sqrt

import numpy as np
import pytest

from contactstudy.lubrication.film_equation import (
    Film,
    FilmEquation,
)
from contactstudy.lubrication.plane_strain import DirectStep
from contactstudy.lubrication.pseudo_time import FilmControls, iterate


def rigid_film(inlet: float, cells: int) -> Film:
    """The film of a rigid cylinder and an isoviscous lubricant at M = 1; the inlet in units of sqrt(2 H)."""
    load_parameter = 1.0
    film = 2.447484 * pi / (8 * load_parameter**2)
    width = sqrt(2 * film)
    size = (inlet + 3) * width / cells
    x = -inlet * width + (np.arange(cells) + 0.5) * size
    rigid = FilmEquation(
        gap=(x**2 / 2)[:, None],
        deflection=np.zeros_like,
        cell=(size, 1.0),
        resistance=3 * pi**2 / (8 * load_parameter**2),
        load=pi / 2,
        log_viscosity=lambda pressure: (np.zeros_like(pressure), np.zeros_like(pressure)),
        density=lambda pressure: (np.ones_like(pressure), np.zeros_like(pressure)),
    )
    pressure = np.exp(-(x**2))[:, None]
    pressure[rigid.fixed] = 0
    pressure *= rigid.load / (pressure.sum() * size)
    start = rigid.film_of(pressure, np.zeros_like(pressure), film)
    last = iterate(rigid, start, DirectStep.for_equation(rigid), FilmControls())
    assert last.converged(1e-8)
    return last.film


@pytest.mark.cases(1)
@pytest.mark.parametrize(("inlet", "film"), [(12, 2.4067), (25, 2.4379), (50, 2.4452)])
def test_rigid_cylinders_have_the_film_of_martin(inlet: float, film: float) -> None:
    # the change by halving is three times the error, of second order; published digits
    coarse, fine = (8 / pi * rigid_film(inlet, cells).separation for cells in (400, 800))
    assert fine == pytest.approx(film, abs=abs(fine - coarse) + 1e-4)
