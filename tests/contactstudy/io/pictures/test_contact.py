import numpy as np
import pytest
import xarray as xr

from contactstudy.io.pictures.contact import contact_picture

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
    bonded = contact_picture(stressed.isel(z=[0, 0, 1])).axes[
        4
    ]  # both sides of a bond at the same depth
    [bond] = bonded.lines
    assert list(bond.get_ydata()) == pytest.approx([10, 10])
    single = contact_picture(stressed.isel(z=[1])).axes[4]
    assert single.lines[0].get_xydata() == pytest.approx(np.transpose([X * 1e6, [15, 19, 23]]))
