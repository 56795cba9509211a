"""The verdict on a scene: which padding, grid and tolerance keep an error, and their cost, by solves on nested grids.

What is tried depends on the scene and the error alone. Costs are processor times of :func:`contactstudy.solve` on one
thread, the least of a few rounds in which all settings take turns. The error of a setting is the bound of its answer.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isfinite, log, nan, prod
from time import process_time

import contactstudy as cs
from contactstudy.domain.errors import Request
from contactstudy.domain.fields import Array
from contactstudy.domain.reuse import caching
from contactstudy.io.scene_files.scene_schema import PlanSettings
from contactstudy.planning.grid_requirements import grid_requirements, with_random_extents
from contactstudy.scene import methods
from studies.advice.reference_error import last_of
from studies.advice.verdict import (
    EVERY_NUMBER,
    NAMED,
    PRESSURE,
    TIE,
    Measured,
    SceneToJudge,
    Setting,
    Verdict,
    bound_of,
    meets,
)
from studies.model.case import Answer
from studies.model.plain_text import Log
from studies.reference.line_contact import hertz_means, relative_l1, with_edges_moved
from studies.reference.paddings import PADDINGS, padding_label, padding_text

# Grids that are tried have these multiples of a sixth of the planned cells: up to twice those, or in a dry contact,
# which takes milliseconds, up to this number of cells.
SIXTHS = 6
MULTIPLES, FINEST, CHEAP_CELLS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 48, 96, 192), 2 * SIXTHS, 2**14
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6)
IMAGES = {"superposed": (1, 6, 20), "circular": (1, 2, 4, 6, 10, 20)}
# How much finer than needed grids of lines are tried.
FINER = 4
# A promise holds for a load that is lower by this factor too, whose contact edge lies elsewhere in its cell.
LOWER_LOAD = 0.92
# Other paddings are tried on cells of at most so many squares of the thickness of a layer: their coefficients are sums
# over waves as short as the layer, which grow with it.
MOST_WAVES = 30
# A window that is folded off centre, by half a cell, has at least so many cells along.
CENTRED = 8
# Factors on the planned width that are tried while the contact reaches the edge.
WIDER = (1.0, 1.5, 2.25)
# A grid that is expected to take longer is announced [s].
LONG = 60.0
# Rounds of times of the fastest: as many as take this processor time [s], at most so many.
ROUND_SECONDS, MAX_ROUNDS = 4.0, 40

NO_GRID = "no grid that was tried keeps the error with exact periodicity, or the ends of the scene"
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
    given: tuple[int, int] | None = None

    @property
    def error(self) -> float:
        """Requested error, the least of several."""
        return least_error(self.request)

    @property
    def is_line(self) -> bool:
        """Whether the contact is Hertz's line contact, of which a solve takes milliseconds."""
        return self.unit[1] == 1 and self.hertz_of(self.scene) is not None

    @property
    def multiples(self) -> tuple[int, ...]:
        """Multiples of the coarsest cells that may be tried."""
        return tuple(m for m in MULTIPLES if m <= FINEST or self.is_cheap(m))

    def is_cheap(self, multiple: int) -> bool:
        """Return whether a grid is tried without asking what it may give."""
        is_dry = self.scene.lubrication is None
        return multiple <= SIXTHS or (is_dry and prod(self.cells(multiple)) <= CHEAP_CELLS)

    def cells(self, multiple: int) -> tuple[int, int]:
        """Return the cells of a grid; a direction along which nothing varies has one."""
        across, along = (n * multiple if n > 1 else 1 for n in self.unit)
        return across, along

    def setting(
        self,
        label: str,
        padding: cs.Padding | cs.Paddings,
        cells: tuple[int, int],
        tolerance: float,
    ) -> Setting:
        """Return a setting on these cells, or on as many along as a copy needs to cover both sides alike."""
        across, along = cells
        if self.is_line and isinstance(padding, cs.DuplicatedPadding):
            along = max(along, CENTRED)
        return Setting(label, padding, (across, along), tolerance)

    def solve(
        self, setting: Setting, scene: cs.Scene | None = None, grid: cs.Grid | None = None
    ) -> Answer:
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
            lower = replace(
                self.scene, load=replace(load, **{name: LOWER_LOAD * getattr(load, name)})
            )
            hertz = lower.hertz if self.unit[1] == 1 else None
            grids = [grid] if hertz is None else with_edges_moved(grid, hertz.half_width)
            yield from ((lower, moved) for moved in grids)

    def measured(self, setting: Setting, reference: Array | None) -> Measured | None:
        """Return the largest bound and difference of a setting's variants; None without an answer."""
        try:
            return self._measured(setting, reference)
        except cs.InvalidInput as refused:
            self.notes[setting.label] = (
                f"{setting.label} on {_cells(setting.cells)} cells: {refused}"
            )
            return None

    def _measured(self, setting: Setting, reference: Array | None) -> Measured | None:
        l1 = difference = 0.0
        error, seconds, worst = nan if self.measure == PRESSURE else 0.0, inf, ""
        for number, (scene, grid) in enumerate(self.variants(setting)):
            with caching(None):
                start = process_time()
                answer = self.solve(setting, scene, grid)
                if number == 0:
                    seconds = process_time() - start
            if answer.status not in (cs.Status.CONVERGED, cs.Status.PRECISION_LIMIT):
                self.at_edge |= answer.status is cs.Status.CONTACT_AT_EDGE
                self.notes[setting.label] = (
                    f"{setting.label} on {_cells(setting.cells)} cells: {answer.status}"
                )
                return None
            l1 = max(l1, answer.error.l1.total)
            if self.measure != PRESSURE:
                error, worst = max((error, worst), _worst(answer, self.request))
            pressure = last_of(answer).pressure
            if number == 0:
                self.pressures[setting] = pressure
            if (hertz := self.hertz_of(scene)) is not None:
                difference = max(difference, relative_l1(pressure, hertz_means(hertz, grid)))
            elif number == 0 and reference is not None:
                difference = relative_l1(pressure, reference)
            if min(l1, error) > self.error and self.unit[1] > 1:
                break
        return Measured(setting, l1, error, worst, difference, seconds)

    def meets(self, one: Measured) -> bool:
        """Return whether a setting meets the error, by the measure."""
        return meets(one, self.error, self.measure)

    def choose_measure(self, found: Sequence[Measured]) -> None:
        """Let the pressure alone keep the error, where no setting keeps it by every number."""
        if self.measure == EVERY_NUMBER and not any(map(self.meets, found)):
            self.measure = PRESSURE

    def is_worth_refining(self, tried: Sequence[Measured], multiple: int) -> bool:
        """Return whether a finer grid may meet the error, by the rate at which the bound fell over the last three."""
        if self.meets(tried[-1]) or multiple == self.multiples[-1]:
            return False
        bounds = [(one.setting.cells[0], bound_of(one, self.measure)) for one in tried]
        bounds = [(cells, bound) for cells, bound in bounds if isfinite(bound)]
        if len(bounds) < 4 or multiple < SIXTHS:
            return True
        *coarser, (coarse, first), middle, (fine, last) = bounds
        if self.is_cheap(self.multiples[self.multiples.index(multiple) + 1]):
            # a bound that counts cells jumps from one grid to the next
            return min(first, middle[1], last) < min(bound for _, bound in coarser)
        rate = log(first / last) / log(fine / coarse)
        finest = self.cells(self.multiples[-1])[0]
        return bool(last * (fine / finest) ** rate <= self.error)

    def on_given_grid(self, base: str) -> Measured | None:
        """Return what was measured on the cells of the scene file if they meet the error, else None."""
        if self.given is None:
            return None
        setting = self.setting(base, self.own, self.given, self.options.tolerance)
        one = self.measured(setting, None)
        return one if one is not None and self.meets(one) else None

    def hertz_of(self, scene: cs.Scene) -> "cs.analytic.HertzLine | None":
        """Return Hertz's line contact where it is the exact solution: a smooth elastic cylinder under a load."""
        at_rest = scene.method is methods.STATIC
        hertz = scene.hertz
        if (
            hertz is None
            or isinstance(self.own, tuple)
            or not at_rest
            or scene.adhesion is not None
        ):
            return None
        is_plain = scene.friction is None and all(
            type(body) is cs.HalfSpace for body in scene.solids
        )
        is_smooth = is_plain and grid_requirements(scene).is_smooth
        is_exact = is_smooth and scene.hardness > hertz.peak_pressure
        return hertz if is_exact and not isinstance(scene.load, cs.Approach) else None


