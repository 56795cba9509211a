import json
from dataclasses import replace
from math import inf, log, pi

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.validation import readable
from contactstudy.io.dataset import with_quantities
from contactstudy.io.quantities.evolution_quantities import evolution_quantities
from contactstudy.io.quantities.quantity import Quantity, as_json, as_text, with_bound
from contactstudy.scene.scene import PosedScene
from tests.conftest import STEEL, LineContact

GRID = cs.Grid((4, 2), (4e-3, 6e-3))
UNLOADED = PosedScene(cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL)), GRID, cs.ZeroPadding())
PRESSURE = np.array([[0.0, 0.0], [1e6, 0.0], [2e6, 5e6], [0.0, 0.0]])


def test_a_value_is_shown_in_the_unit_that_is_read_most_easily() -> None:
    for value, units, text in (
        (5.0e8, "Pa", "500 MPa"), (1.234567e9, "Pa", "1.235 GPa"), (-2.5e-3, "m", "-2.5 mm"), (-0.0, "m", "0 nm"),
        (5.31e-8, "m2", "0.0531 mm²"), (1e5, "N m-1", "100 N/mm"), (0.125, "1", "0.125"), (3.0, "kg", "3 kg"),
    ):  # fmt: skip
        assert readable(value, units) == text


def test_numbers_are_those_of_the_fields(line_contact: LineContact) -> None:
    solved = cs.solve(line_contact.scene.problem(GRID, cs.ExactPeriodicity()), max_iterations=1)
    numbers = replace(solved, pressure=PRESSURE, gap=np.full((4, 2), 2e-6), approach=3e-6).quantities
    values = {name: number.value for name, number in numbers.items()}
    cell = 1e-3 * 3e-3
    # three cells within an outline of six sides (Yastrebov et al. 2017)
    area = 3 - 6 * (pi - 1 + log(2)) / 24
    assert values == pytest.approx({
        "peak_pressure": 5e6, "mean_pressure": 8e6 / area, "half_width": 1e-3, "contact_area": area * cell / 6e-3,
        "mean_gap": 2e-6, "approach": 3e-6, "load_per_length": 8e6 * cell / 6e-3,
    })  # fmt: skip
    assert numbers["contact_area"].unit == "m2 m-1"
    assert "over the grid's width of 4 mm" in numbers["mean_gap"].detail
    assert numbers["peak_pressure"].position == pytest.approx({"x": 0.5e-3, "y": 1.5e-3})


@pytest.mark.parametrize(("cells", "within"), [(24, 5e-3), (96, 5e-4)])
def test_the_edges_of_a_smooth_contact_lie_inside_their_cells(
    line_contact: LineContact, cells: int, within: float
) -> None:
    width = line_contact.scene.hertz.half_width
    grid = cs.Grid((cells, 1), (2.4 * width, width))
    numbers = cs.solve(line_contact.scene, grid, cs.ExactPeriodicity()).quantities
    for name, value in (("half_width", width), ("contact_area", 2 * width)):
        assert numbers[name].value == pytest.approx(value, rel=within / 10)
        assert abs(numbers[name].value - value) <= numbers[name].bound < within * value


def test_an_error_relative_to_zero_bounds_nothing() -> None:
    unknown = with_bound(Quantity(0.0, "1", "fraction"), ErrorParts(discretisation=0.1))
    assert unknown.bound == inf
    assert "relative to it" in unknown.reason


def test_the_largest_friction_in_time_is_that_of_the_largest_size() -> None:
    frames = [{"friction_coefficient": Quantity(value, "1", "")} for value in (-1e-4, -2e-4)]
    numbers = evolution_quantities(frames, [0.0, 1.0], {}, {}, UNLOADED, ErrorParts(), {})
    assert numbers["friction_coefficient"].value == 2e-4


def test_the_largest_in_time_has_no_bound_where_the_load_is_higher_between_instants() -> None:
    history = cs.LoadHistory((0.0, 1.0, 2.0, 2.0), (0.0, 1e5, 9e4, 5e4))
    scene = cs.Scene(history, (STEEL, STEEL), (cs.Cylinder(0.01),))
    for times, said in (((0.0, 0.6, 1.5, 2.0), "extreme at 1 s"), ((0.0, 1.0, 2.0), ""), ((0.0, 0.3), "")):
        answer = cs.solve(scene, cs.Grid((32, 1), (4e-4, 1e-3)), cs.ExactPeriodicity(), times=times)
        peak = answer.quantities["peak_pressure"]
        assert (peak.bound == inf) == bool(said)
        assert said in peak.reason


