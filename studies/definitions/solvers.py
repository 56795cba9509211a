"""Time, iterations, convolutions and memory of both solvers against the grid."""

import tracemalloc
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import prod

import xarray as xr

import contactstudy as cs
from contactstudy.domain.checks import whole_number
from studies.model.axis import Axis, one_of
from studies.model.case import Case, contact_fraction, dimensionless
from studies.model.study import Point
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE, A

SOLVERS: dict[str, cs.Solver] = {
    "preconditioned_cg": cs.PreconditionedCG(),
    "polonsky_keer": cs.PolonskyKeer(),
}
# the roughness leaves a third of Hertz's area in contact
SURFACES: dict[str, tuple[cs.Shape, ...]] = {
    "smooth": (),
    "wavy": (cs.Waviness(amplitude=0.3 * HERTZ_HEIGHT, across=0.6 * A, along=0.6 * A),),
    "rough": (
        cs.Roughness(rms=0.6 * HERTZ_HEIGHT, hurst=0.8, roll_off=1.2 * A, cut_off=0.15 * A, seed=1),
    ),
}
WIDTH, PERIOD = 4.8, 2.4  # half-widths

axes = (
    Axis("solver", tuple(SOLVERS), "solver"),
    Axis("surface", tuple(SURFACES), "what lies on the cylinder"),
    Axis("grid", (128, 256, 512), "cells across the width and along one period"),
)


def case_at(point: Point) -> Case:
    """Return a line contact, exactly periodic, to the default tolerance."""
    solver = one_of("solver", point["solver"], SOLVERS)
    surface = one_of("surface", point["surface"], SURFACES)
    cells = whole_number("grid", point["grid"], 2, "give at least 2 cells across the width")
    return Case(
        scene=replace(SCENE, shapes=SCENE.shapes + SURFACES[surface]),
        grid=cs.Grid(cells=(cells, cells), extent=(WIDTH * A, PERIOD * A)),
        padding=cs.ExactPeriodicity(),
        options=cs.SolveOptions(max_iterations=5000, solver=SOLVERS[solver]),
    )


def measures(case: Case, result: cs.Contact) -> Mapping[str, xr.Variable]:
    """Return the fraction in contact and the peak memory of a solve."""
    short_case = replace(case, options=replace(case.options, max_iterations=ENOUGH))
    problem = short_case.prepare()
    peak = peak_bytes(lambda: short_case.run(problem))
    return {
        "contact_fraction": contact_fraction(result.pressure),
        "memory": dimensionless(
            peak / (8 * prod(case.grid.cells)), "peak memory of a solve over that of one field"
        ),
    }


# Iterations after which the memory of a solve does not grow: all fields are allocated after the second.
ENOUGH = 3


def peak_bytes(compute: Callable[[], object]) -> int:
    """Return the peak memory [bytes] that Python and numpy allocate in `compute`."""
    tracemalloc.start()
    try:
        compute()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
