"""What is drawn in three dimensions: cells between edges, and stress at points in depth."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cli import show
from studies.cli.show import _edges


def test_edges_lie_half_a_cell_beside_the_centres() -> None:
    assert _edges(np.array([1.0, 3.0, 5.0])) == pytest.approx([0, 2, 4, 6])
    assert _edges(np.array([-1.0, 0.0])) == pytest.approx([-1.5, -0.5, 0.5])


def test_one_cell_is_as_wide_as_its_place_or_a_micrometre() -> None:
    assert _edges(np.array([4.0])) == pytest.approx([-2, 2])
    assert _edges(np.array([0.0])) == pytest.approx([-5e-7, 5e-7])


def test_fields_lie_in_one_thin_layer_of_cells_and_stress_below_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    written: dict[str, Any] = {}

    def write(name: str, *axes: np.ndarray, **data: Any) -> str:
        written[name] = axes, data
        return f"{name}.vtr"

    monkeypatch.setattr(show, "import_for", lambda *_: SimpleNamespace(gridToVTK=write))
    pressure = np.arange(6.0).reshape(2, 3)
    stress = np.arange(12.0).reshape(2, 2, 3)
    dataset = xr.Dataset(
        {
            "pressure": (("x", "y"), pressure),
            "gap": (("x", "y"), 10 + pressure),
            "von_mises": (("z", "x", "y"), stress),
        },
        coords={"x": [1.0, 3.0], "y": [0.0, 0.5, 1.0], "z": [0.1, 0.4]},
    )
    assert show._vtk(dataset, Path("here")) == "here.vtr"
    (x, y, z), data = written["here"]
    assert (x.tolist(), y.tolist()) == ([0, 2, 4], [-0.25, 0.25, 0.75, 1.25])
    # as thick as the narrowest cell
    assert z.tolist() == [0, 0.5]
    assert set(data["cellData"]) == {"pressure", "gap"}
    np.testing.assert_array_equal(data["cellData"]["gap"], (10 + pressure)[:, :, None])
    (x, y, z), data = written["here-stress"]
    assert (x.tolist(), y.tolist()) == ([1, 3], [0, 0.5, 1])
    # from the depth up
    assert z.tolist() == [-0.4, -0.1]
    found = data["pointData"]["von_mises"]
    np.testing.assert_array_equal(found[:, :, 0], stress[1])
    np.testing.assert_array_equal(found[:, :, 1], stress[0])
    flat = dataset.drop_vars("von_mises")
    written.clear()
    show._vtk(flat, Path("flat"))
    assert set(written) == {"flat"}
