"""This program beside others: time, and difference from its converged solution on cells of constant pressure.

On periodic axes the other programs represent the pressure as a sum of waves, which is another discretisation: there the
difference is no error. They are optional: ``pip install 'contactstudy[peers]'``. A program that is not installed, or
lacks a boundary condition, is left out. The form is that of asv (airspeed velocity); ``python -m benchmarks peers`` runs
them without it.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from time import process_time

import numpy as np
from threadpoolctl import ThreadpoolController

import contactstudy as cs
from contactstudy.domain.grid import Array
from studies.reference.line_contact import HERTZ, HERTZ_HEIGHT, P_H, SCENE, A

MODULUS = HERTZ.contact_modulus
FREE, EXACT = cs.ZeroPadding(), cs.ExactPeriodicity()
PADDINGS: dict[str, cs.Paddings] = {"semi-periodic": (FREE, EXACT), "free": (FREE, FREE), "periodic": (EXACT, EXACT)}
# a cylinder, a sphere whose contact fills the grid but for its corners, and a rough flat with a seventh in contact
SHAPES: dict[str, cs.Shape] = {
    "semi-periodic": cs.Cylinder(0.01),
    "free": cs.Sphere(0.02),
    "periodic": cs.Roughness(rms=HERTZ_HEIGHT, hurst=0.8, roll_off=A, cut_off=0.1 * A, seed=1),
}
WIDTH = 2.4  # half-widths, both ways
TOLERANCE = 1e-10  # for an error of about 1e-7; the others are given 1e-8 of their own measures


@dataclass(frozen=True)
class ProgramRun:
    """A program that solves one of the problems on a grid."""

    program: str
    boundary: str
    cells: int
    threads: int = 1

    def __post_init__(self) -> None:
        try:
            import_module(self.program)
        except ImportError:
            raise NotImplementedError(f"{self.program} is not installed") from None

    @property
    def grid(self) -> cs.Grid:
        """Grid, the same for every program."""
        return cs.Grid(cells=(self.cells, self.cells), extent=(WIDTH * A, WIDTH * A))

    def problem(self) -> cs.Problem:
        """Return the problem of this package."""
        scene = cs.Scene(SCENE.load, SCENE.solids, (SHAPES[self.boundary],))
        return scene.problem(self.grid, PADDINGS[self.boundary])

    def prepare(self) -> Callable[[], Array]:
        """Set the program up; return its solve."""
        with self._openmp():
            return PROGRAMS[self.program](self)

    def run(self, prepared: Callable[[], Array]) -> Array:
        """Solve; return the pressure [Pa]."""
        with self._openmp():
            return prepared()

    def _openmp(self) -> AbstractContextManager[object]:
        """Limit the threads of programs that use OpenMP."""
        limited: AbstractContextManager[object] = _libraries(self.program).limit(limits=self.threads, user_api="openmp")
        return limited


@cache
def _libraries(program: str) -> ThreadpoolController:
    """Return the libraries with threads that are loaded with `program`: to find them takes as long as a small solve."""
    import_module(program)
    return ThreadpoolController()


def _contactstudy(program_run: ProgramRun) -> Callable[[], Array]:
    """Return the solve of this package, whose result is the pressure (x, y) [Pa]."""
    problem, device = program_run.problem(), cs.Cpu(threads=program_run.threads)
    return lambda: cs.solve(problem, tolerance=TOLERANCE, device=device).pressure


def _contact_mechanics(program_run: ProgramRun) -> Callable[[], Array]:
    """Return the solve of ContactMechanics, whose result is the pressure (x, y) [Pa]."""
    if program_run.threads > 1:
        raise NotImplementedError("ContactMechanics has no threads: it shares work by MPI alone")
    import ContactMechanics as peer
    from ContactMechanics.Optimization import constrained_conjugate_gradients
    from SurfaceTopography import Topography

    grid, heights = program_run.grid, _heights(program_run)
    substrate = {
        "semi-periodic": lambda: peer.SemiPeriodicFFTElasticHalfSpace(
            grid.cells, MODULUS, grid.extent, periodicity=(False, True), n_images=10
        ),
        "free": lambda: peer.FreeFFTElasticHalfSpace(grid.cells, MODULUS, grid.extent),
        "periodic": lambda: peer.PeriodicFFTElasticHalfSpace(grid.cells, MODULUS, grid.extent),
    }[program_run.boundary]()

    def solve() -> Array:
        result = constrained_conjugate_gradients(
            substrate,
            Topography(heights, grid.extent),
            external_force=SCENE.largest_load * grid.length,
            pentol=1e-8 * P_H * A / MODULUS,
            forcetol=1e-8 * P_H * grid.cell_area,
        )
        return np.asarray(result.jac)[: program_run.cells, : program_run.cells] / grid.cell_area

    return solve


def _tamaas(program_run: ProgramRun) -> Callable[[], Array]:
    """Return the solve of tamaas, whose result is the pressure (x, y) [Pa]."""
    import tamaas as peer

    if program_run.boundary == "semi-periodic":
        raise NotImplementedError("tamaas has no boundary that is periodic along one axis only")
    peer.initialize(program_run.threads)
    grid, heights = program_run.grid, _heights(program_run)
    model = peer.ModelFactory.createModel(peer.model_type.basic_2d, list(grid.extent), list(grid.cells))
    model.E, model.nu = MODULUS, 0.0
    if program_run.boundary == "free":
        peer.ModelFactory.registerNonPeriodic(model, "dcfft")
    primal = peer.PolonskyKeerRey.pressure
    solver = peer.PolonskyKeerRey(model, heights, 1e-8, primal, primal)
    if program_run.boundary == "free":
        solver.setIntegralOperator("dcfft")
    solver.max_iter = 20_000
    solver.dump_freq = 100_000

    def solve() -> Array:
        model.traction[...] = 0.0  # it would begin at its last solution
        solver.solve(SCENE.largest_load / grid.extent[0])
        return np.array(model.traction)

    return solve


def _aspher(program_run: ProgramRun) -> Callable[[], Array]:
    """Return the solve of aspher, whose result is the pressure (x, y) [Pa]."""
    import aspher as peer

    if program_run.boundary == "semi-periodic":
        raise NotImplementedError("aspher has no boundary that is periodic along one axis only")
    grid, gap = program_run.grid, -_heights(program_run)
    backend = "fft" if program_run.boundary == "free" else "periodic"
    # its nested solver, in its own order of tasks: coarser grids first, down to the coarsest it halves to
    coarsest = program_run.cells
    while coarsest % 2 == 0 and coarsest > 64:
        coarsest //= 2

    def solve() -> Array:
        result = peer.solve_nested(
            program_run.cells,
            gap / A,
            SCENE.largest_load / grid.extent[0] / MODULUS,
            domain_size=grid.extent[0] / A,
            coarsest=coarsest,
            tol=1e-9,
            backend=backend,
        )
        return np.asarray(result.pressure).reshape(grid.cells) * MODULUS

    return solve


def _heights(program_run: ProgramRun) -> Array:
    """Return the heights (x, y) towards the other body [m]."""
    gap = SHAPES[program_run.boundary].gap(program_run.grid)
    return np.ascontiguousarray(-gap * np.ones(program_run.grid.cells))


PROGRAMS: dict[str, Callable[[ProgramRun], Callable[[], Array]]] = {
    "contactstudy": _contactstudy,
    "ContactMechanics": _contact_mechanics,
    "tamaas": _tamaas,
    "aspher": _aspher,
}


class Peers:
    """A program with a boundary condition on a grid, on one thread."""

    params = (list(PROGRAMS), list(PADDINGS), [128, 256, 512])
    param_names = ("program", "boundary", "cells")
    timer = staticmethod(process_time)

    def setup(self, program: str, boundary: str, cells: int) -> None:
        """Set a program up; raise NotImplementedError for one that is not there or lacks the boundary."""
        self.case = ProgramRun(program, boundary, cells)
        self.solve = self.case.prepare()

    def time_solve(self, program: str, boundary: str, cells: int) -> None:
        """Solve."""
        self.case.run(self.solve)

    def track_difference(self, program: str, boundary: str, cells: int) -> float:
        """Return the largest difference of the pressure over the peak pressure."""
        converged = cs.solve(self.case.problem(), tolerance=1e-12).pressure
        return float(np.abs(self.case.run(self.solve) - converged).max() / converged.max())

    def track_load(self, program: str, boundary: str, cells: int) -> float:
        """Return the load carried over the load given: they should agree."""
        load = SCENE.largest_load * self.case.grid.length
        return float(self.case.run(self.solve).sum()) * self.case.grid.cell_area / load
