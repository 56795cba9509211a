"""The verdict on a scene: which padding, grid and tolerance keep an error, and their cost, by solves on nested grids.

What is tried depends on the scene and the error alone. Costs are processor times of :func:`contactstudy.solve` on one
thread, the least of a few rounds in which all settings take turns. The error of a setting is the bound of its answer.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import floor, inf, isfinite, log10, nan, prod
from pathlib import Path
from time import process_time

from threadpoolctl import threadpool_limits

import contactstudy as cs
from contactstudy.domain.device import caching
from contactstudy.domain.errors import Request
from contactstudy.domain.grid import Array, cells_text
from contactstudy.domain.imports import source_hash
from contactstudy.io.scene_files.scene_schema import PlanSettings
from contactstudy.planning.grid_requirements import grid_requirements, with_random_extents
from contactstudy.scene import combinations as methods
from studies.advice.reference_error import last_of
from studies.advice.verdict import (
    EVERY_NUMBER,
    NAMED,
    PRESSURE,
    SETTINGS,
    TIE,
    Measured,
    SceneToJudge,
    Setting,
    Verdict,
    bound_of,
    from_dataset,
    meets,
    to_dataset,
)
from studies.model.case import Answer
from studies.model.plain_text import Log
from studies.reference.line_contact import hertz_means, relative_l1, with_edges_moved
from studies.reference.paddings import PADDINGS
from studies.store.netcdf import check_kind, open_folder, read, write
from studies.store.provenance import provenance

# Grids that are tried have multiples of a sixth of the cells of the scene file, or of the planned ones: up to twice
# those, and in a dry contact, which takes milliseconds, up to this number of cells.
SIXTHS, CHEAP_CELLS = 6, 2**14
MULTIPLES = sorted(factor * 2**power for factor in (1, 3) for power in range(7))
IMAGES = (1, 2, 6, 20)
# A promise holds for a load that is lower by this factor too, whose contact edge lies elsewhere in its cell.
LOWER_LOAD = 0.92
# A window that is folded off centre, by half a cell, has at least so many cells along.
CENTRED = 8
# Processor time [s] of the rounds in which the fastest settings take turns.
ROUND_SECONDS = 4.0

NO_GRID = (
    "No other padding was tried, since no grid that was tried keeps the error with exact periodicity, or the ends of "
    "the scene."
)
COPY_OFF_CENTRE = "Duplicated padding was not tried, since its window is off centre with one cell."
# Attributes that are equal where a stored verdict is that of a scene, here and now.
MATCHED_ATTRIBUTES = ("cpu", "source", "sources", "key")
NO_REFERENCE = "no finer solution, which would cost more than all the grids that were tried"


@dataclass(eq=False)
class _Trials:
    """Solves of a scene for an error, each once, on one extent."""

    scene: cs.Scene
    extent: tuple[float, float]
    own: cs.Padding | cs.Paddings
    unit: tuple[int, int]
    options: cs.SolveOptions
    times: cs.TimeSteps | None
    request: Request
    measure: str
    notes: dict[str, str] = field(default_factory=dict)
    pressures: dict[Setting, Array] = field(default_factory=dict)
    at_edge: bool = False

    @property
    def error(self) -> float:
        """Requested error, the least of several."""
        return least_error(self.request)

    @property
    def is_line(self) -> bool:
        """True for Hertz's line contact, of which a solve takes milliseconds."""
        return self.unit[1] == 1 and self.hertz_of(self.scene) is not None

    @property
    def multiples(self) -> tuple[int, ...]:
        """Multiples of the coarsest cells that may be tried."""
        is_dry = self.scene.lubrication is None
        return tuple(
            m for m in MULTIPLES
            if m <= 2 * SIXTHS or (is_dry and prod(self.cells(m)) <= CHEAP_CELLS)
        )  # fmt: skip

    def cells(self, multiple: int) -> tuple[int, int]:
        """Return the cells of a grid; a direction along which nothing varies has one."""
        across, along = (n * multiple if n > 1 else 1 for n in self.unit)
        return across, along

    def setting(self, padding: cs.Padding | cs.Paddings, cells: tuple[int, int], tolerance: float) -> Setting:
        """Return a setting on these cells, or on as many along as a copy needs to cover both sides alike."""
        across, along = cells
        if self.is_line and isinstance(padding, cs.DuplicatedPadding):
            along = max(along, CENTRED)
        return Setting(padding, (across, along), tolerance)

    def paddings(self, given: cs.Padding | cs.Paddings | None) -> list[cs.Padding | cs.Paddings]:
        """Return all paddings that the scene may have, its own first, with that which its file gives."""
        if isinstance(self.own, tuple):
            return [self.own]
        every = dict.fromkeys([self.own, given or self.own, *(make(n) for make in PADDINGS.values() for n in IMAGES)])
        if self.unit[1] == 1 and not self.is_line:
            del every[cs.DuplicatedPadding()]
            self.notes["duplicated"] = COPY_OFF_CENTRE
        return list(every)

    def solve(self, setting: Setting, scene: cs.Scene | None = None, grid: cs.Grid | None = None) -> Answer:
        """Return the answer at a setting, as a scene file with its tables would be solved."""
        return cs.solve(
            scene or self.scene,
            grid or cs.Grid(setting.cells, self.extent),
            setting.padding,
            error=self.request,
            times=self.times,
            options=replace(self.options, tolerance=setting.tolerance),
        )

    def seconds(self, setting: Setting) -> float:
        """Return the processor time of one solve [s], posed again."""
        with caching(None):
            start = process_time()
            self.solve(setting)
            return process_time() - start

    def variants(self, setting: Setting) -> Iterator[tuple[cs.Scene, cs.Grid]]:
        """Yield the scene on its grid, and with a lower load, whose edge a smooth contact has at several places."""
        grid = cs.Grid(setting.cells, self.extent)
        yield self.scene, grid
        load = self.scene.load
        if self.scene.method.takes_times or not isinstance(load, cs.LineLoad | cs.TotalLoad):
            return
        name = "per_length" if isinstance(load, cs.LineLoad) else "total"
        if getattr(load, name) > 0:
            lower = replace(self.scene, load=replace(load, **{name: LOWER_LOAD * getattr(load, name)}))
            hertz = lower.hertz if self.unit[1] == 1 else None
            grids = [grid] if hertz is None else with_edges_moved(grid, hertz.half_width)
            yield from ((lower, shifted) for shifted in grids)

    def measured(self, setting: Setting) -> Measured | None:
        """Return the largest bound, and difference to Hertz's contact, of a setting's variants; None without one."""
        try:
            return self._measured(setting)
        except cs.InvalidInput as refused:
            self.notes[setting.label] = f"{setting.label} on {cells_text(setting.cells)}: {refused}"
            return None

    def _measured(self, setting: Setting) -> Measured | None:
        """Return what was measured of a setting on its variants; None, and a note, where one of them has no answer."""
        l1, difference = 0.0, 0.0 if self.is_line else nan
        error, seconds, worst = nan if self.measure == PRESSURE else 0.0, inf, ""
        for number, (scene, grid) in enumerate(self.variants(setting)):
            with caching(None):
                start = process_time()
                answer = self.solve(setting, scene, grid)
                if number == 0:
                    seconds = process_time() - start
            if answer.status not in (cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT):
                self.at_edge |= answer.status is cs.Status.CONTACT_AT_EDGE
                self.notes[setting.label] = f"{setting.label} on {cells_text(setting.cells)}: {answer.status}"
                return None
            l1 = max(l1, answer.error.l1.total)
            if self.measure != PRESSURE:
                error, worst = max((error, worst), _worst(answer, self.request))
            pressure = last_of(answer).pressure
            if number == 0:
                self.pressures[setting] = pressure
            if (hertz := self.hertz_of(scene)) is not None:
                difference = max(difference, relative_l1(pressure, hertz_means(hertz, grid)))
            if min(l1, error) > self.error and self.unit[1] > 1:
                break
        return Measured(setting, l1, error, worst, difference, seconds)

    def meets(self, result: Measured) -> bool:
        """Return whether a setting meets the error, by the measure."""
        return meets(result, self.error, self.measure)

    def is_falling(self, tried: Sequence[Measured]) -> bool:
        """Return whether the bound of one of the last three grids is below those of all coarser ones."""
        bounds = [bound_of(result, self.measure) for result in tried]
        return len(bounds) < 4 or min(bounds[-3:]) < min(bounds[:-3])

    def hertz_of(self, scene: cs.Scene) -> "cs.analytic.HertzLine | None":
        """Return Hertz's line contact where it is the exact solution: a smooth elastic cylinder under a load."""
        hertz = scene.hertz
        is_plain = scene.method is methods.STATIC and not isinstance(scene.load, cs.Approach)
        is_plain &= scene.adhesion is None and scene.friction is None
        is_plain &= all(type(body) is cs.HalfSpace for body in scene.solids)
        if hertz is None or isinstance(self.own, tuple) or not is_plain:
            return None
        needs = grid_requirements(scene)
        is_smooth = not (needs.is_rough or needs.roller_length or needs.height)
        return hertz if is_smooth and scene.hardness > hertz.peak_pressure else None


