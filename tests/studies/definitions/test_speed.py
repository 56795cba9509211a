"""What the study of growing grids measures."""

import numpy as np
import pytest
from scipy.special import erf

import contactstudy as cs
from studies.definitions.speed import SLOPE, self_affine
from studies.reference.line_contact import SCENE
from studies.registry import load

POINT = {
    "surface": "self-affine",
    "hurst": 0.5,
    "cut_off": 4.0,
    "fraction": 0.3,
    "precision": "double",
    "device": "cpu",
    "threads": 1,
    "grid": 32,
}


def test_a_self_affine_surface_bears_the_load_of_its_share_and_ends_at_so_many_cells() -> None:
    """Persson (2001): the fraction is erf(sqrt(2) p / (E* slope)), p the mean pressure."""
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
        ({"fraction": 1.0}, r"^fraction is 1\.0: give a fraction between 0 and 1\."),
        ({"cut_off": 0.0}, r"^cut_off is 0\.0: give a number of cells above 0\."),
        ({"threads": 0}, r"^threads is 0: must be a whole number of threads, at least 1\."),
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
