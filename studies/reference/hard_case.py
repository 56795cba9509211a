"""What a hard case is: a contact, how it may end, and what its answer is held to."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.domain.padding import across_and_along
from studies.reference.dense_solver import answer, stated_error
from studies.reference.line_contact import HERTZ, SCENE

A, P_H = HERTZ.half_width, HERTZ.peak_pressure
# heights that the contact itself flattens
FLATTENED = SCENE.scales(cs.Grid(cells=(2, 1), extent=(A, A))).gap

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


@dataclass(frozen=True)
class Twin:
    """An equivalent form of the same contact: its pressure, brought ``back``, differs by no more than ``within``.

    Relative to the peak pressure. Where the heights are others, ``within`` comes on top of what their
    difference over the softest wave allows.
    """

    scene: cs.Scene
    grid: cs.Grid
    back: Callable[[Array], Array]
    within: float
    other_heights: bool = False


@dataclass(frozen=True)
class HardCase:
    """A scene on a grid with what is ``hard`` about it, and the statuses it may end in.

    Its pressure is held to the dense answer of :mod:`studies.reference.dense_solver`, or to that of its ``twin``.
    """

    group: str
    hard: str
    scene: cs.Scene
    grid: cs.Grid
    ends: frozenset[cs.Status] = ENDED
    twin: Twin | None = None
    options: cs.SolveOptions = field(default_factory=lambda: cs.SolveOptions(1e-10))
    start: Start | None = None
    paddings: tuple[str, ...] = tuple(PADDINGS)

    def solve(self, problem: cs.Problem, solver: cs.Solver) -> cs.Solution:
        """Return the solution of ``problem`` with this case's settings."""
        start = self.start(problem, solver) if self.start else None
        return replace(self.options, solver=solver).solved(problem, start)

    def may_end(self, padding: str) -> frozenset[cs.Status]:
        """Return the statuses it may end in with that padding: a free length cuts off whatever varies along it."""
        cut_off = padding == "zero" and cs.Status.CONVERGED in self.ends
        return self.ends | {cs.Status.CONTACT_AT_EDGE} if cut_off else self.ends

    def judge(
        self, solution: cs.Solution, padding: cs.Padding | cs.Paddings, solver: cs.Solver
    ) -> tuple[float, float]:
        """Return the error of the pressure and the error stated for it, over the peak pressure."""
        highest = float(solution.pressure.max())
        unit = solution.problem.scales.pressure
        twin_solution, allowed = None, 0.0
        if self.twin is not None:
            twin_solution = self.solve(self.twin.scene.problem(self.twin.grid, padding), solver)
            allowed = self.twin.within
        if self.twin is None or self.twin.other_heights:
            dense = answer(self.scene, self.grid, across_and_along(padding), solution)
            allowed += stated_error(solution, dense) * unit / highest
            right = dense.pressure * unit
        if twin_solution is not None:
            assert self.twin is not None
            right = self.twin.back(twin_solution.pressure)
            if self.twin.other_heights:
                gap_change = twin_solution.problem.undeformed_gap - solution.problem.undeformed_gap
                nudge = float(np.linalg.norm(gap_change)) / solution.problem.scales.gap
                allowed += nudge / dense.softest * unit / highest
        return float(np.abs(right - solution.pressure).max()) / highest, allowed


def grid(
    cells: tuple[int, int] = (24, 12), width: float = 2.4, period: float = 1.2, metre: float = 1.0
) -> cs.Grid:
    """Extents in Hertz half-widths of the plain scene."""
    return cs.Grid(cells=cells, extent=(width * A * metre, period * A * metre))


def bumpy(heights: Array, scene: cs.Scene = SCENE) -> cs.Scene:
    """``scene`` with ``heights`` towards the other body, in multiples of what it flattens, on its cells."""
    return replace(scene, shapes=(*scene.shapes, cs.MeasuredSurface(heights * FLATTENED)))


def noise(cells: tuple[int, int] = (24, 12), seed: int = 1) -> Array:
    """White: the grid's own wavelength is as strong as every other."""
    return np.random.default_rng(seed).standard_normal(cells)


FLAT = replace(SCENE, shapes=())
CELLS = (24, 12)
ROUGH = 0.1 * noise()
