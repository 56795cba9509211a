"""What the study of growing grids measures."""

import numpy as np
import pytest
from scipy.special import erf

import contactstudy as cs
from studies.definitions.cost.speed import SLOPE, CaseOnDevice, Timed, self_affine
from studies.reference.line_contact import SCENE
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


def test_a_self_affine_surface_bears_the_load_of_its_share_and_ends_at_so_many_cells() -> None:
    """Persson (2001): the share is erf(sqrt(2) p / (E* slope)), p the mean pressure."""
    grid = cs.Grid((64, 64), (3e-3, 3e-3))
    scene = self_affine(grid, 0.5, 4.0, 0.3)
    mean = scene.load.largest / 3e-3
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
        ({"surface": "smoth"}, "^surface is 'smoth': choose from rough, self-affine"),
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
    monkeypatch.setattr("studies.definitions.cost.speed.transform_seconds", lambda *_: 0.5)
    study = load("speed")
    case = study.scene_at(POINT)
    assert isinstance(case, CaseOnDevice)
    solution = case.solved(case.prepare(), 2000)
    found = study.measures(case, Timed(solution, 6.0))
    assert float(found["transform_ratio"]) == pytest.approx(12 / solution.convolutions)
    assert float(found["contact_share"]) == (solution.pressure > 0).mean()


def test_two_cells_are_a_grid_and_one_is_none() -> None:
    study = load("speed")
    case = study.scene_at(POINT | {"surface": "rough", "grid": 2})
    assert isinstance(case, CaseOnDevice)
    assert case.case.grid.cells == (2, 2)
    with pytest.raises(cs.InvalidInput, match=r"^grid is 1: give at least 2 cells"):
        study.scene_at(POINT | {"grid": 1})
