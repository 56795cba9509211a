from pathlib import Path

import pytest
import xarray as xr

from contactstudy import InvalidInput
from studies.store import open_folder, read, replacing, write


def test_a_file_stays_until_the_new_one_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "kept.txt"
    path.write_text("old")

    def fail() -> None:
        with replacing(path) as partial:
            partial.write_text("half of the n")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    with replacing(path) as partial:
        partial.write_text("new")
    assert path.read_text() == "new"
    assert [entry.name for entry in tmp_path.iterdir()] == ["kept.txt"]


def test_a_dataset_comes_back_as_it_went(tmp_path: Path) -> None:
    dataset = xr.Dataset({"a": ("n", [1.0, 2.0], {"units": "m"})}, {"n": [1, 2]}, {"title": "t"})
    write(dataset, tmp_path / "a.nc")
    xr.testing.assert_identical(read(tmp_path / "a.nc"), dataset)


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
