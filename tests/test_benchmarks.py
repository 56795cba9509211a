import pytest

from benchmarks.__main__ import results
from benchmarks.peers import PADDINGS, Peers
from benchmarks.speed import SURFACES, Solve


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
