"""Linear systems of a step: solved directly in plane strain, else by GMRES with two multiplicative preconditioners.

By elasticity all cells act on each other. The Fourier stage of the preconditioner inverts the system averaged over the
length, one harmonic at a time: it has the elasticity of long range. In its average, the equation of a touching cell is
that of its film thickness. The local stage solves for what that leaves, with the coefficients of a cell and its
neighbours and a small fraction of the elasticity: it has the variation of the conductance by orders of magnitude. It
takes lines in turn along the shorter sides of the cells, or sparse LU factors where cells touch. The equations of
touching cells have the preconditioner of the dry contact there.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
from scipy import fft
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator, gmres, splu

from contactstudy.domain.grid import Array
from contactstudy.elasticity.convolution import Convolution
from contactstudy.lubrication.film_equation import Bands, Film, FilmEquation, Linearised, Mask, neighbour
from contactstudy.lubrication.pseudo_time import ActiveSets, FilmCorrection
from contactstudy.problem.problem import ApproximateInverse, Extension

# Elasticity in the local stage: the coefficient of a change of pressure has the first times that of thickness, and on
# the diagonal the second times the width of a cell. These, of lines ALONG the length and of others, and the PASSES over
# every second line, were chosen by counts of iterations on 50 rough, crowned and mixed films of 64 x 16 to 864 x 128
# cells, with Moes's load parameter M = 20 and 100 and his material parameter L = 0 to 10.
ELASTICITY, ELASTICITY_ALONG, PASSES = (0.05, 0.1), (0.03, 0.03), 3
# Linear residual where GMRES stops, without and with cells that touch, and that above which a step is rejected. With
# 0.1 more steps were taken, with 0.01 half as many iterations again; with 1e-2 the active sets of touching cells did
# not converge on 128 x 32 cells. These and the constants below were chosen on rough films of 64^2 to 256^2 cells.
TOLERANCE, TOLERANCE_TOUCHING, MAX_RESIDUAL = 3e-2, 1e-3, 0.1
# Length of the basis of GMRES, and the largest number of cycles of that length.
BASIS, RESTARTS = 120, 4
# Harmonics along the length in the Fourier stage, the mean included. Shorter waves follow the conductance, which the
# local stage has: with 33, light rough films took 1.1 to 3 times the iterations, each 1.5 times as long.
WAVES = 9
# The stages are built again when iterations exceed GROWTH times those after the last build plus EXTRA, or when the step
# in pseudo-time, at most LONGEST_STEP, has changed by the factor STEP_RATIO.
GROWTH, EXTRA, STEP_RATIO, LONGEST_STEP = 1.5, 5, 4.0, 3.0
# Function that solves for a right-hand side (x, y), approximately.
LocalStage = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class DirectSolver:
    """Gaussian elimination; ``influence`` (i, j) is the deflection of cell i under a unit pressure on cell j."""

    influence: Array

    @classmethod
    def for_equation(cls, equation: FilmEquation) -> "DirectSolver":
        """Return the solver for ``equation`` in plane strain, whose deflection is a convolution."""
        first = np.zeros(equation.gap.shape)
        first[0] = 1
        downstream, upstream = (equation.deflection(end)[:, 0] for end in (first, first[::-1]))
        index = np.arange(len(downstream))
        return cls(np.concatenate((upstream[:-1], downstream))[len(downstream) - 1 + index[:, None] - index])

    def step(self, linear: Linearised, film: Film, active: ActiveSets, load_residual: float) -> FilmCorrection:
        """Return the step for given ``active`` sets.

        The unknowns are the pressure or the void fraction of each cell, the asperity pressure of each touching cell, and
        the separation; the rows are the flow balance of each cell, the thickness of each touching cell, and the load.
        """
        equation, width = linear.equation, linear.equation.cell[0]
        n, fixed, cavitated = len(film.thickness), equation.fixed[:, 0], active.cavitated[:, 0]
        full_film = ~(cavitated | fixed)
        by_deflection = self._by_deflection(linear)
        # prescribed changes: pressures and voids that vanish
        pressure = np.where(cavitated, -film.pressure[:, 0], 0.0)
        void = np.where(cavitated, 0.0, -film.void[:, 0])
        change = linear.change_with(pressure[:, None], void[:, None], equation.deflection(pressure[:, None]))
        balance = -(linear.residual + change)[:, 0]
        load_residual -= width * pressure.sum()
        touching_cells = np.flatnonzero(active.touching)
        asperity_pressure = np.where(active.touching, 0.0, -film.asperity_pressure)[:, 0]
        balance -= by_deflection @ asperity_pressure
        load_residual -= width * asperity_pressure.sum()
        balance[fixed] = 0

        size = n + len(touching_cells) + 1
        system = np.zeros((size, size))
        system[:n, :n] = by_deflection + _matrix(linear.pressure, n)
        system[:n, :n][:, cavitated] = _matrix(linear.void, n)[:, cavitated]
        system[:n, -1] = np.asarray(sum(linear.thickness.values()))[:, 0]
        system[-1, :n] = width * full_film
        rhs = np.zeros(size)
        rhs[:n], rhs[-1] = balance, load_residual
        if len(touching_cells):
            system[:n, n:-1] = by_deflection[:, touching_cells]
            system[n:-1, :n] = self.influence[touching_cells] * full_film
            system[n:-1, n:-1] = self.influence[np.ix_(touching_cells, touching_cells)]
            system[n:-1, -1] = 1
            system[-1, n:-1] = width
            distance = equation.boundary_film - film.thickness[:, 0] - self.influence @ (pressure + asperity_pressure)
            rhs[n:-1] = distance[touching_cells]
        system[:n][fixed] = np.eye(n, size)[fixed]
        scale = np.abs(system).max(axis=1)
        system /= scale[:, None]
        try:
            solution = np.linalg.solve(system, rhs / scale)
        except np.linalg.LinAlgError:
            unchanged = film.pressure, film.asperity_pressure, film.void, 0.0
            return FilmCorrection(*unchanged, self, solved=False)
        unknown, asperity_pressure[touching_cells] = solution[:n], solution[n:-1]
        return FilmCorrection(
            np.where(cavitated, pressure, unknown)[:, None],
            asperity_pressure[:, None],
            np.where(cavitated, unknown, void)[:, None],
            float(solution[-1]),
            self,
        )

    def _by_deflection(self, linear: Linearised) -> Array:
        """Return the derivatives (n, n) of the flow balance by asperity pressures, which only deflect the surfaces."""
        n = len(self.influence)
        matrix = np.zeros((n, n))
        for (offset, _), coefficient in linear.thickness.items():
            first, end = max(0, -offset), min(n, n - offset)
            # a diagonal times the influence is the influence with its rows shifted
            matrix[first:end] += coefficient[first:end] * self.influence[first + offset : end + offset]
        return matrix


def _matrix(bands: Bands, n: int) -> Array:
    """Return the matrix (n, n) of bands in plane strain."""
    matrix = np.zeros((n, n))
    for (offset, _), coefficient in bands.items():
        index = np.arange(max(0, -offset), min(n, n - offset))
        matrix[index, index + offset] = coefficient[index, 0]
    return matrix


def local_stage(linear: Linearised, cavitated: Mask, touching: Mask) -> LocalStage:
    """Return the stage for unknown pressures, and void fractions of cavitated cells.

    It is Gauss-Seidel by lines, across the contact, or along its length where cells are shorter along than across, if
    numba is installed: by the others it took twice as long with ratios of two to six. Factors of 800 x 128 cells cost
    as much as 35 iterations, and solve in six times the time of the lines. Where cells touch, lubricant flows around
    them: lines took up to a hundred times the iterations there.

    Raises ``RuntimeError`` for a singular system.
    """
    dx, dy = linear.equation.cell
    sweep = None if touching.any() or dy >= dx else compiled_sweep()
    elasticity = ELASTICITY if sweep is None else ELASTICITY_ALONG

    def coefficient(across: int, along: int) -> Array:
        return _coefficient(linear, cavitated, touching, (across, along), elasticity)

    if sweep is None:
        stage = _by_factors if touching.any() else _by_lines
        return stage(coefficient, cavitated.shape)
    offsets = (0, 0), (0, -1), (0, 1), (-1, 0), (-2, 0)
    coefficients = [coefficient(*offset) for offset in offsets]
    return lambda right: sweep(*coefficients, right)


def _by_lines(coefficient: Callable[[int, int], Array], shape: tuple[int, ...]) -> LocalStage:
    """Return the stage by lines across, with the factors of every second line as those of one banded matrix."""
    rows, columns = shape
    downstream, diagonal, upstream, second, previous, following = (
        np.ascontiguousarray(coefficient(*offset).T) for offset in ((1, 0), (0, 0), (-1, 0), (-2, 0), (0, -1), (0, 1))
    )
    halves = []
    for start in (0, 1):
        lines = np.arange(start, columns, 2)
        bands = np.zeros((6, len(lines) * rows))  # two rows are for the factors
        # the first two cells of a line and the last are fixed, so that lines do not act on each other
        bands[2, 1:] = downstream[lines].ravel()[:-1]
        bands[3] = diagonal[lines].ravel()
        bands[4, :-1] = upstream[lines].ravel()[1:]
        bands[5, :-2] = second[lines].ravel()[2:]
        factors, pivots, failed = dgbtrf(bands, 2, 1, overwrite_ab=True)
        if failed:
            raise RuntimeError("singular")
        halves.append((lines, factors, pivots, previous[lines], following[lines]))

    def solve(right: Array) -> Array:
        given = np.ascontiguousarray(right.T)
        solution = np.zeros_like(given)
        for number in range(PASSES):
            lines, factors, pivots, before, behind = halves[number % 2]
            left = given[lines]
            if number:
                left -= before * solution[lines - 1]
                left -= behind * solution[(lines + 1) % columns]
            solved = dgbtrs(factors, 2, 1, left.ravel(), pivots, overwrite_b=True)[0]
            solution[lines] = solved.reshape(left.shape)
        return solution.T

    return solve


def _by_factors(coefficient: Callable[[int, int], Array], shape: tuple[int, ...]) -> LocalStage:
    """Return the stage by sparse LU factors."""
    index = np.arange(np.prod(shape)).reshape(shape)
    rows, columns, values = [], [], []
    for offset in ((0, 0), (0, -1), (0, 1), (1, 0), (-1, 0), (-2, 0)):
        inside = neighbour(np.ones(shape, dtype=bool), offset)
        rows.append(index[inside])
        columns.append(neighbour(index, offset)[inside])
        values.append(coefficient(*offset)[inside])
    indices = np.concatenate(rows), np.concatenate(columns)
    factors = splu(csc_matrix((np.concatenate(values), indices), shape=(index.size, index.size)))
    return lambda right: np.asarray(factors.solve(right.ravel()).reshape(shape))


def _coefficient(
    linear: Linearised, cavitated: Mask, touching: Mask, offset: tuple[int, int], elasticity: tuple[float, float]
) -> Array:
    """Return the coefficient (x, y) of the neighbour at ``offset``, of its void fraction where it is cavitated.

    That of a pressure has a part of the `elasticity`. Cells without an unknown have a row of the identity.
    """
    fixed = linear.equation.fixed
    zero = np.zeros(fixed.shape)
    film_can_change = neighbour(~touching, offset)
    pressure = linear.pressure.get(offset, zero)
    pressure = pressure + elasticity[0] * film_can_change * linear.thickness.get(offset, zero)
    if offset == (0, 0):
        pressure = pressure + elasticity[1] * linear.equation.cell[0] * film_can_change
    unknown = np.where(neighbour(cavitated, offset), linear.void.get(offset, zero), pressure)
    return np.where(fixed | neighbour(fixed, offset), offset == (0, 0), unknown)


@cache
def compiled_sweep() -> Callable[..., Array] | None:
    """Return the compiled sweep; None where numba is not installed."""
    try:
        from contactstudy.domain.loops.compiled import sweep  # imported late, since numba may be missing
    except ModuleNotFoundError:
        return None
    compiled: Callable[..., Array] = sweep
    return compiled


@dataclass(frozen=True, eq=False)
class KrylovSolver:
    """GMRES for a film that varies along its length, with what the next system may reuse.

    The stages were ``built_for`` a step in pseudo-time, and GMRES took ``iterations_at_build`` with them at first.
    ``last`` is the last system with its solution, ``inverse`` the preconditioner of the dry contact.
    """

    deflection: Convolution
    fourier: "FourierStage | None" = None
    built_for: float = 0.0
    iterations_at_build: int | None = None
    last: "tuple[StepSystem, Array] | None" = None
    inverse: ApproximateInverse | None = None

    def step(self, linear: Linearised, film: Film, active: ActiveSets, load_residual: float) -> FilmCorrection:
        """Return the step for given ``active`` sets.

        GMRES starts from the solution for the last sets, if the linearised balance is the same. The change of thickness
        of a touching cell is known: to the boundary film.
        """
        equation, (cavitated, touching) = linear.equation, active
        # prescribed changes: pressures and voids that vanish
        pressure = np.where(cavitated, -film.pressure, 0.0)
        void = np.where(cavitated, 0.0, -film.void)
        asperity_pressure = np.where(touching, -pressure, -film.asperity_pressure)
        total = pressure + asperity_pressure
        fixed = pressure, asperity_pressure, void, 0.0
        unsolved = FilmCorrection(*fixed, replace(self, fourier=None), solved=False)
        try:
            staged = self._with_fourier_stage(linear, cavitated, touching)
            assert staged.fourier is not None
            local = local_stage(linear, cavitated, touching)
        except (np.linalg.LinAlgError, RuntimeError):  # the system is singular
            return unsolved
        system = StepSystem(linear, cavitated, touching, staged.fourier, local)
        inverse = self.inverse
        if touching.any():
            inverse = inverse or self.deflection.approximate_inverse()
            system = replace(system, extension=inverse.extension(touching.astype(float)))
        deflection = equation.deflection(total)
        to_boundary = equation.boundary_film - film.thickness
        remaining_load = load_residual - system.mean * total.sum()
        change = linear.change_with(pressure, void, np.where(touching, to_boundary, deflection))
        balance = -(linear.residual + change)
        right = system.stacked(balance, (to_boundary - deflection) * touching, system.flow * remaining_load)
        norm = float(np.linalg.norm(right))
        if norm == 0:
            return FilmCorrection(*fixed, staged)
        start = np.zeros_like(right)
        if self.last is not None and self.last[0].linear is linear:
            start = system.restricted_from(*self.last)
        unknowns, residual, count = system.solve(right, start, norm)
        solved = bool(np.isfinite(residual) and residual < MAX_RESIDUAL)
        at_first = count if staged.iterations_at_build is None else staged.iterations_at_build
        slow = count > GROWTH * at_first + EXTRA
        solver = replace(
            staged,
            fourier=None if slow else staged.fourier,
            iterations_at_build=at_first,
            last=(system, unknowns),
            inverse=inverse,
        )
        change_of_pressure, change_of_void, asperities, separation = system.split(unknowns)
        pressure = pressure + change_of_pressure
        asperity_pressure = np.where(touching, asperities - pressure, -film.asperity_pressure)
        void = void + change_of_void
        return FilmCorrection(pressure, asperity_pressure, void, separation, solver, solved, count)

    def _with_fourier_stage(self, linear: Linearised, cavitated: Mask, touching: Mask) -> "KrylovSolver":
        """Return the solver with a new Fourier stage where the time step has changed, or iterations grew."""
        time_step = 1 / max(linear.inverse_time_step, 1 / LONGEST_STEP)
        ratio = time_step / self.built_for if self.built_for else 0.0
        if self.fourier is not None and 1 / STEP_RATIO < ratio < STEP_RATIO:
            return self
        full_film = ~(cavitated | linear.equation.fixed)
        fourier = FourierStage.of(linear, full_film, touching, influence_by_harmonic(self.deflection))
        return replace(self, fourier=fourier, built_for=time_step, iterations_at_build=None)


@dataclass(frozen=True, eq=False)
class StepSystem:
    """Linear system of a step, with its preconditioner; all unknowns are changes.

    The unknowns are one for each cell, the pressure of the lubricant or, where it is cavitated, its void fraction; the
    total pressure of lubricant and asperities of each touching cell; and the separation. The rows are the flow balance
    of each cell, the thickness of each touching cell, and the load times the flow.
    """

    linear: Linearised
    cavitated: Mask
    touching: Mask
    fourier: "FourierStage"
    local: LocalStage
    extension: Extension | None = None

    @cached_property
    def full_film(self) -> Mask:
        """Cells (x, y) whose unknown is the pressure of the lubricant."""
        return ~(self.cavitated | self.linear.equation.fixed)

    @cached_property
    def flow(self) -> float:
        """Largest flow through a face."""
        return float(np.abs(self.linear.flux[1:-1]).max())

    @property
    def mean(self) -> float:
        """Load of a unit pressure on one cell."""
        return float(self.linear.equation.cell[0] / self.full_film.shape[1])

    def stacked(self, cells: Array, touching: Array, last: float) -> Array:
        """Return a vector of values of cells (x, y), of touching cells (x, y), and of the separation or the load."""
        return np.concatenate((cells.ravel(), touching[self.touching], [last]))

    def unstacked(self, values: Array) -> tuple[Array, Array, float]:
        """Return the three parts of a vector of :meth:`stacked`; the second is zero where a cell does not touch."""
        cells = values[: self.full_film.size].reshape(self.full_film.shape)
        touching = np.zeros_like(cells)
        touching[self.touching] = values[self.full_film.size : -1]
        return cells, touching, float(values[-1])

    def split(self, values: Array) -> tuple[Array, Array, Array, float]:
        """Return pressure, void fraction, total pressure of touching cells (x, y) and separation of the unknowns."""
        cells, touching, separation = self.unstacked(values)
        return cells * self.full_film, cells * self.cavitated, touching, separation

    def restricted_from(self, system: "StepSystem", values: Array) -> Array:
        """Return the unknowns of another system that are also unknowns of this one, and zero for the others."""
        cells, touching, separation = system.unstacked(values)
        return self.stacked(cells * (self.cavitated == system.cavitated), touching, separation)

    def product(self, values: Array) -> Array:
        """Multiply the matrix with a vector of unknowns."""
        pressure, void, touching, separation = self.split(values)
        total = np.where(self.touching, touching, pressure)
        film = self.linear.equation.deflection(total) + separation
        balance = self.linear.change_with(pressure, void, np.where(self.touching, 0.0, film))
        return self.stacked(balance, film, self.flow * self.mean * total.sum())

    def preconditioned(self, values: Array) -> Array:
        """Return the Fourier stage's solution plus the local stage's of the residual it leaves."""
        cells, touching, load = self.unstacked(values)
        solved = self.full_film | self.touching
        rows = np.where(self.touching, touching, cells * self.full_film)
        coarse, separation = self.fourier.solve(rows, load / self.flow)
        coarse = coarse * solved
        unknowns = self.stacked(coarse * (self.full_film & ~self.touching), coarse, separation)
        cells, touching, _ = self.unstacked(values - self.product(unknowns))
        correction = self.local(cells) * ~self.linear.equation.fixed
        if self.extension is not None:
            touching = self.extension.pressure(self.extension(touching))
        return unknowns + self.stacked(correction, touching, 0.0)

    def solve(self, right: Array, start: Array, norm: float) -> tuple[Array, float, int]:
        """Return unknowns, their residual over ``norm``, that of ``right``, and the iterations from ``start``."""
        count = 0

        def counted(_: float) -> None:
            nonlocal count
            count += 1

        tolerance = TOLERANCE_TOUCHING if self.touching.any() else TOLERANCE
        missing = right - self.product(start) if start.any() else right
        if np.linalg.norm(missing) > norm:  # a start from zero is better
            start, missing = np.zeros_like(start), right
        system = LinearOperator(
            (right.size, right.size), matvec=lambda values: self.product(self.preconditioned(values)), dtype=float
        )
        solution, _ = gmres(
            system, missing, rtol=0.0, atol=tolerance * norm, restart=BASIS, maxiter=RESTARTS,
            callback=counted, callback_type="pr_norm",
        )  # fmt: skip
        unknowns = start + self.preconditioned(solution)
        residual = float(np.linalg.norm(right - self.product(unknowns))) / norm
        return unknowns, residual, count


@dataclass(frozen=True, eq=False)
class FourierStage:
    """Inverses (x, x) of the system averaged over the length, one for each harmonic.

    That of the ``mean`` has the separation and the load as a last column and row; ``waves`` (harmonic, x, x) are the
    others, in single precision. ``scale`` (harmonic, x) are the largest coefficients of the rows, which are divided by
    them.
    """

    mean: Array
    waves: Array
    scale: Array

    @classmethod
    def of(cls, linear: Linearised, full_film: Mask, touching: Mask, influence: Array) -> "FourierStage":
        """Average the coefficients over the length, and invert; ``influence`` (harmonic, x, x) in single precision.

        The row of a touching cell is that of its thickness.
        """
        equation = linear.equation
        nx, ny = full_film.shape
        number = len(influence)
        matrices = np.zeros((number, nx, nx), dtype=np.float32)
        index = np.arange(nx)
        by_separation = np.zeros(nx)
        # rows of the identity for cells without an unknown pressure
        solved, film_can_change, full_film = full_film | touching, ~touching, full_film & ~touching
        matrices[:, index, index] = 1 - solved.mean(axis=1)
        turn = np.cos(2 * np.pi * np.arange(number) / ny)
        for bands, elastic in ((linear.pressure, False), (linear.thickness, True)):
            for (across, along), coefficient in bands.items():
                counted = full_film & neighbour(film_can_change, (across, along)) if elastic else full_film
                average = (coefficient * counted).mean(axis=1).astype(np.float32)
                rows = index[max(0, -across) : nx - max(0, across)]
                weight = turn if along else np.ones(number)
                scaled = weight[:, None].astype(np.float32) * average[rows]
                if elastic:
                    matrices[:, rows] += scaled[:, :, None] * influence[:, rows + across]
                    by_separation += average
                else:
                    matrices[:, rows, rows + across] += scaled
        touched = touching.mean(axis=1)
        matrices += touched[:, None].astype(np.float32) * influence
        by_separation += touched
        scale = np.abs(matrices).max(axis=2)
        bordered = np.zeros((nx + 1, nx + 1))
        bordered[:nx, :nx] = matrices[0]
        bordered[:nx, nx] = by_separation
        bordered[nx, :nx] = equation.cell[0] * solved.mean(axis=1)
        bordered[:nx] /= scale[0][:, None]
        return cls(np.linalg.inv(bordered), np.linalg.inv(matrices[1:] / scale[1:, :, None]), scale)

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


def influence_by_harmonic(deflection: Convolution) -> Array:
    """Return the deflection (harmonic, x, x') at x under a unit pressure at x', by harmonics along the length."""
    nx, ny = deflection.cells
    number = min(WAVES, ny // 2 + 1)
    columns = fft.ifft(deflection.spectrum[:, :number], axis=0).real.astype(np.float32)
    index = np.arange(nx)
    return np.ascontiguousarray(columns[np.abs(index[:, None] - index)].transpose(2, 0, 1))
