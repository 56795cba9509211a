import pytest

from contactstudy import InvalidInput
from studies.model.axis import Axis, Value
from studies.registry import load

WHOLE = Axis("images", (6,), "n")
REAL = Axis("period", (2.4,), "L")
NAME = Axis("padding", ("zero",), "mode")


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("axis", "given", "values"),
    [
        (WHOLE, "0:10", tuple(range(11))),
        (WHOLE, "0:10:3,100", (0, 5, 10, 100)),
        (WHOLE, "32:1024:6:log", (32, 64, 128, 256, 512, 1024)),
        (WHOLE, "6, 1,6", (1, 6)),
        (REAL, "0.6:2.4:4", (0.6, 1.2, 1.8, 2.4)),
        (NAME, "zero,exact", ("zero", "exact")),
        (WHOLE, range(3), (0, 1, 2)),
        (REAL, [1, 2.5], (1.0, 2.5)),
    ],
)
def test_values_are_read_as_written(axis: Axis, given: str, values: tuple[Value, ...]) -> None:
    found = axis.override(given).values
    assert found == values
    assert {type(value) for value in found} == {axis.kind}


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("axis", "text"),
    [
        (WHOLE, "six"), (WHOLE, "1.5"), (WHOLE, "3:1"), (WHOLE, "1,,2"), (WHOLE, "inf"), (REAL, "0:10"),
        (REAL, "1e999"), (REAL, "0:1:3:log"), (WHOLE, "0:10:4"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_with_its_axis(axis: Axis, text: str) -> None:
    with pytest.raises(InvalidInput, match=rf"^{axis.name} is .*: give .*\.$"):
        axis.override(text)


def test_whole_numbers_are_those_that_a_double_holds() -> None:
    assert Axis("a", (2**53,), "a").values == (2**53,)
    with pytest.raises(InvalidInput, match=r"give whole numbers up to 2\^53\.$"):
        Axis("a", (2**53 + 1,), "a")


@pytest.mark.parametrize(
    ("axis", "values", "message"),
    [("grid", "1", "grid is 1: give"), ("padding", "exakt", "padding is 'exakt': did you mean 'exact'")],
)
def test_a_point_that_cannot_be_is_refused_before_anything_runs(axis: str, values: str, message: str) -> None:
    with pytest.raises(InvalidInput, match=f"^{message}"):
        load("padding").override({axis: values}).cases()
