from typing import Any

import numpy as np
import pytest
from mpmath import diff, lu_solve, matrix, mp, mpf
from mpmath import exp as mp_exp

from contactstudy.elasticity.kernels.layer.response import LayerResponse
from tests.contactstudy.elasticity.kernels.layer_materials import LAYERS
from tests.fifty_digits import stored


def rest(layer: LayerResponse, k: float) -> float:
    return float(np.real(layer.remainder(np.array([k])))[0])


@stored
def judged_layer(
    shear_ratio: float, coating_poisson_ratio: float, substrate_poisson_ratio: float, k: float
) -> mpf:
    """1 + D by the layered problem in plane strain: Airy functions, six conditions, 60 digits.

    With unit wave number and the layer from z = 0 to k: ``phi = (a + b z) e^-z + (c + d z) e^z`` in the
    layer, the first two alone below; ``s_zz = -phi``, ``s_xz ~ phi'``.
    """
    with mp.workdps(60):
        h = mpf(k)
        above = [
            lambda z: mp_exp(-z),
            lambda z: z * mp_exp(-z),
            lambda z: mp_exp(z - h),
            lambda z: z * mp_exp(z - h),
        ]
        below = [lambda z: mp_exp(h - z), lambda z: z * mp_exp(h - z)]
        bodies = (
            (above, 1, mpf(coating_poisson_ratio)),
            (below, mpf(shear_ratio), mpf(substrate_poisson_ratio)),
        )

        def at(body: Any, z: mpf) -> list[list[mpf]]:
            """phi, phi', 2 G1 times the displacements along and down, for each of the body's functions."""
            functions, ratio, nu = body
            found = []
            for function in functions:
                d = [diff(function, z, n) for n in range(4)]
                along = ratio * ((1 - nu) * d[2] + nu * d[0])
                down = ratio * ((1 - nu) * d[3] - (2 - nu) * d[1])
                found.append([d[0], d[1], along, down])
            return found

        surface, top, bottom = at(bodies[0], mpf(0)), at(bodies[0], h), at(bodies[1], h)
        system, right = matrix(6), matrix([1, 0, 0, 0, 0, 0])
        for column in range(4):
            system[0, column], system[1, column] = surface[column][0], surface[column][1]
            for row in range(4):
                system[2 + row, column] = top[column][row]
        for column in range(2):
            for row in range(4):
                system[2 + row, 4 + column] = -bottom[column][row]
        strength = lu_solve(system, right)
        moved = sum(strength[column] * surface[column][3] for column in range(4))
        return moved / (2 * (1 - mpf(coating_poisson_ratio)))


@pytest.mark.cases(100)
@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("k", [1e-4, 0.013, 0.4, 1.7, 6.0])
def test_the_response_is_that_of_the_layered_boundary_value_problem(name: str, k: float) -> None:
    layer = LAYERS[name]
    materials = *layer.shear_ratios, *layer.poisson_ratios
    wanted = judged_layer(*materials, k)
    found = 1 + layer.contrast * np.exp(-2 * k) + rest(layer, k)
    # rounding errors of d0 and of R, and those of d0 e^-2k in a sum that may cancel
    rounding = 16 * np.finfo(float).eps * (1 + abs(layer.contrast))
    assert abs(found - float(wanted)) <= rounding + 1e-13 * abs(rest(layer, k))


def test_a_layer_of_its_substrates_material_has_no_rest() -> None:
    alike = LayerResponse((1.0,), (0.3, 0.3))
    k = np.geomspace(1e-6, 20, 50)
    assert alike.contrast == 0
    # the rounding of some five steps of either stack
    assert np.abs(alike.remainder(k)).max() <= 32 * np.finfo(float).eps


def test_the_far_field_above_an_auxetic_substrate_is_that_of_long_waves() -> None:
    """The singularity nearest to zero comes closer as the substrate's Poisson's ratio falls below 0."""
    layer = LayerResponse((1e4,), (0.5, -0.99))
    # on a circle of half the distance of that singularity, 1 / (4 m (1 - nu2)), 64 points leave 2^-64
    radius = 0.5 / (4 * 1e4 * 1.99)
    around = layer.remainder(radius * np.exp(2j * np.pi * np.arange(64) / 64))
    terms = np.real(np.fft.fft(around)) / 64
    wanted = [terms[n] / radius**n for n in (2, 4, 6)]
    assert layer.taylor[1:] == pytest.approx(wanted, rel=1e-10)
