"""Every array library there is gives numpy's answers: a strict one, PyTorch and a GPU where they are at hand."""

import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.device import Device, Namespace, Precision, available_bytes
from contactstudy.domain.fields import Array
from contactstudy.domain.loops import gpu
from contactstudy.elasticity import approximate_inverse
from contactstudy.solvers import conjugate_gradients as preconditioned_cg
from contactstudy.solvers.solve import ReportingSolver
from tests.conftest import LineContact
from tests.contactstudy.domain import host_gpu
from tests.contactstudy.solvers.test_preconditioned_cg import problem

# The strict one has nothing beyond the array API standard, so that no call of numpy's alone is left.
LIBRARIES = ["array_api_strict", "array_api_compat.torch"]


@dataclass(frozen=True)
class Library:
    """Library of the array API standard (2024.12) whose arrays are on this machine's processor.

    `arrays` is its namespace. Its arrays can be changed in place, and slices of them are views.
    """

    arrays: Namespace

    @property
    def available_bytes(self) -> float:
        return available_bytes()

    def to_device(self, field: np.ndarray) -> np.ndarray:
        return cast(np.ndarray, self.arrays.asarray(field, copy=True))

    def to_numpy(self, field: np.ndarray) -> np.ndarray:
        return np.array(np.from_dlpack(field))


STRICT = Library(import_module(LIBRARIES[0]))


def devices() -> Iterator[Device]:
    yield cs.Cpu(2)
    for name in LIBRARIES:
        if find_spec(name.partition(".")[0]) and find_spec(name.rpartition(".")[2]):
            yield Library(import_module(name))
    if host_gpu.COMPILER:
        yield host_gpu.HostGpu()
    try:
        yield cs.Gpu()
    except cs.InvalidInput:
        return


def name(device: Device) -> str:
    if isinstance(device, cs.Cpu | host_gpu.HostGpu):
        return type(device).__name__
    return str(getattr(device.arrays, "__name__", device))


