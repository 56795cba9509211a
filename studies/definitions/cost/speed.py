"""What grows with the grid: time, iterations and memory, by threads, and on surfaces as fine as the cells."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import prod, sqrt
from time import process_time

import numpy as np
import xarray as xr
from scipy.special import erfinv

import contactstudy as cs
from contactstudy.domain.checks import in_range, positive, whole
from contactstudy.domain.device import using
from contactstudy.elasticity.convolution import Convolution
from contactstudy.elasticity.transforms import TRANSFORMS
from studies.definitions.cost import solvers
from studies.definitions.cost.peak_memory import ENOUGH, peak_bytes
from studies.model.axis import Axis, one_of
from studies.model.case import Case, number
from studies.model.study import Point
from studies.reference.line_contact import HERTZ, SCENE

ROUGH, SELF_AFFINE = "rough", "self-affine"
# Single precision does not reach the residual of double.
TOLERANCES = {cs.Precision.DOUBLE: 1e-8, cs.Precision.SINGLE: 1e-5}
# Of the self-affine surface: its longest wave over its side, and its rms slope.
ROLL_OFF, SLOPE = 0.25, 0.1

points = (
    Axis("surface", (ROUGH, SELF_AFFINE), "surface: rough on a cylinder, or self-affine and flat"),
    Axis("hurst", (0.2, 0.8), "Hurst exponent of the self-affine surface"),
    Axis("cut_off", (2.0,), "shortest wavelength of the self-affine surface, in cells"),
    Axis("share", (0.2,), "share in contact of the self-affine surface, by Persson (2001)"),
    Axis("precision", ("double",), "floating-point numbers"),
    Axis("threads", (1, 2), "threads of the solve"),
    Axis("grid", (128, 256, 512), "cells across the width and along one period"),
)


@dataclass(frozen=True)
class Timed:
    """A solution, and the CPU time [s] of its solve, that of all threads together."""

    solution: cs.Solution
    seconds: float


@dataclass(frozen=True)
class CaseOnThreads:
    """A case to solve on so many threads."""

    case: Case
    threads: int = 1

    def prepare(self) -> cs.Problem:
        """Influence coefficients, transforms, gap."""
        return self.case.prepare()

    def run(self, prepared: cs.Problem) -> Timed:
        """The solve proper."""
        before = process_time()
        solution = self.solved(prepared, self.case.max_iterations)
        return Timed(solution, process_time() - before)

    def solved(self, problem: cs.Problem, max_iterations: int) -> cs.Solution:
        """The solution, or what it is after so many iterations."""
        return cs.solve(
            problem,
            tolerance=self.case.tolerance,
            max_iterations=max_iterations,
            precision=self.case.precision,
            on=cs.Cpu(self.threads),
        )

    def record(self, result: Timed) -> Mapping[str, xr.Variable]:
        """The solver's own numbers."""
        return self.case.record(result.solution)


def scene_at(point: Point) -> CaseOnThreads:
    """A contact on so many threads: a line contact, or a flat self-affine surface periodic along both axes."""
    surface = one_of("surface", point["surface"], (ROUGH, SELF_AFFINE))
    cells = whole("grid", point["grid"], 2, "give at least 2 cells across the width")
    threads = whole("threads", point["threads"], 1, "give a whole number of threads from 1 on")
    precision = cs.Precision.named(str(point["precision"]))
    if surface == ROUGH:
        described = solvers.scene_at({"solver": "preconditioned_cg", "surface": ROUGH, **point})
        scene, grid, padding = described.scene, described.grid, described.padding
    else:
        grid = cs.Grid(cells=(cells, cells), extent=(HERTZ.half_width, HERTZ.half_width))
        scene = self_affine(grid, *(float(point[name]) for name in ("hurst", "cut_off", "share")))
        padding = (cs.ExactPeriodicity(), cs.ExactPeriodicity())
    case = Case(scene, grid, padding, tolerance=TOLERANCES[precision], precision=precision)
    return CaseOnThreads(case, threads)


def self_affine(grid: cs.Grid, hurst: float, cut_off: float, share: float) -> cs.Scene:
    """A flat surface with waves down to so many cells, under the load of a ``share`` in contact.

    Source: Persson (2001): the share is ``erf(sqrt(2) p / (E* slope))``.
    """
    side = grid.period
    cut_off = positive("cut_off", cut_off, "give a number of cells above 0")
    share = in_range("share", share, "give a share between 0 and 1")
    if share >= 1:
        raise cs.InvalidInput(f"share is {share!r}: give a share between 0 and 1.")
    shape = cs.Roughness(
        rms=cs.RmsSlope(SLOPE),
        hurst=hurst,
        roll_off=ROLL_OFF * side,
        cut_off=cut_off * grid.cell[0],
        seed=1,
    )
    mean = float(erfinv(share)) / sqrt(2) * SCENE.contact_modulus * SLOPE
    return cs.Scene(cs.LineLoad(mean * side), SCENE.solids, (shape,))


def measures(case: CaseOnThreads, result: Timed) -> Mapping[str, xr.Variable]:
    """The share in contact, the most memory a solve holds, and its time over that of its transforms."""
    problem = result.solution.problem
    peak = peak_bytes(lambda: case.solved(problem, ENOUGH))
    pair = transform_seconds(problem.operator, case.case.precision, case.threads)
    return {
        "contact_share": number(
            float((result.solution.pressure > 0).mean()), "share of cells in contact"
        ),
        "memory": number(
            peak / (8 * prod(problem.grid.cells)),
            "peak memory of a solve over that of one field in double precision",
        ),
        "transform_ratio": number(
            result.seconds / (result.solution.convolutions * pair),
            "CPU time of a solve over that of its bare transforms",
        ),
    }


def transform_seconds(operator: cs.Operator, precision: cs.Precision, threads: int) -> float:
    """CPU time [s] of one bare pair of transforms of the operator's size, the least of three."""
    assert isinstance(operator, Convolution)
    field = np.zeros(operator.cells, dtype=precision.real)
    px, py = operator.padded
    work = np.empty((px, py // 2 + 1), dtype=np.result_type(precision.real, np.complex64))
    least = np.inf
    with using(cs.Cpu(threads)):
        for _ in range(3):
            before = process_time()
            waves = TRANSFORMS.forward(field, operator.padded, work)
            TRANSFORMS.backward(waves, operator.cells, operator.padded)
            least = min(least, process_time() - before)
    return float(least)
