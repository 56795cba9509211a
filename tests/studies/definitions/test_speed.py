"""What the study of growing grids measures."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.special import erf

import contactstudy as cs
from studies.definitions import speed as module
from studies.definitions.speed import SLOPE, CaseOnDevice, least_seconds, self_affine
from studies.reference.line_contact import HERTZ, SCENE
from studies.registry import load

POINT = {
    "surface": "self-affine",
    "hurst": 0.5,
    "cut_off": 4.0,
    "share": 0.3,
    "precision": "double",
    "device": "cpu",
    "threads": 1,
    "grid": 32,
}


def test_a_surface_that_is_not_self_affine_is_solved_once_for_all_of_its_parameters() -> None:
    study = load("speed")
    rough = {study.scene_at(POINT | {"surface": "rough", "hurst": hurst}) for hurst in (0.2, 0.8)}
    assert len(rough) == 1
    assert study.scene_at(POINT) != study.scene_at(POINT | {"hurst": 0.8})
    assert study.scene_at(POINT) != study.scene_at(POINT | {"threads": 2})


def test_a_line_is_a_smooth_cylinder_with_one_cell_along() -> None:
    line, smooth = (
        load("speed").scene_at(POINT | {"surface": name}) for name in ("line", "smooth")
    )
    assert isinstance(line, CaseOnDevice)
    assert isinstance(smooth, CaseOnDevice)
    assert line.case.grid.cells == (32, 1)
    assert smooth.case.grid.cells == (32, 32)
    assert line.case.scene == smooth.case.scene == SCENE


def test_a_self_affine_surface_bears_the_load_of_its_share_and_ends_at_so_many_cells() -> None:
    """Persson (2001): the share is erf(sqrt(2) p / (E* slope)), p the mean pressure."""
    grid = cs.Grid((64, 64), (3e-3, 3e-3))
    scene = self_affine(grid, 0.5, 4.0, 0.3)
    mean = scene.load.largest / 3e-3
    shape = scene.shapes[0]
    assert isinstance(shape, cs.Roughness)
    assert shape.rms == cs.RmsSlope(0.1)
    assert shape.roll_off == pytest.approx(3e-3 / 4)
    assert erf(np.sqrt(2) * mean / (SCENE.contact_modulus * SLOPE)) == pytest.approx(0.3)
    waves = np.abs(np.fft.rfft2(scene.shapes[0].gap(grid)))  # type: ignore[union-attr]
    index = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.rfftfreq(64), indexing="ij"))
    assert waves[index > 1.001 / 4].max() < 1e-12 * waves.max() < waves[index > 0.9 / 4].max()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"share": 1.0}, r"^share is 1\.0: give a share between 0 and 1\."),
        ({"cut_off": 0.0}, r"^cut_off is 0\.0: give a number of cells above 0\."),
        ({"threads": 0}, r"^threads is 0: give a whole number of threads from 1 on\."),
        ({"device": "gpu"}, "^Gpu "),
        ({"surface": "smoth"}, "^surface is 'smoth': did you mean 'smooth'"),
        ({"precision": "half"}, "^precision is 'half': give 'single' or 'double'"),
    ],
)
def test_a_point_that_is_none_is_refused_with_a_remedy(
    change: dict[str, object], message: str
) -> None:
    with pytest.raises(cs.InvalidInput, match=message):
        load("speed").scene_at(POINT | change)


def test_the_ratio_is_of_the_solve_to_as_many_transforms(monkeypatch: pytest.MonkeyPatch) -> None:
    """A solve of 6 s beside transforms of 0.5 s each: twelve over its number of transform pairs."""
    monkeypatch.setattr(module, "transform_seconds", lambda *_: 0.5)
    monkeypatch.setattr(module, "least_seconds", lambda *_: 6.0)
    study = load("speed")
    case = study.scene_at(POINT)
    assert isinstance(case, CaseOnDevice)
    solution = case.solved(case.prepare(), 2000)
    found = study.measures(case, solution)
    assert float(found["transform_ratio"]) == pytest.approx(12 / solution.convolutions)
    assert float(found["contact_share"]) == (solution.pressure > 0).mean()


def test_memory_is_counted_in_fields_of_double_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.definitions.speed.transform_seconds", lambda *_: 0.5)
    study = load("speed")
    case = study.scene_at(POINT)
    assert isinstance(case, CaseOnDevice)
    solution = case.solved(case.prepare(), 2000)
    hoard = 40_000_000

    def solved(*_: object) -> np.ndarray:
        return np.ones(hoard, dtype=np.int8)[:1].copy()

    monkeypatch.setattr(CaseOnDevice, "solved", solved)
    found = study.measures(case, solution)
    assert float(found["memory"]) == pytest.approx(hoard / (8 * 32 * 32), rel=1e-2)


def test_the_least_of_three_runs_counts_or_of_as_many_as_take_50_ms() -> None:
    """Three long runs, of 5 s, 3 s and 4 s; short ones of 20 ms, which are three, and of 11 ms, which are five."""
    for lengths in ((5.0, 3.0, 4.0), (0.02, 0.02, 0.02), (0.011,) * 5):
        at = iter(np.cumsum([(10.0, length) for length in lengths]).tolist())
        assert least_seconds(lambda at=at: next(at), lambda: None) == pytest.approx(min(lengths))
        assert not [*at]


def test_a_timed_run_is_one_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    case = load("speed").scene_at(POINT)
    calls: list[object] = []
    monkeypatch.setattr(CaseOnDevice, "solved", lambda *_: calls.append(1))
    case.run(None)  # type: ignore[arg-type]
    assert len(calls) == 1


def test_single_precision_is_solved_to_1e_5_and_another_device_takes_one_thread() -> None:
    study = load("speed")
    for precision, tolerance in (("single", 1e-5), ("double", 1e-8)):
        case = study.scene_at(POINT | {"precision": precision, "threads": 3})
        assert isinstance(case, CaseOnDevice)
        assert (case.case.options.tolerance, case.threads) == (tolerance, 3)
    elsewhere: Any = SimpleNamespace()
    assert CaseOnDevice(case.case, elsewhere).threads == 1


def test_the_finest_wave_is_so_many_cells_across_and_the_load_is_of_the_length() -> None:
    grid = cs.Grid((64, 32), (2e-3, 3e-3))
    scene = self_affine(grid, 0.5, 4.0, 0.3)
    assert scene.shapes[0].cut_off == pytest.approx(4 * 2e-3 / 64)  # type: ignore[attr-defined]
    square = self_affine(cs.Grid((64, 32), (3e-3, 3e-3)), 0.5, 4.0, 0.3)
    assert scene.load.largest == pytest.approx(square.load.largest)


def test_two_cells_are_a_grid_and_one_is_none() -> None:
    study = load("speed")
    case = study.scene_at(POINT | {"surface": "rough", "grid": 2})
    assert isinstance(case, CaseOnDevice)
    assert case.case.grid.cells == (2, 2)
    side = HERTZ.half_width
    assert study.scene_at(POINT).case.grid.extent == (side, side)  # type: ignore[attr-defined]
    with pytest.raises(cs.InvalidInput, match=r"^grid is 1: give at least 2 cells"):
        study.scene_at(POINT | {"grid": 1})
