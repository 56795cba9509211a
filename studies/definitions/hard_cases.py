"""Hard cases: contacts that are difficult to solve, and the statuses in which a solve may end.

The study `stability` solves those that are named here, with every padding and by two solvers; the tests have more of
each kind.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import inf
from typing import cast

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.error_terms import residual_errors
from contactstudy.domain.grid import Array
from contactstudy.io.dataset import flags
from studies.model.axis import Axis, one_of
from studies.model.case import dimensionless, recorded
from studies.model.study import Point, Study
from studies.reference.line_contact import HERTZ_HEIGHT, P_H, SCENE, STEEL, A, relative_l1

Start = Callable[[cs.Problem, cs.Solver], Array]
ENDED = frozenset({cs.Status.CONVERGED})
AT_EDGE = frozenset({cs.Status.CONVERGED, cs.Status.CONTACT_AT_EDGE})
EXACT_TO_ROUNDING = frozenset({cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT})
# Statuses without an answer, which say why.
UNFINISHED = frozenset({cs.Status.ITERATION_LIMIT, cs.Status.STALLED, cs.Status.NO_ADMISSIBLE_PRESSURE})
# Stated errors above this, or this many tolerances, are worth nothing: a residual times the condition number of some
# dozen long cells is smaller.
WORTHLESS, WORTHLESS_TOLERANCES = 1e-4, 100
SOLVERS: dict[str, cs.Solver] = {"preconditioned CG": cs.PreconditionedCG(), "Polonsky-Keer": cs.PolonskyKeer()}


@dataclass(frozen=True)
class HardCase:
    """A scene on a grid that is difficult to solve.

    Attributes
    ----------
    scene, grid
        The contact.
    ends
        Statuses in which a solve may end.
    options
        Options of a solve.
    start
        Function of problem and solver that returns the pressure to start from.
    padding
        That of the study.
    """

    scene: cs.Scene
    grid: cs.Grid
    ends: frozenset[cs.Status] = ENDED
    options: cs.SolveOptions = field(default_factory=lambda: cs.SolveOptions(1e-10))
    start: Start | None = None
    padding: cs.Padding | cs.Paddings = field(default_factory=cs.ExactPeriodicity)

    def prepare(self) -> cs.Problem:
        """Return the problem."""
        return self.scene.problem(self.grid, self.padding)

    def run(self, prepared: cs.Problem) -> list[cs.Contact]:
        """Return the solution by each solver."""
        return [self.solve(prepared, solver) for solver in SOLVERS.values()]

    def record(self, result: list[cs.Contact]) -> Mapping[str, xr.Variable]:
        """Return the numbers of the first solver."""
        return recorded(result[0])

    def solve(self, problem: cs.Problem, solver: cs.Solver) -> cs.Contact:
        """Return the solution of ``problem`` with this case's settings."""
        start = self.start(problem, solver) if self.start else None
        return cast(cs.Contact, cs.solve(problem, start=start, options=replace(self.options, solver=solver)))

    def expects(self, solution: cs.Contact, padding: object) -> bool:
        """Return whether a solve with a padding may end so; free ends cut off what varies along the length."""
        cut_off = padding == cs.ZeroPadding() and cs.Status.CONVERGED in self.ends
        return solution.status in (self.ends | {cs.Status.CONTACT_AT_EDGE} if cut_off else self.ends)

    def is_useful(self, stated: float) -> bool:
        """Return whether a stated error is small enough to be worth stating."""
        return stated <= max(WORTHLESS, WORTHLESS_TOLERANCES * self.options.tolerance)


def stated_error(solution: cs.Contact) -> float:
    """Return the relative L1 error of the pressure that the program states for the residual of a solution."""
    stated = solution.error.l1.residual
    # no bound is known for windows along both axes
    return residual_errors(solution).l1 if stated is None else stated


def grid(cells: tuple[int, int] = (24, 12), width: float = 2.4, period: float = 1.2) -> cs.Grid:
    """Return a grid of some `width` and `period` in half-widths of the plain scene."""
    return cs.Grid(cells, (width * A, period * A))


def with_heights(heights: Array, scene: cs.Scene = SCENE) -> cs.Scene:
    """Return a scene with heights (x, y) towards the other body, over the height that the contact flattens."""
    return replace(scene, shapes=(*scene.shapes, cs.MeasuredSurface(heights * HERTZ_HEIGHT)))


def noise(cells: tuple[int, int] = (24, 12), seed: int = 1) -> Array:
    """Return white noise (x, y) of unit variance."""
    return np.random.default_rng(seed).standard_normal(cells)


FLAT = replace(SCENE, shapes=())
CELLS = (24, 12)  # of most cases
ROUGH = 0.1 * noise()


def between(first: cs.HalfSpace, second: cs.HalfSpace) -> HardCase:
    """Return a smooth contact of two materials, on a grid of its own half-width."""
    scene = replace(SCENE, solids=(first, second))
    hertz = scene.hertz
    assert hertz is not None
    return HardCase(scene, cs.Grid(CELLS, (2.4 * hertz.half_width, 1.2 * hertz.half_width)))


