import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.io.pictures.contact import contact_picture, film_picture
from contactstudy.io.pictures.picture import picture_of

X = np.array([-1e-4, 0.0, 1e-4])
Y = np.array([0.0, 1e-3, 2e-3, 3e-3])
Z = np.array([1e-5, 3e-5])
PRESSURE = 1e6 * np.array([[1.0, 2, 3, 4], [10, 20, 30, 40], [5, 6, 7, 8]])
GAP = 1e-8 * np.arange(12.0).reshape(3, 4)
STRESS = 1e9 * np.arange(1.0, 25.0).reshape(2, 3, 4)


def labelled(**more: object) -> xr.Dataset:
    fields = {"pressure": (("x", "y"), PRESSURE), "gap": (("x", "y"), GAP)}
    return xr.Dataset(
        {**fields, "hertz_peak_pressure": 45e6, "hertz_half_width": 2e-4, **more},
        coords={"x": X, "y": Y, "z": Z},
    )


def test_the_map_and_both_sections_show_each_number_in_its_unit() -> None:
    pressed, along, across, gaped, *bars = contact_picture(labelled()).axes
    assert len(bars) == 1
    [mesh] = pressed.collections
    assert np.asarray(mesh.get_array()) == pytest.approx(PRESSURE / 1e6)

    middle, law = along.lines
    assert middle.get_xydata() == pytest.approx(np.transpose([Y * 1e3, [10, 20, 30, 40]]))
    assert law.get_ydata() == pytest.approx([45, 45])

    middle, law = across.lines
    assert middle.get_xydata() == pytest.approx(np.transpose([X * 1e6, [3, 30, 7]]))
    side = 45 * 0.75**0.5
    assert law.get_xydata() == pytest.approx(np.transpose([X * 1e6, [side, 45, side]]))
    [band] = across.collections
    low, high = band.get_datalim(across.transData).intervaly
    assert (low, high) == pytest.approx((1, 40))

    [line] = gaped.lines
    assert line.get_xydata() == pytest.approx(np.transpose([X * 1e6, [20, 60, 100]]))


def test_shear_is_drawn_in_the_directions_that_it_has() -> None:
    sheared = labelled(shear_x=(("x", "y"), -PRESSURE / 2), shear_y=(("x", "y"), 0 * PRESSURE))
    shear = contact_picture(sheared).axes[4]
    [line] = shear.lines
    assert line.get_xydata() == pytest.approx(np.transpose([X * 1e6, [-1.5, -15, -3.5]]))


def test_the_attraction_is_drawn_downwards_in_the_middle() -> None:
    across = contact_picture(labelled(attraction=(("x", "y"), PRESSURE / 10))).axes[2]
    assert across.lines[1].get_xydata() == pytest.approx(np.transpose([X * 1e6, [-0.3, -3, -0.7]]))


def test_stress_is_drawn_over_depth_or_across_at_a_single_depth() -> None:
    stressed = labelled(von_mises=(("z", "x", "y"), STRESS))
    figure = contact_picture(stressed)
    deep = figure.axes[4]
    [filled] = deep.collections
    # the third row of four along the length
    assert (filled.zmin, filled.zmax) == pytest.approx((3, 23))
    assert not deep.lines
    bonded = contact_picture(stressed.isel(z=[0, 0, 1])).axes[4]  # both sides of a bond at the same depth
    [bond] = bonded.lines
    assert list(bond.get_ydata()) == pytest.approx([10, 10])
    single = contact_picture(stressed.isel(z=[1])).axes[4]
    assert single.lines[0].get_xydata() == pytest.approx(np.transpose([X * 1e6, [15, 19, 23]]))


def test_the_drop_is_drawn_beside_the_pressure_at_the_ends_and_what_was_met_below() -> None:
    solids = (cs.HalfSpace(210e9, 0.3),) * 2
    crown = cs.Crown.of_drop(2e-6, 8e-3)
    shapes = (cs.Cylinder(5e-3), crown, cs.FiniteLength(8e-3))
    scene = cs.Scene(cs.LineLoad(1e5), solids, shapes)
    found = cs.solve(scene, cs.Grid((24, 40), (4e-4, 1e-2)), cs.ZeroPadding())
    dataset = found.to_dataset()
    on_roller = abs(found.grid.y) < 4e-3
    drop = crown.gap(found.grid)[0] - crown.gap(found.grid).min()
    np.testing.assert_allclose(dataset["drop"][on_roller], drop[on_roller])
    assert np.isnan(dataset["drop"][~on_roller]).all()
    figure = found.plot(dataset)
    ax = next(ax for ax in figure.axes if ax.get_title() == "at the ends")
    beside = next(ax for ax in figure.axes if ax.get_ylabel() == "drop [µm]")
    (pressure,), (dropped,) = ax.get_lines(), beside.get_lines()
    assert min(pressure.get_xdata()) == pytest.approx(0.125)  # mm from the end, half a cell
    assert max(pressure.get_ydata()) == pytest.approx(found.pressure[:, 30].max() / 1e6, rel=0.3)
    assert max(dropped.get_ydata()) == pytest.approx(1e6 * drop[on_roller].max())
    (legend,) = figure.legends
    assert "".join(legend.get_title().get_text().split()) == "".join(found.accuracy.split())


def test_pressure_film_and_temperature_are_drawn_in_one() -> None:
    x = np.linspace(-3e-4, 3e-4, 61)
    fields = {
        "film": ("m", 1e-7 + 100 * x**2),
        "film_temperature_rise": ("K", 20 * np.exp(-((x / 1e-4) ** 2))),
        "pressure": ("Pa", 1e9 * np.clip(1 - (x / 1e-4) ** 2, 0, None)),
    }
    film = xr.Dataset(
        {name: (("x", "y"), values[:, None], {"units": unit}) for name, (unit, values) in fields.items()}
        | {"hertz_half_width": 1e-4, "hertz_peak_pressure": 1e9},
        {"x": x, "y": [0.0]},
    )
    axes = film_picture(film).axes
    drawn = {ax.get_ylabel(): ax.get_lines()[0].get_ydata() for ax in axes if ax.get_xlim() == axes[0].get_xlim()}
    assert np.nanmax(drawn["pressure [GPa]"]) == pytest.approx(1)
    assert np.nanmin(drawn["film [nm]"]) == pytest.approx(100)
    assert np.nanmax(drawn["temperature rise [K]"]) == pytest.approx(20)


def test_a_dataset_of_no_answer_has_no_picture() -> None:
    assert picture_of(labelled()) is not None
    assert picture_of(xr.Dataset({"load": 1.0})) is None
