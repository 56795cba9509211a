"""Values of a varied field as a person writes them."""

import pytest

from contactstudy import InvalidInput
from studies.scene_study.variation import parse_values


@pytest.mark.parametrize(
    ("text", "whole", "wanted"),
    [
        ("1,2.5,-3e2", False, [1, 2.5, -300.0]),
        ("50:400:8 N/mm", False, [f"{50 * n} N/mm" for n in range(1, 9)]),
        ("0.1:0.3:3", False, [0.1, 0.2, 0.3]),
        ("1:100:3:log", False, [1.0, 10.0, 100.0]),
        ("1 um:4 um:3:log", False, ["1 um", "2 um", "4 um"]),
        ("1:2:2", False, [1.0, 2.0]), ("0:4", True, [0, 1, 2, 3, 4]), ("0:5:2", True, [0, 5]), ("3:3", True, [3]),
        ("1,2,3 mm", False, ["1 mm", "2 mm", "3 mm"]),
        ("1 um,2 mm", False, ["1 um", "2 mm"]),
        ("[32, 1],[64, 1]", False, [[32, 1], [64, 1]]),
        ("{a = [1, 2]}, 'x,y'", False, [{"a": [1, 2]}, "x,y"]),
        ("true,false,name", False, [True, False, "name"]),
        ("0:2,7", True, [0, 1, 2, 7]),
    ],
)  # fmt: skip
def test_lists_ranges_and_units(text: str, whole: bool, wanted: list[object]) -> None:  # noqa: FBT001
    found = parse_values("field", text, whole=whole)
    assert found == wanted
    assert [type(one) for one in found] == [type(one) for one in wanted]


@pytest.mark.parametrize(
    ("text", "whole", "said"),
    [
        ("1,,2", False, "lacks a value"), ("", False, "lacks a value"),
        ("1:2", False, "give a rising range with its number"),
        ("1:2:1", False, "give a rising range with its number"),
        ("0:2:3:log", False, "for equal ratios above 0"),
        ("-1:2:3:log", False, "for equal ratios above 0"),
        ("1 um:2 mm:3", False, "has the units"), ("3:1", True, "or of whole numbers"),
        ("0.5:3", True, "or of whole numbers"), ("1:2:100001", False, "100000"), ("[1,2", False, "close its brackets"),
        ("'a", False, "close its brackets"), ("1,2 mm,3", False, ""),
        ("a,1,2 mm", False, "some numbers have a unit"),
        ("1,a,2 mm", False, "some numbers have a unit"),
    ],
)  # fmt: skip
def test_what_is_none_of_these_is_refused(text: str, whole: bool, said: str) -> None:  # noqa: FBT001
    if said:
        with pytest.raises(InvalidInput, match=said):
            parse_values("field", text, whole=whole)
    else:
        # a unit that is not that of the last is its own
        assert parse_values("field", text, whole=whole) == [1, "2 mm", 3]
