import numpy as np
import pytest
from scipy.special import erf

import contactstudy as cs
from benchmarks.__main__ import results
from benchmarks.peers import PADDINGS, Peers
from benchmarks.speed import SLOPE, SURFACES, Solve, self_affine
from studies.reference.line_contact import SCENE


def test_each_surface_is_timed_on_a_grid_and_a_program_that_is_not_there_is_left_out() -> None:
    lines = list(results(Solve, [32]))
    assert [line.partition(",")[0] for line in lines] == list(SURFACES)
    assert all("ms of processor time; fields" in line for line in lines)
    own = [line for line in results(Peers, [32]) if line.startswith("contactstudy")]
    assert len(own) == len(PADDINGS)
    with pytest.raises(NotImplementedError, match=r"periodic along one axis only|not installed"):
        Peers().setup("tamaas", "semi-periodic", 32)


@pytest.mark.parametrize(
    ("program", "boundary"),
    [("contactstudy", "semi-periodic"), ("ContactMechanics", "semi-periodic"), ("tamaas", "free"), ("aspher", "free")],
)
def test_programs_agree_where_they_hold_pressure_constant_in_cells(program: str, boundary: str) -> None:
    pytest.importorskip(program)
    peers = Peers()
    peers.setup(program, boundary, 32)
    assert peers.track_load(program, boundary, 32) == pytest.approx(1, abs=1e-6)
    # 10 images leave 3e-3
    most = 1e-7 if program == "contactstudy" else 1e-2
    assert peers.track_difference(program, boundary, 32) < most


def test_a_self_affine_surface_bears_the_load_of_its_share_and_ends_at_so_many_cells() -> None:
    """Persson (2001): the fraction is erf(sqrt(2) p / (E* slope)), p the mean pressure."""
    grid = cs.Grid((64, 64), (3e-3, 3e-3))
    scene = self_affine(grid, 0.5, 4.0, 0.3)
    assert erf(np.sqrt(2) * scene.largest_load / 3e-3 / (SCENE.contact_modulus * SLOPE)) == pytest.approx(0.3)
    waves = np.abs(np.fft.rfft2(scene.shapes[0].gap(grid)))  # type: ignore[union-attr]
    index = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.rfftfreq(64), indexing="ij"))
    assert waves[index > 1.001 / 4].max() < 1e-12 * waves.max() < waves[index > 0.9 / 4].max()
