import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.model.measured import MAX_CASE_BYTES, MeasuredNaNError, check_size, measured_variables
from studies.store.netcdf import read, write

AXES = frozenset({"number"})


def scalar(**attrs: Any) -> xr.Variable:
    return xr.Variable((), 1.0, attrs)


VALUES = (
    1 + 2j, np.array([1j])[0], np.datetime64("2020-01-01", "ns"), np.timedelta64(5, "s"), None, object(), [1, 2],
    np.arange(3.0), {}, {1}, b"abc", 10**30, np.uint64(2**64 - 1), -(2**53) - 1, xr.Variable("x", [-(2**53) - 1, 0]),
    np.longdouble(1) / 3, np.ma.masked_array([1.0, 2.0], [0, 1]), "lone \udcff surrogate", "NUL \0 inside",
    "NUL at the end\0", xr.Variable((), "NUL at the end\0"), xr.Variable(("k",), ["a", "\udcff"]),
    xr.Variable(("k",), np.array(["a", 1], dtype=object)), xr.Variable(("number",), [1.0]),
    xr.Variable(("a/b",), [1.0]), xr.Variable(("",), [1.0]),
)  # fmt: skip
# o and u0308 are a letter and its accent, which netCDF would join
NAMES = ("a/b", "", " a", "a ", "a\n", "o\u0308", 5, "é" * 126, "-a", "number", "case_status")
ATTRIBUTES = (
    *({name: 1.0} for name in ("scale_factor", "add_offset", "_FillValue", "missing_value", "a/b")),
    {"_Unsigned": "true"}, {"dtype": "x"}, {"coordinates": "number"},
    *({"units": units} for units in ("days since 2000-01-01", "seconds", 5)),
    *({"note": note} for note in (
        None, True, np.bool_(1), datetime.date(2020, 1, 1), object(), {"a": 1}, [1, None], ["a", 1], [[1, 2], [3, 4]],
        1j, 10**30, "\udcff", "a\0b",
    )),
)  # fmt: skip


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "measured",
    [
        *({"q": value} for value in VALUES),
        *({name: 1.0} for name in NAMES),
        *({"q": scalar(**attributes)} for attributes in ATTRIBUTES),
        {"q": xr.Variable(("k",), [1.0]), "p": xr.Variable(("k",), [1.0, 2.0])},
        {"k": 1.0, "q": xr.Variable(("k",), [1.0])},
        *([1, 2], 1.0, np.arange(3.0), None),
    ],
)
def test_what_netcdf_would_change_or_refuse_is_refused_in_one_sentence(measured: Any) -> None:
    with pytest.raises(InvalidInput, match=r"^measures [^\n]*: [^\n]*\.$"):
        measured_variables(measured, AXES | {"case_status"})


@pytest.mark.parametrize("value", [np.nan, np.float32("nan"), xr.Variable(("k",), [1.0, np.nan])])
def test_nan_is_an_error_of_its_own(value: Any) -> None:
    assert measured_variables({"q_bound": value, "q_estimate_images": value}, ())  # not known
    with pytest.raises(MeasuredNaNError, match=r"^q is nan$"):
        measured_variables({"q": value}, AXES)


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "value",
    [
        1, -0.0, np.inf, True, 2**53, "", "größer\n✓",
        np.float16(0.1), np.float32(0.1), np.int8(-3), xr.DataArray([1.0, 2.0], dims="k"),
        xr.Variable(("k",), np.arange(3, dtype=">f8")), xr.Variable(("k",), ["a", "bcd"]),
        xr.Variable(("k", "m"), np.asfortranarray(np.arange(6.0).reshape(2, 3))),
        scalar(units="1/m", n=3, x=0.1, word="a", row=np.array([1, 2], dtype=np.int8)),
        scalar(words=["a", "b"]),
    ],
)  # fmt: skip
def test_what_is_accepted_comes_back_from_netcdf_as_it_was(value: Any, tmp_path: Path) -> None:
    measured = measured_variables({"q": value}, AXES)["q"]
    write(xr.Dataset({"q": measured}), tmp_path / "q.nc")
    back = read(tmp_path / "q.nc")["q"].variable
    given = value.variable if isinstance(value, xr.DataArray) else value
    plain = given.values if isinstance(given, xr.Variable) else np.asarray(given)
    np.testing.assert_array_equal(back.values.astype(plain.dtype), plain)
    assert back.dims == measured.dims
    for name, attribute in measured.attrs.items():
        np.testing.assert_array_equal(back.attrs[name], attribute)


def test_more_than_a_table_can_hold_is_refused_with_its_size() -> None:
    row = xr.Variable(("n",), np.zeros(MAX_CASE_BYTES // 8))
    check_size({"row": row})
    with pytest.raises(InvalidInput, match=r"gives 67.1 MB, more than the 33.6 MB of a case"):
        check_size({"row": row, "other": row})
