"""Hard cases: a contact, the statuses in which a solve may end, and the verdict on its pressure."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum
from math import inf
from typing import NamedTuple

import numpy as np

import contactstudy as cs
from contactstudy.accuracy.residual_errors import residual_errors
from contactstudy.domain.fields import Array
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE, A, relative_l1

FREE, EXACT = cs.ZeroPadding(), cs.ExactPeriodicity()
PADDINGS: dict[str, cs.Padding | cs.Paddings] = {
    "zero": FREE,
    "duplicated": cs.DuplicatedPadding(),
    "superposed": cs.Superposition(2),
    "circular": cs.CircularSuperposition(2),
    "exact": EXACT,
    "exact on both": (EXACT, EXACT),
    "circular on both": (cs.CircularSuperposition(1), cs.DuplicatedPadding()),
}
SOLVERS: dict[str, cs.Solver] = {
    "preconditioned CG": cs.PreconditionedCG(),
    "Polonsky-Keer": cs.PolonskyKeer(),
}

Start = Callable[[cs.Problem, cs.Solver], Array]
ENDED = frozenset({cs.Status.CONVERGED})
AT_EDGE = frozenset({cs.Status.CONVERGED, cs.Status.CONTACT_AT_EDGE})
EXACT_TO_ROUNDING = frozenset({cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT})


# Statuses without an answer, which say why.
UNFINISHED = frozenset(
    {cs.Status.ITERATION_LIMIT, cs.Status.STALLED, cs.Status.NO_ADMISSIBLE_PRESSURE}
)
# Stated errors above this, or this many tolerances, are worth nothing: a residual times the condition number of some
# dozen long cells is smaller.
WORTHLESS, WORTHLESS_TOLERANCES = 1e-4, 100


class Verdict(Enum):
    """Verdict on an answer: its error is within the stated one; a status explains why there is none; or neither."""

    WITHIN_STATED_ERROR = 0
    EXPLAINED_BY_STATUS = 1
    WRONG = 2
    NOT_APPLICABLE = 3


class Judgement(NamedTuple):
    """Verdict on an answer, its relative L1 error, and the one that the program states; infinite without an answer."""

    verdict: Verdict
    error: float = inf
    stated: float = inf


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
    paddings
        Names of the paddings to which the case applies.
    """

    scene: cs.Scene
    grid: cs.Grid
    ends: frozenset[cs.Status] = ENDED
    options: cs.SolveOptions = field(default_factory=lambda: cs.SolveOptions(1e-10))
    start: Start | None = None
    paddings: tuple[str, ...] = tuple(PADDINGS)

    def solve(self, problem: cs.Problem, solver: cs.Solver) -> cs.Contact:
        """Return the solution of ``problem`` with this case's settings."""
        start = self.start(problem, solver) if self.start else None
        return cs.solve(problem, start=start, options=replace(self.options, solver=solver))

    def allowed_statuses(self, padding: str) -> frozenset[cs.Status]:
        """Return the statuses in which a solve with a padding may end; free ends cut off what varies along it."""
        cut_off = padding == "zero" and cs.Status.CONVERGED in self.ends
        return self.ends | {cs.Status.CONTACT_AT_EDGE} if cut_off else self.ends

    def judge(
        self, solution: cs.Contact, padding: str, reference: Callable[[], tuple[Array, float]]
    ) -> Judgement:
        """Return the verdict on a solution, with its error and the one that the program states.

        `reference` gives the pressure (x, y) [Pa] to compare with, and a bound on its own relative L1 error. The stated
        error is that by the residual in ``solution.error``. It must be small enough to be worth stating, so that an
        answer which says that it is wrong by all of itself is refused.
        """
        if padding not in self.paddings:
            return Judgement(Verdict.NOT_APPLICABLE)
        expected = solution.status in self.allowed_statuses(padding)
        if solution.status in UNFINISHED:
            return Judgement(Verdict.EXPLAINED_BY_STATUS if expected else Verdict.WRONG)
        pressure, of_reference = reference()
        error, stated = relative_l1(solution.pressure, pressure), stated_error(solution)
        useful = max(WORTHLESS, WORTHLESS_TOLERANCES * self.options.tolerance)
        right = expected and error <= stated + of_reference and stated <= useful
        return Judgement(Verdict.WITHIN_STATED_ERROR if right else Verdict.WRONG, error, stated)


def stated_error(solution: cs.Contact) -> float:
    """Return the relative L1 error of the pressure that the program states for the residual of a solution."""
    stated = solution.error.l1.residual
    # no bound is known for windows along both axes
    return residual_errors(solution).l1 if stated is None else stated


def grid(
    cells: tuple[int, int] = (24, 12), width: float = 2.4, period: float = 1.2, metre: float = 1.0
) -> cs.Grid:
    """Return a grid whose extents are in Hertz half-widths of the plain scene, with lengths in another unit."""
    return cs.Grid(cells=cells, extent=(width * A * metre, period * A * metre))


def with_heights(heights: Array, scene: cs.Scene = SCENE) -> cs.Scene:
    """Return a scene with heights (x, y) towards the other body, over the height that the contact flattens."""
    return replace(scene, shapes=(*scene.shapes, cs.MeasuredSurface(heights * HERTZ_HEIGHT)))


def noise(cells: tuple[int, int] = (24, 12), seed: int = 1) -> Array:
    """Return white noise (x, y) of unit variance."""
    return np.random.default_rng(seed).standard_normal(cells)


FLAT = replace(SCENE, shapes=())
CELLS = (24, 12)
ROUGH = 0.1 * noise()
