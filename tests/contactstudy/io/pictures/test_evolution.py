import numpy as np
import pytest
import xarray as xr

from contactstudy.io.pictures import picture_of

TIME = np.array([0.0, 1.0, 1.0, 4.0])
X = np.array([-2e-3, 0.0, 2e-3])
# (time, x, y); two rows along the length
PRESSURE = 1e6 * np.arange(1.0, 25.0).reshape(4, 3, 2)


def labelled(**more: object) -> xr.Dataset:
    def named(values: object, name: str, units: str) -> tuple[str, object, dict[str, str]]:
        return "time", values, {"long_name": name, "units": units}

    return xr.Dataset(
        {
            "pressure": (("time", "x", "y"), PRESSURE, {"long_name": "pressure", "units": "Pa"}),
            "gap": (("time", "x", "y"), np.zeros_like(PRESSURE), {"long_name": "gap", "units": "m"}),
            "load": named([1.0, 2.0, 4.0, 4.0], "load", "N/m"),
            "peak_pressure": named([6e6, 12e6, 18e6, 24e6], "peak pressure", "Pa"),
            "contact_area": named([0.0, 0.0, 0.0, 0.0], "contact area", "m2"),
            "time_discretisation_error": named([0.0, 1e-3, np.inf, 1e-2], "time-discretisation error", "1"),
            "grid_error": named([np.inf] * 4, "grid error", "1"),
            **more,
        },
        coords={"time": TIME, "x": X, "y": [0.0, 1.0]},
    )


def test_profiles_map_numbers_and_known_errors_are_drawn_over_time() -> None:
    figure = picture_of(labelled())
    assert figure is not None
    profiles, over_time, numbers, errors, *_ = figure.axes
    for line, rows in zip(profiles.lines, PRESSURE[:, :, 1], strict=True):
        assert line.get_xydata() == pytest.approx(np.transpose([X * 1e3, rows / 1e6]))
    [mesh] = over_time.collections
    # the mean along the length, without the instant before a jump
    assert np.asarray(mesh.get_array()) == pytest.approx((PRESSURE.mean(axis=2) / 1e6)[[0, 2, 3]].T)
    assert numbers.lines[0].get_xydata() == pytest.approx(np.transpose([TIME, [0.25, 0.5, 1, 1]]))
    [steps] = errors.lines
    assert steps.get_xydata() == pytest.approx(np.array([[1, 1e-3], [4, 1e-2]]))


def test_passes_in_which_nothing_yields_are_drawn_too() -> None:
    depths = {"z": ("z", [1e-5, 2e-5], {"units": "m"}), "component": ["xx", "yy"], "pass_number": [1, 2]}
    strain = ("pass_number", "z"), np.zeros((2, 2)), {"long_name": "plastic strain", "units": "1"}
    stress = ("pass_number", "component", "z"), np.zeros((2, 2, 2)), {"long_name": "stress", "units": "Pa"}
    figure = picture_of(xr.Dataset({"residual_stress": stress, "equivalent_plastic_strain": strain}, coords=depths))
    assert figure is not None
    assert all(len(ax.lines) == 2 for ax in figure.axes)
