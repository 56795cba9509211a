from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain import device as memory
from contactstudy.domain.reuse import ArrayCache, cached_array, caching


def test_cell_centres_are_symmetric_to_the_last_bit() -> None:
    grid = cs.Grid(cells=(7, 10), extent=(0.3, 0.7))
    assert (grid.x == -grid.x[::-1]).all()
    assert (grid.y == -grid.y[::-1]).all()
    assert grid.x[3] == 0
    np.testing.assert_allclose(np.diff(grid.y), grid.cell[1], rtol=1e-14)
    np.testing.assert_allclose(grid.x[-1] + grid.cell[0] / 2, 0.15, rtol=1e-15)


def test_cells_are_the_extent_parted() -> None:
    grid = cs.Grid(cells=(4, 2), extent=(8.0, 6.0))
    assert (grid.cell, grid.cell_area, grid.period) == ((2, 3), 6, 6)
    assert grid.x.tolist() == [-3, -1, 1, 3]
    assert grid.y.tolist() == [-1.5, 1.5]


@pytest.mark.parametrize(
    ("cells", "extent", "field", "value"),
    [
        ((1, 8), (1.0, 1.0), "Grid.cells[0]", "1"),
        ((8, 0), (1.0, 1.0), "Grid.cells[1]", "0"),
        ((8.5, 8), (1.0, 1.0), "Grid.cells[0]", "8.5"),
        ((True, 8), (1.0, 1.0), "Grid.cells[0]", "True"),
        (8, (1.0, 1.0), "Grid.cells", "8"),
        ((8, 8), (1.0, 0.0), "Grid.extent[1]", "0.0"),
        ((8, 8), (-1.0, 1.0), "Grid.extent[0]", "-1.0"),
        ((8, 8), (float("nan"), 1.0), "Grid.extent[0]", "nan"),
        ((8, 8), (1.0, float("inf")), "Grid.extent[1]", "inf"),
        ((8, 8), 1.0, "Grid.extent", "1.0"),
    ],
)
def test_a_bad_grid_is_refused_in_one_sentence(
    cells: object, extent: object, field: str, value: str
) -> None:
    with pytest.raises(cs.InvalidInput) as refusal:
        cs.Grid(cells=cells, extent=extent)  # type: ignore[arg-type]
    sentence = str(refusal.value)
    assert sentence.startswith(f"{field} is {value}: give ")
    assert sentence.endswith(".")
    assert "\n" not in sentence


def test_cells_may_be_a_billion_times_as_long_as_wide_and_no_longer() -> None:
    for extent in ((2.0, 0.9e9), (0.9e9 * 2, 1.0), (2.0, 1e9), (2e9, 1.0), (2e20, 3e20)):
        assert cs.Grid(cells=(2, 1), extent=extent).extent == extent
    for extent in ((2.0, 1.1e9), (1.1e9 * 2, 1.0)):
        with pytest.raises(cs.InvalidInput, match=r"^Grid\.extent is .* times as"):
            cs.Grid(cells=(2, 1), extent=extent)


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


def test_linux_says_kibibytes_and_swap_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = tmp_path / "meminfo"
    said.write_text("MemFree: 1 kB\nMemAvailable:  300 kB\nSwapFree: 50 kB\n")
    monkeypatch.setattr(memory, "Path", lambda _: said)
    assert memory._of_system() == 350 * 1024


def test_a_container_has_its_limit_less_what_it_uses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory, "CGROUP", tmp_path)
    assert memory._of_container() == float("inf")
    (tmp_path / "memory.max").write_text("1000\n")
    (tmp_path / "memory.current").write_text("300\n")
    assert memory._of_container() == 700
    (tmp_path / "memory.max").write_text("max\n")
    assert memory._of_container() == float("inf")


def test_a_process_has_its_limit_less_its_pages(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
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