@pytest.fixture(autouse=True)
def _size_of_strict_arrays_is_a_method(monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is of PyTorch's, which are not everywhere."""
    strict = type(STRICT.arrays.asarray(0.0))
    monkeypatch.setattr(strict, "size", lambda array: array._array.size)


on_every_device = pytest.mark.parametrize("device", list(devices()), ids=name)

BOTH = cs.ExactPeriodicity(), cs.ExactPeriodicity()
FREE = cs.ZeroPadding(), cs.ZeroPadding()
GRIDS: dict[str, tuple[tuple[int, int], cs.Padding | cs.Paddings]] = {
    "semi-periodic": ((64, 48), cs.ExactPeriodicity()),
    "doubly periodic": ((64, 64), BOTH),
    "free": ((36, 40), FREE),
    "some images": ((33, 40), cs.Superposition(2)),
    "circular images": ((40, 33), cs.CircularSuperposition(2)),
    "odd": ((37, 51), BOTH),
    "odd, free along x": ((45, 31), (cs.ZeroPadding(), cs.ExactPeriodicity())),
    "one row along": ((129, 1), cs.ExactPeriodicity()),
}


def rough(
    contact: LineContact,
    cells: tuple[int, int],
    padding: cs.Padding | cs.Paddings,
    hardness: float | None,
) -> cs.Problem:
    """A rough contact with a hardness over Hertz's peak pressure."""
    posed = problem(contact, cells, "30 %", padding)
    if hardness is None:
        return posed
    limit = cs.HardnessLimited(hardness * contact.hertz.peak_pressure)
    return replace(posed, constraint=limit)


@on_every_device
@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("hardness", [None, 0.8])
def test_a_rough_contact_is_the_same(
    grid: str, hardness: float | None, device: Device, line_contact: LineContact
) -> None:
    cells, padding = GRIDS[grid]
    posed = rough(line_contact, cells, padding, hardness)
    ours, other = (cs.solve(posed, tolerance=1e-10, device=each) for each in (cs.Cpu(), device))
    agree(ours, other, 1e-10)
    assert other.status is ours.status
    if hardness is not None:
        assert np.count_nonzero(other.pressure == other.pressure.max()) > 1


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
def test_single_precision_reaches_what_it_can(device: Device, line_contact: LineContact) -> None:
    posed = problem(line_contact, 64, "80 %")
    ours = cs.solve(posed, tolerance=1e-10)
    other = cs.solve(posed, tolerance=1e-5, precision="single", device=device)
    assert other.status is cs.Status.CONVERGED
    agree(ours, other, 1e-5)


@on_every_device
def test_a_warm_start_needs_its_pressure_alone(device: Device, line_contact: LineContact) -> None:
    posed = problem(line_contact, 48, "80 %", BOTH)
    ours = cs.solve(posed, tolerance=1e-10)
    begin = ours.pressure.copy()
    again = cs.solve(posed, tolerance=1e-8, start=begin, device=device)
    assert again.iterations == 0
    np.testing.assert_array_equal(begin, ours.pressure)
    agree(ours, again, 1e-8)


@on_every_device
@pytest.mark.parametrize("solver", [cs.PolonskyKeer(), cs.PreconditionedCG()], ids=str)
def test_a_given_approach_is_the_same(solver: cs.Solver, device: Device, line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, load=cs.Approach(2e-6))
    posed = scene.problem(line_contact.grid(32, 1.2), cs.ExactPeriodicity())
    ours, other = (cs.solve(posed, tolerance=1e-9, solver=solver, device=each) for each in (cs.Cpu(), device))
    agree(ours, other, 1e-9)


@on_every_device
def test_a_contact_with_friction_is_the_same(device: Device, line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, friction=cs.PartialSlip(0.3, 1.2e4))
    posed = scene.problem(line_contact.grid((64, 1), 2.4), cs.ExactPeriodicity())
    ours, other = (cs.solve(posed, device=each) for each in (cs.Cpu(), device))
    scale = ours.pressure.max()
    # two contacts of one operator, each to the tolerance
    np.testing.assert_allclose(other.shear, ours.shear, rtol=0, atol=2 * 10 * 64 * 1e-8 * scale)


@on_every_device
def test_a_report_gets_numpy_arrays(device: Device, line_contact: LineContact) -> None:
    posed = problem(line_contact, 32, "smooth")
    seen: list[Array] = []
    found = cs.solve(posed, device=device, solver=ReportingSolver(lambda _, p: seen.append(p.copy())))
    assert {type(one) for one in seen} == {np.ndarray}
    np.testing.assert_array_equal(seen[-1] * posed.scales.pressure, found.pressure)


needs_compiler = pytest.mark.skipif(host_gpu.COMPILER is None, reason="no C++ compiler is here")


@needs_compiler
@pytest.mark.parametrize("grid", ["semi-periodic", "doubly periodic", "free"])
def test_the_coarser_grids_of_large_contacts_on_a_gpu_give_the_same(
    grid: str, line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    smaller = replace(approximate_inverse.CONSTANTS, min_gpu_cells=1)
    monkeypatch.setattr(approximate_inverse, "CONSTANTS", smaller)
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
    emulated = tmp_path / "loops_emulated.cu"
    emulated.write_text(source.replace(shared, own), encoding="utf-8")
    program = Path(__file__).with_name("emulate.cpp")
    options = "-O1", "-std=c++20", "-pthread", "-DREAL=double", "-DPRE=double", f"-I{tmp_path}"
    made = tmp_path / "emulate"
    compiler = str(host_gpu.COMPILER)
    subprocess.run([compiler, *options, str(program), "-o", str(made)], check=True)
    subprocess.run([str(made)], check=True)


class Spring:
    work, own, blocks = 1.0, 1.0, (1, 1)

    def scaled(self, factor: float, precision: Precision) -> "Spring":
        return self


def test_an_operator_of_one_s_own_is_refused(line_contact: LineContact) -> None:
    posed = replace(problem(line_contact, 8, "smooth"), operator=Spring())  # type: ignore[arg-type]
    with pytest.raises(cs.InvalidInput, match=r"^solve\.device is .* of your own .*, give Cpu\(\)\.$"):
        cs.solve(posed, device=STRICT)


def test_what_the_device_has_no_room_for_is_refused(line_contact: LineContact, monkeypatch: pytest.MonkeyPatch) -> None:
    posed = problem(line_contact, (8, 4), "smooth", BOTH)
    # 14 fields of 32 cells, and as many as 4 of the transforms, of 8 bytes each
    monkeypatch.setattr(Library, "available_bytes", 18 * 32 * 8)
    cs.solve(posed, device=STRICT)
    monkeypatch.setattr(Library, "available_bytes", 18 * 32 * 8 - 1)
    with pytest.raises(cs.InvalidInput, match=r"needs 4\.61e-06 GB and it has 4\.61e-06 GB left"):
        cs.solve(posed, device=STRICT)
    cs.solve(posed, device=STRICT, precision="single")


class NoDriverError(Exception):
    pass


def no_driver() -> int:
    raise NoDriverError("no driver")


def test_a_gpu_says_its_memory_and_without_one_or_cupy_one_sentence_is_raised(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "array_api_compat.cupy", STRICT.arrays)  # type: ignore[arg-type]
    runtime = SimpleNamespace(CUDARuntimeError=NoDriverError, memGetInfo=lambda: (1000, 10**6))
    pool = SimpleNamespace(free_bytes=lambda: 24)
    cupy: Any = SimpleNamespace(cuda=SimpleNamespace(runtime=runtime), get_default_memory_pool=lambda: pool)
    monkeypatch.setitem(sys.modules, "cupy", cupy)
    runtime.getDeviceCount = lambda: 1
    # what is free, and what CuPy keeps
    assert cs.Gpu().available_bytes == 1024
    for count in (lambda: 0, no_driver):
        runtime.getDeviceCount = count
        with pytest.raises(cs.InvalidInput, match=r"^Gpu found no GPU.*: give Cpu\(\)"):
            cs.Gpu()
    monkeypatch.setitem(sys.modules, "cupy", None)  # type: ignore[arg-type]
    with pytest.raises(cs.InvalidInput, match=r"^Gpu needs CuPy, .*: pip install .*, or give"):
        cs.Gpu()
