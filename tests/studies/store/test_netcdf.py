import signal
from pathlib import Path

import pytest

from contactstudy import InvalidInput
from studies.store.netcdf import interrupts_deferred, open_folder, read


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
