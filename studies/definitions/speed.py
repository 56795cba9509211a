"""Time, iterations and memory against the grid, by device, and on surfaces as fine as the cells."""

import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import prod, sqrt
from time import perf_counter, process_time

import numpy as np
import xarray as xr
from scipy.special import erfinv

import contactstudy as cs
from contactstudy.domain.checks import in_range, positive, whole_number
from contactstudy.domain.device import Device, using
from contactstudy.elasticity.convolution import Convolution
from contactstudy.elasticity.transforms import transforms
from studies.model.axis import Axis, one_of
from studies.model.case import Case, contact_fraction, dimensionless, recorded
from studies.model.study import Point
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE, A

LINE, SMOOTH, ROUGH, SELF_AFFINE = "line", "smooth", "rough", "self-affine"
SURFACES = (LINE, SMOOTH, ROUGH, SELF_AFFINE)
DEVICES: dict[str, Callable[[int], Device]] = {"cpu": cs.Cpu, "gpu": lambda threads: cs.Gpu()}
EXACT = cs.ExactPeriodicity()
# Single precision does not reach the residual of double.
TOLERANCES = {cs.Precision.DOUBLE: 1e-8, cs.Precision.SINGLE: 1e-5}
# Solves and transforms are repeated until they have taken so long together [s].
SECONDS = 0.05
WIDTH, PERIOD = 4.8, 2.4  # half-widths
# It leaves a third of Hertz's area in contact.
ROUGHNESS = cs.Roughness(
    rms=0.6 * HERTZ_HEIGHT, hurst=0.8, roll_off=1.2 * A, cut_off=0.15 * A, seed=1
)
# Iterations after which the memory of a solve does not grow: all fields are allocated after the second.
ENOUGH = 3
# Of the self-affine surface: its longest wave over its side, and its rms slope.
ROLL_OFF, SLOPE = 0.25, 0.1

axes = (
    Axis(
        "surface",
        SURFACES,
        "surface: a line in plane strain, a smooth or rough cylinder, or self-affine and flat",
    ),
    Axis("hurst", (0.2, 0.8), "Hurst exponent of the self-affine surface"),
    Axis("cut_off", (2.0,), "shortest wavelength of the self-affine surface, in cells"),
    Axis("fraction", (0.2,), "fraction in contact of the self-affine surface, by Persson (2001)"),
    Axis("precision", ("double",), "floating-point precision"),
    Axis("device", ("cpu",), "what solves: the CPU, or the GPU"),
    Axis("threads", (1, 2), "threads of the processor"),
    Axis("grid", (32, 64, 128, 256, 512), "cells across the width and along one period"),
)


@dataclass(frozen=True)
class CaseOnDevice:
    """A case to solve on a device."""

    case: Case
    device: Device

    def prepare(self) -> cs.Problem:
        """Return the problem: influence coefficients, transforms, gap."""
        return self.case.prepare()

    def run(self, prepared: cs.Problem) -> cs.Contact:
        """Solve; return the solution."""
        return self.solved(prepared, self.case.options.max_iterations)

    def solved(self, problem: cs.Problem, max_iterations: int) -> cs.Contact:
        """Return the solution after at most ``max_iterations``."""
        options = replace(self.case.options, max_iterations=max_iterations)
        return cs.solve(problem, device=self.device, options=options)

    def record(self, result: cs.Contact) -> Mapping[str, xr.Variable]:
        """Return the solver's numbers."""
        return recorded(result)


def clock_of(device: Device) -> Callable[[], float]:
    """Return the clock: CPU time, which a busy neighbour does not lengthen, where the processor does all the work."""
    return process_time if isinstance(device, cs.Cpu) else perf_counter


