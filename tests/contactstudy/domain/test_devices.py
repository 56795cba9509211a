"""Every array library there is gives numpy's answers: a strict one, and a GPU or its stand-in where one is at hand."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import Mock

import array_api_strict
import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.device import Device, Namespace, available_bytes
from contactstudy.domain.loops import gpu
from contactstudy.elasticity import approximate_inverse
from contactstudy.solvers import conjugate_gradients as preconditioned_cg
from contactstudy.solvers.solve import ReportingSolver
from tests.conftest import LineContact
from tests.contactstudy.domain import host_gpu
from tests.contactstudy.solvers.test_preconditioned_cg import problem


@dataclass(frozen=True)
class Strict:
    """Nothing beyond the array API standard (2024.12), so that no call of numpy's alone is left."""

    arrays: Namespace

    @property
    def available_bytes(self) -> float:
        return available_bytes()

    def to_device(self, field: np.ndarray) -> np.ndarray:
        return cast(np.ndarray, self.arrays.asarray(field, copy=True))

    def to_numpy(self, field: np.ndarray) -> np.ndarray:
        return np.array(np.from_dlpack(field))


STRICT = Strict(array_api_strict)


def devices() -> Iterator[Device]:
    yield from (cs.Cpu(2), STRICT)
    if host_gpu.COMPILER:
        yield host_gpu.HostGpu()
    try:
        yield cs.Gpu()
    except cs.InvalidInput:
        return


