"""Function plan: the grid, memory and seconds of a solve, from its first levels.

A plan first chooses grid and padding (`plan_grid`). Then the scene is solved on coarser grids, its levels, each for
about a second of processor time at most; how their seconds grow with the cells tells those of the whole. A solve that
is ended early tells them by its progress. The error to expect follows from the bounds on the levels.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from math import inf, log, prod
from time import process_time
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from contactstudy.accuracy.bound import SHARP_EDGE
from contactstudy.accuracy.coarser import coarsened
from contactstudy.answers.answer import judged_numbers
from contactstudy.answers.contact import contact_answer
from contactstudy.domain.device import ONE_THREAD, Device
from contactstudy.domain.errors import DEFAULT_ERROR, Request, pressure_request
from contactstudy.domain.grid import Grid, Padding, Paddings, cells_text
from contactstudy.domain.imports import loaded
from contactstudy.domain.validation import InvalidInput, checked_errors, readable
from contactstudy.planning.grid_requirements import grid_requirements
from contactstudy.planning.plan import plan_grid
from contactstudy.planning.planned import Plan, speedup
from contactstudy.planning.refinement import CONVERGENCE_ORDER, OTHER_CAUSES, WIDENING, FirstGrids
from contactstudy.progress import Progress
from contactstudy.scene import combinations as methods
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Status
from contactstudy.solving import REFINEMENTS, grid_for_numbers, next_grid, refines, solve

if TYPE_CHECKING:
    from contactstudy.evolution.march import TimeSteps


# Seconds that the solve of one level may take, and all together: a plan is asked for interactively.
SOLVE_SECONDS, ALL_SECONDS = 1.0, 2.0
# Seconds that a solve which refines its grid itself may take, where nothing of its last grid is done: until then its
# progress says nothing of that grid.
GRID_SECONDS = 10.0
# Seconds up to which a solve on the planned grid itself, or on a finer one for numbers, is carried out as a level: so
# small a solve is known best by doing it.
EXACT_SECONDS = 0.5
# Factor on the cells along an axis, from the grid for the pressure to a finer one for all numbers of the answer, up to
# which a plan leaves the finer one out. Coarse levels ask for it too often, as their bounds fall faster than assumed:
# with 1, two of five rough contacts had plans for 1.8 and 1.5 times the cells of their solves.
LEAST_FINER = 1.5
# Factor on the seconds of a finer grid for numbers that is not solved for the plan, for the grids that may follow it:
# some solves take one more, of up to twice the cells.
WITH_FURTHER_GRIDS = 1.25
# Number of cells across of the coarsest level: on fewer a contact has three or four, and its iterations are no measure.
LEAST_CELLS = 12
# Least fraction done from which the seconds of a solve are extrapolated: below it a progress is that of the set-up.
LEAST_FRACTION = 1e-4
# Number of cells that take as long as the part of a solve that does not grow with the cells, such as calls. Rough and
# crowned contacts of 48^2 to 768^2 cells take 0.015 s, and 1 s more for each million cells.
CELLS_OF_CALL = 16_000
# Least and largest power of the cells with which the seconds are taken to grow, where two levels show one: calls alone
# make it small, and dense matrices, or more steps on finer cells, large.
POWERS_OF_CELLS = 0.3, 2.5
# Largest factor by which a level has fewer cells along an axis in a contact with adhesion, whose cohesive zone coarser
# cells do not hold.
COARSEST_WITH_ADHESION = 2
# Least and largest power of the seconds with which the fraction done is taken to grow: linear for equal steps, more
# where the iteration converges faster towards its end.
PROGRESS_POWERS = 0.75, 4.0
# Largest error to which a film is solved on a coarse level: with more, its grid does not resolve the contact.
MOST_ERROR = 0.3
NOT_PREDICTED = (
    f"plan.error is not predicted, since no solve on coarse cells ended within {SOLVE_SECONDS:g} s: "
    "solve, and read answer.error."
)


def plan(
    scene: Scene,
    *,
    error: Request | str | None = None,
    period: float | None = None,
    grid: Grid | None = None,
    padding: Padding | Paddings | None = None,
    times: "ArrayLike | TimeSteps | None" = None,
    device: Device = ONE_THREAD,
) -> Plan:
    """Choose a grid and a padding that solve a scene to a relative error: those on which its solve is expected to end.

    It solves a static contact on the first grids of its solve, of up to some ten thousand cells, and other scenes on
    grids coarser than the planned one, for some seconds at most.

    Parameters
    ----------
    scene
        The scene, which may change in time or roll.
    error
        Relative L1 error of the pressure, above 0 and below 1, or a text such as ``"1 %"``; of a film, that of its
        thickness, friction, temperatures and the fraction of the load that asperities carry; or errors by the names of
        numbers. If it is None, a measured surface of a static dry contact without adhesion is solved at its own points,
        and any other scene to 1 %.
    period
        Length of the grid [m]; chosen if None.
    grid
        Grid to keep. The plan then warns of its faults.
    padding
        Boundary conditions to keep; chosen if None.
    times
        Instants [s] to record, or :class:`~contactstudy.TimeSteps`, as for :func:`~contactstudy.solve`.
    device
        Device that the seconds of a dry static contact without adhesion are for; those of others are for one thread.

    Raises
    ------
    InvalidInput
        If the scene does not determine a grid: the width of the contact needs a curved shape, the length of a crowned
        roller a FiniteLength.
    """
    planned = plan_grid(scene, error=error, period=period, grid=grid, padding=padding, times=times, device=device)
    requested: Request | None = DEFAULT_ERROR if grid is None else None
    if error is not None:
        requested = checked_errors("plan.error", error)
    request = _Request(planned, requested, times, is_chosen=grid is None, is_default=error is None)
    try:
        levels = request.levels()
    except InvalidInput as refused:
        reason = f"seconds: unknown, since {refused}"
        return replace(planned, seconds=inf, reasons=(*planned.reasons, reason))
    last, seconds, reason = request.end(levels)
    final = planned
    if last != planned.grid:  # the plan is to speak of the last grid, and of its memory
        final = plan_grid(planned.scene, error=error, grid=last, padding=padding, times=times, device=device)
        begins = f"refinement: a solve begins on {cells_text(planned.grid.cells)}."
        final = replace(
            final, reasons=(*final.reasons, begins), warnings=planned.warnings, first_grids=planned.first_grids
        )
    return replace(
        final,
        error=planned.error if scene.lubrication else request.error_on(last, levels),
        seconds=seconds / request.speedup,
        reasons=(*final.reasons, reason),
        warnings=(*final.warnings, *request.warnings_of(levels)),
    )


@dataclass(frozen=True)
class Level:
    """A solve on one grid.

    Attributes
    ----------
    grid
        The grid.
    seconds
        Seconds of processor time of the whole solve, extrapolated if it was ended early.
    answer
        The answer; None where the solve was ended early.
    seconds_of_numbers
        Part of the seconds that goes into the numbers of the answer, which a solve that goes on to finer grids does not
        spend.
    """

    grid: Grid
    seconds: float
    answer: Any
    seconds_of_numbers: float = 0.0


@dataclass(frozen=True, eq=False)
class _Request:
    """A planned solve, to be carried out on coarser grids.

    Attributes
    ----------
    planned
        The plan, as yet without error and seconds.
    error
        Requested error; None where the grid is given without one.
    times
        Instants [s] to record.
    is_chosen
        True if the grid was not given, so that the solve refines it.
    is_default
        True if the error is the default one.
    """

    planned: Plan
    error: Request | None
    times: "ArrayLike | TimeSteps | None"
    is_chosen: bool
    is_default: bool

    @property
    def target(self) -> float | None:
        """Relative error of the pressure that is requested, or of a film the least of its numbers; None without one."""
        if self.scene.lubrication is not None and isinstance(self.error, Mapping):
            return min(self.error.values())
        return None if self.error is None else pressure_request(self.error)

    @property
    def scene(self) -> Scene:
        """The scene."""
        return self.planned.scene

    @property
    def refines_film(self) -> bool:
        """True if the scene is a steady film that refines its cells itself."""
        is_film = self.scene.method is methods.FILM
        return is_film and self.is_chosen and self.planned.grid.cells[1] == 1

    @property
    def speedup(self) -> float:
        """Ratio of the seconds on one thread to those on the device; 1 but for a dry static contact without adhesion."""
        scene, planned = self.scene, self.planned
        if scene.method is not methods.STATIC or scene.adhesion:
            return 1.0
        return speedup(planned.grid, planned.padding, planned.device)

    def end(self, levels: list[Level]) -> tuple[Grid, float, str]:
        """Return the grid on which a solve is expected to end, the seconds of all its grids, and a sentence on these.

        Further levels, on grids for numbers that take little time, are appended to `levels`. Raises
        :class:`~contactstudy.InvalidInput` for the name of a number in the requested error that no answer has.
        """
        for level in levels:
            if level.answer is not None:
                judged_numbers(level.answer.quantities, self.error)  # refuses names of numbers that the answer lacks
        # the grids for the pressure, and the levels themselves where the solve begins with these
        last, grids = levels[-1], self.grids_of_pressure(levels)
        seconds = sum(self.seconds_on(grid, levels) for grid in grids)
        if self.planned.first_grids is not None:
            seconds += sum(level.seconds for level in levels) - (last.seconds_of_numbers if grids else 0.0)
        # then finer ones for numbers whose bounds the error asks for: one is solved if it is small, else it is the last
        grid, numbers = grids[-1] if grids else self.planned.grid, ""
        refines_numbers = self.planned.first_grids is not None or refines(self.scene)
        while self.is_chosen and refines_numbers and (answer := levels[-1].answer) is not None:
            further = grid_for_numbers(answer, is_default=self.is_default)
            axes = 1 if grid.cells[1] == 1 else 2
            least = 1.0 if levels[-1].grid == grid else LEAST_FINER**axes
            if further is None or prod(further.cells) <= least * prod(grid.cells):
                break
            grid, numbers = further, f" Numbers other than the pressure take {cells_text(further.cells)} or more."
            expected = self.seconds_on(grid, levels)
            if expected > EXACT_SECONDS:
                seconds += WITH_FURTHER_GRIDS * expected
                break
            levels.append(self.solved(grid, 1))
            seconds += levels[-1].seconds
        part = "" if last.answer is not None else "a part of "
        return grid, seconds, f"seconds: from {part}a solve on {cells_text(last.grid.cells)}.{numbers}"

    def grids_of_pressure(self, levels: list[Level]) -> list[Grid]:
        """Return the grids that a solve is expected to take for its pressure or film, beside the first grids if any."""
        planned, first = self.planned.grid, self.planned.first_grids
        if first is not None:
            # grids between the levels and the planned one; without any the levels end on the planned one
            between = [grid for grid in first.between if prod(grid.cells) < prod(planned.cells)]
            return [*between, planned] if first.between else []
        if self.refines_film and levels[-1].answer is not None:
            return [self.grid_of_film(levels[-1])]
        is_refined = self.is_chosen and refines(self.scene)
        return [planned, *(self.refinements(levels) if is_refined else ())]

    def first_levels(self, first: FirstGrids) -> list[Level]:
        """Return the levels with which the solve of a static contact begins, the last one with its numbers."""
        levels = []
        for bounded in first.levels:
            answer = contact_answer(bounded.solution, estimate=bounded.estimate, requested=self.error)
            levels.append(Level(bounded.grid, bounded.seconds, answer))
        begin = process_time()
        len(levels[-1].answer.quantities)  # computes them
        taken = process_time() - begin
        levels[-1] = replace(levels[-1], seconds=levels[-1].seconds + taken, seconds_of_numbers=taken)
        return levels

    def error_on(self, grid: Grid, levels: list[Level]) -> float:
        """Return the error of the pressure to expect on a grid, without that of steps in time; infinite if not known."""
        parts = self.parts_on(grid, levels)
        return sum(parts.values()) - parts.get("steps", 0.0) if parts else inf

    def parts_on(self, grid: Grid, levels: list[Level]) -> dict[str, float]:
        """Return the bound of the pressure to expect on a grid by cause, from the last level that was solved.

        It is empty if none was. The cells' part falls by the `CONVERGENCE_ORDER`.
        """
        last = next((level for level in reversed(levels) if level.answer is not None), None)
        if last is None:
            return {}
        parts = dict(last.answer.error.l1.by_cause)
        if "discretisation" in parts:
            coarser = prod(last.grid.cells) / prod(grid.cells)
            axes = 1 if grid.cells[1] == 1 else 2
            parts["discretisation"] *= coarser ** (CONVERGENCE_ORDER / axes)
        return parts

    def warnings_of(self, levels: list[Level]) -> tuple[str, ...]:
        """Return a sentence for each fault of the plan that the last level shows; none of a film."""
        answer = levels[-1].answer
        if self.scene.lubrication is not None:
            return ()
        if answer is None:
            return () if any(level.answer is not None for level in levels) else (NOT_PREDICTED,)
        warnings = [text for text in answer.error.warnings if SHARP_EDGE in text]
        width, parts = answer.grid.extent[0], answer.error.l1.by_cause
        if answer.status is Status.CONTACT_AT_EDGE:
            parts = {}  # a contact that is cut off has no bound
        touching = answer.pressure.reshape(-1, *answer.grid.cells).any(axis=(0, 2))
        if self.scene.hertz is not None and (touching[0] or touching[-1]):
            requirements = grid_requirements(self.scene)
            known, wider = requirements.known_width, max(WIDENING * width, requirements.width_of_contact)
            remedy = "give a width of "
            if wider > known:
                only = f"the surface is known over {readable(known)} only"
                remedy = f"{only}; give a smaller load, or a surface as wide as "
            warnings.append(f"Grid.extent[0] is {readable(width)}: the contact is wider, {remedy}{readable(wider)}.")
        least = min(self.target or inf, parts.get("discretisation", inf))
        for cause, (sentence, remedy) in OTHER_CAUSES.items():
            if (part := parts.get(cause, 0.0)) > least:
                amount = "an amount not known" if part == inf else f"{100 * part:.2g} %"
                warnings.append(f"plan.error: {sentence} {amount} to the error, {remedy}.")
        return tuple(warnings)

    def levels(self) -> list[Level]:
        """Return the levels: solves on ever finer grids, up to the planned one, as long as their seconds allow.

        Of a static contact they are those with which its own solve begins. Raises :class:`~contactstudy.InvalidInput`
        where the scene refuses all of these grids.
        """
        if self.planned.first_grids is not None:
            return self.first_levels(self.planned.first_grids)
        refused, levels = InvalidInput("no grid is coarser"), list[Level]()
        for factor in (8, 4, 2, 1):
            grid = coarsened(self.planned.grid, factor)
            is_exact = grid == self.planned.grid
            too_coarse = grid.cells[0] < LEAST_CELLS or (
                self.scene.adhesion is not None and factor > COARSEST_WITH_ADHESION
            )
            if too_coarse and not is_exact:
                continue
            spent = sum(level.seconds for level in levels)
            limit = EXACT_SECONDS if is_exact else ALL_SECONDS - spent
            expected = self.seconds_on(grid, levels) if levels[1:] else 0.0
            if levels and (levels[-1].answer is None or expected > limit):
                break
            try:
                levels.append(self.solved(grid, factor))
            except InvalidInput as fault:  # so few cells may not resolve the waves of a surface
                refused = fault
        if not levels:
            raise refused
        return levels

    def solved(self, grid: Grid, factor: int) -> Level:
        """Return the level on a `grid` of 1 / `factor` of the planned cells along each axis.

        A steady film is solved to an error larger by the square of the factor, for which it chooses its own cells where
        no grid was given.
        """
        error, named = self.error, dict[str, Any]()
        if self.scene.method is methods.FILM and self.target is not None:
            error = min(self.target * factor**2, MOST_ERROR)
        if self.scene.method.takes_times:
            named["times"] = self.times
        on = None if self.refines_film else grid
        while True:
            before, watch = loaded(), _Watch()
            answer: Any = None
            try:
                answer = solve(self.scene, on, self.planned.padding, error=error, progress=watch, **named)
                len(answer.quantities)  # computes them, and the stress
            except _TimeLimitReached:
                answer = None
            if before == loaded():  # what is imported or compiled is not counted
                break
        if answer is None:
            return Level(grid, watch.seconds_of_all, None)
        return Level(answer.grid, watch.seconds, answer)

    def seconds_on(self, grid: Grid, levels: list[Level]) -> float:
        """Return the seconds on a `grid` by the power of the cells that the last two `levels` show, or else linearly.

        They are linear for a static contact too, whose levels each start from the one before.
        """
        last, cells = levels[-1], prod(grid.cells)
        present = prod(last.grid.cells)
        if len(levels) > 1 and self.planned.first_grids is None:
            before = levels[-2]
            coarser = prod(before.grid.cells)
            if coarser < present:
                power = log(last.seconds / before.seconds) / log(present / coarser)
                power = min(max(power, POWERS_OF_CELLS[0]), POWERS_OF_CELLS[1])
                return float(last.seconds * (cells / present) ** power)
        fixed = CELLS_OF_CALL
        return last.seconds * (cells + fixed) / (present + fixed)

    def refinements(self, levels: list[Level]) -> Iterator[Grid]:
        """Yield the finer grids that a solve is expected to take after the planned one, from the bounds on `levels`."""
        grid: Grid | None = self.planned.grid
        for _ in range(REFINEMENTS):
            assert grid is not None
            assert self.target is not None
            parts = self.parts_on(grid, levels)
            grid = next_grid(grid, parts, self.target) if parts else None
            if grid is None:
                return
            yield grid

    def grid_of_film(self, last: Level) -> Grid:
        """Return the grid on which a film is expected to end: the planned one, refined as in the `last` level.

        That level has a larger error: its first grid is the one planned for that error.
        """
        from contactstudy.planning.film_plan import film_grid

        planned, refined = self.planned.grid, last.grid
        first = film_grid(self.scene, last.answer.requested, refined.length)
        wider = refined.extent[0] / first.extent[0]
        across = round(planned.cells[0] * refined.cells[0] / first.cells[0])
        return Grid((across, planned.cells[1]), (planned.extent[0] * wider, planned.length))


class _TimeLimitReached(Exception):
    """Ends a solve that has taken as many seconds as it may."""


class _Watch:
    """Follows a solve by its progress, and ends it after some seconds by raising `_TimeLimitReached`."""

    def __init__(self) -> None:
        self._begin = process_time()
        # fractions done, each with the seconds since the solve began
        self.reports: list[tuple[float, float]] = []
        # index of the first report on the present grid, and the seconds at which that grid began
        self._first, self._begun = 0, 0.0

    def __call__(self, progress: Progress) -> None:
        """Record the fraction that is done by a `progress`, which begins anew on each grid of a film."""
        if self.reports and progress.fraction < self.reports[-1][0]:
            self._first, self._begun = len(self.reports), self.reports[-1][1]
        self.reports.append((progress.fraction, self.seconds))
        # a fraction of 0 says nothing yet of a finer grid
        limit = GRID_SECONDS if self._first and not progress.fraction else SOLVE_SECONDS
        if self.seconds > limit:
            raise _TimeLimitReached

    @property
    def seconds(self) -> float:
        """Seconds of processor time since the solve began."""
        return process_time() - self._begin

    @property
    def seconds_of_all(self) -> float:
        """Seconds that all of the solve is expected to take: the fraction done grows with a power of the seconds.

        The power is that between half of the seconds spent and all of them.
        """
        reports = [(fraction, at - self._begun) for fraction, at in self.reports[self._first :]]
        done, seconds = reports[-1]
        done = min(max(done, LEAST_FRACTION), 1.0)
        half = max((fraction for fraction, at in reports if at <= seconds / 2), default=done / 2)
        power = log(done / max(half, LEAST_FRACTION / 2)) / log(2)
        ratio = done ** (-1 / min(max(power, PROGRESS_POWERS[0]), PROGRESS_POWERS[1]))
        return self._begun + seconds * float(ratio)
