"""The studies of coatings and of friction: what they measure, pinned by closed forms."""

from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.scene.solids.coated import CoatedHalfSpace
from contactstudy.scene.solids.stress_model import HalfSpaceStress
from contactstudy.scene.stress import SubsurfaceStressOperator
from studies.definitions import coating
from studies.definitions.coating import A, coated, interface
from studies.engine.run import run
from studies.reference.line_contact import STEEL
from studies.registry import load
from tests.studies.conftest import quiet


def test_stress_at_the_interface_of_like_materials_is_that_of_a_half_space() -> None:
    """Under Hertz's pressure the largest shear, half-way down to half a half-width, is a quarter of the highest."""
    grid = cs.Grid((400, 1), (4e-4, 1.0))
    x = grid.x / 1e-4
    pressure = np.sqrt(np.maximum(1 - x**2, 0))
    body = CoatedHalfSpace(STEEL, 0.5e-4, STEEL)
    shear, tension = interface(body, pressure, grid.cell_size[0])
    # the period is 128 half-widths: its square is the error
    assert shear == pytest.approx(0.25, abs=1e-3)
    below = SubsurfaceStressOperator(
        grid, (cs.ZeroPadding(), cs.ExactPeriodicity()), HalfSpaceStress(0.3), (0.5e-4,)
    )
    along = below(pressure[:, None])[0, 0, :, 0]
    assert tension == pytest.approx(max(along.max(), 0), abs=1e-3)


def test_a_stiff_coating_is_in_tension_at_its_interface_and_a_soft_one_is_not() -> None:
    x = np.linspace(-2, 2, 400, endpoint=False) + 0.005
    pressure = np.sqrt(np.maximum(1 - x**2, 0))
    step = 0.01 * A
    stiff, soft = (interface(coated(ratio, A), pressure, step)[1] for ratio in (4, 0.25))
    assert stiff > 0.3
    assert soft < 0.05


@pytest.mark.whole
def test_coatings_are_measured(tmp_path: Path) -> None:
    study = load("coating").override({"ratio": "4", "thickness": "1e-4,1,1e3", "grid": "128"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    one = dataset.isel(ratio=0, grid=0)
    # the substrate's Hertz contact, and that of the coating: half as wide, twice as high
    assert one["half_width"].isel(thickness=0) == pytest.approx(1, rel=1e-2)
    assert one["half_width"].isel(thickness=2) == pytest.approx(0.5, rel=1e-2)
    assert one["peak_pressure"].isel(thickness=2) == pytest.approx(2, rel=1e-2)
    assert one["image_error"].isel(thickness=1) > 0.05
    # second order in the cell
    assert one["reference_error"].max() < (2.4 / 128) ** 2


@pytest.mark.whole
def test_friction_is_measured(tmp_path: Path) -> None:
    study = load("friction").override({"poisson_ratio": "0,0.3", "grid": "201", "rough_grid": "32"})
    dataset = run(study, tmp_path, workers=0, repeats=0, log=quiet)
    cork, steel = (dataset.isel(poisson_ratio=n, grid=0, rough_grid=0) for n in (0, 1))
    for coefficient, wanted in ((0.0, 0.55751), (0.2, 0.58999), (0.4, 0.81584)):
        found = float(steel["von_mises"].sel(coefficient=coefficient))
        assert found == pytest.approx(wanted, abs=5e-3)
    assert steel["depth"].sel(coefficient=0.3) < 0.01
    np.testing.assert_allclose(steel["stick"], np.sqrt(1 - steel["fraction"]), atol=2.6 / 201)
    np.testing.assert_allclose(cork["stick_sphere"], np.cbrt(1 - cork["fraction"]), atol=2.5 / 32)
    assert cork["superposition_error"] < 1e-3
    assert steel["superposition_error"] > 0.02


@pytest.mark.parametrize(
    ("axis", "value", "said"),
    [("grid", 31, "at least 32 cells"), ("rough_grid", 15, "at least 16 cells")],
)
def test_a_grid_that_shows_no_contact_is_refused(axis: str, value: int, said: str) -> None:
    point = {"poisson_ratio": 0.3, "grid": 32, "rough_grid": 16} | {axis: value}
    with pytest.raises(cs.InvalidInput, match=said):
        load("friction").case_at(point)


MODULUS = 70e9


def body(ratio: float, above: float, below: float, thickness: float = 1.0) -> CoatedHalfSpace:
    return CoatedHalfSpace(
        cs.HalfSpace(ratio * MODULUS, above), thickness, cs.HalfSpace(MODULUS, below)
    )


@pytest.mark.parametrize("nu", [0.2, 0.4])
def test_stress_at_a_rigid_base_is_that_of_a_layer_bonded_to_it(nu: float) -> None:
    """Airy's function ``c ((1 - 2 nu) S + t C) + d (t S - 2 (1 - nu) C)`` is still at the base, t above it.

    S and C are the hyperbolic sine and cosine of t; it is 1 and flat at the top, where t is k.
    """
    k = np.array([0.3, 1.0, 2.5])
    s, c = np.sinh(k), np.cosh(k)
    value = np.array([(1 - 2 * nu) * s + k * c, k * s - 2 * (1 - nu) * c])
    slope = np.array([2 * (1 - nu) * c + k * s, k * c - (1 - 2 * nu) * s])
    det = value[0] * slope[1] - value[1] * slope[0]
    first, second = slope[1] / det, -slope[0] / det
    shear, along = coating._at_interface(body(1e-9, nu, 0.3), k)
    # the base gives way by its fraction of the moduli
    np.testing.assert_allclose(shear, -2 * (1 - nu) * first, rtol=1e-6)
    np.testing.assert_allclose(along, 2 * nu * second, rtol=1e-6)


@pytest.mark.parametrize(("ratio", "above", "below"), [(3.0, 0.2, 0.4), (0.5, 0.35, 0.1)])
def test_a_thin_layer_is_stretched_like_the_surface_under_it(
    ratio: float, above: float, below: float
) -> None:
    """Under a pressure p the surface of a half-plane bears -p along it as well, and so contracts.

    By ``(1 + nu) (1 - 2 nu) p / E``; the layer does the same under the same pressure across.
    """
    k = np.array([1e-4])
    shear, along = coating._at_interface(body(ratio, above, below), k)
    stretched = ratio * (1 + below) * (1 - 2 * below)
    wanted = -(stretched + above * (1 + above)) / (1 - above**2)
    # what bends is of the order of the wave number; balance along the layer leaves its thickness' worth of shear
    np.testing.assert_allclose(along, wanted, rtol=20 * k[0])
    np.testing.assert_allclose(shear, k * wanted, rtol=20 * k[0])


@pytest.mark.parametrize("ratio", [0.25, 4.0])
def test_known_contacts_are_met_to_the_square_of_the_cell(ratio: float) -> None:
    # a thin coating and one as thick as the contact is wide to one side
    assert [wide for known, wide, *_ in coating.REFERENCE if known == ratio] == [0.2, 1.0]
    found = coating._reference_error(ratio, 96)
    # half-widths of one in a width of 2.4
    assert found < (2.4 / 96) ** 2
