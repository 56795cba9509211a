"""Function solve, which chooses the method from the scene: static, time-dependent, rolling or lubricated.

A scene's method, with the keywords that it uses, is in the table of :mod:`contactstudy.scene.combinations`; `SOLVED_BY`
has what solves by it. Each solves on the grid that is given, or on one that is planned, and then again on finer grids
until the bounds of the answer meet the request. Methods are imported only where a scene asks for them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf, isclose, isfinite, prod
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.accuracy.coarser import coarsened
from contactstudy.answers.answer import NOT_REFINED, finer_grid, widened
from contactstudy.answers.contact import Contact, contact_answer
from contactstudy.domain.device import ONE_THREAD, Cpu, Device, using
from contactstudy.domain.errors import DEFAULT_ERROR, Request, pressure_request
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, on_cells
from contactstudy.domain.validation import InvalidInput, checked_errors, readable, valid
from contactstudy.problem.problem import Problem
from contactstudy.progress import Progress, Reporter
from contactstudy.scene import combinations as methods
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.solids.bodies import is_layered, yields
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import ReportingSolver, SolveOptions, solve_contact

if TYPE_CHECKING:
    from contactstudy.answers.evolution import Evolution
    from contactstudy.answers.lubricated_contact import LubricatedContact
    from contactstudy.evolution.march import TimeSteps

# Most iterations of a film by default, of which up to 35 were seen, the most refinements of its grid, and the fraction
# of the requested error for its steps in time, as much as for its cells.
FILM_ITERATIONS, FILM_REFINEMENTS, STEP_FRACTION = 300, 5, 0.5
# Relative difference of two extents that is rounding, and of two loads below which a start is that of the same load: of
# one that differs by more, the note says so.
SAME, SAME_LOAD = 1e-6, 1e-2
# Largest error of the steps on coarser cells to compare with, beyond which steps would no longer follow the scene.
LARGEST_STEP_ERROR = 0.3
# Cells times convolutions that a further grid may take for the numbers of an answer, its estimate left out: about a
# second by default, and half a minute where an error is requested; and cells that take as long as the call for them.
DEFAULT_WORK, REQUESTED_WORK, CELLS_OF_A_CALL = 1.5e7, 3e8, 1500
# Most grids for the numbers, of which up to 4 were seen, and the largest factor on the cells along an axis from one to
# the next, beyond which an error extrapolated by its order is a guess.
REFINEMENTS_OF_NUMBERS, MAX_GROWTH = 5, 4.0
# Most cells of a grid for the numbers of a contact that slips, whose iterations the convolutions do not count, of one
# whose stress is asked for, and of a row with the stress of a coated body, of which 2400 take 16 s.
MAX_CELLS_OF_SLIP, MAX_CELLS_OF_STRESS, MAX_ROW_OF_COATED_STRESS = 10_000, 200_000, 4000
# Refinements of a scene that is not static: their number, the order with which its error is expected to fall, between
# the first order of rolling and the 1.5 of a contact at rest, the margin on the cells that this gives, the largest
# factor on the cells along an axis, and the most cells of a grid.
REFINEMENTS, ORDER, MARGIN, MAX_REFINEMENT, MAX_CELLS = 3, 1.25, 1.05, 3.0, 2_000_000


def solve(
    scene: Scene | Problem,
    grid: Grid | None = None,
    padding: Padding | Paddings | None = None,
    *,
    error: Request | str | None = None,
    period: float | None = None,
    times: "ArrayLike | TimeSteps | None" = None,
    start: "Array | Contact | Progress | LubricatedContact | None" = None,
    folder: str | PathLike[str] | None = None,
    progress: Callable[[Progress], object] | None = None,
    device: Device = Cpu(),  # noqa: B008 (a frozen value)
    options: SolveOptions | None = None,
    **named: Any,
) -> "Contact | LubricatedContact | Evolution":
    """Solve a scene: static, time-dependent, rolling once or many times, dry or lubricated, as its effects determine.

    Parameters
    ----------
    scene
        A scene, or a problem of your own.
    grid, padding
        Where to solve; chosen for the `error` if None. ``grid`` alone keeps the grid.
    error
        Relative error not to exceed, such as ``1e-2`` or ``"1 %"``, the default without a grid: of the pressure in L1,
        and of every number of the answer that has a bound. ``{"peak_pressure": "2 %", "von_mises": "5 %"}`` names some,
        ``pressure`` is that in L1. Where a number would take many more cells, the answer says which and how many: by
        default beyond some seconds, where an error is given beyond a minute.
    period
        Length [m] of the grid that is chosen.
    times
        Instants [s] to record, or :class:`~contactstudy.TimeSteps`, of a scene that changes in time.
    start
        Pressure (x, y) [Pa], answer or :class:`~contactstudy.Progress` to begin with, on a grid of the same extent; one
        of another load is scaled, and the note of the answer says so. A grid that is chosen is refined from that of the
        start, and the note says whether it suits the scene. Of a film a :class:`~contactstudy.LubricatedContact`. A
        contact with adhesion continues from the state of an answer.
    folder
        Folder in which a dry scene with state variables (creep, wear, yielding, fretting) keeps its frames, to go on
        from there after a stop; those of a grid that was refined in a folder of their own in it.
    progress
        Called with a :class:`~contactstudy.Progress` as the solve goes on.
    device
        Device to solve on, such as ``Cpu(threads=2)``. A GPU takes a dry static contact or a problem.
    options, named
        :class:`~contactstudy.SolveOptions`, or its fields by name: ``tolerance``, ``max_iterations``, ... The default
        of ``max_iterations`` is 300 of a film; its ``solver`` and ``precision`` are not chosen.

    Returns
    -------
    Contact, LubricatedContact or Evolution
        Fields and quantities with their bounds, and a :class:`~contactstudy.Status`.

    Raises
    ------
    InvalidInput
        For input that cannot be used, and for a keyword that this scene cannot use.
    """
    if named:
        options = replace(options, **named) if options else SolveOptions(**named)
    requested = None if error is None else checked_errors("solve.error", error)
    request = _Request(
        scene, grid, padding, requested, period, times, start, folder, progress, device, options or SolveOptions()
    )  # fmt: skip
    # any other device is given to the iteration of a contact alone, since arrays around it are numpy's
    with using(device if isinstance(device, Cpu) else ONE_THREAD):
        return request.answer()


@dataclass(frozen=True, eq=False)
class _Request:
    """Arguments of :func:`solve`, and what answers them for each kind of scene; `error` is the requested one."""

    scene: Any
    grid: Grid | None
    padding: Padding | Paddings | None
    error: Request | None
    period: float | None
    times: "ArrayLike | TimeSteps | None"
    start: Any
    folder: str | PathLike[str] | None
    progress: Callable[[Progress], object] | None
    device: Device
    options: SolveOptions

    def answer(self) -> "Contact | LubricatedContact | Evolution":
        """Refuse the keywords that this scene cannot use, and solve it by its method."""
        scene = self.scene
        if not isinstance(scene, Scene | Problem):
            raise InvalidInput(f"solve.scene is {scene!r}: give a Scene, or scene.problem(grid, padding).")
        valid("grid", self.grid, Grid | None)
        if not (self.progress is None or callable(self.progress)):
            raise InvalidInput(f"solve.progress is {self.progress!r}: give a function of a Progress, or leave it out.")
        method = scene.method if isinstance(scene, Scene) else PROBLEM
        self.refuse_unused(method)
        return SOLVED_BY[method](self)

    def refuse_unused(self, method: methods.Method) -> None:
        """Raise InvalidInput for a keyword, an option or a setting of the steps that a `method` does not use."""
        is_problem, grid, period = method is PROBLEM, self.grid, self.period
        arguments = {
            "grid": is_problem and grid is not None,
            "padding": is_problem and self.padding is not None,
            "times": self.times is not None,
            "start": self.start is not None,
            "folder": self.folder is not None,
            "device": not isinstance(self.device, Cpu),
            "period": period is not None and (is_problem or (grid is not None and not isclose(period, grid.length))),
        }
        why = dict.fromkeys(("grid", "padding"), "a problem has its own")
        why |= {"period": "the grid has its own", "device": f"{method.kind} is solved on the CPU"}
        for name, is_given in arguments.items():
            if is_given and name not in method.keywords:
                reason = why.get(name, f"{method.kind} has no use for it")
                raise InvalidInput(f"solve.{name} is given, and {reason}: leave it out.")
        settings: list[tuple[str, Any, tuple[str, ...]]] = [("solve", self.options, methods.OPTIONS)]
        if self.times is not None:
            settings.append(("TimeSteps", self.steps, ("error", "scheme", "step", "error_estimator")))
        for place, given, names in settings:
            for name in names:
                value = getattr(given, name)
                if name not in method.keywords and value != getattr(type(given)(), name):
                    raise InvalidInput(
                        f"{place}.{name} is {value!r}, and {method.kind} has no use for it: leave it out."
                    )

    @property
    def requested(self) -> Request | None:
        """Relative error not to exceed: the requested one, or the default without a grid."""
        return DEFAULT_ERROR if self.error is None and self.grid is None else self.error

    @property
    def target(self) -> float | None:
        """Relative error that the first grid is planned for: of the pressure in L1, of a film that of its numbers."""
        requested = self.requested
        if self.scene.lubrication is not None and isinstance(requested, Mapping):
            return min(requested.values())
        return None if requested is None else pressure_request(requested)

    def planned(self) -> tuple[Grid, Padding | Paddings]:
        """Return grid and padding: those that are given, else planned for the error."""
        if self.grid is not None and self.scene.lubrication is not None:
            from contactstudy.planning.film_plan import check_varies_on

            check_varies_on(self.scene, self.grid)
        if self.grid is not None and self.padding is not None:
            return self.grid, self.padding
        # imported only where something is left to be chosen
        from contactstudy.planning.plan import plan_grid

        planned = plan_grid(
            self.scene,
            error=None if self.error is None else self.target,
            period=self.period,
            grid=self.grid,
            padding=self.padding,
            times=self.times,
        )
        return planned.grid, planned.padding

    @property
    def steps(self) -> "TimeSteps":
        """Instants to record and how steps are taken."""
        from contactstudy.evolution.march import TimeSteps

        return TimeSteps.of(self.times)

    @property
    def first_pressure(self) -> Any:
        """Pressure (x, y) [Pa] to begin with, that of the answer if one was given; None if nothing was."""
        return getattr(self.start, "pressure", self.start)

    def problem(self) -> Contact:
        """Solve a problem of the user's own."""
        return replace(self.solve_problem(self.scene), requested=self.error)

    def solve_problem(self, problem: Problem) -> Contact:
        """Solve one problem, and report its progress."""
        before = getattr(self.start, "adhesion", None)
        if problem.adhesion is not None and before is not None:
            problem = replace(problem, adhesion=problem.adhesion.continued(before.attraction))
        options = self.options
        if self.progress is not None:
            report = Reporter(self.progress, options.tolerance, problem).iteration
            options = replace(options, solver=ReportingSolver(report, options.solver))
        given, extent = getattr(self.start, "grid", problem.grid).extent, problem.grid.extent
        if not np.allclose(given, extent, rtol=SAME, atol=0):
            there, here = (" x ".join(map(readable, sides)) for sides in (given, extent))
            raise InvalidInput(f"solve.start is on a grid of {there}, and this one is {here}: give one of that extent.")
        return contact_answer(self._noted(solve_contact(problem, options, self.first_pressure, self.device)))

    def _noted(self, solution: Solution) -> Solution:
        """Return `solution`, with a note where the pressure that it began with carried another load."""
        grid, start = solution.problem.grid, np.asarray(0.0 if self.start is None else self.first_pressure)
        before = getattr(self.start, "grid", grid if start.shape == grid.cells else None)
        is_scaled = solution.adhesion is None and solution.problem.control.approach is None
        if before is None or not (is_scaled and solution.pressure.any()):
            return solution
        ratio = before.cell_area / before.length * grid.length / grid.cell_area
        carried = float(ratio * start.sum() / solution.pressure.sum())
        if abs(carried - 1) <= SAME_LOAD:
            return solution
        note = f"The pressure in solve.start carried {carried:.3g} times the load, and was scaled to it."
        return replace(solution, note=f"{solution.note} {note}".lstrip())

    def contact(self) -> Contact:
        """Solve a static contact."""
        from contactstudy.planning.grid_requirements import measured_length_scales

        # the points of a measured surface are the cells by default, and of one on a flat (not Hertzian) on request too
        keeps_points = self.error is None or self.scene.hertz is None
        on_own_points = keeps_points and measured_length_scales(self.scene) is not None
        # a short attraction has its range from the grid
        if self.grid is not None or on_own_points or self.scene.adhesion is not None:
            return replace(self.solve_problem(self.scene.problem(*self.planned())), requested=self.requested)
        from contactstudy.planning.refinement import solve_to  # only where the grid is chosen

        target = self.target
        assert target is not None  # it has a default without a grid
        refined = solve_to(
            self.scene,
            target,
            period=self.period,
            padding=self.padding,
            options=self.options,
            start=self.first_pressure,
            start_grid=getattr(self.start, "grid", None),
            device=self.device,
            progress=self.progress and Reporter(self.progress, target).grid,
        )
        answer = contact_answer(refined.solution, estimate=refined.estimate, requested=self.requested)
        posed = refined.solution.problem.description  # with the extent of random surfaces
        assert isinstance(posed, PosedScene)

        def solve_on(grid: Grid) -> Contact:
            start = on_cells(refined.solution.pressure, grid.cells)
            problem = posed.scene.problem(grid, posed.padding)
            solution = solve_contact(problem, self.options, start, self.device)
            return contact_answer(replace(solution, note=refined.solution.note))

        return cast(Contact, self._noted(self._refined(answer, solve_on, by_pressure=0)))

    def steady_rolling(self) -> Contact:
        """Solve a contact that rolls steadily."""
        from contactstudy.evolution.steady_rolling import solve_rolling

        grid, padding = self.planned()

        def solve_on(grid: Grid) -> Contact:
            progress = self.progress and Reporter(self.progress).change
            rolling = solve_rolling(self.scene, grid, padding, options=self.options, progress=progress)
            return contact_answer(rolling.solution, rolling=rolling)

        answer = replace(solve_on(grid), requested=self.requested)
        is_refined = self.grid is None and refines(self.scene)
        return self._refined(answer, solve_on) if is_refined else answer

    def repeated_rolling(self) -> "Evolution":
        """Roll a contact over a body that yields, as often as its scene says."""
        from contactstudy.answers.evolution import passes_answer
        from contactstudy.evolution.repeated_rolling import roll_repeatedly

        grid, padding = self.planned()
        rolled = roll_repeatedly(
            self.scene, grid, padding, options=self.options, progress=self.progress and Reporter(self.progress).passes
        )
        return passes_answer(rolled, self.requested)

    def evolution(self) -> "Evolution":
        """Follow a scene through time: its states, a history of loads, wear, or a film."""
        from contactstudy.answers.evolution import evolution_answer, films_answer

        method, steps, error = self.scene.method, self.steps, self._error_of_steps
        if method is methods.TIME_DEPENDENT:
            from contactstudy.evolution.evolve import evolve

            named = {"error_estimator": steps.error_estimator, "scheme": steps.scheme}
            return self._followed(evolve, evolution_answer, error, **named, options=self.options)
        if method is methods.FILM_IN_TIME:
            from contactstudy.evolution.evolve_lubricated import evolve_lubricated

            tolerance = self.options.tolerance
            return self._followed(evolve_lubricated, films_answer, error, step=steps.step, tolerance=tolerance)
        from contactstudy.evolution import stationary

        if method is methods.FILM_WEAR:
            return self._followed(stationary.follow_film_wear, films_answer, error, options=self._film_options)
        if method is methods.STEADY_WEAR:
            return self._followed(stationary.follow_wear, evolution_answer, error, options=self.options)
        return self._followed(stationary.follow_load, evolution_answer, options=self.options)

    def _followed(
        self,
        follow: Callable[..., Any],
        answer_of: Callable[..., "Evolution"],
        error: float | None = None,
        **named: Any,
    ) -> "Evolution":
        """Return as an answer what `follow` finds at the instants to record.

        `answer_of` makes an answer of it, `error` is the largest one of its steps, and `named` are further arguments.
        The bounds of the answer take the same on coarser cells, with longer steps.
        """
        from contactstudy.planning.grid_requirements import with_random_extents

        first, padding = self.planned()
        times = self.steps.instants_of(*self.scene.histories)

        def on(grid: Grid, factor: int = 1) -> "Evolution":
            scene, arguments = self.scene, {"times": times, **named}
            if error is not None:  # of a pair of steps, about the square of its length
                arguments["error"] = min(factor**2 * error, LARGEST_STEP_ERROR) if factor > 1 else error
            if factor > 1:  # random surfaces as on the first grid
                scene = with_random_extents(scene, first.extent)
            else:
                arguments["progress"] = self.progress and Reporter(self.progress).time
                if self.folder is not None:  # frames of a finer grid beside those before
                    finer = "" if grid == first else "{} x {} cells".format(*grid.cells)
                    arguments["folder"] = Path(self.folder, finer)
            followed = follow(scene, grid, padding, **arguments)
            return answer_of(followed, None if factor > 1 else self.requested)

        def solve_on(grid: Grid) -> "Evolution":
            def coarser(factor: int, widening: int = 1) -> "Evolution":
                return on(widened(coarsened(grid, factor), widening), factor)

            return replace(on(grid), coarser=coarser)

        is_refined = self.grid is None and refines(self.scene)
        answer = solve_on(first)
        return self._refined(answer, solve_on) if is_refined else answer

    @property
    def _film_options(self) -> SolveOptions:
        """Options of each film."""
        is_default = self.options.max_iterations == SolveOptions().max_iterations
        return replace(self.options, max_iterations=FILM_ITERATIONS) if is_default else self.options

    @property
    def _error_of_steps(self) -> float | None:
        """Largest error of the steps in time: the given one, or a fraction of the requested error.

        None for steps of a given length, and those whose error is not estimated.
        """
        steps = self.steps
        if steps.error is not None or steps.step is not None or steps.error_estimator == "none":
            return steps.error
        return self.target and STEP_FRACTION * self.target

    def film(self) -> "LubricatedContact":
        """Solve a steady film."""
        from contactstudy.answers.lubricated_contact import film_answer
        from contactstudy.lubrication.pseudo_time import FilmControls
        from contactstudy.lubrication.steady_film import solve_lubricated
        from contactstudy.planning import film_plan

        if self.start is not None and not hasattr(self.start, "film"):
            raise InvalidInput(
                f"solve.start is of the type {type(self.start).__name__}: give a LubricatedContact, such as the film at "
                "a somewhat higher speed."
            )
        smooth = self.grid is None and not any(map(film_plan.varies_along, self.scene.shapes))
        error = self.target if smooth or self.error is not None else None
        most_cells = film_plan.MAX_CELLS if self.error is None else film_plan.MAX_REQUESTED_CELLS
        first, padding = self.planned()
        controls = FilmControls(
            tolerance=self.options.tolerance,
            max_iterations=self._film_options.max_iterations,
            progress=self.progress and Reporter(self.progress, self.options.tolerance).film_step,
        )

        def solve_on(grid: Grid, start: Any) -> "LubricatedContact":
            film = solve_lubricated(self.scene, grid, padding, controls, start)
            return film_answer(film, requested=self.requested)

        answer = solve_on(first, self.start)
        for _ in range(FILM_REFINEMENTS if error is not None else 0):
            assert error is not None
            self.report_bounds(answer)
            kept = None if smooth else first  # the extent of a rough surface, or of a grid that is given, is kept
            finer = film_plan.finer_film_grid(answer.grid, first, answer.requested_errors, error, most_cells, kept)
            if finer is None:
                break
            answer = solve_on(finer, answer)
        return answer

    def _refined(self, answer: Any, solve_on: Callable[[Grid], Any], by_pressure: int = REFINEMENTS) -> Any:
        """Solve again on finer grids until the bounds of the answer meet the request, where that is possible.

        It is solved at most `by_pressure` times for the pressure in L1, and then for the numbers whose bounds are above
        the request. `solve_on` solves on a grid.
        """
        target = self.target
        assert target is not None  # it has a default without a grid
        self.report_bounds(answer)
        for number in range(by_pressure + REFINEMENTS_OF_NUMBERS):
            if number < by_pressure:
                grid = next_grid(answer.grid, answer.error.l1.by_cause, target)
            else:
                grid = grid_for_numbers(answer, is_default=self.error is None)
            if grid is not None:
                answer = replace(solve_on(grid), requested=answer.requested)
                self.report_bounds(answer)
        return answer

    def report_bounds(self, answer: Any) -> None:
        """Report that the outputs and the bounds of an answer are next; its pressure is kept if it is a static one."""
        if self.progress is not None:
            pressure = answer.pressure if self.scene.method is methods.STATIC else None
            Reporter(self.progress).bounds(answer.grid, pressure)


