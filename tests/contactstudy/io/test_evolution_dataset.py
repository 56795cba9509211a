"""What a dataset holds of frames that are written here."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import contactstudy as cs
from contactstudy.evolution.evolution import Frame, Trajectory
from contactstudy.io.dataset import evolution_dataset
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import PosedScene
from tests.conftest import LineContact

GRID = cs.Grid((3, 2), (6.0, 4.0))
PRESSURE = np.arange(6.0).reshape(3, 2)
WORN = Field(("x", "y"), PRESSURE / 8, "m", "worn depth")
FRAME = Frame(
    time=0.5, load=3.0, pressure=PRESSURE, gap=10 + PRESSURE, approach=0.25, fields={"worn_depth": WORN},
    status=cs.Status.STALLED, residual=2e-9, step_error=0.03, grid_error=0.004, steps=2, iterations=10,
    convolutions=12.5,
)  # fmt: skip


class Deep:
    """Twice the pressure at three depths, which are a coordinate of their own."""

    def fields(self, pressure: np.ndarray) -> dict[str, Field]:
        return {
            "deep": Field(("z", "x", "y"), np.stack([2 * pressure] * 3), "Pa", "deep", {"a": "b"}),
            "z": Field(("z",), np.array([1.0, 2.0, 4.0]), "m", "depth", {"axis": "Z"}),
        }


def dataset(contact: LineContact, *frames: Frame, outputs: tuple[Any, ...] = (Deep(),)) -> Any:
    posed = PosedScene(contact.scene, GRID, cs.ExactPeriodicity())
    problem: Any = SimpleNamespace(grid=GRID, outputs=outputs, friction=None)
    return evolution_dataset(Trajectory(problem, frames, 0, 0, posed), {})


def test_a_single_instant_has_all_its_fields_over_a_time_of_one(line_contact: LineContact) -> None:
    found = dataset(line_contact, FRAME)
    assert dict(found.sizes) == {"time": 1, "x": 3, "y": 2, "z": 3}
    assert found["worn_depth"].dims == ("time", "x", "y")
    assert found["deep"].dims == ("time", "z", "x", "y")
    np.testing.assert_array_equal(found["deep"][0, 1], 2 * PRESSURE)
    assert found["deep"].attrs == {"units": "Pa", "long_name": "deep", "a": "b"}
    # depths are the same at every instant
    assert found["z"].values.tolist() == [1, 2, 4]
    assert found["z"].attrs["axis"] == "Z"
    assert found["x"].values.tolist() == [-2, 0, 2]


def test_each_instant_has_its_own(line_contact: LineContact) -> None:
    later = replace(
        FRAME, time=2.0, load=5.0, pressure=3 * PRESSURE, status=cs.Status.CONVERGED,
        fields={"worn_depth": replace(WORN, values=PRESSURE)}, steps=4,
    )  # fmt: skip
    found = dataset(line_contact, FRAME, later)
    assert found["time"].values.tolist() == [0.5, 2.0]
    assert found["load"].values.tolist() == [3, 5]
    assert found["steps"].values.tolist() == [2, 4]
    assert found["contact_area"].values.tolist() == [5 * 4, 5 * 4]
    meanings = found["status"].attrs["flag_meanings"].split()
    assert [meanings[one] for one in found["status"].values] == ["STALLED", "CONVERGED"]
    np.testing.assert_array_equal(found["worn_depth"][1], PRESSURE)
    np.testing.assert_array_equal(found["deep"][1, 2], 6 * PRESSURE)
