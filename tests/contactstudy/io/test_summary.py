"""Test the numbers of a contact that are looked at first."""

import json
from dataclasses import replace
from math import inf

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.io.summary import (
    Quantity,
    as_json,
    as_text,
    march_quantities,
    quantities,
    readable,
    rolling_quantities,
)
from tests.conftest import STEEL, LineContact

GRID = cs.Grid((4, 2), (4e-3, 6e-3))
PRESSURE = np.array([[0.0, 0.0], [1e6, 0.0], [2e6, 5e6], [0.0, 0.0]])


@pytest.mark.parametrize(
    ("value", "units", "text"),
    [
        (5.0e8, "Pa", "500 MPa"),
        (1.234567e9, "Pa", "1.235 GPa"),
        (1.83e-4, "m", "183 µm"),
        (-2.5e-3, "m", "-2.5 mm"),
        (5.31e-8, "m2", "0.0531 mm²"),
        (1e5, "N m-1", "100 N/mm"),
        (2e3, "N", "2 kN"),
        (0.0, "m", "0 nm"),
        (0.125, "1", "0.125"),
        (3.0, "kg", "3 kg"),
    ],
)
def test_a_value_is_shown_in_the_unit_that_is_read_most_easily(
    value: float, units: str, text: str
) -> None:
    assert readable(value, units) == text


@pytest.fixture
def solution(line_contact: LineContact) -> cs.Solution:
    """A solution with fields that are written here."""
    solved = cs.solve(line_contact.scene.problem(GRID, cs.ExactPeriodicity()), max_iterations=1)
    return replace(
        solved, pressure=PRESSURE, gap=np.full((4, 2), 2e-6), approach=3e-6, residual=1e-9
    )


def test_numbers_are_those_of_the_fields(solution: cs.Solution) -> None:
    numbers = {number.name: number for number in quantities(solution)}
    values = {name: number.value for name, number in numbers.items()}
    cell = 1e-3 * 3e-3
    assert values == pytest.approx(
        {
            "peak_pressure": 5e6,
            "mean_pressure": 8e6 / 3,
            "half_width": 1e-3,
            "contact_area": 3 * cell,
            "mean_gap": 2e-6,
            "smallest_gap": 2e-6,
            "approach": 3e-6,
            "total_load": 8e6 * cell,
            "load_per_length": 8e6 * cell / 6e-3,
        }
    )
    assert numbers["peak_pressure"].place == pytest.approx({"x": 0.5e-3, "y": 1.5e-3})
    assert np.isnan(numbers["peak_pressure"].error)


def test_numbers_have_the_errors_of_the_estimate(line_contact: LineContact) -> None:
    solution = cs.solve(line_contact.scene, line_contact.grid((64, 1), 1.4), cs.ExactPeriodicity())
    estimate = cs.error_estimate(solution)
    errors = {number.name: number.error for number in quantities(solution, estimate)}
    assert errors["peak_pressure"] == estimate.peak_pressure.total
    assert errors["contact_area"] == errors["half_width"] == estimate.contact_area.total
    assert errors["mean_gap"] == estimate.mean_gap.total
    hertz = line_contact.hertz
    half_width = next(n for n in quantities(solution, estimate) if n.name == "half_width")
    assert abs(half_width.value / hertz.half_width - 1) <= half_width.error


def test_the_load_of_a_roller_is_spread_over_its_length() -> None:
    shapes = (cs.Cylinder(0.01), cs.FiniteLength(4e-3))
    scene = cs.Scene(cs.TotalLoad(400.0), (STEEL, STEEL), shapes)
    solution = cs.solve(scene, cs.Grid((32, 10), (8e-4, 5e-3)), cs.ZeroPadding())
    numbers = {number.name: number.value for number in quantities(solution)}
    assert numbers["total_load"] == pytest.approx(400.0, rel=1e-7)
    assert numbers["load_per_length"] == pytest.approx(1e5, rel=1e-7)


def test_the_largest_stress_has_its_place(line_contact: LineContact) -> None:
    stress = cs.SubsurfaceStress((2e-5, 4e-5, 8e-5))
    scene = replace(line_contact.scene, outputs=(stress,))
    solution = cs.solve(scene, line_contact.grid((32, 1), 1.4), cs.ExactPeriodicity())
    von_mises = solution.to_dataset()["von_mises"]
    number = quantities(solution, von_mises=von_mises)[-1]
    assert number.value == float(von_mises.max())
    assert number.place is not None
    assert float(von_mises.sel(x=number.place["x"], z=number.place["z"]).max()) == number.value


