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
    fields = {"pressure": (("x", "y"), values), "approach": ((), approach)}
    return xr.Dataset(fields, {"x": ("x", grid.x), "y": ("y", grid.y)})


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


def test_cells_count_by_their_area() -> None:
    for a, b, l1 in (
        # halves and thirds of a period of 6 m: cells of 2, 1, 1 and 2 m, of which two differ, by 4 and 3 Pa
        (contact([[1, 2]] * 2, period=6.0), contact([[1, 5, 2]] * 2, period=6.0), 7 / 9),
        # beyond a narrower grid there is no pressure
        (contact([[1], [1], [1], [1]], width=2.0), contact([[1], [1]]), 0.5),
        # one cell along stands for any period
        (contact([[1], [2]], period=0.3), contact([[1, 1, 1], [2, 2, 2]], period=2.0), 0.0),
        # periods apart by rounding are one
        (contact([[1, 2], [3, 4]]), contact([[1, 2], [3, 4]], period=1 + 0.5e-6), 0.0),
    ):
        assert cs.compare(a, b).l1 == pytest.approx(l1, abs=1e-5)


def test_bodies_that_only_attract_each_other_have_no_area_and_no_peak_to_relate_others_to() -> None:
    apart = contact([[0], [0]]).assign(attraction=(("x", "y"), np.array([[2.0], [2.0]])))
    found = cs.compare(apart, contact([[1], [0]]))
    assert np.isnan([found.contact_area, found.peak_pressure]).all()
    assert str(found).splitlines()[:2] == ["pressure in L1: 125 %", "load: -125 %"]


def over_time(*pressures: Any, times: tuple[float, ...]) -> xr.Dataset:
    frames = xr.concat([contact(pressure) for pressure in pressures], "time")
    return frames.assign_coords(time=list(times))


def test_what_cannot_be_compared_is_refused() -> None:
    line, in_time = contact([[1], [1]]), over_time([[1], [1]], [[4], [2]], times=(0, 1))
    for a, b, words in (
        (contact([[1, 2]] * 2), contact([[1, 2]] * 2, period=1 + 1.5e-6), "the same period"),
        (line, xr.Dataset(), "without a pressure"),
        (line, contact([[1], [np.nan]]), "b has a pressure that is no number"),
        (in_time, over_time([[4], [4]], [[4], [4]], times=(0, 0.9)), "record both at the same"),
        (in_time, line, "one changes in time"),
    ):
        with pytest.raises(cs.InvalidInput, match=words):
            cs.compare(a, b)


def test_grids_of_one_scene_differ_by_no_more_than_the_estimate_says(line_contact: LineContact) -> None:
    scene = line_contact.scene
    coarse, fine = (cs.solve(scene.problem(line_contact.grid((n, 1), 1.2), cs.ExactPeriodicity())) for n in (64, 512))
    found = cs.compare(fine, coarse)
    # the coarse one's estimate, against cell means, and what the means of its cells leave out: below half a
    # cell of 2.4/64 half-widths of the steepest pressure, 2 / (pi a) of the load per length
    assert found.l1 < error_estimate(coarse).l1.total + 2 * (2.4 / 64)
    assert abs(found.load) < 1e-7  # both carry the load, to their residual
    assert len(found.plot().axes) == 1


def test_keys_in_which_the_scenes_differ_are_said_and_numbers_are_in_per_cent(line_contact: LineContact) -> None:
    grid = line_contact.grid((64, 1), 1.6)
    heavier = replace(line_contact.scene, load=cs.LineLoad(1.21 * line_contact.scene.largest_load))
    a, b = (cs.solve(scene, grid, cs.ExactPeriodicity()) for scene in (line_contact.scene, heavier))
    found = cs.compare(a, b)
    text = str(found)
    assert "load: +21 %\n" in text
    assert f"peak pressure: {100 * found.peak_pressure:+.3g} %" in text
    assert "scenes differ in load.per_length: 100000 and 121000" in text
    assert found.quantities["half-width (outermost edges)"] == pytest.approx(0.1, abs=2e-3)
    assert cs.compare(a, a).differing == ()
    with pytest.raises(cs.InvalidInput, match=r"of different kinds: b ends at both ends of its grid"):
        cs.compare(a, cs.solve(line_contact.scene, grid, cs.ZeroPadding()))


def test_evolutions_are_compared_at_the_instant_of_the_highest_pressure() -> None:
    a = over_time([[1], [1]], [[4], [2]], [[2], [1]], times=(0, 1, 2))
    found = cs.compare(a, over_time([[9], [9]], [[4], [4]], times=(0, 1)))
    assert (found.time, found.l1, found.largest) == pytest.approx((1, 2 / 6, 2))
    jump = over_time([[9], [9]], [[4], [4]], times=(1, 1))  # a load that jumps is recorded twice
    assert cs.compare(over_time([[1], [1]], [[4], [2]], times=(0, 1)), jump).largest == 2
    assert cs.compare(over_time([[4], [2]], [[1], [1]], times=(1, 1)), jump).largest == 7
