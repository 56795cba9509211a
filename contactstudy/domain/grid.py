"""The grid of cells over the width and one period of the length, its padding along both axes, and sums over its fields.

A field (x, y) has one number for each cell. Work on large fields is done in blocks of rows that fit into the cache of a
core, is shared between threads, or is left to compiled loops; its results do not depend on the number of threads.

For one axis a padding defines the ``window`` of periods whose pressure acts on a point. It also says whether the
convolution is circular (``wraps``, n points) or padded with zeros (2 n points). A line contact is usually unbounded
along x and periodic along y; either axis may take any padding.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from contextvars import copy_context
from functools import cache, partial
from importlib import import_module
from importlib.util import find_spec
from math import inf, isnan, nan, prod
from typing import Annotated, Any, ClassVar, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.device import Array as Array
from contactstudy.domain.device import Cpu, Numbers, arrays, device, threads, using
from contactstudy.domain.validation import InvalidInput, Limits, Metres, at_least, validated

S = TypeVar("S")  # what the work is shared by, such as blocks of rows
T = TypeVar("T")  # what it returns

# Cells in a block: six blocks of double precision fit into the cache of a core.
BLOCK_CELLS = 2**15
# From this number of cells on, compiled loops save more time in about a dozen solves than loading them takes.
MIN_COMPILED_CELLS = 2**14
# In rows of fewer cells, as of a line contact in plane strain, a compiled loop over each row is slower than numpy.
MIN_COMPILED_COLUMNS = 4
# Smallest number of cells for a thread: waking a thread takes as long as a loop over about 100 000 cells.
CELLS_PER_THREAD = 2**17


def in_blocks(work: Callable[..., T], *fields: Numbers) -> list[T]:
    """Call `work` on the same block of rows of all `fields` (x, y), for every block, and return the results in order.

    Blocks, and so sums over blocks, do not depend on the number of threads. `work` is called once with whole fields if
    they fit into one block, or are on a device that is not a :class:`Cpu`.
    """
    cells = prod(fields[0].shape)
    if cells <= BLOCK_CELLS or not isinstance(device(), Cpu):
        return [work(*fields)]

    def in_turn(blocks: Sequence[slice]) -> list[T]:
        return [work(*(field[block, :] for field in fields)) for block in blocks]

    blocks = _blocks(*fields[0].shape)
    return [result for part in _distributed(in_turn, blocks, cells) for result in part]


def equal(first: Array, second: Array) -> bool:
    """Return whether two fields (x, y) are the same."""
    if (loops := device_loops()) is not None:  # a GPU sums all parts: (1, 1)
        return bool(loops.differences(first, second, results=1)[0] == 0)
    return all(in_blocks(lambda one, other: bool(arrays().all(one == other)), first, second))


def in_threads(work: Callable[[slice], object], shape: tuple[int, ...]) -> None:
    """Call `work` in each thread on one part of the rows of a field of that `shape`.

    A part has an even number of rows, unless it is the last one, so that no block of 2 x 2 cells is cut.
    """
    rows, columns = shape

    def on_rows(pairs: Sequence[int]) -> object:
        return work(slice(pairs[0], min(pairs[-1] + 2, rows)))

    _distributed(on_rows, range(0, rows, 2), rows * columns)


def first_cells(field: Array, shape: tuple[int, ...]) -> Array:
    """Return the first cells of `field` along both axes, as many as `shape` says: the field itself, or else a copy."""
    if field.shape == shape:
        return field
    cells: Array = arrays().asarray(field[: shape[0], : shape[1]], copy=True)
    return cells


def replace_blocks(field: Array, new: Callable[[Array], Array]) -> Array:
    """Replace every block of `field` (x, y) by what `new` returns for it, in place, and return the field."""

    def replace(block: Array) -> None:
        block[...] = new(block)

    in_blocks(replace, field)
    return field


def _blocks(rows: int, columns: int) -> list[slice]:
    """Return the rows of each block of a field, an even number except in the last block."""
    step = max(2, BLOCK_CELLS // columns // 2 * 2)
    return [slice(begin, min(begin + step, rows)) for begin in range(0, rows, step)]


def _distributed(work: Callable[[Sequence[S]], T], items: Sequence[S], cells: int) -> list[T]:
    """Give each thread a part of the `items` of a field of that many `cells`, and return all results in order.

    The threads use no further ones and give no floating-point warnings, like the solve itself.
    """
    count = min(threads(), len(items), cells // CELLS_PER_THREAD)
    if count <= 1:
        return [work(items)]

    def in_thread(part: Sequence[S]) -> T:
        with using(Cpu()), np.errstate(all="ignore"):
            return work(part)

    size = -(-len(items) // count)
    parts = [items[begin : begin + size] for begin in range(0, len(items), size)]
    futures = [_pool(count - 1).submit(copy_context().run, in_thread, part) for part in parts[1:]]
    return [work(parts[0]), *(future.result() for future in futures)]


def compiled_loops(shape: tuple[int, ...]) -> Any:
    """Return compiled loops over fields of that `shape` (x, y); None if they are not installed or would not pay.

    ``loops.NAME(*arguments, results=n)`` runs one, where the first argument is a field. It returns the sums or maxima
    that it takes (n, parts), of parts of the field.
    """
    if (loops := device_loops()) is not None:
        return loops
    rows, columns = shape
    pays = rows * columns >= MIN_COMPILED_CELLS and columns >= MIN_COMPILED_COLUMNS
    return _loops() if pays and isinstance(device(), Cpu) else None


def device_loops() -> Any:
    """Return the loops of a device that has some of its own, as a GPU, else None."""
    return getattr(device(), "loops", None)


class ThreadedLoops:
    """Loops of a `module` compiled by numba, each called once in every thread with a part of the rows."""

    def __init__(self, module: Any) -> None:
        self._module = module

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a loop as a function of fields (x, y)."""
        run: Callable[..., Any] = _over_blocks if name in self._module.OVER_BLOCKS else _over_rows
        return partial(run, getattr(self._module, name))


