"""A contact of a sweep: set up once for all loads, and started from its neighbours' pressures."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import log, pi
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.scene.scene import under_load
from studies.model.case import Case

# Of the pressure that would close a cell's gap alone, how much stands for the gap in a forecast of the
# pressure: cells about to touch are foreseen to do so. From 0.05 to 0.5 the iterations differ by 2 %.
SEED = 0.2
# Loads are extrapolated no farther than so many times the step between the two before.
FAR = 2.0


@dataclass(frozen=True, eq=False)
class Solved:
    """A ``solution``, the wall time [s] of set-up and solve, and where its approach counts from [m].

    ``datum`` is None where the padding leaves nothing open.
    """

    solution: cs.Solution
    seconds: float
    datum: float | None


@dataclass(frozen=True)
class SceneCase(Case):
    """A :class:`~studies.model.case.Case` that its process sets up and starts from the last ones of its kind.

    Cases that differ in their load alone share heights and coefficients. The start changes the solution
    within its tolerance only, so that a case may be computed alone, in any order and process. The
    approach counts from half the grid's width at every load; a scene's own problem counts it from
    Hertz's half-width, which changes with the load.
    """

    def prepare(self) -> Any:
        """The problem, from the last one if that differs in its load alone."""
        start = perf_counter()
        problem = under_load(_LAST.problem_like(self), self.load)
        return problem, perf_counter() - start

    def run(self, prepared: Any) -> Any:
        """The solve, from the pressures at the loads before."""
        problem, seconds = prepared
        start = perf_counter()
        start_pressure = _LAST.pressure_for(problem, self.load.per_length)
        solution = self.options.solved(problem, start_pressure)
        seconds += perf_counter() - start
        if solution.status is cs.Status.CONVERGED:
            _LAST.add(self.load.per_length, solution)
        return Solved(solution, seconds, self.datum)

    def record(self, result: Solved) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """The solver's own numbers, and its status as CF flags."""
        return super().record(result.solution)

    def fields(self, result: Solved) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """Pressure and gap over the grid, and the outputs that the scene names, such as stress."""
        dataset = cs.to_dataset(result.solution)
        shown = [
            str(name)
            for name, one in dataset.variables.items()
            if one.ndim and name != "displacement"
        ]
        return {name: dataset[name].variable for name in shown}

    @property
    def load(self) -> cs.LineLoad:
        """The load, which does not change with time."""
        load = self.scene.load
        if not isinstance(load, cs.LineLoad):
            raise cs.InvalidInput(
                "Scene.load changes with time: vary a LineLoad, or follow one scene with evolve."
            )
        return load

    @property
    def datum(self) -> float | None:
        """Where the approach counts from [m]: half the grid's width, where infinitely many images leave it open."""
        across, along = (
            self.padding if isinstance(self.padding, tuple) else (cs.ZeroPadding(), self.padding)
        )
        is_open = along.window is None and across.window is not None
        return self.grid.extent[0] / 2 if is_open else None


class _Last:
    """What this process knows of the cases it has just computed: those of one kind, at two loads."""

    def __init__(self) -> None:
        self.kind: object = None
        self.problem: cs.Problem | None = None
        self.solved: list[tuple[float, Array, Array]] = []

    def problem_like(self, case: SceneCase) -> cs.Problem:
        kind = (replace(case.scene, load=_at_half_width(case)), case.grid, case.padding)
        if self.problem is None or kind != self.kind:
            self.kind, self.problem, self.solved = None, None, []
            self.problem = kind[0].problem(case.grid, case.padding)
            self.kind = kind
        return self.problem

    def add(self, load: float, solution: cs.Solution) -> None:
        self.solved = [*self.solved[-1:], (load, solution.pressure, solution.gap)]

    def pressure_for(self, problem: cs.Problem, load: float) -> Array | None:
        """A pressure to start from, extrapolated in the logarithm of the load; None if nothing is known."""
        if not self.solved:
            return None
        known, pressure, gap = self.solved[-1]
        scaled: Array = pressure * (load / known)
        if len(self.solved) < 2 or load == known or self.solved[0][0] == known:
            return scaled
        before, its_pressure, its_gap = self.solved[0]
        step = log(load / known) / log(known / before)
        if abs(step) > FAR:
            return scaled
        seed = SEED / problem.operator.own
        last = pressure - seed * gap
        start = last + (last - (its_pressure - seed * its_gap)) * step
        np.maximum(start, 0, out=start)
        return start if start.any() else scaled


_LAST = _Last()


def _at_half_width(case: SceneCase) -> cs.LineLoad:
    """The load at which Hertz's contact fills the grid's width, so that heights count from there."""
    hertz = case.scene.hertz
    if hertz is None:
        return cs.LineLoad(1.0)
    half_width = case.grid.extent[0] / 2
    return cs.LineLoad(pi * hertz.contact_modulus * half_width**2 / (4 * hertz.radius))
