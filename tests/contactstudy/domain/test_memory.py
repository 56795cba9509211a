from collections.abc import Callable
from pathlib import Path

import numpy as np
import psutil
import pytest

from contactstudy.domain import device
from contactstudy.domain.device import ArrayCache, cached_array, caching


def eight_bytes(computed: list[str], name: str) -> Callable[[], np.ndarray]:
    def compute() -> np.ndarray:
        computed.append(name)
        return np.zeros(1)

    return compute


def test_equal_keys_share_one_read_only_array_and_none_do_on_request() -> None:
    computed: list[str] = []
    with caching(ArrayCache(100)):
        first = cached_array((1, 0.3), eight_bytes(computed, "first"))
        assert cached_array((1, 0.3), eight_bytes(computed, "equal")) is first
        assert cached_array((1, 3 * 0.1), eight_bytes(computed, "other")) is not first
    with caching(None):
        cached_array((1, 0.3), eight_bytes(computed, "again"))
    assert computed == ["first", "other", "again"]
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1.0


def test_memory_left_is_what_a_limit_of_the_process_leaves() -> None:
    resource = pytest.importorskip("resource", reason="this system has no limits of POSIX")
    limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (psutil.Process().memory_info().vms + 2**28, limits[1]))
    try:
        assert 2**27 < device.available_bytes() <= 2**28
    finally:
        resource.setrlimit(resource.RLIMIT_AS, limits)


def test_a_container_leaves_its_limit_less_what_it_uses_beside_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(device, "CGROUP", tmp_path)
    (tmp_path / "memory.current").write_text("300\n")
    (tmp_path / "memory.stat").write_text("anon 180\nfile 120\ninactive_file 100\n")
    for limit, left in (("1000\n", 800), ("200\n", 0)):
        (tmp_path / "memory.max").write_text(limit)
        assert device.available_bytes() == left
    (tmp_path / "memory.max").write_text("max\n")  # no limit
    assert device.available_bytes() > 700