def _rough(heights: Array, scene: cs.Scene = SCENE) -> HardCase:
    """Return a contact with heights (x, y) over a²/(2R), which may reach the edges of the grid."""
    return HardCase(with_heights(heights, scene), grid(heights.shape), AT_EDGE)


def _corner(problem: cs.Problem, solver: cs.Solver) -> Array:
    """Return a pressure on one corner cell."""
    pressure = np.zeros_like(problem.undeformed_gap)
    pressure[0, 0] = 1.0
    return pressure


WAVY = replace(FLAT, shapes=(cs.Waviness(1e-3 * HERTZ_HEIGHT, along=1.2 * A),))
PUNCH = np.where(np.abs(grid().x)[:, None] < 0.5 * A, 0.0, -1e4) * np.ones(CELLS)
YIELDING = replace(with_heights(ROUGH), hardness=0.33 * P_H)  # from 0.327 p_H on the load is carried
TOO_SOFT = replace(SCENE, hardness=0.3 * P_H)
START = _rough(3 * ROUGH)
CASES: dict[str, HardCase] = {
    "period of 0.001 half-widths": HardCase(SCENE, grid((24, 6), period=1e-3)),
    "period of 1000 half-widths": HardCase(SCENE, grid((24, 6), period=1e3)),
    "cells 1000 times as long as wide": HardCase(SCENE, grid((24, 6), period=600.0)),
    "one cell touches": HardCase(with_heights(np.eye(1, 288, 150).reshape(CELLS) * 30), grid()),
    "full contact": HardCase(WAVY, grid(), AT_EDGE),
    "load of 1e-30 N/m": HardCase(replace(SCENE, load=cs.LineLoad(1e-30)), grid()),
    "rigid on elastic": between(cs.HalfSpace(inf, 0.3), STEEL),
    "moduli 1:1000000": between(STEEL, cs.HalfSpace(210e3, 0.3)),
    "hardness just above the mean pressure": HardCase(YIELDING, grid(width=4.8), AT_EDGE),
    "hardness below the mean pressure": HardCase(
        TOO_SOFT, grid(width=4.8), frozenset({cs.Status.NO_ADMISSIBLE_PRESSURE})
    ),
    "a needle": _rough(100 * np.eye(1, 1024, 16 * 32 + 8).reshape(32, 32)),
    "a step": _rough(np.where(np.arange(12) < 6, 0.0, 0.5) * np.ones(CELLS)),
    "a flat punch": _rough(PUNCH, FLAT),
    "white noise": _rough(noise()),
    "tolerance 1e-14": replace(START, options=cs.SolveOptions(1e-14), ends=EXACT_TO_ROUNDING | AT_EDGE),
    "single precision": replace(
        START, options=cs.SolveOptions(1e-10, precision="single"), ends=frozenset({cs.Status.PRECISION_LIMIT})
    ),
    "one iteration": replace(START, options=cs.SolveOptions(1e-10, 1), ends=frozenset({cs.Status.ITERATION_LIMIT})),
    "start at a wrong corner": replace(START, start=_corner),
}


# The study `stability`

PADDINGS: dict[str, cs.Padding | cs.Paddings] = {
    "zero": cs.ZeroPadding(),
    "superposed": cs.Superposition(2),
    "exact": cs.ExactPeriodicity(),
    "exact on both": (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
}
AXES = (
    Axis("case", tuple(CASES), "hard case"),
    Axis("padding", tuple(PADDINGS), "treatment of both directions (padding)"),
)
WITHIN, EXPLAINED, NEITHER = range(3)
VERDICTS = "within_stated_error", "explained_by_status", "neither"


def case_at(point: Point) -> HardCase:
    """Return a case by its name."""
    padding = PADDINGS[one_of("padding", point["padding"], PADDINGS)]
    return replace(CASES[one_of("case", point["case"], CASES)], padding=padding)


def measures(case: HardCase, solutions: list[cs.Contact]) -> Mapping[str, xr.Variable]:
    """Return the L1 difference of the pressures, the sum of the errors stated for their residuals, and the verdict."""
    first, second = solutions
    expected = all(case.expects(solved, case.padding) for solved in solutions)
    difference, stated = inf, inf
    if all(solved.status in UNFINISHED for solved in solutions):
        verdict = EXPLAINED if expected else NEITHER
    else:
        difference = relative_l1(second.pressure, first.pressure)
        stated = sum(map(stated_error, solutions))
        is_within = expected and difference <= stated and case.is_useful(stated)
        verdict = WITHIN if is_within else NEITHER
    what = "relative L1 {} of the pressure{}, infinite where there is no answer"
    return {
        "pressure_difference_l1": dimensionless(difference, what.format("difference", " by two solvers")),
        "stated_error": dimensionless(stated, what.format("error", " that the program states for both")),
        "verdict": flags((), np.asarray(verdict), VERDICTS, "verdict on the case"),
    }


# the grids are small, and their times are not reported
stability = Study(
    "stability",
    "Hard cases: whether two solvers give one answer within the errors that they state, with every padding.",
    AXES, case_at, measures, "none",
)  # fmt: skip
