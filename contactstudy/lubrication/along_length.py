"""The linear system of a step where the film varies along its length: GMRES with two stages of preconditioning.

The Fourier stage solves the system with all coefficients averaged over the length, wave by wave, which knows how distant
cells act on each other. The line stage then solves what is left line by line downstream, with the coefficients as they
are and a mere remainder of elasticity, which knows how conductance varies by orders of magnitude from cell to cell.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib import import_module

import numpy as np
from scipy import fft
from scipy.linalg import solve_banded
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator, SuperLU, gmres, splu

from contactstudy.domain.fields import Array
from contactstudy.elasticity.convolution import Convolution
from contactstudy.lubrication.film_equation import Film, Linearised, Mask, neighbour
from contactstudy.lubrication.pseudo_time import ActiveSets, FilmStep


@dataclass(frozen=True)
class KrylovTuning:
    """Tuning constants of the linear solver, chosen by counts of iterations on rough films of 64^2 to 256^2 cells.

    Attributes
    ----------
    reached, missed
        Linear residual where GMRES stops (0.1 costs steps), and above which a step is refused.
    basis, restarts
        Length of the basis of GMRES, and restarts.
    waves
        Waves along the length that the Fourier stage knows: further ones change no count.
    film_part, own_part
        What the local stage has of elasticity: a part of the coefficients of the film, and of a cell's width.
    film_part_long, own_part_long, long_cell
        The same by sparse factors, for cells so many times as long as wide, which lines along the length do not couple.
    slower, more, step_ratio, longest_step
        Rebuild the preconditioner when iterations exceed ``slower`` times the count at the last build plus ``more``, or
        when the step in pseudo-time, up to the longest, has changed by ``step_ratio``.
    """

    reached: float = 1e-2
    missed: float = 0.1
    basis: int = 120
    restarts: int = 4
    waves: int = 33
    film_part: float = 0.03
    own_part: float = 0.03
    film_part_long: float = 0.05
    own_part_long: float = 0.1
    long_cell: float = 2.0
    slower: float = 1.5
    more: int = 5
    step_ratio: float = 4.0
    longest_step: float = 3.0


TUNING = KrylovTuning()


@dataclass(frozen=True, eq=False)
class KrylovStep:
    """GMRES for a film that varies along its length.

    The Fourier stage was ``made_for`` a step in pseudo-time, and GMRES took ``iterations_then`` with it at first.
    ``last`` are the last system and its unknowns.
    """

    deflection: Convolution
    fourier: "FourierStage | None" = None
    made_for: float = 0.0
    iterations_then: int | None = None
    last: "tuple[StepSystem, Array] | None" = None

    def step(
        self, linear: Linearised, film: Film, active: ActiveSets, load_missing: float
    ) -> FilmStep:
        """Return the step for given ``active`` sets.

        GMRES starts from the step for the set of cells before, if the linearised balance is the same.
        """
        cavitated = active.cavitated
        pressure = np.where(cavitated, -film.pressure, 0.0)
        void = np.where(cavitated, 0.0, -film.void)
        try:
            staged = self._staged(linear, cavitated)
            assert staged.fourier is not None
            local = local_stage(linear, cavitated)
        except (np.linalg.LinAlgError, RuntimeError):  # singular, as scipy has it
            return FilmStep(pressure, void, 0.0, replace(self, fourier=None), solved=False)
        system = StepSystem(
            linear, ~(cavitated | linear.equation.fixed), cavitated, staged.fourier, local
        )
        missing = load_missing - system.mean * pressure.sum()
        balance = -(linear.residual + linear.change(pressure, void, 0.0))
        right = np.append(balance.ravel(), system.flow * missing)
        norm = float(np.linalg.norm(right))
        if norm == 0:
            return FilmStep(pressure, void, 0.0, staged)
        start = np.zeros_like(right)
        if self.last is not None and self.last[0].linear is linear:
            same = self.last[0].cavitated == cavitated
            start = self.last[1] * np.append(same.ravel(), True)
        unknowns, missed, count = system.solve(right, start, norm)
        at_first = count if staged.iterations_then is None else staged.iterations_then
        slow = count > TUNING.slower * at_first + TUNING.more
        solver = replace(
            staged,
            fourier=None if slow else staged.fourier,
            iterations_then=at_first,
            last=(system, unknowns),
        )
        change, opened, separation = system.split(unknowns)
        solved = bool(np.isfinite(missed) and missed < TUNING.missed)
        return FilmStep(pressure + change, void + opened, separation, solver, solved, count)

    def _staged(self, linear: Linearised, cavitated: Mask) -> "KrylovStep":
        """Return the solver with a new Fourier stage where the time step has changed, or the last no longer serves."""
        time_step = (
            min(1 / linear.rate, TUNING.longest_step) if linear.rate else TUNING.longest_step
        )
        ratio = time_step / self.made_for if self.made_for else 0.0
        if self.fourier is not None and 1 / TUNING.step_ratio < ratio < TUNING.step_ratio:
            return self
        free = ~(cavitated | linear.equation.fixed)
        fourier = FourierStage.of(linear, free, toeplitz(self.deflection))
        return replace(self, fourier=fourier, made_for=time_step, iterations_then=None)


@dataclass(frozen=True, eq=False)
class StepSystem:
    """Linear system of a step, with its preconditioner.

    The unknowns are one for each cell, its pressure or, where it is cavitated, its void fraction, and the separation.
    The last row is the load, in units of the flow.
    """

    linear: Linearised
    free: Mask
    cavitated: Mask
    fourier: "FourierStage"
    local: "LineStage | FactorStage"

    @cached_property
    def flow(self) -> float:
        """Largest flow through a face."""
        return float(np.abs(self.linear.flux[1:-1]).max())

    @property
    def mean(self) -> float:
        """Load of a unit pressure on one cell."""
        return float(self.linear.equation.cell[0] / self.free.shape[1])

    def split(self, values: Array) -> tuple[Array, Array, float]:
        """Return pressure and void fraction (x, y) and separation of a vector of unknowns."""
        cells = values[:-1].reshape(self.free.shape)
        return cells * self.free, cells * self.cavitated, float(values[-1])

    def product(self, values: Array) -> Array:
        """Multiply the matrix with a vector of unknowns."""
        pressure, void, separation = self.split(values)
        balance = self.linear.change(pressure, void, separation)
        return np.append(balance.ravel(), self.flow * self.mean * pressure.sum())

    def preconditioned(self, values: Array) -> Array:
        """Apply the Fourier stage, then the local stage to what it leaves."""
        shape = self.free.shape
        cells = values[:-1].reshape(shape)
        coarse, separation = self.fourier.solve(cells * self.free, float(values[-1]) / self.flow)
        unknowns = np.append((coarse * self.free).ravel(), separation)
        remainder = (values - self.product(unknowns))[:-1].reshape(shape)
        unknowns[:-1] += (self.local.solve(remainder) * ~self.linear.equation.fixed).ravel()
        return unknowns

    def solve(self, right: Array, start: Array, norm: float) -> tuple[Array, float, int]:
        """Return unknowns, their residual over ``norm``, and the number of iterations from ``start``."""
        count = 0

        def counted(_: float) -> None:
            nonlocal count
            count += 1

        missing = right - self.product(start) if start.any() else right
        system = LinearOperator(
            (right.size, right.size),
            matvec=lambda values: self.product(self.preconditioned(values)),
            dtype=float,
        )
        solution, _ = gmres(
            system, missing, rtol=0.0, atol=TUNING.reached * norm, restart=TUNING.basis, maxiter=TUNING.restarts,
            callback=counted, callback_type="pr_norm",
        )  # fmt: skip
        unknowns = start + self.preconditioned(solution)
        missed = float(np.linalg.norm(right - self.product(unknowns))) / norm
        return unknowns, missed, count


@dataclass(frozen=True, eq=False)
class FourierStage:
    """Inverses (wave, x, x) of the system averaged over the length; that of the mean has the load as a last row."""

    mean: Array
    waves: Array
    scale: Array

    @classmethod
    def of(cls, linear: Linearised, free: Mask, influence: Array) -> "FourierStage":
        """Average over the length, and invert; ``influence`` (wave, x, x) in single precision."""
        equation = linear.equation
        nx, ny = free.shape
        number = len(influence)
        matrices = np.zeros((number, nx, nx), dtype=np.float32)
        index = np.arange(nx)
        by_separation = np.zeros(nx)
        # cells that are not free stay as they are
        matrices[:, index, index] = 1 - free.mean(axis=1)
        turn = np.cos(2 * np.pi * np.arange(number) / ny)
        for bands, elastic in ((linear.pressure, False), (linear.film, True)):
            for (across, along), coefficient in bands.items():
                average = (coefficient * free).mean(axis=1).astype(np.float32)
                rows = index[max(0, -across) : nx - max(0, across)]
                weight = turn if along else np.ones(number)
                scaled = weight[:, None].astype(np.float32) * average[rows]
                if elastic:
                    matrices[:, rows] += scaled[:, :, None] * influence[:, rows + across]
                    by_separation += average
                else:
                    matrices[:, rows, rows + across] += scaled
        scale = np.abs(matrices).max(axis=2)
        bordered = np.zeros((nx + 1, nx + 1))
        bordered[:nx, :nx] = matrices[0]
        bordered[:nx, nx] = by_separation
        bordered[nx, :nx] = equation.cell[0] * free.mean(axis=1)
        bordered[:nx] /= scale[0][:, None]
        return cls(
            np.linalg.inv(bordered),
            np.linalg.inv(matrices[1:] / scale[1:, :, None]),
            scale,
        )

    def solve(self, right: Array, load: float) -> tuple[Array, float]:
        """Return pressure (x, y) and separation for the right-hand side of cells and of the load."""
        number = len(self.scale)
        transformed = fft.rfft(right, axis=1)
        scaled = transformed[:, :number].T / self.scale
        ny = right.shape[1]
        mean = self.mean @ np.append(scaled[0].real / ny, load)
        parts = np.stack((scaled[1:].real, scaled[1:].imag), axis=2).astype(np.float32)
        waves = self.waves @ parts
        solution = np.zeros_like(transformed)
        solution[:, 0] = mean[:-1] * ny
        solution[:, 1:number] = (waves[..., 0] + 1j * waves[..., 1]).T
        return fft.irfft(solution, n=ny, axis=1), float(mean[-1])


def toeplitz(deflection: Convolution) -> Array:
    """Return the influence (wave, x, x) of cells across on each other, for the first waves along the length."""
    nx, ny = deflection.cells
    number = min(TUNING.waves, ny // 2 + 1)
    columns = fft.ifft(deflection.spectrum[:, :number], axis=0).real.astype(np.float32)
    index = np.arange(nx)
    return np.ascontiguousarray(columns[np.abs(index[:, None] - index)].transpose(2, 0, 1))


@dataclass(frozen=True, eq=False)
class LineStage:
    """Coefficients (x, y) of lines along the length: of the own cell, its neighbours along, and those upstream."""

    own: Array
    before: Array
    behind: Array
    upstream: Array
    further: Array

    @classmethod
    def of(cls, linear: Linearised, cavitated: Mask) -> "LineStage":
        """Take from each cell the coefficients of its unknown, the void fraction where it is cavitated."""
        offsets = (0, 0), (0, -1), (0, 1), (-1, 0), (-2, 0)
        return cls(
            *(
                _coefficient(linear, cavitated, offset, TUNING.film_part, TUNING.own_part)
                for offset in offsets
            )
        )

    def solve(self, right: Array) -> Array:
        """Return the solution of one sweep downstream."""
        return sweeper()(self.own, self.before, self.behind, self.upstream, self.further, right)


@dataclass(frozen=True, eq=False)
class FactorStage:
    """Sparse factors of the local coefficients, for cells that are long along the length."""

    factors: SuperLU

    @classmethod
    def of(cls, linear: Linearised, cavitated: Mask) -> "FactorStage":
        """Factorise the coefficients of all neighbours."""
        index = np.arange(cavitated.size).reshape(cavitated.shape)
        rows, columns, values = [], [], []
        for offset in ((0, 0), (0, -1), (0, 1), (1, 0), (-1, 0), (-2, 0)):
            coefficient = _coefficient(
                linear, cavitated, offset, TUNING.film_part_long, TUNING.own_part_long
            )
            inside = neighbour(np.ones_like(cavitated), offset)
            rows.append(index[inside])
            columns.append(neighbour(index, offset)[inside])
            values.append(coefficient[inside])
        places = np.concatenate(rows), np.concatenate(columns)
        size = cavitated.size
        return cls(splu(csc_matrix((np.concatenate(values), places), shape=(size, size))))

    def solve(self, right: Array) -> Array:
        """Return the solution by the factors."""
        return np.asarray(self.factors.solve(right.ravel()).reshape(right.shape))


def local_stage(linear: Linearised, cavitated: Mask) -> LineStage | FactorStage:
    """Return lines along the length, or sparse factors where cells are too long for lines to couple them."""
    dx, dy = linear.equation.cell
    return (FactorStage if dy > TUNING.long_cell * dx else LineStage).of(linear, cavitated)


def _coefficient(
    linear: Linearised,
    cavitated: Mask,
    offset: tuple[int, int],
    film_part: float,
    own_part: float,
) -> Array:
    """Return the coefficient of the unknown of the neighbour at ``offset``, with a remainder of elasticity."""
    fixed = linear.equation.fixed
    zero = np.zeros(fixed.shape)
    pressure = linear.pressure.get(offset, zero) + film_part * linear.film.get(offset, zero)
    if offset == (0, 0):
        pressure = pressure + own_part * linear.equation.cell[0]
    unknown = np.where(neighbour(cavitated, offset), linear.void.get(offset, zero), pressure)
    return np.where(fixed | neighbour(fixed, offset), offset == (0, 0), unknown)


@cache
def sweeper() -> Callable[..., Array]:
    """Return the compiled sweep, or that of arrays where numba is not installed."""
    try:
        compiled: Callable[..., Array] = import_module(
            "contactstudy.lubrication.compiled_sweep"
        ).sweep
    except ModuleNotFoundError:
        return sweep_by_arrays
    return compiled


def sweep_by_arrays(
    own: Array, before: Array, behind: Array, upstream: Array, further: Array, right: Array
) -> Array:
    """Solve one line along y after the other, with scipy."""
    rows, columns = right.shape
    solution = np.zeros_like(right)
    for i in range(rows):
        line = right[i].copy()
        if i > 0:
            line -= upstream[i] * solution[i - 1]
        if i > 1:
            line -= further[i] * solution[i - 2]
        # the corners of a cyclic line, after Sherman & Morrison (1950)
        shift, ratio = -own[i, 0], before[i, 0] / -own[i, 0]
        banded = np.stack((np.roll(behind[i], 1), own[i], np.roll(before[i], -1)))
        banded[1, 0] -= shift
        banded[1, -1] -= behind[i, -1] * ratio
        corner = np.zeros(columns)
        corner[0], corner[-1] = shift, behind[i, -1]
        both = solve_banded((1, 1), banded, np.stack((line, corner), axis=1), check_finite=False)
        weight = (both[0, 0] + ratio * both[-1, 0]) / (1 + both[0, 1] + ratio * both[-1, 1])
        solution[i] = both[:, 0] - weight * both[:, 1]
    return solution