def verdict_on(
    described: SceneToJudge, error: Request, log: Log = lambda text: None, measure: str = EVERY_NUMBER
) -> Verdict:
    """Return what was measured of a scene's settings for a relative error, or some by name, and the choice among them.

    Grids are tried from the coarsest until the bound of one meets the error; then tolerances and paddings on that grid.
    For Hertz's line contact all paddings are tried on all grids. A scene whose bodies end along it, or
    that repeats across, is solved with its own boundary conditions alone. Where no grid is given and the contact
    reaches the edge of the planned one, a wider one is tried.

    Raises
    ------
    InvalidInput
        If the scene does not determine a grid and has none.
    """
    asked = error if isinstance(error, Mapping) else {}
    measure = NAMED if asked else measure
    for wider in (1, 2):
        trials = _trials(described.file, error, measure, wider)
        paddings = trials.paddings(described.file.padding)
        on_grids = paddings if trials.is_line else [trials.own]
        results = list(_on_grids(trials, on_grids, lambda text: log(f"{described.name}: {text}")))
        if described.file.grid is not None or not trials.at_edge or any(map(trials.meets, results)):
            break
    if not results:
        raise cs.InvalidInput(f"{described.name} has no answer: {' '.join(trials.notes.values())}")
    if trials.measure == EVERY_NUMBER and not any(map(trials.meets, results)):
        trials.measure = PRESSURE  # the pressure alone may keep the error
    finest = results[-1].setting
    # of grids on which the pressure meets the error, and no other number ever does, the coarsest
    coarsest = {result.setting.padding: result.setting.cells for result in reversed(results) if trials.meets(result)}
    if coarsest:
        cells, loosest = coarsest.get(trials.own, finest.cells), trials.options.tolerance
        if trials.own in coarsest:
            loosest = _loosest(trials, Setting(trials.own, cells, loosest))
        settings = [trials.setting(padding, coarsest.get(padding, cells), loosest) for padding in paddings]
        tried = {result.setting for result in results}
        results += [result for new in settings if new not in tried and (result := trials.measured(new))]
    elif len(paddings) > 1:
        trials.notes["other paddings"] = NO_GRID
    against = "Hertz's contact"
    if not trials.is_line:
        against, reference = _reference(trials, finest) if coarsest else (NO_REFERENCE, None)
        if reference is not None:
            differences = (relative_l1(trials.pressures[result.setting], reference) for result in results)
            results = [replace(result, difference=off) for result, off in zip(results, differences, strict=True)]
    log(f"{described.name}: times of {sum(map(trials.meets, results))} settings that meet it")
    answered = {result.setting.label for result in results}
    own = replace(finest, padding=described.file.padding or trials.own).label
    return Verdict(
        described.name, described.text, trials.error, trials.measure, trials.extent, own, against,
        tuple(_timed(trials, results, own)),
        tuple(note for label, note in trials.notes.items() if label not in answered),
        asked,
    )  # fmt: skip


