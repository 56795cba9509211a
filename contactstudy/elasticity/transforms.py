"""Real Fourier transforms of a zero-padded field (x, y); rows of zeros are not transformed. On a GPU cuFFT is called.

A field (nx, ny) is padded with zeros to (px, py) points; its Fourier coefficients are (px, py // 2 + 1), since those of
negative wave numbers along y are conjugate. :func:`transforms` returns the pair for the device in use: :class:`Ducc` by
ducc0, :class:`CuFft` by cuFFT, or the plain :class:`Transforms` of the device's array library.

ducc0 is used, the fastest of three libraries, and numpy where it is missing. Convolutions of 512 x 512 to 1024 x 1024
cells on one thread (AMD EPYC) take scipy 1.3 to 1.8 times as long, FFTW (planned, measured) 1.0 to 1.2 times. All three
agree to 6e-16.
"""

import os
from functools import cache, lru_cache
from importlib import import_module
from importlib.util import find_spec
from math import prod
from operator import imul
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray
from scipy import fft

from contactstudy.domain.device import Cpu, arrays, device, threads
from contactstudy.domain.grid import Array, compiled_loops, device_loops, first_cells, in_blocks

ComplexField = NDArray[np.complexfloating[Any, Any]]
# Number of cells or points (x, y).
Cells = tuple[int, int]
# Array (px, py // 2 + 1) that a transform may overwrite, or None for a new one.
Work = ComplexField | None
# Transforms of fewer numbers, which take less than 0.3 ms, run on one thread: waking others takes longer than it saves.
MIN_THREADED = 2**16


class Transforms:
    """Pair of transforms by the device's array library; subclasses call other libraries.

    A subclass may write Fourier coefficients into the given `work` array; this class makes new ones.
    """

    def forward(self, field: Array, padded: Cells, work: Work = None) -> ComplexField:
        """Return the Fourier coefficients (px, py // 2 + 1) of `field` (nx, ny), padded with zeros.

        The field is transformed along y on its own rows, then along x.
        """
        library = _fft_library()
        waves: ComplexField = library.fft(library.rfft(field, n=padded[1], axis=1), n=padded[0], axis=0)
        return waves

    def backward(self, waves: ComplexField, cells: Cells, padded: Cells) -> Array:
        """Return the first (nx, ny) cells of the field with the Fourier coefficients `waves`, which may be overwritten.

        The coefficients are transformed along x, then along y on the rows of the field alone.
        """
        library = _fft_library()
        rows = library.ifft(waves, axis=0)[: cells[0], :]
        return first_cells(library.irfft(rows, n=padded[1], axis=1), cells)

    def convolved(self, field: Array, factors: Array, padded: Cells, work: Work) -> Array:
        """Return `field` (nx, ny), padded with zeros, with its Fourier coefficients multiplied by `factors`."""
        waves = self.forward(field, padded, work)
        scale(waves, factors)
        return self.backward(waves, (field.shape[0], field.shape[1]), padded)

    def filtered(self, field: Array, factors: Array, work: ComplexField | None) -> Array:
        """Return `field` (nx, ny), periodic along both axes, with its Fourier coefficients multiplied by `factors`."""
        return self.convolved(field, factors, (field.shape[0], field.shape[1]), work)


def _fft_library() -> Any:
    """Return the transforms of the device's array library."""
    return np.fft if isinstance(device(), Cpu) else arrays().fft