def case_at(point: Point) -> CaseOnDevice:
    """Return a contact on a device: a line contact, or a flat self-affine surface periodic along both axes."""
    surface = one_of("surface", point["surface"], SURFACES)
    cells = whole_number("grid", point["grid"], 2, "give at least 2 cells across the width")
    threads = whole_number("threads", point["threads"], 1, "must be a whole number, at least 1")
    precision = cs.Precision.named(str(point["precision"]))
    padding: cs.Padding | cs.Paddings = EXACT
    if surface == SELF_AFFINE:
        grid = cs.Grid(cells=(cells, cells), extent=(A, A))
        family = (float(point[name]) for name in ("hurst", "cut_off", "fraction"))
        scene, padding = self_affine(grid, *family), (EXACT, EXACT)
    else:
        grid = cs.Grid((cells, 1 if surface == LINE else cells), (WIDTH * A, PERIOD * A))
        rough = (ROUGHNESS,) if surface == ROUGH else ()
        scene = replace(SCENE, shapes=SCENE.shapes + rough)
    options = cs.SolveOptions(TOLERANCES[precision], precision=precision)
    case = Case(scene, grid, padding, options)
    return CaseOnDevice(case, DEVICES[one_of("device", point["device"], DEVICES)](threads))


def self_affine(grid: cs.Grid, hurst: float, cut_off: float, fraction: float) -> cs.Scene:
    """Return a flat surface with waves down to so many cells, under the load of a ``fraction`` in contact.

    Source: Persson (2001): the fraction is ``erf(sqrt(2) p / (E* slope))``.
    """
    side = grid.length
    cut_off = positive("cut_off", cut_off, "give a number of cells above 0")
    fraction = in_range("fraction", fraction, "give a fraction between 0 and 1")
    if fraction >= 1:
        raise cs.InvalidInput(f"fraction is {fraction!r}: give a fraction between 0 and 1.")
    rms, longest, shortest = cs.RmsSlope(SLOPE), ROLL_OFF * side, cut_off * grid.cell_size[0]
    shape = cs.Roughness(rms=rms, hurst=hurst, roll_off=longest, cut_off=shortest, seed=1)
    mean = float(erfinv(fraction)) / sqrt(2) * SCENE.contact_modulus * SLOPE
    return cs.Scene(cs.LineLoad(mean * side), SCENE.solids, (shape,))


def measures(case: CaseOnDevice, result: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return the fraction in contact, the peak host memory of a solve, and its time over that of its transforms."""
    problem = result.problem
    peak = peak_bytes(lambda: case.solved(problem, ENOUGH))
    seconds = least_seconds(clock_of(case.device), lambda: case.run(problem))
    pair = transform_seconds(problem.operator, case.case.options.precision, case.device)
    fields, ratio = peak / (8 * prod(problem.grid.cells)), seconds / (result.convolutions * pair)
    what = "peak host memory of a solve over that of one field in double precision"
    return {
        "contact_fraction": contact_fraction(result.pressure),
        "memory": dimensionless(fields, what),
        "transform_ratio": dimensionless(ratio, "time of a solve over that of its bare transforms"),
    }


def peak_bytes(compute: Callable[[], object]) -> int:
    """Return the peak memory [bytes] that Python and numpy allocate in `compute`."""
    tracemalloc.start()
    try:
        compute()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def least_seconds(clock: Callable[[], float], act: Callable[[], object]) -> float:
    """Return the least time [s] of three runs of `act`, or of as many more as take ``SECONDS`` together."""
    durations: list[float] = []
    while len(durations) < 3 or sum(durations) < SECONDS:
        before = clock()
        act()
        durations.append(clock() - before)
    return min(durations)


def transform_seconds(operator: cs.Operator, precision: cs.Precision, device: Device) -> float:
    """Return the least time [s] of a bare pair of transforms of the operator's size."""
    assert isinstance(operator, Convolution)
    with using(device):
        scaled, pair = operator.scaled(1.0, precision), transforms()
        field = device.to_device(np.zeros(scaled.cells, dtype=precision.real))

        def transform_pair() -> float:
            work = scaled.work_array(scaled.padded, precision.real)
            waves = pair.forward(field, scaled.padded, work)
            # read, so that another device is done
            return float(pair.backward(waves, scaled.cells, scaled.padded)[0, 0])

        return least_seconds(clock_of(device), transform_pair)
