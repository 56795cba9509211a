import pytest

from contactstudy import InvalidInput
from studies.scene_study.values import parse_values


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("text", "kind", "wanted"),
    [
        ("1,2.5,-3e2", float, [1, 2.5, -300.0]),
        ("50:400:8 N/mm", float, [f"{50 * n} N/mm" for n in range(1, 9)]),
        ("0.1:0.3:3", float, [0.1, 0.2, 0.3]),
        ("1:100:3:log", float, [1.0, 10.0, 100.0]),
        ("1 um:4 um:3:log", float, ["1 um", "2 um", "4 um"]),
        ("1:2:2", float, [1.0, 2.0]), ("0:4", int, [0, 1, 2, 3, 4]), ("0:5:2", int, [0, 5]), ("3:3", int, [3]),
        ("1,2,3 mm", float, ["1 mm", "2 mm", "3 mm"]),
        ("1 um,2 mm", float, ["1 um", "2 mm"]),
        ("[32, 1],[64, 1]", float, [[32, 1], [64, 1]]),
        ("{a = [1, 2]}, 'x,y'", float, [{"a": [1, 2]}, "x,y"]),
        ("true,false,name", float, [True, False, "name"]),
        ("0:2,7", int, [0, 1, 2, 7]),
    ],
)  # fmt: skip
def test_lists_ranges_and_units(text: str, kind: type, wanted: list[object]) -> None:
    found = parse_values("field", text, kind)
    assert found == wanted
    assert [type(one) for one in found] == [type(one) for one in wanted]


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("1,,2", float, "lacks a value"), ("", float, "lacks a value"),
        ("1:2", float, "give a rising range with its number"),
        ("1:2:1", float, "give a rising range with its number"),
        ("0:2:3:log", float, "for equal ratios above 0"),
        ("-1:2:3:log", float, "for equal ratios above 0"),
        ("1 um:2 mm:3", float, "has the units"), ("3:1", int, "or of whole numbers"),
        ("0.5:3", int, "or of whole numbers"), ("1:2:100001", float, "100000"), ("[1,2", float, "close its brackets"),
        ("'a", float, "close its brackets"), ("1,2 mm,3", float, ""),
        ("a,1,2 mm", float, "some numbers have a unit"),
        ("1,a,2 mm", float, "some numbers have a unit"),
    ],
)  # fmt: skip
def test_what_is_none_of_these_is_refused(text: str, kind: type, said: str) -> None:
    if said:
        with pytest.raises(InvalidInput, match=said):
            parse_values("field", text, kind)
    else:
        # a unit that is not that of the last is its own
        assert parse_values("field", text, kind) == [1, "2 mm", 3]
