import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.io.pictures.contact import contact_picture

X = np.array([-1e-4, 0.0, 1e-4])
Y = np.array([0.0, 1e-3, 2e-3, 3e-3])
PRESSURE = 1e6 * np.array([[1.0, 2, 3, 4], [10, 20, 30, 40], [5, 6, 7, 8]])
GAP = 1e-8 * np.arange(12.0).reshape(3, 4)


def labelled(**more: object) -> xr.Dataset:
    fields = {"pressure": (("x", "y"), PRESSURE), "gap": (("x", "y"), GAP)}
    return xr.Dataset(
        {**fields, "hertz_peak_pressure": 45e6, "hertz_half_width": 2e-4, **more},
        coords={"x": X, "y": Y, "z": [1e-5, 3e-5]},
    )


def test_the_map_and_both_sections_show_each_number_in_its_unit() -> None:
    pressed, along, across, gaped, *_ = contact_picture(labelled()).axes
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


def test_the_drop_is_drawn_beside_the_pressure_at_the_ends_and_what_was_met_below() -> None:
    crown = cs.Crown.of_drop(2e-6, 8e-3)
    scene = cs.Scene(
        cs.LineLoad(1e5), (cs.HalfSpace(210e9, 0.3),) * 2, (cs.Cylinder(5e-3), crown, cs.FiniteLength(8e-3))
    )
    found = cs.solve(scene, cs.Grid((24, 40), (4e-4, 1e-2)), cs.ZeroPadding())
    dataset = found.to_dataset()
    on_roller = abs(found.grid.y) < 4e-3
    drop = crown.gap(found.grid)[0] - crown.gap(found.grid).min()
    np.testing.assert_allclose(dataset["drop"], np.where(on_roller, drop, np.nan))
    figure = found.plot(dataset)
    ax = next(ax for ax in figure.axes if ax.get_title() == "at the ends")
    beside = next(ax for ax in figure.axes if ax.get_ylabel() == "drop [µm]")
    (pressure,), (dropped,) = ax.get_lines(), beside.get_lines()
    assert min(pressure.get_xdata()) == pytest.approx(0.125)  # mm from the end, half a cell
    assert max(dropped.get_ydata()) == pytest.approx(1e6 * drop[on_roller].max())
    (legend,) = figure.legends
    assert "".join(legend.get_title().get_text().split()) == "".join(found.accuracy.split())