def _on_grids(trials: _Trials, paddings: Sequence[cs.Padding | cs.Paddings], log: Log) -> Iterator[Measured]:
    """Yield what was measured with some paddings on grids from the coarsest.

    The last grid is the first on which the scene's own padding meets the error; beyond the planned one they end where
    its bound no longer falls. All grids of lines are tried.
    """
    tried = list[Measured]()
    for multiple in trials.multiples:
        cells = trials.cells(multiple)
        if not trials.is_line:
            log(f"{Setting(trials.own, cells, 0.0).label} on {cells_text(cells)}")
        for padding in paddings:
            if result := trials.measured(trials.setting(padding, cells, trials.options.tolerance)):
                yield result
                if padding == trials.own:
                    tried.append(result)
        is_enough = any(map(trials.meets, tried))
        if not trials.is_line and (is_enough or (multiple >= SIXTHS and not trials.is_falling(tried))):
            return


def least_error(request: Request) -> float:
    """Return a requested error, the least of several."""
    return min(request.values()) if isinstance(request, Mapping) else request


def _trials(file: cs.SceneFile, error: Request, measure: str, wider: int) -> _Trials:
    """Return the solves of a scene from a sixth of the cells of its grid, or of the plan for the error, made wider."""
    padding: cs.Padding | cs.Paddings | None
    padding = file.padding if isinstance(file.padding, tuple) else None
    grid, scene = file.grid, file.scene
    if grid is None or scene.hertz is not None:
        named = error if isinstance(error, Mapping) else {"pressure": error}
        settings = PlanSettings(named, file.plan_settings.period)
        planned = replace(file, padding=padding, plan_settings=settings).plan()
        padding = padding or planned.padding
        if grid is None:
            (nx, ny), (width, length) = planned.grid.cells, planned.grid.extent
            grid = cs.Grid((wider * nx, ny), (wider * width, length))
        elif not grid_requirements(scene).varies:
            grid = replace(grid, cells=(grid.cells[0], 1))
    own = padding or cs.ExactPeriodicity()
    across, along = (max(1, round(n / SIXTHS)) if n > 1 else 1 for n in grid.cells)
    scene = with_random_extents(file.scene, grid.extent)
    times = file.time_steps if scene.method.takes_times and file.time_steps != cs.TimeSteps() else None
    return _Trials(
        scene, grid.extent, own, (max(2, across), along), file.options, times, error, measure,
    )  # fmt: skip


