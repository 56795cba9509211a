"""Hard cases: a contact, the statuses in which a solve may end, and the reference for its pressure."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import across_and_along
from studies.reference.dense_solver import answer, stated_error
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE, STEEL, A

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
class EquivalentForm:
    """An equivalent form of the same contact, and the function that converts its pressure to the original form.

    `tolerance` is the largest difference of the converted pressure over the peak pressure. With `other_heights` the
    heights differ from those of the original form, and it is added to their difference over the compliance of the
    stiffest mode.
    """

    scene: cs.Scene
    grid: cs.Grid
    to_original: Callable[[Array], Array]
    tolerance: float
    other_heights: bool = False


@dataclass(frozen=True)
class HardCase:
    """A scene on a grid that is difficult to solve, with its reference solution.

    Its pressure is compared with that of :mod:`studies.reference.dense_solver`, or with that of its `equivalent`.

    Attributes
    ----------
    scene, grid
        The contact.
    ends
        Statuses in which a solve may end.
    equivalent
        Equivalent form of the contact.
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
    equivalent: EquivalentForm | None = None
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

    def error_and_bound(
        self, solution: cs.Contact, padding: cs.Padding | cs.Paddings, solver: cs.Solver
    ) -> tuple[float, float]:
        """Return the error of the pressure and the error stated for it, over the peak pressure."""
        highest = float(solution.pressure.max())
        unit = solution.problem.scales.pressure
        form, bound = self.equivalent, 0.0
        if form is None or form.other_heights:
            dense = answer(self.scene, self.grid, across_and_along(padding), solution)
            bound += stated_error(solution, dense) * unit / highest
            reference = dense.pressure * unit
        if form is not None:
            problem = form.scene.problem(form.grid, padding)
            reference = form.to_original(self.solve(problem, solver).pressure)
            bound += form.tolerance
            if form.other_heights:
                gap_change = problem.undeformed_gap - solution.problem.undeformed_gap
                height_change = float(np.linalg.norm(gap_change)) / solution.problem.scales.gap
                bound += height_change / dense.smallest_eigenvalue * unit / highest
        return float(np.abs(reference - solution.pressure).max()) / highest, bound


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


def units() -> dict[str, HardCase]:
    """Return the rough contact with every number in another unit."""
    cases = {}
    for name, metre, newton in (
        ("in nm", 1e9, 1.0),
        ("in km", 1e-3, 1.0),
        ("in TPa", 1.0, 1e-12),
        ("in nm and TPa", 1e9, 1e6),
        ("in Gm and yPa", 1e-9, 1e6),
    ):
        pascal = newton / metre**2
        solid = replace(STEEL, youngs_modulus=STEEL.youngs_modulus * pascal)
        load = cs.LineLoad(SCENE.largest_load * newton / metre)
        plain = with_heights(ROUGH)
        heights = cs.MeasuredSurface(ROUGH * HERTZ_HEIGHT * metre)
        converted = cs.Scene(load, (solid, solid), (cs.Cylinder(0.01 * metre), heights))
        cases[f"a scene {name}"] = HardCase(
            plain,
            grid(),
            AT_EDGE,
            EquivalentForm(converted, grid(metre=metre), partial(np.multiply, 1 / pascal), 1e-10),
            options=cs.SolveOptions(tolerance=1e-12),
        )
    return cases


def perturbation() -> dict[str, HardCase]:
    """Return the rough contact with changed heights, shifted, mirrored, over two periods, or with two curved bodies."""
    scene = with_heights(ROUGH)
    double = with_heights(np.tile(ROUGH, 2))
    half = replace(SCENE, shapes=(cs.Cylinder(0.02), cs.Cylinder(0.02)))
    on = grid()

    plain = HardCase(scene, on, options=cs.SolveOptions(tolerance=1e-12))
    along = {name: across_and_along(padding)[1] for name, padding in PADDINGS.items()}
    wrapping = tuple(name for name, padding in along.items() if padding.wraps)
    endless = tuple(name for name, padding in along.items() if padding.window is None)
    rolled = with_heights(np.roll(ROUGH, 5, 1))
    back = partial(np.roll, shift=-5, axis=1)
    nudged = ROUGH + 1e-10 * ROUGH.std() * noise(seed=5)
    forms = {
        "heights nudged by 1e-10": EquivalentForm(
            with_heights(nudged), on, np.asarray, 1e-11, other_heights=True
        ),
        "moved by whole cells": EquivalentForm(rolled, on, back, 1e-9),
        "mirrored along": EquivalentForm(with_heights(ROUGH[:, ::-1]), on, np.fliplr, 1e-9),
        "mirrored across": EquivalentForm(with_heights(ROUGH[::-1]), on, np.flipud, 1e-9),
        "twice the period": EquivalentForm(
            double, grid((24, 24), period=2.4), lambda pressure: pressure[:, :12], 1e-9
        ),
        "curved on both sides": EquivalentForm(with_heights(ROUGH, half), on, np.asarray, 1e-9),
    }
    paddings = {"moved by whole cells": wrapping, "twice the period": endless}
    return {
        name: replace(plain, equivalent=form, paddings=paddings.get(name, plain.paddings))
        for name, form in forms.items()
    }
