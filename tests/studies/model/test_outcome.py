from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy import InvalidInput
from studies.model.case import Case, solver_status
from studies.model.outcome import (
    MAX_CASE_BYTES,
    CaseStatus,
    MeasuredNaNError,
    TimedRun,
    check_size,
    measured_variables,
    summary_messages,
    timing_variables,
)
from studies.model.plain_text import one_line
from studies.scene_study.measures import measures
from studies.store.netcdf import read, write

OIL = Path(__file__).parents[3] / "examples" / "oil.toml"


def test_what_is_recorded_of_a_film_is_that_of_its_contact() -> None:
    case = Case(cs.read_scene(OIL).scene, cs.Grid((160, 1), (1.2e-3, 1e-3)), cs.ExactPeriodicity())
    film = case.run()
    measured = measures(case, film)
    assert float(measured["central_film"]) == film.central_film
    assert float(measured["friction_coefficient"]) == film.friction
    assert float(measured["moes_film"]) == film.scales.expected_film * film.scales.film
    assert int(case.record(film)["solver_status"]) == list(cs.Status).index(film.status)
    assert float(measured["central_film_bound"]) == pytest.approx(film.error.central_film.total * film.central_film)


def test_a_run_names_what_did_not_converge_misses_its_accuracy_warns_and_has_no_bound() -> None:
    at_edge = cs.Status.CONTACT_AT_EDGE
    ended = [solver_status(status, "how it ended") for status in (cs.Status.CONVERGED, at_edge, at_edge)]
    for status, flag in zip((cs.Status.CONVERGED, at_edge), ended, strict=False):
        assert flag.attrs["flag_meanings"].split()[int(flag)] == status.name.lower()
    inf, nan = np.inf, np.nan
    measured = {
        "case_key": ["0", "1", "2"],
        "case_status": [CaseStatus.OK] * 3,
        "accuracy_met": [1, 0, 1],
        "accuracy_missed": ["", "1 % not met: 3 % in L1", ""],
        "warnings": ["The bodies are no half-spaces.", "", ""],
        "peak_pressure": [1.0, 2.0, nan],
        "peak_pressure_bound": [0.1, inf, inf],
        "approach": [1.0, 2.0, 3.0],
        "approach_bound": [inf, inf, inf],  # of which the bound is never known
    }
    dataset = xr.Dataset({name: ("load", values) for name, values in measured.items()})
    dataset["solver_status"] = xr.concat([xr.DataArray(status) for status in ended], "load")
    assert list(summary_messages(dataset)) == [
        "2 of 3 solves ended with CONTACT_AT_EDGE; see 'solver_status'",
        "1 of 3 cases misses the requested accuracy, the first with 1 % not met: 3 % in L1",
        "1 of 3 cases warns, the first: The bodies are no half-spaces. See 'warnings'.",
        "no bound of peak_pressure in 1 of 3 cases",
    ]


def test_the_least_time_of_each_case_stands_at_its_points() -> None:
    cases = [[TimedRun(1.0, 3.0, 1.0, 3.0), TimedRun(2.0, 6.0, 0.8, 2.4)], [TimedRun(0.5, 1.5, 0.49, 1.47)], []]
    found = timing_variables(("x",), np.array([1, 0, 0, 2]), cases)
    nan = np.nan
    for name, expected in {
        "setup_time": [0.5, 1, 1, nan],
        "solve_time_cpu": [1.47, 2.4, 2.4, nan],
        "solve_time_all": [[1.5, nan], [3, 6], [3, 6], [nan] * 2],
    }.items():
        np.testing.assert_allclose(found[name].values, expected, rtol=1e-12)
        assert found[name].attrs["units"] == "s"


def scalar(**attrs: Any) -> xr.Variable:
    return xr.Variable((), 1.0, attrs)


# o and u0308 are a letter and its accent, which netCDF would join
@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "measured",
    [
        *(
            {"q": value}
            for value in (
                1j, np.datetime64("2020-01-01", "ns"), None, [1, 2], -(2**53) - 1, np.longdouble(1) / 3,
                "lone \udcff surrogate", "NUL at the end\0", xr.Variable(("k",), np.array(["a", 1], dtype=object)),
                xr.Variable(("number",), [1.0]), xr.Variable(("a/b",), [1.0]),
            )
        ),
        *({name: 1.0} for name in ("a/b", "a ", "o\u0308", 5, "é" * 126, "number")),
        *({"q": scalar(**attributes)} for attributes in (
            {"scale_factor": 1.0}, {"_Unsigned": "true"}, {"units": "days since 2000-01-01"}, {"units": 5},
            {"note": None}, {"note": ["a", 1]}, {"note": [[1, 2], [3, 4]]}, {"note": "a\0b"},
        )),
        {"q": xr.Variable(("k",), [1.0]), "p": xr.Variable(("k",), [1.0, 2.0])},
        {"k": 1.0, "q": xr.Variable(("k",), [1.0])},
        [1, 2],
    ],
)  # fmt: skip
def test_what_netcdf_would_change_or_refuse_is_refused_in_one_sentence(measured: Any) -> None:
    with pytest.raises(InvalidInput, match=r"^measures [^\n]*: [^\n]*\.$"):
        measured_variables(measured, {"number", "case_status"})


def test_nan_is_an_error_of_its_own_but_of_a_bound() -> None:
    value = xr.Variable(("k",), [1.0, np.nan])
    assert measured_variables({"q_bound": value, "q_estimate_images": value}, ())  # not known
    with pytest.raises(MeasuredNaNError, match=r"^q is nan$"):
        measured_variables({"q": value}, ())


@pytest.mark.cases(100)
@pytest.mark.parametrize(
    "value",
    [
        True, 2**53, "größer\n✓", np.float16(0.1), xr.DataArray([1.0, 2.0], dims="k"),
        xr.Variable(("k",), np.arange(3, dtype=">f8")), xr.Variable(("k",), ["a", "bcd"]),
        scalar(units="1/m", n=3, x=0.1, word="a", row=np.array([1, 2], dtype=np.int8), words=["a", "b"]),
    ],
)  # fmt: skip
def test_what_is_accepted_comes_back_from_netcdf_as_it_was(value: Any, tmp_path: Path) -> None:
    measured = measured_variables({"q": value}, ())["q"]
    write(xr.Dataset({"q": measured}), tmp_path / "q.nc")
    back = read(tmp_path / "q.nc")["q"].variable
    plain = np.asarray(getattr(value, "values", value))
    np.testing.assert_array_equal(back.values.astype(plain.dtype), plain)
    assert back.dims == measured.dims
    for name, attribute in measured.attrs.items():
        np.testing.assert_array_equal(back.attrs[name], attribute)


def test_more_than_a_table_can_hold_is_refused_with_its_size() -> None:
    row = xr.Variable(("n",), np.zeros(MAX_CASE_BYTES // 8))
    check_size({"row": row})
    with pytest.raises(InvalidInput, match=r"gives 67.1 MB, more than the 33.6 MB of a case"):
        check_size({"row": row, "other": row})


def test_a_text_is_one_line_of_at_most_so_many_characters_without_control_characters() -> None:
    assert one_line("abcd", 4) == "abcd"
    assert one_line("abcde", 4) == "abcd ..."
    assert one_line("a \n\t b\r\nc\x07d") == r"a b c\x07d"

    class Silent:
        def __str__(self) -> str:
            raise ValueError

    assert one_line(Silent()) == "(no text: its __str__ raises ValueError)"