def verdict_on(
    described: SceneToJudge,
    error: Request,
    log: Log = lambda text: None,
    measure: str = EVERY_NUMBER,
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
    for wider in WIDER:
        trials = _trials(described.file, error, measure, wider)
        base = _label(trials.own)
        own, paddings = base, {base: trials.own}
        if not isinstance(trials.own, tuple):
            named = described.file.padding or trials.own
            own = _label(named)
            paddings |= all_paddings() | {own: named}
        if trials.unit[1] == 1 and not trials.is_line and "duplicated" in paddings:
            del paddings["duplicated"]
            trials.notes["duplicated"] = (
                "Duplicated padding was not tried, since its window is off centre with one cell."
            )
        log(
            f"{described.name}: grids from {_cells(trials.cells(1))} cells, up to {len(paddings)} paddings"
        )
        on_grids = paddings if trials.is_line else {base: trials.own}
        found = list(
            _on_grids(trials, on_grids, base, lambda text: log(f"{described.name}: {text}"))
        )
        if described.file.grid is not None or not trials.at_edge or any(map(trials.meets, found)):
            break
    if not found:
        raise cs.InvalidInput(f"{described.name} has no answer: {' '.join(trials.notes.values())}")
    trials.choose_measure(found)
    # of grids on which the pressure meets the error, and no other number ever does, the coarsest
    coarsest = {
        one.setting.label: one.setting.cells for one in reversed(found) if trials.meets(one)
    }
    against, reference = "Hertz's contact", None
    if not trials.is_line:
        finest = found[-1].setting
        against, reference = _reference(trials, finest) if coarsest else (NO_REFERENCE, None)
        found = [
            replace(one, difference=nan if reference is None else relative_l1(trials.pressures[one.setting], reference))
            for one in found
        ]  # fmt: skip
        if why := _why_own_alone(trials, found):
            trials.notes["other paddings"] = f"No other padding was tried, since {why}."
            paddings = {base: trials.own}
    cells, loosest = coarsest.get(base, found[-1].setting.cells), trials.options.tolerance
    if base in coarsest:
        loosest = _loosest(trials, Setting(base, trials.own, cells, loosest))
    settings = [
        trials.setting(label, padding, coarsest.get(label, cells), loosest)
        for label, padding in paddings.items()
    ]
    tried = {one.setting for one in found}
    settings = [setting for setting in settings if setting not in tried]
    found += [one for setting in settings if (one := trials.measured(setting, reference))]
    log(f"{described.name}: times of {sum(map(trials.meets, found))} settings that meet it")
    return Verdict(
        described.name, described.text, trials.error, trials.measure, trials.extent, own, against,
        tuple(_timed(trials, found)),
        tuple(note for label, note in trials.notes.items() if label not in {one.setting.label for one in found}),
        asked,
    )  # fmt: skip


def _on_grids(
    trials: _Trials, paddings: Mapping[str, cs.Padding | cs.Paddings], base: str, say: Log
) -> Iterator[Measured]:
    """Yield what was measured with some paddings on grids from the coarsest.

    The last grid is the first on which the padding of the name `base` meets the error; that of the scene file stands in
    where no other does. Of lines, whose solves take milliseconds, further ones are tried.
    """
    last, seconds, cells, tried = inf, 0.0, (1, 1), list[Measured]()
    for multiple in trials.multiples:
        if multiple > last:  # which costs more, for an error that nobody asked for
            return
        coarser, cells = cells, trials.cells(multiple)
        if (expected := seconds * prod(cells) / prod(coarser)) > LONG:
            say(f"about {expected:.0f} s or more on {_cells(cells)} cells")
        for label, padding in paddings.items():
            setting = trials.setting(label, padding, cells, trials.options.tolerance)
            one = trials.measured(setting, None)
            if one is None:
                continue
            yield one
            if label == base:
                seconds = one.seconds
                tried.append(one)
                if not trials.is_worth_refining(tried, multiple):
                    if not trials.meets(one) and (own := trials.on_given_grid(base)):
                        yield own
                        return
                    trials.choose_measure(tried)
                if not trials.is_worth_refining(tried, multiple):
                    last = min(last, multiple * (FINER if trials.is_line else 1))


def least_error(request: Request) -> float:
    """Return a requested error, the least of several."""
    return min(request.values()) if isinstance(request, Mapping) else request


def _trials(file: cs.SceneFile, error: Request, measure: str, wider: float) -> _Trials:
    """Return the solves of a scene on the extent of its grid, or of the plan for the error, so many times as wide."""
    padding: cs.Padding | cs.Paddings | None = None
    if isinstance(file.padding, tuple):
        padding = file.padding
    plan = PlanSettings(error, file.plan_settings.period)
    grid = file.grid
    if grid is None or file.scene.hertz is not None:
        wanted = PlanSettings(error, grid.length) if grid is not None else plan
        planned = replace(file, grid=None, padding=padding, plan_settings=wanted).plan()
        if grid is None:
            (nx, ny), (width, length) = planned.grid.cells, planned.grid.extent
            grid = cs.Grid((round(wider * nx), ny), (wider * width, length))
        else:  # the extent that is given, with cells of the size that the error needs
            sizes = zip(
                grid.extent, planned.grid.cell_size, grid.cells, planned.grid.cells, strict=True
            )
            across, along = (
                1 if 1 in (given, plan_cells) else max(SIXTHS, round(side / size))
                for side, size, given, plan_cells in sizes
            )
            grid = cs.Grid((across, along), grid.extent)
        padding = padding or planned.padding
    own = padding or cs.ExactPeriodicity()
    across, along = (max(1, round(n / SIXTHS)) if n > 1 else 1 for n in grid.cells)
    scene = with_random_extents(file.scene, grid.extent)
    times = (
        file.time_steps if scene.method.takes_times and file.time_steps != cs.TimeSteps() else None
    )
    return _Trials(
        scene, grid.extent, own, (max(2, across), along), file.options, times, error, measure,
        given=None if file.grid is None else file.grid.cells,
    )  # fmt: skip


def all_paddings() -> dict[str, cs.Padding]:
    """Return all paddings by their names, with numbers of images where they have one."""
    return {
        padding_label(name, n): make(n)
        for name, make in PADDINGS.items()
        for n in IMAGES.get(name, (0,))
    }


def _label(padding: cs.Padding | cs.Paddings) -> str:
    """Return the name of a padding that a scene has."""
    if isinstance(padding, tuple):
        return "repeating across and along" if padding[0].wraps else "free ends"
    return padding_text(repr(padding))


def _worst(answer: Answer, request: Request) -> tuple[float, str]:
    """Return the largest bound that is judged, and of what it is; numbers without a bound are left out.

    Those of numbers that are named are in proportion to the least request, and infinite without a bound.
    """
    if isinstance(request, Mapping):
        least = least_error(request)
        named = [(number.ratio * least, number) for number in answer.judged.values()]
        counted, worst = max(named, key=lambda one: one[0])
        asked = f", whose {100 * worst.bound:.2g} % of {100 * worst.requested:g} % asked count so"
        return counted, f"in the {worst.label}" + asked * (worst.requested > least)
    measure, parts = answer.judged_error
    bounds = [
        (number.bound, f"in the {number.label}")
        for number in answer.judged.values()
        if isfinite(number.bound)
    ]
    return max([(parts.total, measure), *bounds])


def _cells(cells: tuple[int, int]) -> str:
    """Return numbers of cells as text."""
    return f"{cells[0]} x {cells[1]}"


def _loosest(trials: _Trials, setting: Setting) -> float:
    """Return the loosest tolerance at which a setting meets the error, or the scene's own if none does."""
    for tolerance in (t for t in TOLERANCES if t > setting.tolerance):
        one = trials.measured(replace(setting, tolerance=tolerance), None)
        if one and trials.meets(one):
            return tolerance
    return setting.tolerance


def _why_own_alone(trials: _Trials, found: Sequence[Measured]) -> str:
    """Return why no padding but the scene's own is tried; empty where others are."""
    if isinstance(trials.own, tuple):
        return ""
    meeting = [one for one in found if trials.meets(one)]
    if not meeting:
        return NO_GRID
    layers = [
        body.thickness for body in trials.scene.solids if isinstance(body, cs.CoatedHalfSpace)
    ]
    cell_area = prod(trials.extent) / prod(meeting[0].setting.cells)
    waves = max((cell_area / layer**2 for layer in layers), default=0)
    if waves > MOST_WAVES:
        return (
            f"a cell is {waves:.0f} times as large as the square of the thickness of the layer, "
            "and a coefficient of each sums as many waves"
        )
    return ""


def _reference(trials: _Trials, finest: Setting) -> tuple[str, Array]:
    """Return what differences are against in words, a solution on cells of half the size, and its pressure."""
    across, along = (2 * n if n > 1 else 1 for n in finest.cells)
    finer = replace(finest, cells=(across, along))
    answer = trials.solve(finer)
    bound = answer.judged_error[1].total
    own_error = (
        f"whose own error is at most {100 * bound:.2g} %"
        if isfinite(bound)
        else "which has no bound itself"
    )
    return f"a solution on {_cells(finer.cells)} cells, {own_error}", last_of(answer).pressure


def _timed(trials: _Trials, found: Sequence[Measured]) -> Iterator[Measured]:
    """Yield what was measured with the least processor time of rounds in which all settings that meet it take turns."""
    times = {one.setting: one.seconds for one in found}

    def take(settings: Sequence[Setting], most: int, least: int = 0) -> None:
        total = sum(times[setting] for setting in settings)
        for _ in range(max(least, min(most, int(ROUND_SECONDS / total))) if settings else 0):
            for setting in settings:
                times[setting] = min(times[setting], trials.seconds(setting))

    take(list(times), 2)  # none where a solve takes long
    meeting = [one.setting for one in found if trials.meets(one)]
    take(meeting, 2, 2)
    fastest = min((times[setting] for setting in meeting), default=inf)
    # a busy machine adds more than a tie to most times of a setting, and not to all
    take([setting for setting in meeting if times[setting] <= TIE**3 * fastest], MAX_ROUNDS, 1)
    yield from (replace(one, seconds=times[one.setting]) for one in found)
