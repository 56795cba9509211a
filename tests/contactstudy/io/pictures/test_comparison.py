import numpy as np
import pytest
import xarray as xr

from contactstudy.io.compare import Comparison
from contactstudy.io.pictures.contact import comparison_picture

X, Y = np.array([-1e-5, 0.0, 1e-5]), np.array([0.0, 2e-3])
A = 1e6 * np.array([[1.0, 2], [3, 4], [5, 6]])
B = A + 1e6 * np.array([[0.0, 0], [1, -3], [0, 0]])


def test_the_map_shows_the_difference_and_the_section_both_pressures_where_it_is_largest() -> None:
    fields = {"a": (("x", "y"), A), "b": (("x", "y"), B), "difference": (("x", "y"), B - A)}
    dataset = xr.Dataset(fields, coords={"x": X, "y": Y})
    found = Comparison(0, 0, 0, 0, 0, 3e6, (0.0, 2e-3), dataset)
    shown, section, _ = comparison_picture(found.difference, found.position).axes
    [mesh] = shown.collections
    assert np.asarray(mesh.get_array()) == pytest.approx((B - A) / 1e6)
    first, second = section.lines
    assert first.get_xydata() == pytest.approx(np.transpose([X * 1e6, [2, 4, 6]]))
    assert second.get_ydata() == pytest.approx([2, 1, 6])
    [line] = comparison_picture(dataset.isel(y=[0]), (0.0, 0.0)).axes
    assert line.lines[1].get_ydata() == pytest.approx([1, 4, 5])
