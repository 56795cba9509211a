import numpy as np
import pytest
import xarray as xr

import studies.accessor  # noqa: F401 (registers dataset.study)
from contactstudy import InvalidInput
from studies.model.outcome import CaseStatus

GRID = [16, 32, 64, 128]


@pytest.fixture
def dataset() -> xr.Dataset:
    """Errors N^-1.5 and 3 N^-2 at costs N^2 and 2 N^2."""
    n = np.array(GRID, dtype=float)
    dims = ("mode", "grid")
    data = {
        "error_max": (dims, [n**-1.5, -3 * n**-2]),
        "setup_time_cpu": (dims, [n * 0, n**2]),
        "solve_time_cpu": (dims, [n**2, n**2]),
        "case_status": (dims, np.full((2, 4), CaseStatus.OK, dtype=np.int8)),
        "profile": ((*dims, "x"), np.zeros((2, 4, 3))),
    }
    return xr.Dataset(data, {"mode": ["a", "b"], "grid": GRID, "x": [0.0, 0.5, 1.0]})


def test_the_order_of_a_power_is_its_exponent_with_the_uncertainty_of_a_line(dataset: xr.Dataset) -> None:
    found = dataset.study.order("error_max", "grid", mode="b")
    assert (found.order, found.points) == (pytest.approx(2.0, abs=1e-12), 4)
    assert found.uncertainty < 1e-12
    dataset["error_max"][0] *= np.exp([0.1, -0.1, -0.1, 0.1])
    found = dataset.study.order("error_max", "grid", mode="a")
    fit, covariance = np.polyfit(np.log(GRID), np.log(dataset["error_max"][0].values), 1, cov=True)
    assert found.order == pytest.approx(-fit[0], rel=1e-9)
    assert found.uncertainty == pytest.approx(np.sqrt(covariance[0, 0]), rel=1e-9)


def test_the_front_and_the_cheapest_are_those_by_hand(dataset: xr.Dataset) -> None:
    """By cost a 16, b 16, a 32, ... to b 128: errors fall all the way, but for one made larger, and one failed."""
    dataset["error_max"].loc["b", 32] = 0.006
    dataset["case_status"].loc["a", 16] = CaseStatus.FAILED
    front = dataset.study.pareto("error_max")
    points = set(zip(front["mode"], front["grid"], strict=True))
    assert points == {(mode, n) for mode in "ab" for n in GRID} - {("b", 32), ("a", 16)}
    for error, cheapest in ((0.005, ("a", 64)), (3 * 128**-2.0, ("b", 128))):
        best = dataset.study.cheapest("error_max", error)
        assert (best["mode"], best["grid"]) == cheapest


def test_a_table_has_a_row_for_every_point_and_a_notebook_shows_the_first(dataset: xr.Dataset) -> None:
    table = dataset.study.table()
    assert len(table) == 8
    assert "profile" not in table
    assert list(dataset.study.table(["error_max"]).columns) == ["mode", "grid", "error_max"]
    assert "error_max" in dataset.study._repr_html_()


def test_what_is_not_there_is_refused_with_a_remedy(dataset: xr.Dataset) -> None:
    with pytest.raises(InvalidInput, match="did you mean 'error_max'"):
        dataset.study.pareto("eror_max")
    with pytest.raises(InvalidInput, match=r"more than one value along \['mode'\]"):
        dataset.study.order("error_max", "grid")
    with pytest.raises(InvalidInput, match="order is at mode 'c', which is not on that axis"):
        dataset.study.order("error_max", "grid", mode="c")
    with pytest.raises(InvalidInput, match="give three or more"):
        dataset.isel(grid=slice(2)).study.order("error_max", "grid", mode="a")
    with pytest.raises(InvalidInput, match="the least is"):
        dataset.study.cheapest("error_max", 1e-9)
    with pytest.raises(InvalidInput, match="no point has an error and a time"):
        dataset.isel(grid=[]).study.cheapest("error_max", 1e-9)
    with pytest.raises(InvalidInput, match="variable is 'profile'"):
        dataset.study.table(["profile"])
