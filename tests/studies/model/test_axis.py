import pytest

from contactstudy import InvalidInput
from studies.model.axis import Axis, Value

WHOLE = Axis("images", (6,), "n")
REAL = Axis("period", (2.4,), "L")
NAME = Axis("padding", ("zero",), "mode")


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("axis", "text", "values"),
    [
        (WHOLE, "0:10", tuple(range(11))),
        (WHOLE, "0:10:3,100", (0, 5, 10, 100)),
        (WHOLE, "32:1024:6:log", (32, 64, 128, 256, 512, 1024)),
        (WHOLE, "6, 1,6", (1, 6)),
        (REAL, "0.15,0.6,2.4", (0.15, 0.6, 2.4)),
        (REAL, "0.6:2.4:4", (0.6, 1.2, 1.8, 2.4)),
        (NAME, "zero,exact", ("zero", "exact")),
    ],
)
def test_values_are_read_as_written(axis: Axis, text: str, values: tuple[Value, ...]) -> None:
    assert axis.override(text).values == values
    assert [type(v) for v in axis.override(text).values] == [axis.kind] * len(values)


def test_values_may_come_from_python() -> None:
    assert WHOLE.override(range(3)).values == (0, 1, 2)
    assert REAL.override([1, 2.5]).values == (1.0, 2.5)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("axis", "text"),
    [
        (WHOLE, ""), (WHOLE, "six"), (WHOLE, "1.5"), (WHOLE, "3:1"), (WHOLE, "0:4:0"), (WHOLE, "1,,2"),
        (WHOLE, "0:--3"),
        (WHOLE, "nan"), (WHOLE, "inf"), (REAL, "0:10"), (REAL, "nan"), (REAL, "inf"), (REAL, "1e999"),
        (REAL, ","), (REAL, "0:1:3:log"), (REAL, "2:1:3"), (WHOLE, "0:10:4"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_with_its_axis(axis: Axis, text: str) -> None:
    with pytest.raises(InvalidInput, match=rf"^{axis.name} is .*: give .*\.$"):
        axis.override(text)


def test_whole_numbers_are_those_that_a_double_holds() -> None:
    assert Axis("a", (2**53,), "a").values == (2**53,)
    with pytest.raises(InvalidInput, match=r"give whole numbers up to 2\^53\.$"):
        Axis("a", (2**53 + 1,), "a")
