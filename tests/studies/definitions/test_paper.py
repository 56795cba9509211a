"""The paper's Fig. 4, and analytic values beside it."""

import pytest

import contactstudy as cs
from studies.definitions.line_contact import POINT_CELLS as CELLS
from studies.definitions.line_contact import point_displacement
from studies.registry import load

HALF_A_UNIT = 5e-5


@pytest.mark.parametrize(
    ("padding", "centre", "across", "along"),
    [
        (cs.ZeroPadding(), 0.9999, 0.3007, 0.3007),
        (cs.DuplicatedPadding(), 1.1609, 0.4415, 0.5958),
    ],
    ids=str,
)
def test_displacement_under_a_periodic_point_pressure(
    padding: cs.Padding, centre: float, across: float, along: float
) -> None:
    found = point_displacement(padding)
    middle = CELLS // 2
    assert found["displacement_x"].values[middle] == pytest.approx(centre, abs=HALF_A_UNIT)
    assert found["displacement_x"].values[0] == pytest.approx(across, abs=HALF_A_UNIT)
    assert found["displacement_y"].values[0] == pytest.approx(along, abs=HALF_A_UNIT)


def test_zero_padding_lies_on_the_point_contact() -> None:
    hertz = cs.analytic.HertzPoint(load=1.0, radius=1.0, contact_modulus=1.0)
    a, cell = hertz.contact_radius, 3 * hertz.contact_radius / CELLS
    beside_centre = (2 * (cell / 2) ** 2) ** 0.5
    assert hertz.displacement(beside_centre) / hertz.approach == pytest.approx(
        0.9998, abs=HALF_A_UNIT
    )
    beside_edge = ((1.5 * a - cell / 2) ** 2 + (cell / 2) ** 2) ** 0.5
    assert hertz.displacement(beside_edge) / hertz.approach == pytest.approx(
        0.3006, abs=HALF_A_UNIT
    )


def test_the_pressure_of_fig_5_is_that_in_the_middle_of_the_length() -> None:
    """A window of one image makes the pressure vary along the length, so that the place matters."""
    study = load("paper").override({"padding": "superposed", "images": "1"})
    [case] = study.cases()
    solution = case.run(case.prepare())
    scaled = solution.pressure / case.scene.hertz.peak_pressure
    found = study.measures(case, solution)
    assert found["pressure"].values == pytest.approx(scaled[:, 64], rel=1e-12)
    assert scaled[:, 64] != pytest.approx(scaled[:, 42], rel=1e-3)