ROWS = [
    Quantity("a", "peak", 5e8, "Pa", 0.0123, {"x": 0.0, "y": 2e-3}),
    Quantity("b", "approach", 1e-6, "m"),
    Quantity("c", "area", 2e-6, "m2", inf),
    Quantity("step_error", "error by steps", 0.1, "1"),
]


def test_a_table_has_name_value_error_and_place_below_each_other() -> None:
    lines = as_text(ROWS).splitlines()
    assert lines[0] == "  peak            500 MPa  error <= 1.2 %       at x = 0 nm, y = 2 mm"
    assert [line.split("  ")[-1] for line in lines[1:]] == [
        "error not estimated",
        "error not bounded",
        "0.1",
    ]


def test_json_has_the_same_numbers_in_si_units() -> None:
    table = json.loads(json.dumps(as_json(ROWS)))
    assert table["a"] == {
        "value": 5e8,
        "units": "Pa",
        "error": 0.0123,
        "long_name": "peak",
        "at": {"x": 0.0, "y": 2e-3},
    }
    assert table["b"]["error"] is table["c"]["error"] is None


def test_a_march_gives_its_worn_volume_and_largest_pressure() -> None:
    scene = cs.Scene(
        cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),), wear=cs.Wear(1e-15, 1.0)
    )
    evolution = cs.evolve(
        scene, cs.Grid((32, 1), (4e-4, 1e-3)), cs.ExactPeriodicity(), times=[0, 1, 2]
    )
    numbers = {number.name: number for number in march_quantities(evolution)}
    assert numbers["largest_pressure"].value == max(
        frame.pressure.max() for frame in evolution.frames
    )
    assert numbers["largest_pressure"].error == evolution.step_error + evolution.grid_error
    # k W s L: all of the load wears, whatever the pressure is
    assert numbers["worn_volume"].value == pytest.approx(1e-15 * 1e5 * 2.0 * 1e-3, rel=1e-6)
    dataset = evolution.to_dataset()
    assert float(dataset["worn_volume"]) == numbers["worn_volume"].value
    assert dataset["worn_volume"].attrs["units"] == "m3"


def test_a_yield_strength_gives_a_safety_factor() -> None:
    steel, strong = cs.HalfSpace(210e9, 0.3), cs.HalfSpace(210e9, 0.3, yield_strength=2e9)
    for body in (steel, strong):
        scene = cs.Scene(
            cs.LineLoad(1e5),
            (body, steel),
            (cs.Cylinder(0.01),),
            outputs=(cs.SubsurfaceStress((6e-5,)),),
        )
        grid = cs.Grid((64, 1), (3e-4, 1e-3))
        solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
        dataset = cs.to_dataset(solution)
        numbers = {one.name: one.value for one in quantities(solution, None, dataset["von_mises"])}
        if body is steel:
            assert "safety_factor" not in numbers
        else:
            assert numbers["safety_factor"] == pytest.approx(2e9 / numbers["von_mises_max"])


def test_rolling_gives_its_resistance_and_shift() -> None:
    rubber = cs.ViscoelasticHalfSpace(1e6, 0.5, ((2e6, 0.01),))
    rigid = cs.HalfSpace(inf, 0.3)
    scene = cs.Scene(
        cs.LineLoad(1e2), (rubber, rigid), (cs.Cylinder(0.01),), rolling=cs.Rolling(0.1)
    )
    rolling = cs.solve_rolling(scene, cs.Grid((64, 1), (8e-3, 1e-3)), cs.ExactPeriodicity())
    assert [(n.name, n.value) for n in rolling_quantities(rolling)] == [
        ("resistance", rolling.resistance),
        ("shift", rolling.shift),
    ]


@pytest.mark.parametrize(
    ("units", "shown"),
    [
        ("Pa", {1e9: "1 GPa", 0.999e9: "999 MPa", 1e6: "1 MPa", 2e3: "2 kPa", 2.0: "2 Pa"}),
        ("m", {1.0: "1 m", 0.999: "999 mm", 2e-3: "2 mm", 2e-6: "2 µm", 2e-9: "2 nm"}),
        ("m2", {2.0: "2 m²", 1e-3: "0.001 m²", 2e-6: "2 mm²", 2e-12: "2 µm²"}),
        ("m3", {2.0: "2 m³", 2e-9: "2 mm³", 2e-18: "2 µm³"}),
        ("N", {1e3: "1 kN", 2.0: "2 N"}),
        ("N m-1", {1e3: "1 N/mm", 2.0: "2 N/m"}),
        ("1", {2.0: "2", 0.25: "0.25", 0.0: "0"}),
    ],
)
def test_a_number_is_read_in_the_largest_unit_that_is_not_larger(
    units: str, shown: dict[float, str]
) -> None:
    assert {value: readable(value, units) for value in shown} == shown
