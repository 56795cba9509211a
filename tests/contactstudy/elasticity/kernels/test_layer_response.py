from itertools import pairwise

import numpy as np
import pytest
from mpmath import exp as mp_exp
from mpmath import lu_solve, matrix, mp, mpf

from contactstudy.elasticity.kernels.layer_response import LayerResponse, LayerStress
from tests.contactstudy.elasticity.kernels.layer_materials import LAYERS


def test_a_layer_of_its_substrates_material_has_no_rest() -> None:
    alike = LayerResponse((1.0,), (0.3, 0.3))
    k = np.geomspace(1e-6, 20, 50)
    assert alike.contrast == 0
    # the rounding of some five steps of either stack
    assert np.abs(alike.remainders(k)[0]).max() <= 32 * np.finfo(float).eps


def test_the_far_field_above_an_auxetic_substrate_is_that_of_long_waves() -> None:
    """The singularity nearest to zero comes closer as the substrate's Poisson's ratio falls below 0."""
    layer = LayerResponse((1e4,), (0.5, -0.99))
    # on a circle of half the distance of that singularity, 1 / (4 m (1 - nu2)), 64 points leave 2^-64
    radius = 0.5 / (4 * 1e4 * 1.99)
    around = layer.remainders(radius * np.exp(2j * np.pi * np.arange(64) / 64))[0]
    wanted = np.real(np.fft.fft(around))[1] / 64 / radius
    k = 1e-3 * radius
    assert layer.remainders(np.array([k]))[0] == pytest.approx(wanted * k, rel=1e-2)


@pytest.mark.cases(8)
@pytest.mark.parametrize("name", LAYERS)
@pytest.mark.parametrize("k", [1e-4, 0.02, 0.9, 7.0, 60.0])
def test_layers_respond_as_the_boundary_value_problem_of_all_says(name: str, k: float) -> None:
    """By Airy functions of each with 80 digits: displacements at the surface, stress in the middle of each layer."""
    layers = LAYERS[name]
    ends, ratios = [0.0, *layers.interfaces], (1.0, *layers.shear_ratios)
    with mp.workdps(80):

        def state(number: int, z: mpf) -> list[list[mpf]]:
            """s_zz, s_xz, s_xx, and 2 G1 k times the displacements, for each function of a material."""
            ratio, nu = mpf(ratios[number]), mpf(layers.poisson_ratios[number])
            found = []
            for sign, power in ((-1, 0), (-1, 1), (1, 0), (1, 1))[: 2 if number == len(ends) - 1 else 4]:
                e = mp_exp(sign * z)
                f = [mpf(sign) ** n * e * (z**power + (n * sign if power else 0)) for n in range(4)]
                along = ratio * ((1 - nu) * f[2] + nu * f[0])
                found.append([-f[0], f[1], f[2], along, ratio * ((1 - nu) * f[3] - (2 - nu) * f[1])])
            return found

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
        found = layers.compliances(np.array([k]))[:3, 0]
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-13)
        changes = np.multiply.outer(layers.contrasts, np.exp(-2 * np.array([k])))
        parts = layers.above.compliances(np.array([k])) + changes + layers.remainders(np.array([k]))
        np.testing.assert_allclose(parts[:3, 0], wanted, rtol=1e-12, atol=1e-13)
        for number, (top, bottom) in enumerate(pairwise([*ends, 1.4][: size // 4 + 2])):
            middle = (top + bottom) / 2
            stresses = LayerStress(layers, middle).plane(np.array([k]))[..., 0]
            within = [[at(load, number, middle, part) for part in range(3)] for load in (0, 1)]
            np.testing.assert_allclose(stresses, within, rtol=1e-11, atol=1e-13)


def test_long_waves_press_thin_layers_on_a_rigid_base_like_springs_in_a_row() -> None:
    layers, k = LAYERS["two on a rigid base"], np.array([1e-5])
    moduli = [2 * (1 - nu) / (1 - 2 * nu) for nu in layers.poisson_ratios[:-1]]
    each = zip(np.diff([0.0, *layers.interfaces]), (1.0, *layers.shear_ratios), moduli, strict=False)
    springs = sum(thickness * ratio / modulus for thickness, ratio, modulus in each)
    found = (1 - layers.poisson_ratios[0]) / k * layers.compliances(k)[0]
    assert found == pytest.approx([springs], rel=1e-4)