# What a problem is solved with, and methods of a request by those of scenes.
PROBLEM = methods.Method("a problem", methods.STATIC.keywords)
SOLVED_BY: Mapping[methods.Method, Callable[[_Request], "Contact | LubricatedContact | Evolution"]] = {
    PROBLEM: _Request.problem,
    methods.STATIC: _Request.contact,
    methods.STEADY_ROLLING: _Request.steady_rolling,
    methods.PASSES: _Request.repeated_rolling,
    methods.FILM: _Request.film,
    methods.QUASI_STATIC: _Request.evolution,
    methods.TIME_DEPENDENT: _Request.evolution,
    methods.STEADY_WEAR: _Request.evolution,
    methods.FILM_IN_TIME: _Request.evolution,
    methods.FILM_WEAR: _Request.evolution,
}


def grid_for_numbers(answer: Any, *, is_default: bool) -> Grid | None:
    """Return the grid for the numbers of an answer whose bounds are above the request, within the work for them.

    The work is less where the request `is_default`. None where no grid in reach lessens any of the bounds.
    """
    parts = answer.error.l1.by_cause
    if not parts or max(parts, key=parts.__getitem__) != "discretisation":
        return None
    scene = answer.scene
    if any(map(yields, scene.solids)):  # plastic strain takes the third power of the cells
        return None
    most = DEFAULT_WORK if is_default else REQUESTED_WORK
    largest = MAX_CELLS_OF_STRESS if scene.outputs else MAX_CELLS
    if scene.outputs and answer.grid.cells[1] == 1 and any(map(is_layered, scene.solids)):
        largest = MAX_ROW_OF_COATED_STRESS
    if scene.friction is not None:
        largest = MAX_CELLS_OF_SLIP
    left_out = () if isinstance(answer.requested, Mapping) else NOT_REFINED
    factors = []
    for name, number in answer.judged.items():
        if number.order and 1 < number.ratio < inf and not any(part in name for part in left_out):
            # by its order, 1 or at edges 1/2: beyond MAX_GROWTH by order 1, as there bounds fall faster on coarse cells
            factors.append(max(MARGIN * number.ratio, min(MARGIN * number.finer, MAX_GROWTH)))
    # in cells: iterations grow about as the root of the cells along an axis
    left = most / answer.counts["convolutions"][0]
    for factor in sorted(factors, reverse=True):
        # those that take as long as a call for them count too
        cells = CELLS_OF_A_CALL + prod(finer_grid(answer.grid, factor).cells)
        if cells <= largest and cells * factor**0.5 <= left:
            return finer_grid(answer.grid, min(factor, MAX_GROWTH))
    return None


def refines(scene: Scene) -> bool:
    """Return whether a scene that is not static is solved again on finer grids until its bound meets the error.

    One that rolls with adhesion is not, like one at rest, as a short attraction has its range from the grid.
    """
    return scene.method is methods.TIME_DEPENDENT or (scene.method is methods.STEADY_ROLLING and scene.adhesion is None)


def next_grid(grid: Grid, parts: Mapping[str, float], requested: float) -> Grid | None:
    """Return the grid to solve next for a requested error; None where the error is met, or finer cells do not help.

    Parameters
    ----------
    grid
        The last grid.
    parts
        The bound on it by cause.
    requested
        Relative error not to exceed.
    """
    cells, total = parts["discretisation"], sum(parts.values())
    if total <= requested or not isfinite(cells) or total - cells >= requested:
        return None
    factor = MARGIN * (cells / (requested - total + cells)) ** (1 / ORDER)
    finer = finer_grid(grid, min(factor, MAX_REFINEMENT))
    return finer if prod(finer.cells) <= MAX_CELLS else None
