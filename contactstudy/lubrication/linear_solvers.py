"""Linear systems of Newton's iteration for a film: eliminated in plane strain, else by GMRES with a preconditioner.

By elasticity all cells act on each other. The preconditioner has two multiplicative stages. The Fourier stage inverts
the system averaged over the length, one harmonic at a time: it has the elasticity of long range. In its average, the
equation of a touching cell is that of its film thickness. The local stage solves for the residual of the first, with
the coefficients of a cell and its neighbours and a small fraction of the elasticity. It has the variation of the
conductance by orders of magnitude. The equations of touching cells have the preconditioner of the dry contact. Both
take ``deflection.even``, the elasticity without creep.

Units are those of :mod:`~contactstudy.lubrication.film_equation`; arrays (x, y) have one value for each cell. A
cavitated cell has no pressure, and its void fraction is unknown. A touching cell lies on the boundary film, where
asperities carry a part of the pressure. The separation is the distance of the bodies. Across is along x, in which the
surfaces move, and upstream is towards smaller x; along the length is y, periodic.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import fft
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse import csc_array
from scipy.sparse.linalg import LinearOperator, gmres, splu

from contactstudy.domain.grid import Array
from contactstudy.elasticity.convolution import Convolution
from contactstudy.lubrication.film_equation import Bands, Film, Linearised, Mask, neighbour
from contactstudy.problem.problem import ApproximateInverse

# Elasticity in the local stage: the coefficient of a change of pressure has ELASTIC_FRACTION of that of thickness, and
# on the diagonal WIDTH_FRACTION of the width of a cell. PASSES are those over every second line in turn. All were
# chosen by counts of iterations on 50 rough, crowned and mixed films of 64 x 16 to 864 x 128 cells, with Moes's
# parameters M = 20 and 100, of the load, and L = 0 to 10, of the material.
ELASTIC_FRACTION, WIDTH_FRACTION, PASSES = 0.05, 0.1, 3
# Linear residual over the right-hand side where GMRES stops, without and with cells that touch, and that above which a
# step is rejected. Without touching cells 0.1 took more steps, and 0.01 half as many iterations again. With 0.01 the
# active sets of touching cells did not converge on 128 x 32 cells. These and the constants below were chosen on rough
# films of 64^2 to 256^2 cells.
TOLERANCE, TOLERANCE_TOUCHING, MAX_RESIDUAL = 3e-2, 1e-3, 0.1
# Length of the basis of GMRES, which holds as many numbers for each cell, and the most cycles of that length. Most
# steps take 5 to 40 iterations; one that takes more than a basis hardly converges.
BASIS, RESTARTS = 120, 4
# Harmonics along the length in the Fourier stage, the mean included. Shorter waves follow the conductance, which the
# local stage has: with 33, light rough films took 1.1 to 3 times the iterations, each 1.5 times as long.
WAVES = 9
# The Fourier stage is built again when iterations exceed GROWTH times those after the last build plus EXTRA, or when
# the step in pseudo-time has changed by the factor STEP_RATIO. Without the first rule rough films took a tenth more
# iterations. Steps above LONGEST_STEP count as that, since their squeeze term hardly matters.
GROWTH, EXTRA, STEP_RATIO, LONGEST_STEP = 1.5, 5, 4.0, 3.0
# Function from a right-hand side (x, y), the balance of each cell, to an approximate solution (x, y), its unknown.
LocalStage = Callable[[Array], Array]


class ActiveSets(NamedTuple):
    """Cells (x, y) that are cavitated, and cells that touch at the boundary film; without one none touch."""

    cavitated: Mask
    touching: Mask

    def changes(self, sets: "ActiveSets") -> int:
        """Return the number of cells that are in one of these sets and not in the same one of others, or the reverse."""
        pairs = zip(self, sets, strict=True)
        return sum(int(np.count_nonzero(ours != theirs)) for ours, theirs in pairs)


class FilmCorrection(NamedTuple):
    """Solution of the linear system of a step: the changes of the film in it.

    These are the changes (x, y) of the pressures of lubricant and asperities and of the void fraction, and that of the
    separation. ``solved`` is False where the system is singular, or its residual above MAX_RESIDUAL. ``iterations`` are
    those of GMRES, zero in plane strain.
    """

    pressure: Array
    asperity_pressure: Array
    void: Array
    separation: float
    solved: bool
    iterations: int


class StepSolver:
    """Solver of the linear systems of one film, step by step, which keeps what the next system may reuse.

    In plane strain nothing is kept. Else the Fourier stage was built for a ``time_step`` in pseudo-time, and GMRES took
    ``iterations_at_build`` with it at first. ``last`` is the last system with its solution, ``inverse`` the
    preconditioner of the dry contact. What does not exist yet is None.
    """

    def __init__(self) -> None:
        self.fourier: FourierStage | None = None
        self.time_step = 0.0
        self.iterations_at_build: int | None = None
        self.last: tuple[StepSystem, Array] | None = None
        self.inverse: ApproximateInverse | None = None

    def step(self, linear: Linearised, film: Film, active: ActiveSets, load_residual: float) -> FilmCorrection:
        """Return the step for given sets: without pressure in cavitated cells, at the boundary film in touching ones.

        Parameters
        ----------
        linear
            Flow balance with its derivatives at ``film``, and the squeeze term of the step in pseudo-time.
        film, active
            The film before the step, and the sets that hold after it.
        load_residual
            Load that the film does not carry yet, over ``p_H a``.
        """
        equation, (cavitated, touching) = linear.equation, active
        # prescribed changes: pressures and voids vanish; of touching cells the total pressure is an unknown
        pressure = np.where(cavitated, -film.pressure, 0.0)
        void = np.where(cavitated, 0.0, -film.void)
        asperity_pressure = np.where(touching, -pressure, -film.asperity_pressure)
        total = pressure + asperity_pressure
        system = StepSystem(linear, cavitated, touching)
        deflection = equation.deflection(total)
        to_boundary = equation.boundary_film - film.thickness
        change = linear.change_with(pressure, void, np.where(touching, to_boundary, deflection))
        remaining_load = load_residual - system.cell_load * total.sum()
        right = system.stacked(-(linear.residual + change), to_boundary - deflection, system.flow * remaining_load)
        try:
            if touching.shape[1] == 1:
                unknowns, solved, count = system.eliminate(right), True, 0
            else:
                unknowns, solved, count = self._gmres(system, right)
        except (np.linalg.LinAlgError, RuntimeError):  # the system or a stage is singular
            self.fourier, unknowns, solved, count = None, np.zeros_like(right), False, 0
        change_of_pressure, change_of_void, touching_pressure, separation = system.split(unknowns)
        pressure = pressure + change_of_pressure
        asperity_pressure = np.where(touching, touching_pressure - pressure, -film.asperity_pressure)
        return FilmCorrection(pressure, asperity_pressure, void + change_of_void, separation, solved, count)

    def _gmres(self, system: "StepSystem", right: Array) -> tuple[Array, bool, int]:
        """Return the unknowns for a right-hand side, whether their residual is small enough, and the iterations.

        Both vectors are those of :meth:`StepSystem.stacked`. GMRES starts from the solution for the last sets, if the
        linearised balance is the same.
        """
        touching, linear = system.touching, system.linear
        if not (norm := float(np.linalg.norm(right))):
            return np.zeros_like(right), True, 0
        fourier, local, extension = self._fourier_stage(system), local_stage(system), None
        if touching.any():
            self.inverse = self.inverse or linear.equation.deflection.even.approximate_inverse()
            extension = self.inverse.extension(touching.astype(float))

        def preconditioned(values: Array) -> Array:
            """Return the Fourier stage's solution plus the local stage's of the residual it leaves."""
            cells, of_touching, load = system.unstacked(values)
            rows = np.where(touching, of_touching, cells * system.full_film)
            coarse, separation = fourier.solve(rows, load / system.flow)
            unknowns = system.stacked(coarse * system.free, coarse, separation)
            cells, of_touching, _ = system.unstacked(values - system.product(unknowns))
            correction = local(cells) * ~linear.equation.fixed
            if extension is not None:  # to heights of all cells, then to pressures of touching ones
                of_touching = extension.pressure(extension(of_touching))
            return unknowns + system.stacked(correction, of_touching, 0.0)

        start, missing = np.zeros_like(right), right
        if self.last is not None and self.last[0].linear is linear:
            nearby = system.restricted_from(*self.last)
            remaining = right - system.product(nearby)
            if np.linalg.norm(remaining) <= norm:
                start, missing = nearby, remaining
        iterations: list[float] = []
        matrix = LinearOperator(
            (right.size, right.size), matvec=lambda values: system.product(preconditioned(values)), dtype=float
        )
        solution, _ = gmres(
            matrix, missing, rtol=0.0, atol=(TOLERANCE_TOUCHING if touching.any() else TOLERANCE) * norm,
            restart=BASIS, maxiter=RESTARTS, callback=iterations.append, callback_type="pr_norm",
        )  # fmt: skip
        unknowns, count = start + preconditioned(solution), len(iterations)
        self.last = system, unknowns
        if self.iterations_at_build is None:
            self.iterations_at_build = count
        if count > GROWTH * self.iterations_at_build + EXTRA:
            self.fourier = None
        residual = float(np.linalg.norm(right - system.product(unknowns))) / norm
        return unknowns, bool(residual < MAX_RESIDUAL), count

    def _fourier_stage(self, system: "StepSystem") -> "FourierStage":
        """Return the Fourier stage, a new one where the time step has changed, or iterations grew."""
        time_step = 1 / max(system.linear.inverse_time_step, 1 / LONGEST_STEP)
        if self.fourier is None or not 1 / STEP_RATIO < time_step / self.time_step < STEP_RATIO:
            influence = influence_by_harmonic(system.linear.equation.deflection.even)
            self.fourier = FourierStage.of(system.linear, system.full_film, system.touching, influence)
            self.time_step, self.iterations_at_build = time_step, None
        return self.fourier


@dataclass(frozen=True, eq=False)
class StepSystem:
    """Linear system of a step; all unknowns are changes.

    The unknowns are one for each cell, the pressure of the lubricant or, where it is cavitated, its void fraction; the
    total pressure of lubricant and asperities of each touching cell; and the separation. The rows are the flow balance
    of each cell, the thickness of each touching cell, and the load times the flow.
    """

    linear: Linearised
    cavitated: Mask
    touching: Mask

    @cached_property
    def full_film(self) -> Mask:
        """Cells (x, y) whose unknown is the pressure of the lubricant."""
        return ~(self.cavitated | self.linear.equation.fixed)

    @cached_property
    def free(self) -> Mask:
        """Cells (x, y) whose unknown deflects the surfaces: full film that does not touch."""
        return self.full_film & ~self.touching

    @cached_property
    def flow(self) -> float:
        """Largest flow through a face across, by which the row of the load is scaled as the rows of the balances are."""
        return float(np.abs(self.linear.flux[1:-1]).max())

    @property
    def cell_load(self) -> float:
        """Load of a unit pressure on one cell, mean over the length."""
        return float(self.linear.equation.cell[0] / self.full_film.shape[1])

    def stacked(self, cells: Array, touching: Array, last: float) -> Array:
        """Return a vector of values of cells (x, y), of touching cells (x, y), and of the separation or the load.

        Of the second array it takes the touching cells alone.
        """
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
        return self.stacked(balance, film, self.flow * self.cell_load * total.sum())

    def eliminate(self, right: Array) -> Array:
        """Return the unknowns for a right-hand side in plane strain by Gaussian elimination of the matrix of `product`.

        Raises ``numpy.linalg.LinAlgError`` for a singular system.
        """
        linear, touching, free = self.linear, self.touching[:, 0], self.free[:, 0]
        influence, n = linear.equation.deflection.influence, len(touching)
        load = self.flow * self.cell_load
        matrix = np.zeros((right.size, right.size))
        by_deflection = matrix[:n, :n]
        for offset, coefficient in linear.thickness.items():
            first, end = max(0, -offset[0]), min(n, n - offset[0])
            by_film = (coefficient * neighbour(~self.touching, offset))[first:end]
            # a diagonal times the influence is the influence with its rows shifted
            by_deflection[first:end] += by_film * influence[first + offset[0] : end + offset[0]]
            matrix[first:end, -1] += by_film[:, 0]
        matrix[:n, n:-1] = by_deflection[:, touching]
        by_deflection[:, ~free] = 0
        matrix[n:-1, :n], matrix[n:-1, n:-1] = influence[touching] * free, influence[np.ix_(touching, touching)]
        matrix[n:-1, -1], matrix[-1, :n], matrix[-1, n:-1] = 1, load * free, load
        fixed = np.flatnonzero(linear.equation.fixed)
        matrix[fixed, fixed] = 1
        for bands, columns in ((linear.pressure, self.full_film), (linear.void, self.cavitated)):
            for offset, coefficient in bands.items():
                cells = np.flatnonzero(neighbour(columns, offset))
                matrix[cells, cells + offset[0]] += coefficient[cells, 0]
        scale = np.maximum(matrix.max(axis=1), -matrix.min(axis=1))
        matrix /= scale[:, None]
        return np.asarray(np.linalg.solve(matrix, right / scale))


def local_stage(system: StepSystem) -> LocalStage:
    """Return the local stage, which solves for pressures, and void fractions of cavitated cells.

    Its matrix has bands for a cell, its neighbours and the second cell upstream. It is Gauss-Seidel by lines across the
    contact. Sparse LU factors of 800 x 128 cells cost as much as 35 iterations, and solve in six times the time of the
    lines. They serve where cells touch: lubricant flows around these, and lines took up to a hundred times the
    iterations.

    Raises ``RuntimeError`` for a singular system.
    """
    linear, touching = system.linear, system.touching
    fixed, zero = linear.equation.fixed, np.zeros(touching.shape)
    bands = {}
    for offset in ((0, 0), (0, -1), (0, 1), (1, 0), (-1, 0), (-2, 0)):
        film_can_change = neighbour(~touching, offset)
        pressure = linear.pressure.get(offset, zero)
        pressure = pressure + ELASTIC_FRACTION * film_can_change * linear.thickness.get(offset, zero)
        if offset == (0, 0):
            pressure = pressure + WIDTH_FRACTION * linear.equation.cell[0] * film_can_change
        unknown = np.where(neighbour(system.cavitated, offset), linear.void.get(offset, zero), pressure)
        # cells without an unknown have a row of the identity
        bands[offset] = np.where(fixed | neighbour(fixed, offset), offset == (0, 0), unknown)
    return _by_factors(bands) if touching.any() else _by_lines(bands)


def _by_lines(bands: Bands) -> LocalStage:
    """Return Gauss-Seidel by lines across the contact, with the factors of every second line as one banded matrix.

    Lines of even and of odd numbers are solved in turn, PASSES times, each with the last solution of the other ones.

    Raises ``RuntimeError`` for a singular system.
    """
    downstream, diagonal, upstream, second_upstream, previous, following = (
        np.ascontiguousarray(bands[offset].T) for offset in ((1, 0), (0, 0), (-1, 0), (-2, 0), (0, -1), (0, 1))
    )
    columns, rows = diagonal.shape
    halves = []
    for start in (0, 1):
        lines = np.arange(start, columns, 2)
        matrix = np.zeros((6, len(lines) * rows))  # two rows are for the factors
        # the first two cells of a line and the last are fixed, so that lines do not act on each other
        matrix[2, 1:] = downstream[lines].ravel()[:-1]
        matrix[3] = diagonal[lines].ravel()
        matrix[4, :-1] = upstream[lines].ravel()[1:]
        matrix[5, :-2] = second_upstream[lines].ravel()[2:]
        factors, pivots, failed = dgbtrf(matrix, 2, 1, overwrite_ab=True)
        if failed:
            raise RuntimeError("singular")
        halves.append((lines, factors, pivots, previous[lines], following[lines]))

    def solve(right: Array) -> Array:
        given = np.ascontiguousarray(right.T)
        solution = np.zeros_like(given)
        for number in range(PASSES):
            lines, factors, pivots, by_previous, by_following = halves[number % 2]
            left = given[lines]
            if number:
                left -= by_previous * solution[lines - 1]
                left -= by_following * solution[(lines + 1) % columns]
            solved = dgbtrs(factors, 2, 1, left.ravel(), pivots, overwrite_b=True)[0]
            solution[lines] = solved.reshape(left.shape)
        return solution.T

    return solve


def _by_factors(bands: Bands) -> LocalStage:
    """Return the stage by sparse LU factors of the bands; raise ``RuntimeError`` for a singular system."""
    shape = bands[0, 0].shape
    index = np.arange(np.prod(shape)).reshape(shape)
    rows, columns, values = [], [], []
    for offset, coefficient in bands.items():
        inside = neighbour(np.ones(shape, dtype=bool), offset)
        rows.append(index[inside])
        columns.append(neighbour(index, offset)[inside])
        values.append(coefficient[inside])
    indices = np.concatenate(rows), np.concatenate(columns)
    factors = splu(csc_array((np.concatenate(values), indices), shape=(index.size, index.size)))
    return lambda right: np.asarray(factors.solve(right.ravel()).reshape(shape))


@dataclass(frozen=True, eq=False)
class FourierStage:
    """Inverses of the system averaged over the length, one for each harmonic along it.

    The inverse ``mean`` (x + 1, x + 1) is that of the mean over the length; it has the separation and the load as a
    last column and row. ``waves`` (harmonic, x, x) are those of the other harmonics, in single precision. ``scale``
    (harmonic, x) are the largest coefficients of the rows, which are divided by them, the mean included.
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
        solved, film_can_change, free = full_film | touching, ~touching, full_film & ~touching
        matrices[:, index, index] = 1 - solved.mean(axis=1)
        # both neighbours along have nearly the same mean coefficient, so that the sines of a harmonic cancel
        turn = np.cos(2 * np.pi * np.arange(number) / ny)
        for bands, elastic in ((linear.pressure, False), (linear.thickness, True)):
            for (across, along), coefficient in bands.items():
                counted = free & neighbour(film_can_change, (across, along)) if elastic else free
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
