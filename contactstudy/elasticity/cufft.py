"""Real Fourier transforms of a zero-padded field on a GPU, by plans of cuFFT that are kept."""

from functools import cache, lru_cache
from importlib import import_module
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.device import arrays
from contactstudy.domain.fields import Array, device_loops, first_cells
from contactstudy.elasticity.transforms import Cells, ComplexField, Transforms, Work

# Plans that are kept, with their work areas: those of the grids of two solves.
MAX_PLANS = 48
FORWARD, INVERSE = -1, 1


class Kinds(NamedTuple):
    """Names in cuFFT of the transforms of a precision, and its types of numbers."""

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
    """Return the plan of a `batch` of transforms of fields of that `shape`, rows of an array or columns."""
    library = cufft()
    waves = (*shape[:-1], shape[-1] // 2 + 1)
    into, out = (shape if numbers in "RD" else waves for numbers in (kind[0], kind[2]))
    layout = (
        (into, 1, prod(into), out, 1, prod(out)) if by_row else (shape, batch, 1, shape, batch, 1)
    )
    code = getattr(library, f"CUFFT_{kind}")
    return library.PlanNd(shape, *layout, code, batch, "C", len(shape) - 1, None)


class CuFft(Transforms):
    """Transforms without passes over rows of zeros; not normalised, so that factors are.

    They are taken along y on the rows of the field alone, then along x in place.
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
        """Return the first (nx, ny) cells of the field with the Fourier coefficients `waves`, which is overwritten."""
        (nx, ny), (px, py), kinds = cells, padded, kinds_of(waves)
        columns = _plan(kinds.complex_to_complex, (px,), py // 2 + 1, by_row=False)
        columns.fft(waves, waves, INVERSE)
        field = arrays().empty((nx, py), dtype=kinds.real)
        _plan(kinds.complex_to_real, (py,), nx, by_row=True).fft(waves, field, INVERSE)
        return first_cells(field, (nx, ny))


CUFFT = CuFft()
