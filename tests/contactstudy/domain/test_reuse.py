"""Arrays kept for equal arguments, where a store is open."""

from collections.abc import Callable

import numpy as np
import pytest

from contactstudy.domain.reuse import ArrayCache, cached_array, caching


def eight_bytes(computed: list[str], name: str) -> Callable[[], np.ndarray]:
    def compute() -> np.ndarray:
        computed.append(name)
        return np.zeros(1)

    return compute


def test_without_a_store_nothing_is_kept() -> None:
    computed: list[str] = []
    for _ in range(2):
        assert cached_array("key", eight_bytes(computed, "first")).flags.writeable
    with caching(ArrayCache(100)), caching(None):
        cached_array("key", eight_bytes(computed, "within"))
    assert computed == ["first", "first", "within"]


def test_equal_keys_have_one_array_that_cannot_be_changed() -> None:
    computed: list[str] = []
    with caching(ArrayCache(100)):
        first = cached_array((1, 0.3), eight_bytes(computed, "first"))
        assert cached_array((1, 0.3), eight_bytes(computed, "equal")) is first
        assert cached_array((1, 3 * 0.1), eight_bytes(computed, "other")) is not first
    assert computed == ["first", "other"]
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1.0


def test_a_store_keeps_the_last_used_that_it_has_room_for() -> None:
    computed: list[str] = []
    with caching(ArrayCache(16)):
        for name in ("a", "b", "a", "c", "a", "b"):
            cached_array(name, eight_bytes(computed, name))
        assert cached_array("large", lambda: np.zeros(3)).flags.writeable
        cached_array("b", eight_bytes(computed, "b"))
        assert not cached_array("as large as the store", lambda: np.zeros(2)).flags.writeable
    assert computed == ["a", "b", "c", "b"]
