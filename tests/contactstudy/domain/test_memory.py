from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from contactstudy.domain import device as memory
from contactstudy.domain.reuse import ArrayCache, cached_array, caching


def eight_bytes(computed: list[str], name: str) -> Callable[[], np.ndarray]:
    def compute() -> np.ndarray:
        computed.append(name)
        return np.zeros(1)

    return compute


def test_equal_keys_share_one_read_only_array() -> None:
    computed: list[str] = []
    with caching(ArrayCache(100)):
        first = cached_array((1, 0.3), eight_bytes(computed, "first"))
        assert cached_array((1, 0.3), eight_bytes(computed, "equal")) is first
        assert cached_array((1, 3 * 0.1), eight_bytes(computed, "other")) is not first
    assert computed == ["first", "other"]
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1.0


def test_linux_says_kib_and_swap_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said = tmp_path / "meminfo"
    said.write_text("MemFree: 1 kB\nMemAvailable:  300 kB\nSwapFree: 50 kB\n")
    monkeypatch.setattr(memory, "Path", lambda _: said)
    assert memory._of_system() == 350 * 1024


def test_a_container_has_its_limit_less_its_use(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "CGROUP", tmp_path)
    assert memory._of_container() == float("inf")
    (tmp_path / "memory.max").write_text("1000\n")
    (tmp_path / "memory.current").write_text("300\n")
    assert memory._of_container() == 700
    (tmp_path / "memory.max").write_text("max\n")
    assert memory._of_container() == float("inf")


def test_a_process_has_a_limit_less_pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    resource = SimpleNamespace(
        RLIMIT_AS=9, RLIM_INFINITY=-1, getrlimit=lambda _: (10_000, -1), getpagesize=lambda: 100
    )
    said = tmp_path / "statm"
    said.write_text("30 7 5")
    monkeypatch.setattr(memory, "import_module", lambda _: resource)
    monkeypatch.setattr(memory, "Path", lambda _: said)
    assert memory._of_process() == 7000
    resource.getrlimit = lambda _: (-1, -1)
    assert memory._of_process() == float("inf")
