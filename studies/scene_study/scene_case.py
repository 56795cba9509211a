"""Cases of a sweep over a scene: set up once for all loads, and started from the pressures of their neighbours."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import log, pi
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.io.document import TimeSteps
from contactstudy.scene.scene import under_load
from studies.model.case import Case, march_record, number
from studies.model.film_case import film_status

# Share of the pressure that would close a cell's gap alone, which is subtracted for the gap when pressures are
# extrapolated, so that cells about to touch are included. From 0.05 to 0.5 the iterations differ by 2 %.
SEED = 0.2
# Largest step of an extrapolation over the step between the two loads before.
FAR = 2.0


@dataclass(frozen=True, eq=False)
class Solved:
    """A solution with its cost.

    Attributes
    ----------
    solution
        The solution.
    seconds
        Wall time [s] of set-up and solve.
    datum
        Distance [m] beside the contact from which the approach counts; None where the padding fixes it.
    """

    solution: cs.Solution
    seconds: float
    datum: float | None


@dataclass(frozen=True)
class SceneCase(Case):
    """A :class:`~studies.model.case.Case` that is started from the last solutions of its kind in the same process.

    Cases that differ in their load alone share heights and coefficients. The start changes the solution
    within its tolerance only, so that a case may be computed alone, in any order and process. The
    approach counts from half the grid's width at every load; a scene's own problem counts it from
    Hertz's half-width, which changes with the load.
    """

    def prepare(self) -> Any:
        """Return the problem and the seconds of its set-up; the last problem if only the load differs."""
        start = perf_counter()
        problem = under_load(_LAST.problem_like(self), self.load)
        return problem, perf_counter() - start

    def run(self, prepared: Any) -> Any:
        """Solve the problem, starting from the pressures at the previous loads."""
        problem, seconds = prepared
        start = perf_counter()
        start_pressure = _LAST.pressure_for(problem, self.load.per_length)
        solution = self.options.solved(problem, start_pressure)
        seconds += perf_counter() - start
        if solution.status is cs.Status.CONVERGED:
            _LAST.add(self.load.per_length, solution)
        return Solved(solution, seconds, self.datum)

    def record(self, result: Solved) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """Return the numbers of the solver, and its status as CF flags."""
        return super().record(result.solution)

    def fields(self, result: Solved) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """Return pressure and gap over the grid, and the outputs that the scene names, such as stress."""
        return _fields(cs.to_dataset(result.solution))

    @property
    def load(self) -> cs.LineLoad | cs.TotalLoad:
        """Load of the scene, which does not change with time."""
        assert isinstance(self.scene.load, cs.LineLoad | cs.TotalLoad)  # another is marched
        return self.scene.load

    @property
    def datum(self) -> float | None:
        """Distance [m] from which the approach counts, half the grid's width; None if finitely many images fix it."""
        across, along = (
            self.padding if isinstance(self.padding, tuple) else (cs.ZeroPadding(), self.padding)
        )
        is_open = along.window is None and across.window is not None
        return self.grid.extent[0] / 2 if is_open else None


@dataclass(frozen=True)
class FileCase(Case):
    """A contact that rolls steadily or changes in time, as a computation of a sweep."""

    time_steps: TimeSteps = field(default_factory=TimeSteps)

    def prepare(self) -> cs.SceneFile:  # type: ignore[override]
        """Return the scene with its grid, padding, options and instants."""
        return cs.SceneFile(
            self.scene,
            settings=self.options,
            grid=self.grid,
            padding=self.padding,
            time_steps=self.time_steps,
        )

    def run(self, prepared: cs.SceneFile) -> Any:  # type: ignore[override]
        """Solve the rolling contact, or march through the instants."""
        return prepared.evolve() if self.scene.rolling is None else prepared.roll()

    def record(self, result: Any) -> Mapping[str, xr.Variable]:
        """Return the numbers of the solver, over all steps of a march."""
        if isinstance(result, cs.Evolution):
            return march_record(result)
        return super().record(result.solution)

    def fields(self, result: Any) -> Mapping[str, xr.Variable]:
        """Return pressure and gap over the grid, and the fields of a march over time."""
        if isinstance(result, cs.Evolution | cs.FilmEvolution):
            return _fields(result.to_dataset())
        return _fields(cs.to_dataset(result.solution))


@dataclass(frozen=True)
class MarchedFilm(FileCase):
    """A lubricated scene that changes in time, as a computation of a sweep."""

    def record(self, result: cs.FilmEvolution) -> Mapping[str, xr.Variable]:  # type: ignore[override]
        """Return the numbers of the iteration over all steps, and the worst status."""
        return {
            "solver_status": film_status(result.status),
            "iterations": number(result.iterations, "steps of Newton's method"),
            "linear_iterations": number(result.linear_iterations, "iterations of linear systems"),
            "steps": number(result.steps, "steps in time"),
        }


def _fields(dataset: xr.Dataset) -> Mapping[str, xr.Variable]:
    """Return the variables with dimensions, without the displacement, which follows from the gap."""
    names = [name for name, variable in dataset.variables.items() if variable.ndim]
    return {str(name): dataset[name].variable for name in names if name != "displacement"}


class _Last:
    """The last problem of this process, and its solutions at up to two loads."""

    def __init__(self) -> None:
        self.kind: object = None
        self.problem: cs.Problem | None = None
        self.solved: list[tuple[float, Array, Array]] = []

    def problem_like(self, case: SceneCase) -> cs.Problem:
        """Return the problem of a case with another load; the last problem if it differs in the load alone."""
        kind = (replace(case.scene, load=_at_half_width(case)), case.grid, case.padding)
        if self.problem is None or kind != self.kind:
            self.kind, self.problem, self.solved = None, None, []
            self.problem = kind[0].problem(case.grid, case.padding)
            self.kind = kind
        return self.problem

    def add(self, load: float, solution: cs.Solution) -> None:
        """Keep a solution at the load `load` [N/m]."""
        self.solved = [*self.solved[-1:], (load, solution.pressure, solution.gap)]

    def pressure_for(self, problem: cs.Problem, load: float) -> Array | None:
        """Return a pressure (x, y) [Pa] to start from, extrapolated in the logarithm of the load; None at first."""
        if not self.solved:
            return None
        latest, pressure, gap = self.solved[-1]
        scaled: Array = pressure * (load / latest)
        if len(self.solved) < 2 or load == latest or self.solved[0][0] == latest:
            return scaled
        previous, previous_pressure, previous_gap = self.solved[0]
        step = log(load / latest) / log(latest / previous)
        if abs(step) > FAR:
            return scaled
        seed = SEED / problem.operator.self_compliance
        last = pressure - seed * gap
        start = last + (last - (previous_pressure - seed * previous_gap)) * step
        np.maximum(start, 0, out=start)
        return start if start.any() else scaled


_LAST = _Last()


def _at_half_width(case: SceneCase) -> cs.LineLoad:
    """Return the load at which Hertz's contact fills the grid's width, so that heights count from there."""
    hertz = case.scene.hertz
    if hertz is None:
        return cs.LineLoad(1.0)
    half_width = case.grid.extent[0] / 2
    return cs.LineLoad(pi * hertz.contact_modulus * half_width**2 / (4 * hertz.radius))
