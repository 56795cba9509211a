from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.model.outcome import CaseStatus
from studies.report.drawings.default import figures
from tests.studies.cli.conftest import said
from tests.studies.scene_study.conftest import ROUGH


def axes_text() -> xr.Dataset:
    axes = ("padding", "load")
    data = {
        "peak_pressure": (axes, [[2.0, 4.0], [2.1, 4.4], [2.0, 4.0]]),
        "peak_pressure_bound": (axes, np.full((3, 2), 0.02)),
        "setup_time_cpu": (axes, np.zeros((3, 2))),
        "solve_time_cpu": (axes, [[3.0, 5.0], [1.0, 3.0], [7.0, 9.0]]),
        "case_status": (axes, np.full((3, 2), CaseStatus.OK)),
    }
    coords = {"padding": ["exact", "duplicated", "circular"], "load": [1.0, 2.0]}
    return xr.Dataset(data, coords, {"reference": "padding=exact"})


def test_errors_are_the_largest_of_the_other_axes_beside_the_bound_of_the_reference() -> None:
    *_, errors, front = figures(axes_text())
    (ax,) = errors.figure.axes
    # 5 and 10 % of duplicated; an error of nothing has no place on a logarithmic axis
    (line,) = ax.lines
    np.testing.assert_allclose(line.get_ydata(), [10, np.nan], rtol=1e-9)
    # 0.02 of 2 and of 4
    assert "peak pressure 1.0 %" in errors.caption.replace("\xa0", " ")
    by_load = axes_text().assign_attrs(reference=f"load={1 + 1e-15}")
    (line,) = figures(by_load)[-2].figure.axes[0].lines
    np.testing.assert_allclose(line.get_ydata(), [100 * (4.4 / 2.1 - 1)], rtol=1e-9)
    unknown = axes_text().assign_attrs(reference="padding=2")
    assert len(figures(unknown)) == len(figures(axes_text())) - 2
    marks = front.figure.axes[0].lines[0]
    np.testing.assert_allclose(marks.get_xydata(), [[2.0, 10]], rtol=1e-9)


@pytest.mark.whole
def test_a_scene_is_swept_with_errors_and_times(tmp_path: Path) -> None:
    scene = tmp_path / "scene.toml"
    scene.write_text(ROUGH)
    words = ["run", scene, "--vary", "padding=ExactPeriodicity,DuplicatedPadding"]
    words += ["--repeats", 1, "--workers", 0, "--out", tmp_path, "--reference"]
    said(*words, "padding=ExactPeriodicity")
    names = {path.name for path in (tmp_path / "scene-sweep").iterdir()}
    assert {"errors.png", "front.png"} < names
    with pytest.raises(cs.InvalidInput, match="not one of the values that are varied"):
        said(*words, "padding=ZeroPadding")
