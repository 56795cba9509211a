import signal
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from contactstudy import InvalidInput
from contactstudy.domain.files import replacing
from studies.model.axis import Axis
from studies.model.case import Case
from studies.model.outcome import CaseStatus, Failure, Outcome
from studies.reference import line_contact
from studies.store.netcdf import interrupts_deferred, open_folder, read
from studies.store.table import assemble


def test_a_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "kept.txt"
    path.write_text("old")

    def fail() -> None:
        with replacing(path) as partial:
            partial.write_text("half of the n")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text(encoding="utf-8") == "old"
    with replacing(path) as partial:
        partial.write_text("new")
    assert path.read_text(encoding="utf-8") == "new"
    assert [entry.name for entry in tmp_path.iterdir()] == ["kept.txt"]


def test_a_folder_that_cannot_be_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InvalidInput, match=r"^Output folder .* cannot be written to .*--out\.$"):
        open_folder(tmp_path / "file" / "below")


@pytest.mark.parametrize("content", [None, b"no netCDF"])
def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "a.nc").write_bytes(content)
    with pytest.raises(InvalidInput, match=r"^Study file .* cannot be read"):
        read(tmp_path / "a.nc")


AXES = [Axis("n", (1, 2), "which")]


def outcomes(*variables: dict[str, xr.Variable] | None) -> tuple[list[Case], dict[Case, Outcome]]:
    cases = [
        line_contact.scene_at({"padding": "exact", "images": 0, "period": p, "grid": 8})
        for p in (1, 2)
    ]
    return cases, {
        case: Outcome(CaseStatus.FAILED, failure=Failure("E", "no", "solve"))
        if one is None
        else Outcome(CaseStatus.OK, one)
        for case, one in zip(cases, variables, strict=True)
    }


def test_what_a_failed_case_lacks_is_missing_and_not_made_up() -> None:
    one = {
        "truth": xr.Variable((), np.array(1, dtype=bool)),
        "count": xr.Variable((), np.uint8(3)),
        "field": xr.Variable(("m",), [1, 2]),
    }
    cases, found = outcomes(one, None)
    dataset = assemble(AXES, cases, found.get, lambda _: (), {})
    assert dataset["truth"].values[0] == 1
    assert np.isnan(dataset["truth"].values[1])
    assert np.isnan(dataset["count"].values[1])
    assert np.isnan(dataset["field"].values[1]).all()
    assert dataset["case_status"].values.tolist() == [1, 2]


def test_what_is_not_like_the_others_is_left_out_and_said() -> None:
    first = {
        "y": xr.Variable(("y",), [0.0, 1.0]),
        "f": xr.Variable(("m",), [1.0]),
        "a": xr.Variable((), 1.0),
    }
    second = {
        "y": xr.Variable(("y",), [0.0, 2.0]),
        "f": xr.Variable(("m",), [1.0, 2.0]),
        "a": xr.Variable((), 2.0),
    }
    cases, found = outcomes(first, second)
    dataset = assemble(AXES, cases, found.get, lambda _: (), {})
    assert dataset["a"].values.tolist() == [1.0, 2.0]
    assert "y" not in dataset.coords
    assert dataset.attrs["left_out"] == (
        "y, a coordinate that is not the same at every point; "
        "f of 1 of 2 cases, which differs from the others' in dimensions, type or units"
    )


def test_an_interrupt_comes_after_what_must_not_be_left_half_way() -> None:
    done = []

    def work() -> None:
        with interrupts_deferred():
            signal.raise_signal(signal.SIGINT)
            done.append("whole")
        done.append("beyond")

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            work()
        assert done == ["whole"]
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)
