"""The row of an axis in a command's help."""

import pytest

from studies.cli.study_help import _row
from studies.model.axis import Axis


@pytest.mark.parametrize(
    ("count", "shown"),
    [
        (10, "0, 1, 2, 3, 4, 5, 6, 7, 8, 9"),
        (11, "0, 1, 2, 3, 4, 5, 6, 7, 8, 9, ... (11 values, the last 10)"),
    ],
)
def test_an_axis_shows_ten_values_at_most_and_its_last(count: int, shown: str) -> None:
    row = _row(Axis("images", tuple(range(count)), "images counted"))
    assert row == ("--images COUNTS", f"images counted.  [default: {shown}]")
    assert _row(Axis("gap", (0.5,), "gap", "m"))[1] == "gap [m].  [default: 0.5]"
