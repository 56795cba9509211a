"""A stand-in for a GPU on the processor: the kernels of loops.cu made by a C++ compiler, cuFFT's plans by numpy."""

import ctypes
import shutil
import subprocess
import tempfile
from functools import cache, partial
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from contactstudy.domain.device import Cpu, Namespace, available_bytes
from contactstudy.domain.loops import gpu
from contactstudy.elasticity import transforms

COMPILER = shutil.which("g++")
NAMES = {"d": "double", "f": "float"}


@cache
def library(real: str, preconditioner: str) -> Any:
    """Return the kernels for fields of these types, one thread each."""
    assert COMPILER is not None
    made = Path(tempfile.mkdtemp()) / "loops.so"
    types = f"-DREAL={NAMES[real]}", f"-DPRE={NAMES[preconditioner]}"
    options = "-O1", "-std=c++17", "-shared", "-fPIC", "-x", "c++", "-DSERIAL"
    source = str(gpu.SOURCE)
    subprocess.run([COMPILER, *options, *types, source, "-o", str(made)], check=True)
    return ctypes.CDLL(str(made))


def launch(name: str, *arguments: Any, results: int = 0) -> np.ndarray:
    """Run a kernel on the processor, as :func:`gpu.launch` does on a GPU."""
    real, preconditioner, cells, columns = gpu.types_and_cells(arguments)
    out = np.full(gpu.MAX_SUMS, np.nan)
    values: list[Any] = [ctypes.c_longlong(cells), ctypes.c_longlong(columns)]
    for argument in arguments:
        if isinstance(argument, np.ndarray):
            assert argument.flags.c_contiguous, name
            values.append(ctypes.c_void_p(argument.ctypes.data))
        else:
            values.append(ctypes.c_double(argument))
    kernel = getattr(library(real, preconditioner), name)
    kernel(*values, None, ctypes.c_void_p(out.ctypes.data))
    return out[:results, None]


class Loops:
    def __getattr__(self, name: str) -> Any:
        return partial(launch, name)


class PlanNd:
    """Strided batches as cuFFT's ``cufftMakePlanMany`` defines them, not normalised."""

    def __init__(self, shape: tuple[int, ...], *layout: Any) -> None:
        self.shape = shape
        (
            self.into, self.stride_in, self.distance_in, self.out, self.stride_out,
            self.distance_out, self.kind, self.batch, *_,
        ) = layout  # fmt: skip

    def fft(self, field: np.ndarray, out: np.ndarray, direction: int) -> None:
        waves = (*self.shape[:-1], self.shape[-1] // 2 + 1)
        axes = tuple(range(1, len(self.shape) + 1))
        to_waves, to_field = self.kind[0] in "RD", self.kind[2] in "RD"
        source = self._batches(field, self.into, self.stride_in, self.distance_in, waves if to_field else self.shape)
        target = self._batches(out, self.out, self.stride_out, self.distance_out, waves if to_waves else self.shape)
        if to_waves:
            target[...] = np.fft.rfftn(source, axes=axes)
        elif to_field:
            target[...] = np.fft.irfftn(source, self.shape, axes=axes, norm="forward")
        elif direction == transforms.FORWARD:
            target[...] = np.fft.fftn(source, axes=axes)
        else:
            target[...] = np.fft.ifftn(source, axes=axes, norm="forward")

    def _batches(
        self, array: np.ndarray, embedded: tuple[int, ...], stride: int, distance: int,
        shape: tuple[int, ...],
    ) -> np.ndarray:  # fmt: skip
        assert array.flags.c_contiguous
        steps = distance, *(stride * prod(embedded[axis + 1 :]) for axis in range(len(shape)))
        counts = self.batch, *shape
        last = sum((count - 1) * step for count, step in zip(counts, steps, strict=True))
        assert last < array.size
        sizes = [step * array.itemsize for step in steps]
        return np.lib.stride_tricks.as_strided(array.reshape(-1), counts, sizes)


class Library:
    """The part of CuPy's interface to cuFFT that is used."""

    PlanNd = PlanNd

    def __getattr__(self, name: str) -> str:
        return name.removeprefix("CUFFT_")


class HostGpu:
    """Device whose loops and transforms are those of a GPU."""

    loops = Loops()

    def __init__(self) -> None:
        transforms.cufft = Library  # type: ignore[assignment]

    @property
    def arrays(self) -> Namespace:
        return Cpu().arrays

    @property
    def available_bytes(self) -> float:
        return available_bytes()

    def to_device(self, field: np.ndarray) -> np.ndarray:
        return np.array(field, order="C")

    def to_numpy(self, field: np.ndarray) -> np.ndarray:
        return np.asarray(field)
