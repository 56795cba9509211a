import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.io.pictures import picture_of

X = np.array([-1e-4, 0.0, 1e-4])
Y = np.array([0.0, 1e-3, 2e-3, 3e-3])
PRESSURE = 1e6 * np.array([[1.0, 2, 3, 4], [10, 20, 30, 40], [5, 6, 7, 8]])
GAP = 1e-8 * np.arange(12.0).reshape(3, 4)


def test_the_map_and_both_sections_show_each_number_in_its_unit() -> None:
    fields = {
        "pressure": (("x", "y"), PRESSURE, {"long_name": "contact pressure", "units": "Pa"}),
        "gap": (("x", "y"), GAP, {"long_name": "gap", "units": "m"}),
    }
    of_hertz = {"hertz_peak_pressure": 45e6, "hertz_half_width": 2e-4}
    dataset = xr.Dataset({**fields, **of_hertz}, coords={"x": X, "y": Y})
    figure = picture_of(dataset)
    assert figure is not None
    pressed, along, across, gaped, *_ = figure.axes
    [mesh] = pressed.collections
    assert np.asarray(mesh.get_array()) == pytest.approx(PRESSURE / 1e6)
    middle, law = along.lines
    assert middle.get_xydata() == pytest.approx(np.transpose([Y * 1e3, [10, 20, 30, 40]]))
    assert law.get_ydata() == pytest.approx([45, 45])
    middle, law = across.lines
    assert middle.get_xydata() == pytest.approx(np.transpose([X * 1e6, [3, 30, 7]]))
    side = 45 * 0.75**0.5
    assert law.get_xydata() == pytest.approx(np.transpose([X * 1e6, [side, 45, side]]))
    [line] = gaped.lines
    assert line.get_xydata() == pytest.approx(np.transpose([X * 1e6, [20, 60, 100]]))


def test_the_drop_of_a_crown_is_labelled_up_to_the_ends_of_its_roller() -> None:
    crown = cs.Crown.of_drop(2e-6, 8e-3)
    scene = cs.Scene(
        cs.LineLoad(1e5), (cs.HalfSpace(210e9, 0.3),) * 2, (cs.Cylinder(5e-3), crown, cs.FiniteLength(8e-3))
    )
    found = cs.solve(scene, cs.Grid((24, 40), (4e-4, 1e-2)), cs.ZeroPadding())
    dataset = found.to_dataset()
    on_roller = abs(found.grid.y) < 4e-3
    drop = crown.gap(found.grid)[0] - crown.gap(found.grid).min()
    np.testing.assert_allclose(dataset["drop"], np.where(on_roller, drop, np.nan))