@pytest.fixture(autouse=True)
def _size_of_strict_arrays_is_a_method(monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is of PyTorch's."""
    monkeypatch.setattr(type(STRICT.arrays.asarray(0.0)), "size", lambda array: array._array.size)


on_every_device = pytest.mark.parametrize("device", list(devices()), ids=lambda device: type(device).__name__)
needs_compiler = pytest.mark.skipif(host_gpu.COMPILER is None, reason="no C++ compiler is here")
BOTH = cs.ExactPeriodicity(), cs.ExactPeriodicity()
GRIDS: dict[str, tuple[tuple[int, int], cs.Padding | cs.Paddings]] = {
    "semi-periodic": ((64, 48), cs.ExactPeriodicity()),
    "doubly periodic": ((64, 64), BOTH),
    "free": ((36, 40), (cs.ZeroPadding(), cs.ZeroPadding())),
    "circular images": ((40, 33), cs.CircularSuperposition(2)),
    "odd, free along x": ((45, 31), (cs.ZeroPadding(), cs.ExactPeriodicity())),
    "one row along": ((129, 1), cs.ExactPeriodicity()),
}


def rough(
    contact: LineContact, cells: tuple[int, int], padding: cs.Padding | cs.Paddings, hardness: float | None
) -> cs.Problem:
    """A rough contact with a hardness over Hertz's peak pressure."""
    posed = problem(contact, cells, "30 %", padding)
    if hardness is None:
        return posed
    return replace(posed, constraint=cs.Constraint(hardness * contact.hertz.peak_pressure))


def agree(ours: cs.Solution, other: cs.Solution, tolerance: float) -> None:
    assert max(ours.residual, other.residual) <= tolerance
    for field in (other.pressure, other.displacement, other.gap):
        assert type(field) is np.ndarray
        assert field.dtype == np.float64
    scales = ours.problem.scales
    # a gap of the tolerance is a pressure of that times the operator's condition, up to so many waves across
    bound = 10 * max(other.pressure.shape) * tolerance
    assert np.abs(ours.pressure - other.pressure).max() / scales.pressure < bound
    assert abs(ours.approach - other.approach) / scales.gap < bound


@on_every_device
@pytest.mark.parametrize("grid", GRIDS)
def test_a_rough_contact_with_a_hardness_is_the_same(grid: str, device: Device, line_contact: LineContact) -> None:
    posed = rough(line_contact, *GRIDS[grid], hardness=0.8)
    ours, other = (cs.solve(posed, tolerance=1e-10, device=each) for each in (cs.Cpu(), device))
    agree(ours, other, 1e-10)
    assert other.status is ours.status
    assert np.count_nonzero(other.pressure == other.pressure.max()) > 1


@on_every_device
def test_single_precision_reaches_what_it_can_from_a_warm_start(device: Device, line_contact: LineContact) -> None:
    posed = problem(line_contact, 64, "80 %")
    ours = cs.solve(posed, tolerance=1e-10)
    other = cs.solve(posed, tolerance=1e-5, precision="single", device=device)
    assert other.status is cs.Status.CONVERGED
    agree(ours, other, 1e-5)
    assert cs.solve(posed, tolerance=1e-8, start=ours.pressure, device=device).iterations == 0


@on_every_device
def test_a_given_approach_is_the_same_and_its_report_gets_numpy_arrays(
    device: Device, line_contact: LineContact
) -> None:
    scene = replace(line_contact.scene, load=cs.Approach(2e-6))
    posed = scene.problem(line_contact.grid(32, 1.2), cs.ExactPeriodicity())
    seen: list[np.ndarray] = []
    report = ReportingSolver(lambda _, pressure: seen.append(pressure.copy()), cs.PolonskyKeer())
    other = cs.solve(posed, tolerance=1e-9, solver=report, device=device)
    agree(cs.solve(posed, tolerance=1e-9), other, 1e-9)
    np.testing.assert_array_equal(seen[-1] * posed.scales.pressure, other.pressure)


@needs_compiler
@pytest.mark.parametrize("grid", ["semi-periodic", "free"])
def test_the_coarser_grids_of_large_contacts_on_a_gpu_give_the_same(
    grid: str, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(approximate_inverse, "MIN_GPU_CELLS", 1)
    monkeypatch.setattr(preconditioned_cg, "MAX_DIRECT_GPU_CELLS", 256)
    posed = problem(line_contact, 64, "30 %", GRIDS[grid][1])
    ours = cs.solve(posed, tolerance=1e-10)
    other = cs.solve(posed, tolerance=1e-10, device=host_gpu.HostGpu())
    agree(ours, other, 1e-10)
    assert other.iterations <= ours.iterations + 3


@needs_compiler
def test_sums_over_blocks_of_threads_are_those_of_one_thread(tmp_path: Path) -> None:
    """Barriers, shuffles and shared memory of the kernels, with one thread of the processor for each of the GPU."""
    source = gpu.SOURCE.read_text(encoding="utf-8")
    shared = "__shared__ double parts[SUMS + MAXIMA][32];"
    assert shared in source
    own = "auto& parts = *reinterpret_cast<double (*)[SUMS + MAXIMA][32]>(shared_memory[blockIdx.x].data());"
    (tmp_path / "loops_emulated.cu").write_text(source.replace(shared, own), encoding="utf-8")
    program, made = Path(__file__).with_name("emulate.cpp"), tmp_path / "emulate"
    options = "-O1", "-std=c++20", "-pthread", "-DREAL=double", "-DPRE=double", f"-I{tmp_path}"
    subprocess.run([str(host_gpu.COMPILER), *options, str(program), "-o", str(made)], check=True)
    subprocess.run([str(made)], check=True)


def test_what_the_device_has_no_room_for_is_refused(line_contact: LineContact, monkeypatch: pytest.MonkeyPatch) -> None:
    posed = problem(line_contact, (8, 4), "smooth", BOTH)
    # 14 fields of 32 cells, and as many as 4 of the transforms, of 8 bytes each
    monkeypatch.setattr(Strict, "available_bytes", 18 * 32 * 8)
    cs.solve(posed, device=STRICT)
    monkeypatch.setattr(Strict, "available_bytes", 18 * 32 * 8 - 1)
    with pytest.raises(cs.InvalidInput, match=r"needs 4\.61e-06 GB and .* has 4\.61e-06 GB left"):
        cs.solve(posed, device=STRICT)
    cs.solve(posed, device=STRICT, precision="single")


def test_free_faces_are_refused() -> None:
    free = cs.HalfSpace(2.1e11, 0.3, free_faces=2e-3)
    scene = cs.Scene(cs.TotalLoad(100.0), (free, cs.HalfSpace(2.1e11, 0.3)), (cs.Cylinder(0.01),))
    posed = scene.problem(cs.Grid((8, 8), (1e-3, 2e-3)), (cs.ZeroPadding(), cs.ZeroPadding()))
    with pytest.raises(cs.InvalidInput, match="free_faces"):
        cs.solve(posed, device=STRICT)


class NoDriverError(Exception):
    pass


def test_a_gpu_says_its_memory_and_without_one_or_cupy_one_sentence_is_raised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "array_api_compat.cupy", STRICT.arrays)  # type: ignore[arg-type]
    runtime = SimpleNamespace(CUDARuntimeError=NoDriverError, memGetInfo=lambda: (1000, 10**6))
    pool = SimpleNamespace(free_bytes=lambda: 24)
    cupy: Any = SimpleNamespace(cuda=SimpleNamespace(runtime=runtime), get_default_memory_pool=lambda: pool)
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    runtime.getDeviceCount = lambda: 1
    assert cs.Gpu().available_bytes == 1024  # what is free, and what CuPy keeps
    for runtime.getDeviceCount in (lambda: 0, Mock(side_effect=NoDriverError)):
        with pytest.raises(cs.InvalidInput, match=r"^Gpu found no GPU.*: give Cpu\(\)"):
            cs.Gpu()
    monkeypatch.setitem(sys.modules, "cupy", None)  # type: ignore[arg-type]
    with pytest.raises(cs.InvalidInput, match=r"^Gpu needs CuPy, .*: pip install .*, or give"):
        cs.Gpu()