def test_the_largest_in_time_has_no_bound_where_a_creeping_body_may_be_pressed_harder_between_instants() -> None:
    """At the end of a ramp, after which the pressure relaxes under the load that stays."""
    creeping = cs.ViscoelasticHalfSpace(1.8e6, 0.48, ((2.4e6, 0.8),))
    scene = cs.Scene(cs.LoadHistory((0.0, 0.3, 2.0), (6.0, 23.0, 23.0)), (creeping, STEEL), (cs.Cylinder(1.3e-3),))
    for times, is_bounded in (((0.0, 0.5, 2.0), False), ((0.0, 0.3, 2.0), True)):
        answer = cs.solve(scene, cs.Grid((32, 1), (4e-4, 1e-3)), cs.ExactPeriodicity(), times=times)
        assert (answer.quantities["peak_pressure"].bound < inf) == is_bounded


ROWS = {
    "a": Quantity(5e8, "Pa", "peak", 6.15e6, "", {"x": 0.0, "y": 2e-3}),
    "b": Quantity(1e-6, "m", "approach"),
    "c": Quantity(2e-6, "m2", "area", inf, "A sharp edge."),
}


def test_a_table_has_an_empty_place_for_a_bound_that_is_not_known_and_the_reason_below() -> None:
    assert as_text(ROWS | {"zero": Quantity(0.0, "Pa", "shear", 2e3, "")}).splitlines() == [
        "  peak      500 MPa  error <= 1.2 %  at x = 0 nm, y = 2 mm",
        "  approach     1 µm",
        "  area        2 mm²",
        "  shear        0 Pa  error <= 2 kPa",
        "  approach: No bound: no estimate of its error is known.",
        "  area: A sharp edge.",
    ]


def test_a_bound_that_is_not_known_is_nan_in_a_file_and_none_in_json_with_the_reason() -> None:
    dataset = with_quantities(xr.Dataset(), ROWS)
    assert float(dataset["a_bound"]) == 6.15e6
    assert np.isnan(dataset["c_bound"])
    assert dataset["c_bound"].attrs["comment"] == "A sharp edge."
    table = json.loads(json.dumps(as_json(ROWS)))
    place = {"x": 0.0, "y": 2e-3}
    assert table["a"] == {"value": 5e8, "unit": "Pa", "bound": 6.15e6, "label": "peak", "at": place}
    assert (table["c"]["bound"], table["c"]["reason"]) == (None, "A sharp edge.")


def test_a_film_stands_beside_its_formulas_and_the_roughness() -> None:
    oil = cs.Lubricant(0.04, 2e-8, shear=cs.Eyring(5e6))
    wavy = (cs.Cylinder(0.01), cs.Waviness(5e-8, across=5e-5))
    scene = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), wavy, lubrication=cs.Lubrication(oil, 1.0))
    numbers = cs.solve(scene, cs.Grid((200, 1), (1e-3, 1e-3)), cs.ExactPeriodicity()).quantities
    film = numbers["central_film"]
    assert numbers["lambda_ratio"].value == pytest.approx(film.value / (5e-8 / 2**0.5), rel=0.01)
    assert numbers["lambda_ratio"].relative_bound == pytest.approx(film.relative_bound)
    elastic = 2 * STEEL.youngs_modulus / (2 * (1 - STEEL.poisson_ratio**2))
    speed = 0.04 * 1.0 / (elastic * 0.01)
    dowson = 2.65 * speed**0.7 * (2e-8 * elastic) ** 0.54 * (1e5 / (elastic * 0.01)) ** -0.13 * 0.01
    assert numbers["dowson_higginson_film"].value == pytest.approx(dowson, rel=1e-9)
    assert numbers["elastic_piezoviscous_film"].value == pytest.approx(numbers["moes_film"].value, rel=0.1)
    assert numbers["sliding_loss"].value == 0  # pure rolling
