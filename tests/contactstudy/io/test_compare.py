from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.estimate import error_estimate
from tests.conftest import LineContact


def contact(pressure: Any, width: float = 1.0, period: float = 1.0, approach: float = 0.0) -> xr.Dataset:
    values = np.asarray(pressure, dtype=float)
    grid = cs.Grid(values.shape, (width, period))  # type: ignore[arg-type]
    return xr.Dataset(
        {"pressure": (("x", "y"), values), "approach": ((), approach)},
        {"x": ("x", grid.x), "y": ("y", grid.y)},
    )


def test_differences_are_those_computed_by_hand() -> None:
    # thirds and halves of the width: sixths. a: 3 3 0 0 0 0 | b: 4 4 4 0 0 0, over cells of 1/6
    a, b = contact([[3], [0], [0]], approach=1.0), contact([[4], [0]], approach=1.5)
    found = cs.compare(a, b)
    assert found.l1 == pytest.approx((1 + 1 + 4) / (3 + 3))
    assert found.peak_pressure == pytest.approx(4 / 3 - 1)
    assert found.contact_area == pytest.approx(3 / 2 - 1)
    assert found.load == pytest.approx(12 / 6 - 1)
    assert found.approach == pytest.approx(0.5)
    assert found.largest == pytest.approx(4)
    # the load is less by the adhesive traction: 1 Pa of 3 on a third, 2 Pa of 4 on a half
    attracted = [one.assign(attraction=one["pressure"] / k) for one, k in ((a, 3), (b, 2))]
    assert cs.compare(*attracted).load == pytest.approx((2 / 2) / (2 / 3) - 1)
    # between a third and a half of the width, from its left end; one cell along is around the axis
    assert found.position == pytest.approx((-1 / 12, 0))
    edges = np.array([-3, -1, 0, 1, 3]) / 6
    assert found.difference["x"].values == pytest.approx((edges[1:] + edges[:-1]) / 2)


def test_a_cell_that_differs_is_found_along_the_length_too() -> None:
    a = contact([[1, 2], [3, 4]], width=2.0, period=4.0)
    b = contact([[1, 1, 2, 6], [3, 3, 4, 4]], width=2.0, period=4.0)
    found = cs.compare(a, b)
    # of 4 Pa on a square metre; a bears 10 Pa on two
    assert (found.l1, found.largest, *found.position) == pytest.approx((4 / 20, 4, -0.5, 1.5))
    assert found.difference["x"].values.tolist() == [-0.5, 0.5]
    assert found.difference["y"].values.tolist() == [-1.5, -0.5, 0.5, 1.5]
    assert found.difference["difference"].values.tolist() == [[0, 0, 0, 4], [0, 0, 0, 0]]
    assert found.difference["a"].values.tolist() == [[1, 1, 2, 2], [3, 3, 4, 4]]
    assert found.load == pytest.approx(4 / 20)
    less = cs.compare(b, a)
    assert (less.largest, less.peak_pressure) == pytest.approx((4, 4 / 6 - 1))
    # both grids with one cell along
    line = cs.compare(contact([[1], [2]]), contact([[1], [3]]))
    assert line.position == (0.25, 0)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("a", "b", "l1"),
    [
        # halves and thirds of a period of 6 m: cells of 2, 1, 1 and 2 m, of which two differ, by 4 and 3 Pa
        (contact([[1, 2]] * 2, period=6.0), contact([[1, 5, 2]] * 2, period=6.0), 7 / 9),
        # beyond a narrower grid there is no pressure
        (contact([[1], [1], [1], [1]], width=2.0), contact([[1], [1]]), 0.5),
        (contact([[1], [1]]), contact([[1], [1], [1], [1]], width=2.0), 1.0),
        # one cell along stands for any period
        (contact([[1], [2]], period=0.3), contact([[1, 1, 1], [2, 2, 2]], period=2.0), 0.0),
        (contact([[1, 1, 1], [2, 2, 2]], period=2.0), contact([[1], [2]], period=0.3), 0.0),
        # periods apart by rounding are one
        (contact([[1, 2], [3, 4]]), contact([[1, 2], [3, 4]], period=1 + 0.5e-6), 0.0),
    ],
)
def test_cells_count_by_their_area(a: xr.Dataset, b: xr.Dataset, l1: float) -> None:
    assert cs.compare(a, b).l1 == pytest.approx(l1, abs=1e-5)


def over_time(*pressures: Any, times: tuple[float, ...]) -> xr.Dataset:
    frames = xr.concat([contact(pressure) for pressure in pressures], "time")
    return frames.assign_coords(time=list(times))