class Ducc(Transforms):
    """Transforms by ducc0.fft, on the threads of the device, into the work array."""

    def __init__(self) -> None:
        # optional, and without type stubs
        ducc0: Any = import_module("ducc0")
        self._fft, self._misc = ducc0.fft, ducc0.misc
        self._lock, self._widened = Lock(), False

    def _threads(self, size: int) -> int:
        """Return the threads for `size` numbers, and widen ducc0's pool the first time that there are more than one.

        ducc0 silently takes no more than ``OMP_NUM_THREADS`` allows. The pool must not change while its threads work.
        """
        count = threads() if size > MIN_THREADED else 1
        if count > 1 and not self._widened:
            with self._lock:
                if not self._widened and hasattr(self._misc, "resize_thread_pool"):
                    pool_size = self._misc.thread_pool_size()
                    self._misc.resize_thread_pool(max(os.cpu_count() or 1, pool_size))
                self._widened = True
        return count

    def forward(self, field: Array, padded: Cells, work: Work = None) -> ComplexField:
        """Return the Fourier coefficients of `field`: along y on the rows of the field, then along x."""
        nx, ny = field.shape
        if work is None:
            work = np.empty((padded[0], padded[1] // 2 + 1), dtype=np.result_type(field, 1j))
        if padded[1] == 1:  # the transform of one cell is the cell itself
            work[:nx] = field
        else:
            if ny < padded[1]:
                wide = np.zeros((nx, padded[1]), dtype=field.dtype)
                wide[:, :ny] = field
                field = wide
            self._fft.r2c(field, axes=(1,), out=work[:nx], nthreads=self._threads(field.size))
        work[nx:] = 0
        self._fft.c2c(work, axes=(0,), out=work, nthreads=self._threads(work.size))
        return work

    def backward(self, waves: ComplexField, cells: Cells, padded: Cells) -> Array:
        """Return the field with the Fourier coefficients `waves`: along x, then along y on the rows of the field."""
        count = self._threads(waves.size)
        # inorm=2: ducc0 divides by the number of points
        self._fft.c2c(waves, axes=(0,), forward=False, inorm=2, out=waves, nthreads=count)
        rows = waves[: cells[0]]
        if padded[1] == 1:
            return rows.real.copy()
        if _c2r_is_slow(rows, padded[1]):
            field = fft.irfft(rows, padded[1], axis=1, overwrite_x=True, workers=threads())
        else:
            field = self._fft.c2r(rows, axes=(1,), lastsize=padded[1], forward=False, inorm=2, nthreads=count)
        return np.ascontiguousarray(field[:, : cells[1]])

    def filtered(self, field: Array, factors: Array, work: ComplexField | None) -> Array:
        """Return a periodic `field` with its Fourier coefficients multiplied by `factors`, by one call each way."""
        count = self._threads(field.size)
        work = self._fft.r2c(field, axes=(0, 1), out=work, nthreads=count)
        scale(work, factors)
        if _c2r_is_slow(work, field.shape[1]):
            return self.backward(work, field.shape, field.shape)
        filtered: Array = self._fft.c2r(
            work,
            axes=(0, 1),
            lastsize=field.shape[1],
            forward=False,
            inorm=2,
            nthreads=count,
            allow_overwriting_input=True,
        )
        return filtered


def _c2r_is_slow(waves: ComplexField, along: int) -> bool:
    """Return whether ducc0 takes longer than scipy to transform `waves` to rows of `along` numbers.

    With ducc0 0.42 it takes twice as long in single precision for more than 512 numbers, and less in double precision.
    """
    return waves.dtype == np.complex64 and along > 512


# Number of cuFFT's plans that are kept, with their work areas: those of all grids of two solves.
MAX_PLANS = 48
# cuFFT's directions of a transform.
FORWARD, INVERSE = -1, 1


class Kinds(NamedTuple):
    """Names in cuFFT of the transforms of one precision, such as "D2Z", and its types of numbers."""

    real_to_complex: str
    complex_to_complex: str
    complex_to_real: str
    complex: DTypeLike
    real: DTypeLike


DOUBLE = Kinds("D2Z", "Z2Z", "Z2D", np.complex128, np.float64)
SINGLE = Kinds("R2C", "C2C", "C2R", np.complex64, np.float32)


def kinds_of(field: Array | ComplexField) -> Kinds:
    """Return the kinds of transforms for a field or its waves."""
    return DOUBLE if field.dtype.char in "dD" else SINGLE


@cache
def cufft() -> Any:
    """Return CuPy's interface to cuFFT."""
    return import_module("cupy.cuda.cufft")


@lru_cache(MAX_PLANS)
def _plan(kind: str, shape: tuple[int, ...], batch: int, *, by_row: bool) -> Any:
    """Return cuFFT's plan for a `batch` of transforms of a `kind` of fields of one `shape`.

    The fields lie one after another (`by_row`), or are the columns of one array. `kind` is a name of :class:`Kinds`.
    """
    library = cufft()
    waves = (*shape[:-1], shape[-1] // 2 + 1)
    into, out = (shape if numbers in "RD" else waves for numbers in (kind[0], kind[2]))
    # of the input, then of the output: its shape, the distance of neighbours along the last axis, and that of fields;
    # after the batch come the memory order, the last axis, and a size that is not needed
    layout = (into, 1, prod(into), out, 1, prod(out)) if by_row else (shape, batch, 1, shape, batch, 1)
    code = getattr(library, f"CUFFT_{kind}")
    return library.PlanNd(shape, *layout, code, batch, "C", len(shape) - 1, None)


class CuFft(Transforms):
    """Transforms by cuFFT, along y on the rows of the field alone, then along x in place, without passes over zeros.

    cuFFT does not normalise: the inverse is too large by the number of points, which :meth:`convolved` and
    :meth:`filtered` divide the factors by.
    """

    def convolved(self, field: Array, factors: Array, padded: Cells, work: Work) -> Array:
        """Return `field` (nx, ny), padded with zeros, with its Fourier coefficients multiplied by `factors`."""
        cells = field.shape[0], field.shape[1]
        if cells == padded:
            return self.filtered(field, factors, work)
        waves = self.forward(field, padded)
        device_loops().scale(waves, factors, 1 / prod(padded))
        return self.backward(waves, cells, padded)

    def filtered(self, field: Array, factors: Array, work: Work) -> Array:
        """Return `field` (nx, ny), periodic along both axes, with its Fourier coefficients multiplied by `factors`."""
        xp, shape, kinds = arrays(), (field.shape[0], field.shape[1]), kinds_of(field)
        waves = xp.empty((shape[0], shape[1] // 2 + 1), dtype=kinds.complex)
        _plan(kinds.real_to_complex, shape, 1, by_row=True).fft(field, waves, FORWARD)
        device_loops().scale(waves, factors, 1 / prod(shape))
        filtered = xp.empty_like(field)
        _plan(kinds.complex_to_real, shape, 1, by_row=True).fft(waves, filtered, INVERSE)
        return filtered

    def forward(self, field: Array, padded: Cells, work: Work = None) -> ComplexField:
        """Return the Fourier coefficients (px, py // 2 + 1) of `field` (nx, ny), padded with zeros."""
        xp, (nx, ny), (px, py), kinds = arrays(), field.shape, padded, kinds_of(field)
        if py > ny:
            wide = xp.zeros((nx, py), dtype=field.dtype)
            wide[:, :ny] = field
            field = wide
        waves: Any = xp.empty((px, py // 2 + 1), dtype=kinds.complex)
        _plan(kinds.real_to_complex, (py,), nx, by_row=True).fft(field, waves, FORWARD)
        waves[nx:, :] = 0
        columns = _plan(kinds.complex_to_complex, (px,), py // 2 + 1, by_row=False)
        columns.fft(waves, waves, FORWARD)
        coefficients: ComplexField = waves
        return coefficients

    def backward(self, waves: ComplexField, cells: Cells, padded: Cells) -> Array:
        """Return px py times the first (nx, ny) cells of the field with the coefficients `waves`, overwriting them."""
        (nx, ny), (px, py), kinds = cells, padded, kinds_of(waves)
        columns = _plan(kinds.complex_to_complex, (px,), py // 2 + 1, by_row=False)
        columns.fft(waves, waves, INVERSE)
        field = arrays().empty((nx, py), dtype=kinds.real)
        _plan(kinds.complex_to_real, (py,), nx, by_row=True).fft(waves, field, INVERSE)
        return first_cells(field, (nx, ny))


STANDARD, CUFFT = Transforms(), CuFft()
# Transforms of numpy arrays, whatever the device in use.
TRANSFORMS = Ducc() if find_spec("ducc0") else STANDARD


def transforms() -> Transforms:
    """Return the transforms for arrays of the device in use."""
    if isinstance(device(), Cpu):
        return TRANSFORMS
    return STANDARD if device_loops() is None else CUFFT


def scale(waves: ComplexField, factors: Array) -> None:
    """Multiply Fourier coefficients `waves` by `factors`, one for each, in place."""
    loops = compiled_loops(waves.shape)
    if loops is None or factors.dtype.kind != "f":
        in_blocks(imul, waves, factors)
    else:
        loops.scale(waves, factors, 1.0)