def _worst(answer: Answer, request: Request) -> tuple[float, str]:
    """Return the largest bound that is judged, and of what it is; numbers without a bound are left out.

    Those of numbers that are named are in proportion to the least request, and infinite without a bound.
    """
    if isinstance(request, Mapping):
        least = least_error(request)
        named = [(number.ratio * least, number) for number in answer.judged.values()]
        counted, worst = max(named, key=lambda result: result[0])
        asked = f", whose {100 * worst.bound:.2g} % of {100 * worst.requested:g} % asked count so"
        return counted, f"in the {worst.label}" + asked * (worst.requested > least)
    measure, parts = answer.judged_error
    bounds = [(number.bound, f"in the {number.label}") for number in answer.judged.values() if isfinite(number.bound)]
    return max([(parts.total, measure), *bounds])


def _loosest(trials: _Trials, setting: Setting) -> float:
    """Return the loosest tolerance at which a setting meets the error, or the scene's own if none does."""
    decade = floor(log10(trials.error))
    while 10.0**decade > setting.tolerance:
        result = trials.measured(replace(setting, tolerance=10.0**decade))
        if result and trials.meets(result):
            return result.setting.tolerance
        decade -= 1
    return setting.tolerance


def _reference(trials: _Trials, finest: Setting) -> tuple[str, Array]:
    """Return what differences are against in words, a solution on cells of half the size, and its pressure."""
    across, along = (2 * n if n > 1 else 1 for n in finest.cells)
    finer = replace(finest, cells=(across, along))
    answer = trials.solve(finer)
    bound = answer.judged_error[1].total
    own_error = f"whose own error is at most {100 * bound:.2g} %" if isfinite(bound) else "which has no bound itself"
    return f"a solution on {cells_text(finer.cells)}, {own_error}", last_of(answer).pressure


def _timed(trials: _Trials, results: Sequence[Measured], own: str) -> Iterator[Measured]:
    """Yield what was measured with the least processor time of rounds in which all settings that meet it take turns."""
    times = {result.setting: result.seconds for result in results}

    def take(settings: Sequence[Setting], seconds: float) -> None:
        total = sum(times[setting] for setting in settings)
        for _ in range(max(1, int(seconds / total)) if settings else 0):
            for setting in settings:
                times[setting] = min(times[setting], trials.seconds(setting))

    take(list(times), ROUND_SECONDS / 4)
    meeting = [result.setting for result in results if trials.meets(result)]
    fastest = min((times[setting] for setting in meeting), default=inf)
    # a busy machine adds more than a tie to most times of a setting, and not to all
    near = sorted((result for result in meeting if times[result] <= TIE**3 * fastest), key=times.__getitem__)
    # with the scene's own padding between all others: the least of many settings is less than that of one
    of_own = [result for result in near if result.label == own][:1]
    take([turn for result in near for turn in (result, *of_own)], ROUND_SECONDS)
    yield from (replace(result, seconds=times[result.setting]) for result in results)


def path_in(out: Path) -> Path:
    """Return the file of a verdict in a folder."""
    return out / f"{SETTINGS}.nc"


def verdict_of(described: SceneToJudge, error: Request, out: Path, log: Log, measure: str = EVERY_NUMBER) -> Verdict:
    """Return the verdict on a scene that a folder has, or measure it and store it there.

    One of another error, scene, processor or program is measured again.
    """
    identity = {**provenance(), "sources": _sources(), "key": f"{described.key} {error!r} {measure}"}
    path = path_in(out)
    check_kind(path, "comparison")
    if path.is_file():
        dataset = read(path)
        if all(dataset.attrs.get(name) == identity[name] for name in MATCHED_ATTRIBUTES):
            log(f"read the measurements stored in {path}")
            return from_dataset(dataset)
    open_folder(out)  # refused before anything is measured
    with threadpool_limits(1):  # times are of one thread, and idle ones of a library count as well
        verdict = verdict_on(described, error, log, measure)
    write(to_dataset(verdict).assign_attrs(identity), path)
    return verdict


def _sources() -> str:
    """Return hashes of what solves and what compares."""
    advice = Path(__file__).parent
    return " ".join((source_hash(), source_hash(advice), source_hash(advice.parent / "reference")))