SQUARE, LINE = contact([[1, 2], [3, 4]]), contact([[1], [1]])
IN_TIME = over_time([[1], [1]], [[4], [2]], times=(0, 1))


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("a", "b", "words"),
    [
        (SQUARE, contact([[1, 2], [3, 4]], period=1 + 1.5e-6), "the same period"),
        (SQUARE, contact([[1, 2], [3, 4]], period=1 - 1.5e-6), "the same period"),
        (LINE, xr.Dataset(), "without a pressure"),
        (contact([[0], [0]]), LINE, "carries a load"),
        (LINE, contact([[1], [np.nan]]), "b has a pressure that is no number"),
        (IN_TIME, over_time([[4], [4]], [[4], [4]], times=(0, 0.9)), "record both at the same"),
        (IN_TIME, LINE, "one changes in time"),
    ],
)
def test_what_cannot_be_compared_is_refused(a: xr.Dataset, b: xr.Dataset, words: str) -> None:
    with pytest.raises(cs.InvalidInput, match=words):
        cs.compare(a, b)


def test_grids_of_one_scene_differ_by_no_more_than_the_estimate_says(line_contact: Any) -> None:
    scene = line_contact.scene
    coarse, fine = (cs.solve(scene.problem(line_contact.grid((n, 1), 1.2), cs.ExactPeriodicity())) for n in (64, 512))
    found = cs.compare(fine, coarse)
    # the coarse one's estimate, against cell means, and what the means of its cells leave out: below half a
    # cell of 2.4/64 half-widths of the steepest pressure, 2 / (pi a) of the load per length
    assert found.l1 < error_estimate(coarse).l1.total + 2 * (2.4 / 64)
    assert abs(found.load) < 1e-7  # both carry the load, to their residual
    assert "pressure in L1" in str(found)
    assert len(found.plot().axes) == 1


def test_contacts_of_two_kinds_are_refused(line_contact: LineContact) -> None:
    grid = line_contact.grid((16, 4), 1.4)
    endless, ended = (
        cs.solve(line_contact.scene, grid, padding) for padding in (cs.ExactPeriodicity(), cs.ZeroPadding())
    )
    with pytest.raises(cs.InvalidInput, match=r"of different kinds: b ends at both ends of its grid"):
        cs.compare(endless, ended)
    assert cs.compare(ended, ended).l1 == 0


def test_keys_in_which_the_scenes_differ_are_said_and_numbers_are_in_per_cent(
    line_contact: LineContact,
) -> None:
    grid = line_contact.grid((16, 1), 1.6)
    heavier = replace(line_contact.scene, load=cs.LineLoad(1.21 * line_contact.scene.largest_load))
    a, b = (cs.solve(scene, grid, cs.ExactPeriodicity()) for scene in (line_contact.scene, heavier))
    found = cs.compare(a, b)
    loads = line_contact.scene.largest_load, heavier.load.largest
    assert found.differing == (f"load.per_length: {loads[0]:.6g} and {loads[1]:.6g}",)
    text = str(found)
    assert "load: +21 %\n" in text
    assert f"peak pressure: {100 * found.peak_pressure:+.3g} %" in text
    assert "scenes differ in load.per_length" in text
    assert cs.compare(a, a).differing == ()


def test_evolutions_are_compared_at_the_instant_of_the_highest_pressure() -> None:
    a = over_time([[1], [1]], [[4], [2]], [[2], [1]], times=(0, 1, 2))
    b = over_time([[9], [9]], [[4], [4]], times=(0, 1))
    found = cs.compare(a, b)
    assert found.time == 1
    assert (found.l1, found.largest) == pytest.approx((2 / 6, 2))
    assert "at 1 s" in str(found)
    before, after, high = [[9], [9]], [[4], [4]], [[4], [2]]
    jump = over_time(before, after, times=(1, 1))  # a load that jumps is recorded twice
    assert cs.compare(over_time([[1], [1]], high, times=(0, 1)), jump).largest == 2
    assert cs.compare(over_time(high, [[1], [1]], times=(1, 1)), jump).largest == 7


def test_quantities_of_films_are_compared_too() -> None:
    a, b = (contact([[1], [1]]).drop_vars("approach") for _ in range(2))
    for dataset, film in ((a, 2e-7), (b, 3e-7)):
        dataset["central_film"] = ((), film, {"long_name": "central film thickness"})
        dataset["central_film_bound"] = ((), 0.0)
    found = cs.compare(a, b)
    assert found.quantities == {"central film thickness": pytest.approx(0.5)}
    assert "central film thickness: +50 %" in str(found)
    assert "approach" not in str(found)
    inlet = [contact(p).assign(film=((), 1e-7)) for p in ([[1], [1]], [[0], [1]])]
    assert "contact area" not in str(cs.compare(*inlet))
