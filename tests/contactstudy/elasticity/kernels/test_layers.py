"""Layers on a half-space: their response to one wave, and that to cells, rows and lattices of cells."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from mpmath import exp as mp_exp
from mpmath import lu_solve, matrix, mp, mpf
from scipy.special import j0, j1

from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.kernels.displacement import mean_gauss_rule
from contactstudy.elasticity.kernels.layer_response import (
    DisplacementWaves,
    LayerResponse,
    StressWaves,
    WaveResponse,
)
from contactstudy.elasticity.kernels.layer_waves import WaveCoefficients, composite

# alike and unlike, compressible or not, on a soft, a stiff and a rigid base
LAYERS = {
    "stiff": LayerResponse((4.0,), (0.25, 0.35)),
    "very stiff": LayerResponse((1e3,), (0.3, 0.3)),
    "very soft": LayerResponse((1e-3,), (0.3, 0.45)),
    "rubber on a rigid base": LayerResponse((0.0,), (0.5, 0.3)),
    "soft between stiff": LayerResponse((300.0, 0.5), (0.25, 0.4, 0.3), (0.4, 1.0)),
    "two on a rigid base": LayerResponse((0.2, 5.0, 0.0), (0.3, 0.45, 0.2, 0.3), (0.3, 0.5, 1.0)),
    "auxetic base": LayerResponse((1e3,), (0.5, -0.99)),
    "alike": LayerResponse((1.02,), (0.28, 0.3)),
}
CELLS = (0.0, 0.0, 0.8, 1.3), (0.4, -1.95, 0.8, 1.3), (50.0, -30.0, 2.0, 3.0)


@pytest.mark.cases(8)
@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("k", [1e-6, 1e-4, 0.02, 0.9, 7.0, 60.0])
def test_layers_respond_as_the_boundary_value_problem_of_all_says(name: str, k: float) -> None:
    """By Airy functions of each with 80 digits: displacements at the surface, stress in the middle of each layer."""
    layers = LAYERS[name]
    ends, ratios = [0.0, *layers.interfaces], (1.0, *layers.shear_ratios)
    with mp.workdps(80):

        def state(number: int, z: mpf) -> list[list[mpf]]:
            """s_zz, s_xz, s_xx, and 2 G1 k times the displacements, for each function of a material."""
            ratio, nu = mpf(ratios[number]), mpf(layers.poisson_ratios[number])
            computed = []
            for sign, power in ((-1, 0), (-1, 1), (1, 0), (1, 1))[: 2 if number == len(ends) - 1 else 4]:
                e = mp_exp(sign * z)
                f = [mpf(sign) ** n * e * (z**power + (n * sign if power else 0)) for n in range(4)]
                along = ratio * ((1 - nu) * f[2] + nu * f[0])
                computed.append([-f[0], f[1], f[2], along, ratio * ((1 - nu) * f[3] - (2 - nu) * f[1])])
            return computed

        size = 4 * len(layers.interfaces) + 2
        system, right = matrix(size), matrix(size, 2)
        right[0, 0] = right[1, 1] = -1
        for column, values in enumerate(state(0, mpf(0))):
            system[0, column], system[1, column] = values[:2]
        for number, end in enumerate(ends[1:]):
            for row, part in enumerate((0, 1, 3, 4), 2 + 4 * number):
                for which, sign in ((number, 1), (number + 1, -1)):
                    for column, values in enumerate(state(which, mpf(end) * k), 4 * which):
                        system[row, column] = sign * values[part]
        strengths = [lu_solve(system, right[:, load]) for load in (0, 1)]

        def at(load: int, number: int, z: float, part: int) -> float:
            values = enumerate(state(number, mpf(z) * k), 4 * number)
            return float(sum(strengths[load][column] * value[part] for column, value in values))

        stiff = 2 * (1 - layers.poisson_ratios[0])
        wanted = at(0, 0, 0, 4) / stiff, at(1, 0, 0, 3) / stiff, -at(0, 0, 0, 3)
        computed = layers.compliances(np.array([k]))[:3, 0]
        np.testing.assert_allclose(computed, wanted, rtol=1e-12, atol=1e-13)
        changes = np.multiply.outer(layers.contrasts, np.exp(-2 * np.array([k])))
        parts = layers.above.compliances(np.array([k])) + changes
        parts[:1] += DisplacementWaves(layers, "pressure").remainders(np.array([k]))
        parts[1:] += DisplacementWaves(layers, "traction").remainders(np.array([k]))
        np.testing.assert_allclose(parts[:3, 0], wanted, rtol=1e-12, atol=1e-13)
        for number, (top, bottom) in enumerate(pairwise([*ends, 1.4][: size // 4 + 2])):
            middle = (top + bottom) / 2
            responses = (StressWaves(layers, middle, load) for load in ("pressure", "across"))
            stresses = [waves.stresses(np.array([k]))[:3, 0] for waves in responses]
            within = [[at(load, number, middle, part) for part in range(3)] for load in (0, 1)]
            np.testing.assert_allclose(stresses, within, rtol=1e-11, atol=1e-13)


def by_quadrature(waves: WaveResponse, cell: tuple[float, float, float, float]) -> dict[str, float]:
    """Over the cell, and over the numbers and the directions of all waves; all lengths in thicknesses."""
    x, y, dx, dy = cell
    nodes, weights = np.array(mean_gauss_rule(12)).T
    last = 42 / waves.decay_rate
    ends = 1e-6 * 2.0 ** np.arange(17)
    k, weight = composite(np.concatenate([[0.0], ends[ends < last], np.arange(0.2, last, 0.2)]))
    points = 1j * (y + dy / 2 * nodes) + (x + dx / 2 * nodes)[:, None]
    # s along x: a field turns m times as the point goes about the load
    s, turn = np.abs(points).ravel(), (points / np.abs(points)).ravel()
    phase = np.multiply.outer(s, k)
    bessel = [j0(phase), j1(phase)]
    for m in (1, 2):
        bessel.append(2 * m / phase * bessel[m] - bessel[m - 1])
    computed = {}
    for name, parts in waves.harmonics(k).items():
        field = np.zeros(s.size)
        for m, part in parts.items():
            radial = bessel[m] @ np.real(part * 1j**m * k * weight)
            field += radial * ((turn**m).real if waves.parity(name)[1] > 0 else (turn**m).imag)
        over_cell = weights @ field.reshape(points.shape) @ weights
        computed[name] = float(over_cell * dx * dy / (2 * np.pi))
    return computed


def responses(name: str) -> list[WaveResponse]:
    loads = (0.0, "pressure"), (0.6, "across"), (1.5, "along"), (40.0, "across")
    return [
        *(DisplacementWaves(LAYERS[name], load) for load in ("pressure", "traction")),
        *(StressWaves(LAYERS[name], depth, load) for depth, load in loads),
    ]


@pytest.mark.parametrize("name", LAYERS)
def test_a_cell_is_the_integral_over_it_and_over_all_waves(name: str) -> None:
    for waves in responses(name):
        own = max(abs(value) for value in by_quadrature(waves, CELLS[0]).values())
        for cell in CELLS:
            x, y, dx, dy = cell
            for field, wanted in by_quadrature(waves, cell).items():
                computed = WaveCoefficients(waves, 1.0, field).cell(np.array(x), np.array(y), dx, dy)
                assert abs(float(computed) - wanted) <= 1e-11 * own


@pytest.mark.parametrize("name", LAYERS)
def test_a_cell_far_longer_than_the_layer_is_thick_is_the_sum_of_its_parts(name: str) -> None:
    """Alone, in a row and in a lattice, at edges and corners too, where fields along one axis are largest."""
    x, y, sheared = np.arange(3.0)[:, None], np.arange(4.0), responses(name)[3]
    cases: list[Any] = [
        (
            CoatingCoefficients(DisplacementWaves(LAYERS[name], "pressure"), 0.2, "z", 1.0).row,
            (15 * x, y / 8),
            (15.0, 1 / 8, 1.0),
            (3, 1),
        ),
        (WaveCoefficients(sheared, 0.1, "xy").lattice, (x, 3 * y), (1.0, 3.0, 30.0, 18.0), (5, 15)),
    ]
    for field in sheared.harmonics(np.ones(1)):
        cell = WaveCoefficients(sheared, 1.0, field).cell
        cases.append((cell, (100 * x, 1500 * y), (200.0, 3e3), (2, 2)))
    for kernel, (x, y), (dx, dy, *periods), (m, n) in cases:
        whole, (left, below) = kernel(x, y, dx, dy, *periods), (dx * (1 - m) / (2 * m), dy * (1 - n) / (2 * n))
        places = ((x + left + i * dx / m, y + below + j * dy / n) for i in range(m) for j in range(n))
        parts = sum(kernel(*place, dx / m, dy / n, *periods) for place in places)
        np.testing.assert_allclose(parts, whole, atol=1e-12 * np.abs(whole).max())


# the far field of far stiffer layers begins beyond so many images
@pytest.mark.parametrize("name", ["stiff", "very soft", "rubber on a rigid base", "alike"])
@pytest.mark.parametrize(
    ("thickness", "period", "images"), [(0.06, 1.0, 2000), (0.4, 1.0, 2000), (1.7, 1.0, 2000), (0.4, 60.0, 400)]
)
def test_a_row_is_the_sum_of_its_images(name: str, thickness: float, period: float, images: int) -> None:
    """Those far away are felt as lines: what is left of them falls as the square of their number, but for a constant."""
    coating = CoatingCoefficients(DisplacementWaves(LAYERS[name], "pressure"), thickness, "z", 1.0)
    dx, dy = 0.3, 0.25
    x, y = np.array([[0.0], [0.3], [2.7]]), np.array([0.0, 0.25, 0.5])
    away = (y[:, None] + period * np.arange(-images, images + 1)).ravel()
    cells = coating.cell(x, away, dx, dy).reshape(3, 3, -1)
    half = images // 2
    few, many = cells[:, :, half:-half].sum(axis=2), cells.sum(axis=2)
    # half a step beyond the last image
    ratio = ((images + 0.5) / (half + 0.5)) ** 2
    summed, row = (ratio * many - few) / (ratio - 1), coating.row(x, y, dx, dy, period)
    np.testing.assert_allclose(row - row[0, 0], summed - summed[0, 0], atol=1e-11 * np.abs(cells).max() * images**0.5)
