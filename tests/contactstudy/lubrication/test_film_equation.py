"""The balance of flow on cells, without a scene around it."""

from math import pi, sqrt

import numpy as np
import pytest

from contactstudy.domain.fields import Array
from contactstudy.lubrication.film_equation import (
    Film,
    FilmEquation,
    Linearised,
    Storage,
    _couette_flow,
)
from contactstudy.lubrication.plane_strain import DirectStep
from contactstudy.lubrication.pseudo_time import ActiveSets, FilmControls, FilmStep, iterate


def equation(nx: int, ny: int, rng: np.random.Generator) -> FilmEquation:
    """A rough gap, soft bodies that deflect by the neighbours' mean, and a compressible lubricant."""

    def deflection(pressure: Array) -> Array:
        return 0.3 * pressure + 0.1 * (np.roll(pressure, 1, 1) + np.roll(pressure, -1, 1))

    return FilmEquation(
        gap=rng.uniform(0.5, 1.0, (nx, ny)),
        deflection=deflection,
        cell=(0.1, 0.2),
        resistance=0.7,
        load=1.0,
        log_viscosity=lambda pressure: (2 * pressure, np.full_like(pressure, 2.0)),
        density=lambda pressure: (1 + 0.1 * pressure, np.full_like(pressure, 0.1)),
    )


@pytest.mark.parametrize("along", [1, 4])
def test_the_linearised_balance_is_the_derivative_of_the_balance(along: int) -> None:
    rng = np.random.default_rng(1)
    shape = 9, along
    film_equation = equation(*shape, rng)
    storage = Storage(3.0, rng.uniform(0, 1, shape))
    pressure, void = rng.uniform(0, 2, shape), rng.uniform(0, 0.5, shape)
    step, void_step, rise = rng.normal(size=shape), rng.normal(size=shape), 0.4
    step[film_equation.fixed] = 0

    def balance(length: float) -> Array:
        film = film_equation.film_of(
            pressure + length * step, void + length * void_step, 0.5 + length * rise
        )
        return film_equation.linearise(film, storage).residual

    start = film_equation.film_of(pressure, void, 0.5)
    linear = film_equation.linearise(start, storage).change(step, void_step, rise)
    length = 1e-5
    difference = (balance(length) - balance(-length)) / (2 * length)
    # central differences err by the length squared, rounding by 1e-16 over it
    assert np.abs(linear - difference).max() <= 1e-8 * np.abs(linear).max()


def test_what_leaves_a_cell_enters_the_next() -> None:
    rng = np.random.default_rng(2)
    shape = 9, 4
    film_equation = equation(*shape, rng)
    film = film_equation.film_of(rng.uniform(0, 2, shape), np.zeros(shape), 0.5)
    linear = film_equation.linearise(film)
    through = linear.flux[-1].sum() - linear.flux[1].sum()
    assert linear.residual.sum() == pytest.approx(through, rel=1e-13)


def test_the_content_drawn_through_a_face_is_of_second_order() -> None:
    errors = []
    for cells in (40, 80):
        x = (np.arange(cells) + 0.5) / cells
        content = 2 + np.sin(2 * np.pi * x)
        flux = _couette_flow(content[:, None])[0][1:, 0]
        exact = 2 + np.sin(2 * np.pi * (np.arange(2, cells) / cells))
        errors.append(np.abs(flux - exact).max())
    assert errors[0] / errors[1] > 2**1.8


def test_the_content_drawn_through_a_face_is_never_negative() -> None:
    content = 10.0 ** np.random.default_rng(3).uniform(-6, 6, (1000, 1))
    assert (_couette_flow(content)[0] >= 0).all()


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


class Unmoved:
    """Return steps that change nothing."""

    def step(
        self, linear: Linearised, film: Film, active: ActiveSets, load_residual: float
    ) -> FilmStep:
        still = np.zeros_like(film.pressure)
        return FilmStep(still, still, 0.0, self)


def test_an_iteration_ends_after_thirty_steps_that_do_not_halve_the_residual() -> None:
    rough = equation(9, 1, np.random.default_rng(4))
    start = rough.film_of(np.zeros((9, 1)), np.zeros((9, 1)), 0.5)
    last = iterate(rough, start, Unmoved(), FilmControls())
    assert last.iterations == 30
    assert not last.converged(1e-8)


@pytest.mark.cases(1)
@pytest.mark.parametrize(("inlet", "film"), [(12, 2.4067), (25, 2.4379), (50, 2.4452)])
def test_rigid_cylinders_have_the_film_of_martin(inlet: float, film: float) -> None:
    # the change by halving is three times the error, of second order; published digits
    coarse, fine = (8 / pi * rigid_film(inlet, cells).separation for cells in (400, 800))
    assert fine == pytest.approx(film, abs=abs(fine - coarse) + 1e-4)
