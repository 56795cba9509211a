import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.coating import CoatingCoefficients
from contactstudy.elasticity.convolution import general_convolutions
from contactstudy.elasticity.kernels.layer_response import DisplacementWaves, LayerResponse, StressWaves
from contactstudy.elasticity.kernels.layer_waves import amplitudes
from tests.conftest import STEEL

STIFF = cs.HalfSpace(420e9, 0.2)
CYLINDER = (cs.Cylinder(0.01),)
ROUGH = (*CYLINDER, cs.Roughness(1.5e-7, hurst=0.8, roll_off=1e-4, cut_off=2e-5, seed=1))
EXACT = cs.ExactPeriodicity()
MATERIALS = [LayerResponse((4.0,), (0.25, 0.35)), LayerResponse((0.2,), (0.3, 0.45))]
FIELDS = ["xx", "yy", "xy", "x", "y", "z"]


@pytest.mark.parametrize("layer", MATERIALS)
def test_a_wave_of_shear_moves_the_surface_as_its_stress_says(layer: LayerResponse) -> None:
    """By the stress s_xx at the surface, which is 2 under shear and -1 under pressure without a substrate."""
    k, waves = np.linspace(0.05, 6, 40), DisplacementWaves(layer, "traction")
    along = amplitudes(waves, k, 0 * k)["xx"]
    pressed, sheared = (StressWaves(layer, 0.0, load).stresses(k)[2] for load in ("pressure", "across"))
    nu, (m,) = layer.poisson_ratios[0], layer.shear_ratios
    np.testing.assert_allclose(along, 2 * np.pi / k * (sheared / 2 - 1), atol=1e-12)
    coupling = amplitudes(waves, k, 0 * k)["x"]
    # by reciprocity, the displacement along the surface under pressure
    expected = -(1 - nu) * pressed - nu - (1 - 2 * nu)
    np.testing.assert_allclose(coupling, -2j * np.pi / k * expected, atol=1e-12)
    across = amplitudes(waves, k, 0 * k)["yy"]
    antiplane = (m + np.tanh(k)) / (1 + m * np.tanh(k)) - 1
    np.testing.assert_allclose(across, 2 * np.pi / k * antiplane / (1 - nu), atol=1e-12)


@pytest.mark.parametrize("name", FIELDS)
def test_a_lattice_answers_a_wave_by_its_amplitude(name: str) -> None:
    layer, thickness, n, width = MATERIALS[0], 0.2, 64, 1.0
    grid = cs.Grid((n, n), (width, width))
    waves = DisplacementWaves(layer, "pressure" if name == "z" else "traction")
    coefficients = CoatingCoefficients(waves, thickness, name, 1.0)
    (convolution,) = general_convolutions([{coefficients: 1.0}], grid, (EXACT, EXACT))
    qx, qy = 2 * np.pi / width * np.array([3, 2])
    phase = qx * grid.x[:, None] + qy * grid.y
    kx, ky = np.array([[qx * thickness]]), np.array([[qy * thickness]])
    amplitude = thickness * complex(amplitudes(waves, kx, ky)[name][0, 0])
    # piecewise constant cells have the mean of the wave, and add what is aliased: below 1e-3 of it
    mean = np.sinc(3 / n) * np.sinc(2 / n)
    expected = mean * (amplitude * np.exp(1j * phase)).real
    assert np.abs(convolution(np.cos(phase)) - expected).max() < 2e-3 * abs(amplitude)


LAWS = [cs.TractiveRolling(0.3, longitudinal=1e-3, lateral=5e-4), cs.Fretting.cycle(0.3, 1.5e4)]


def shear(law: object, first: object, second: object, shapes: object, paddings: object) -> cs.Contact:
    scene = cs.Scene(cs.LineLoad(1e5), (first, second), shapes, friction=law)
    return cs.solve(scene, cs.Grid((32, 16), (3.2e-4, 3.2e-4)), paddings, tolerance=1e-7)


@pytest.mark.parametrize("paddings", [EXACT, (cs.ZeroPadding(), cs.ZeroPadding())])
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("body", [cs.CoatedHalfSpace(STEEL, 1.0, STIFF), cs.CoatedHalfSpace(STIFF, 1e-12, STEEL)])
def test_a_thick_or_thin_coating_gives_the_shear_of_one_material(
    body: cs.CoatedHalfSpace, law: object, paddings: object
) -> None:
    coated, plain = (shear(law, one, one, ROUGH, paddings) for one in (body, STEEL))
    change = np.abs(coated.shear - plain.shear).sum() / np.abs(plain.shear).sum()
    assert change < 1e-5
    assert coated.status is plain.status


def test_one_coated_body_slides_as_unlike_bodies_do_where_the_coating_is_thick_or_thin() -> None:
    def shift(first: object, second: object = STEEL) -> float:
        contact = shear(cs.Sliding(0.3), first, second, CYLINDER, EXACT)
        assert contact.status is cs.Status.CONVERGED
        x = contact.grid.x[:, None]
        return float((contact.pressure * x).sum() / contact.pressure.sum())

    unlike = shift(STIFF)
    thick, thin, between = (shift(cs.CoatedHalfSpace(STIFF, h, STEEL)) for h in (1.0, 1e-12, 2e-5))
    assert thick == pytest.approx(unlike, rel=1e-3)
    assert abs(thin) < 1e-6 * unlike
    assert 0.02 * unlike < between < 0.5 * unlike


def test_shear_locked_in_below_a_coating_is_known_to_its_step_error() -> None:
    """Load and force rise in proportion; without a coating one step would be exact."""
    body = cs.CoatedHalfSpace(cs.HalfSpace(50e9, 0.4), 1e-5, STEEL)
    friction = cs.Fretting(0.3, (0.0, 1.2e4), times=(0.0, 1.0))
    scene = cs.Scene(cs.LoadHistory((0.0, 1.0), (2e4, 1e5)), (body, body), CYLINDER, friction=friction)
    coarse, fine = (
        cs.solve(scene, cs.Grid((64, 1), (4e-4, 1e-3)), EXACT, times=np.linspace(0, 1, count + 1), tolerance=1e-6)
        for count in (4, 64)
    )
    shear, wanted = coarse.frames[-1].shear, fine.frames[-1].shear
    change = np.abs(shear - wanted).sum() / np.abs(wanted).sum()
    assert 1e-4 < change < coarse.frames[-1].error.l1.steps