def _over_rows(loop: Callable[..., object], *arguments: Any, results: int = 0) -> Array:
    """Run a `loop` over fields (x, y) and numbers, and return its results by row (`results`, x).

    It gets the thread's part of each field, other arguments as they are, and last, if it has `results`, that part of an
    array for them.
    """
    shape = arguments[0].shape
    values = np.empty((shape[0], results))

    def run(rows: slice) -> None:
        parts = [value[rows] if isinstance(value, np.ndarray) else value for value in arguments]
        loop(*parts, *([values[rows]] if results else []))

    in_threads(run, shape)
    return values.T


def _over_blocks(loop: Callable[..., object], field: Array, *arguments: Any) -> None:
    """Run a `loop` over blocks of 2 x 2 cells of a `field` (x, y); it gets the ends of a thread's rows of blocks."""
    rows, columns = field.shape
    in_threads(lambda part: loop(field, *arguments, part.start, part.stop), (rows // 2, 2 * columns))


@cache
def _loops() -> ThreadedLoops | None:
    """Return the loops compiled by numba; None if it is missing or does not work."""
    if find_spec("numba") is None:
        return None
    # raised by numba for another version of numpy, or without a folder for compiled code
    with suppress(ImportError, RuntimeError):
        return ThreadedLoops(import_module("contactstudy.domain.loops.compiled"))
    return None


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    """Return the pool of so many threads, which is kept, so that they are started once."""
    return ThreadPoolExecutor(threads, thread_name_prefix="contactstudy")


# Up to this many cells BLAS starts no threads, and sums in single precision are accurate without sums of rows.
MAX_FLAT_CELLS = 1024


def inner(a: Array, b: Array) -> float:
    """Return the sum of ``a b`` over two fields (x, y).

    It is taken row by row: BLAS would start threads for a whole large field, which on a busy machine cost a hundred
    times the time they save.
    """
    return sum(in_blocks(dot, a, b))


def dot(a: Array, b: Array) -> float:
    """Return the sum of ``a b`` over one block of two fields."""
    xp = arrays()
    if prod(a.shape) <= MAX_FLAT_CELLS:
        return float(xp.vecdot(xp.reshape(a, (-1,)), xp.reshape(b, (-1,))))
    return float(xp.sum(xp.vecdot(a, b)))


def total(field: Array) -> float:
    """Return the sum over a field (x, y)."""
    return sum(in_blocks(lambda block: float(arrays().sum(block)), field))


def max_abs(field: Array) -> float:
    """Return the largest absolute value in a field (x, y); nan if one is nan."""
    xp = arrays()
    sizes = in_blocks(lambda block: max(float(xp.max(block)), -float(xp.min(block))), field)
    return nan if isnan(sum(sizes)) else max(sizes)


def mean_over(active: Array, field: Array) -> float:
    """Return the mean of `field` over the cells in which `active` is 1; `active` is 0 in the others."""
    return inner(field, active) / total(active)


def matrix_product(a: Array, b: Array) -> Array:
    """Return the matrix product of two numpy arrays, row by row.

    BLAS would start threads for it, which on a busy machine cost a hundred times the time they save.
    """
    return np.asarray(np.matmul(a[:, None], b)[:, 0])


# Largest length of a cell over its width: beyond it the coefficients of the displacement, differences of logarithms of
# the corners of a cell, are lost in rounding. Largest width over length: beyond it the images of a cell along the
# length, which are then summed one by one, take minutes.
LONGEST_CELL, WIDEST_CELL = 1e9, 1e6


@validated
class Grid:
    """Grid of equal rectangular cells, centred on the origin.

    x runs across the contact line, in the direction of motion (longitudinal), y along the line (lateral). Fields are
    constant in a cell and have the shape (nx, ny).

    Parameters
    ----------
    cells
        Number of cells (nx, ny), across and along; ``ny = 1`` with :class:`ExactPeriodicity` along is
        plane strain.
    extent
        Width and length (across, along) [m]; the length is a period where the axis is periodic.

    Raises
    ------
    InvalidInput
        If there are fewer than two cells across or none along, or if the extent is no positive length; for cells more
        than 1e9 times as long as wide, whose influence coefficients would be lost in rounding, or more than 1e6 times
        as wide as long, whose coefficients would take minutes.
    """

    cells: tuple[Annotated[int, at_least(2)], Annotated[int, at_least(1)]]
    extent: tuple[Metres, Metres]

    def check_together(self) -> None:
        """Check the ratio of the sides of a cell."""
        aspect_ratio = self.cell_size[1] / self.cell_size[0]
        if not 1 / WIDEST_CELL <= aspect_ratio <= LONGEST_CELL:
            raise InvalidInput(
                f"Grid.extent is {self.extent!r}: give lengths whose cells are at most {LONGEST_CELL:g} times as long "
                f"as wide, and {WIDEST_CELL:g} times as wide as long; these are {aspect_ratio:g} times as long."
            )

    @property
    def cell_size(self) -> tuple[float, float]:
        """Sides of a cell (dx, dy) [m]."""
        return self.extent[0] / self.cells[0], self.extent[1] / self.cells[1]

    @property
    def cell_area(self) -> float:
        """Area of a cell, dx dy [m^2]."""
        return self.cell_size[0] * self.cell_size[1]

    @property
    def length(self) -> float:
        """Extent along the length [m]."""
        return self.extent[1]

    @property
    def x(self) -> Array:
        """Cell centres across the width, shape (nx,) [m], antisymmetric to the last bit."""
        return _centres(self.cells[0], self.cell_size[0])

    @property
    def y(self) -> Array:
        """Cell centres along the length, shape (ny,) [m], antisymmetric to the last bit."""
        return _centres(self.cells[1], self.cell_size[1])


def _centres(count: int, step: float) -> Array:
    """Return the centres of `count` cells of size `step`, antisymmetric to the last bit."""
    return np.asarray((2 * np.arange(count) - (count - 1)) * (step / 2))


class Padding(Protocol):
    """Boundary condition of one axis: which images of the pressure act on a point, and whether the axis is periodic."""

    @property
    def wraps(self) -> bool:
        """True if the convolution along this axis is circular."""

    @property
    def window(self) -> range | None:
        """Periods whose pressure acts on a point, relative to its own (0); None for all of them.

        The image in period m is at the offset ``d + m L``. L is the length of the axis; d, the offset in period 0, is
        from 0 to L where the axis wraps.
        """

    def reach(self, period: float) -> float:
        """Return the distance to each side whose pressure acts on a point in the middle, in the unit of `period`."""


class _Windowed:
    """Padding whose reach is that of its window of periods."""

    window: ClassVar[range | None]

    def reach(self, period: float) -> float:
        """Return half the length of the window; infinity where all periods act."""
        return inf if self.window is None else len(self.window) * period / 2


@validated
class ZeroPadding(_Windowed):
    """Padding with zeros, the classical DC-FFT: no images, not periodic (Liu, Wang & Liu 2000)."""

    wraps: ClassVar[bool] = False
    window = range(1)


@validated
class DuplicatedPadding(_Windowed):
    """Padding with a copy of the pressure in the padded half of the axis, in place of zeros.

    The pressure within one period to either side then acts on every point. The doubled transform equals a circular one
    with the folded coefficients ``K(d) + K(d - L)``, which is used here: ``K(d)`` is the displacement at the distance
    ``d`` from a loaded cell, and ``L`` the length of the axis. The coefficient ``K(L)``, which the wrap-around order of
    the transform leaves open, is kept and not set to zero. The window therefore covers half a cell more on one side of
    a point than on the other, which matters with few cells along.
    """

    wraps: ClassVar[bool] = True
    window = range(-1, 1)


# The displacement of so many images is that of ExactPeriodicity to five digits, and each one is summed.
MAX_IMAGES = 10_000
Images = Annotated[
    int,
    Limits(f"from 0 to {MAX_IMAGES}, since each is summed; all are ExactPeriodicity()", lambda x: 0 <= x <= MAX_IMAGES),
]


class _Counted(_Windowed):
    """Padding with a number of images on each side; the subclass says whether of the domain or of each point."""

    images: int

    @property
    def window(self) -> range:  # type: ignore[override]
        """Periods whose pressure acts on a point, `images` on each side."""
        return range(-self.images, self.images + 1)


@validated
class Superposition(_Counted):
    """Padding with zeros, and coefficients summed over images on each side.

    The window of images is centred on the domain and not on each point, so that points near the ends of the domain
    see more pressure on one side.

    Parameters
    ----------
    images
        Number of periods on each side, from 0 to 10000; 0 is :class:`ZeroPadding`.
    """

    wraps: ClassVar[bool] = False
    images: Images


@validated
class CircularSuperposition(_Counted):
    """Periodic axis with coefficients summed over images on each side of every point.

    The pressure within ``images + 1/2`` periods to either side acts on every point, so a uniform contact stays uniform,
    with a transform of half the size of :class:`Superposition`. This is how semi-periodic contacts are computed in
    ContactMechanics (with 10 images) and slippy.

    Parameters
    ----------
    images
        Number of periods on each side, from 0 to 10000.
    """

    wraps: ClassVar[bool] = True
    images: Images


@validated
class ExactPeriodicity(_Windowed):
    """Periodic axis with the sum over infinitely many images, in closed form.

    The displacement under infinitely many loads is finite only up to a rigid displacement. Along one axis it counts from
    a point at the distance ``Scene.datum`` from a load, for a cylinder twice its radius; along both axes from its mean.
    """

    wraps: ClassVar[bool] = True
    window = None


# The padding across the width and the padding along the length.
Paddings = tuple[Padding, Padding]


def is_free(padding: Padding) -> bool:
    """Return whether the surface continues beyond the domain without pressure on it."""
    return not padding.wraps and padding.window is not None and len(padding.window) == 1


def across_and_along(padding: Padding | Paddings) -> Paddings:
    """Return the paddings of both axes, (across, along).

    Parameters
    ----------
    padding
        Padding of the length, with ZeroPadding across, or a tuple of two.

    Raises
    ------
    InvalidInput
        If it is neither.
    """
    both = padding if isinstance(padding, tuple) else (ZeroPadding(), padding)
    if len(both) != 2 or any(isinstance(axis, type) or not hasattr(axis, "window") for axis in both):
        raise InvalidInput(
            f"padding is {padding!r}: give one for the length, such as ExactPeriodicity(), or a "
            "tuple of two, (across, along)."
        )
    return both


def cells_text(cells: tuple[int, ...]) -> str:
    """Return numbers of cells, across and along, such as "128 x 96 cells"."""
    return f"{' x '.join(map(str, cells))} cells"


def on_cells(field: Array, cells: tuple[int, int]) -> Array:
    """Return the means of a field over the cells of another grid of the same extent.

    Parameters
    ----------
    field
        Values (x, y), constant in each cell.
    cells
        Number of cells (across, along) of the other grid.
    """
    for axis, count in enumerate(cells):
        along = axis_first(field, axis)
        present = len(along)
        if count % present == 0:
            along = np.repeat(along, count // present, axis=0)
        elif present % count == 0:
            merged = present // count
            along = sum((along[k::merged] for k in range(1, merged)), start=along[::merged]) / merged
        else:
            # the integral up to each border of the new cells, which is linear inside a given cell
            sums = np.concatenate([np.zeros((1, along.shape[1])), np.cumsum(along, axis=0)])
            border = np.arange(count + 1) * (present / count)
            full_cells = np.minimum(border.astype(int), present - 1)
            integral = sums[full_cells] + (border - full_cells)[:, None] * along[full_cells]
            along = np.diff(integral, axis=0) * (count / present)
        field = axis_first(along, axis)
    return field


def axis_first(field: Array, axis: int) -> Array:
    """Return a `field` (x, y) with its `axis` first; done twice, it is the field again."""
    return field.T if axis else field


def edge_fraction(touching: NDArray[np.bool_]) -> float:
    """Return the fraction of the `touching` cells (x, y) with a neighbour that does not touch; zero without any.

    Cells at opposite ends of the grid are neighbours.
    An area counted in whole cells may be the same on several grids and still be wrong by these cells.
    """
    inside = touching.copy()
    for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
        inside &= np.roll(touching, step, axis)
    return float(1 - inside.sum() / touching.sum()) if touching.any() else 0.0
