import numpy as np
import pytest

from studies.definitions.friction import COEFFICIENTS
from tests.studies.conftest import measured


def test_coatings_are_measured() -> None:
    thin, known, thick = (
        measured("coating", ratio=4.0, thickness=thickness, grid=128)
        for thickness in (1e-4, 1.0, 1e3)
    )
    # the substrate's Hertz contact, and that of the coating: half as wide, twice as high
    assert thin["half_width"] == pytest.approx(1, rel=1e-2)
    assert thick["half_width"] == pytest.approx(0.5, rel=1e-2)
    assert thick["peak_pressure"] == pytest.approx(2, rel=1e-2)
    # second order in the cell
    assert known["reference_error"] < (2.4 / 128) ** 2


def test_friction_is_measured() -> None:
    cork, steel = (
        measured("friction", poisson_ratio=ratio, grid=201, rough_grid=32) for ratio in (0.0, 0.3)
    )
    for coefficient, wanted in ((0.0, 0.55751), (0.2, 0.58999), (0.4, 0.81584)):
        found = float(steel["von_mises"][COEFFICIENTS.index(coefficient)])
        assert found == pytest.approx(wanted, abs=5e-3)
    assert steel["depth"][COEFFICIENTS.index(0.3)] < 0.01
    part = steel["fraction"].values
    np.testing.assert_allclose(steel["stick"], np.sqrt(1 - part), atol=2.6 / 201)
    np.testing.assert_allclose(cork["stick_sphere"], np.cbrt(1 - part), atol=2.5 / 32)
    assert cork["superposition_error"] < 1e-3
    assert steel["superposition_error"] > 0.02
    # without Poisson's ratio all shear is along the force
    assert cork["transverse_traction"] < 1e-3 < steel["transverse_traction"] < 1
