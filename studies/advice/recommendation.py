"""Recommendations: the cheapest setting that meets an error, a memory and a time, and the runner-up."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf, isfinite, prod

import contactstudy as cs
from contactstudy.accuracy.expected_error import L1_LEFT, Edges, ErrorParts, HertzianContact, Metric
from contactstudy.accuracy.truncation import expected_truncation
from contactstudy.domain.checks import positive
from contactstudy.domain.device import available_bytes
from contactstudy.domain.grid import Paddings
from contactstudy.planning.cost import (
    ROUGH_CONVOLUTIONS,
    SMOOTH_CONVOLUTIONS,
    CostModel,
    convolutions_to,
    memory,
)
from contactstudy.planning.grid_requirements import ROOM, Needs
from contactstudy.planning.grid_search import GridForecast, reaching
from contactstudy.planning.plan import SHARE, needs_of
from contactstudy.planning.trials import cheapest
from studies.reference.line_contact import COUNTS_IMAGES, LINE, PADDINGS, padding_at

# Candidates: cells across that can be halved repeatedly, images, and tolerances.
ACROSS = tuple(part * 2**k for k in range(16) for part in (32, 40, 48, 56))
IMAGES = (1, 2, 3, 4, 6, 8, 12, 20, 30, 50, 80, 120, 200)
TOLERANCES = tuple(10.0**-k for k in range(4, 12))
LARGEST = 2**26  # cells
# From this tolerance on the solver knows which cells of a rough contact touch.
SETTLED = 1e-5
# Shares of the requested error for the cells of a rough contact; the remainder is for the images.
SHARES = (0.95, 0.8, 0.5, 2.0, 5.0, 20.0, 100.0)


@dataclass(frozen=True)
class Limits:
    """Requested accuracy and cost.

    Attributes
    ----------
    error
        Relative error.
    metric
        Quantity that the error refers to.
    memory
        Largest number of bytes.
    seconds
        Longest time [s] on one thread.
    """

    error: float
    metric: Metric = Metric.L1
    memory: float = inf
    seconds: float = inf

    def __post_init__(self) -> None:
        positive("error", self.error, "give a relative error above 0, such as 1e-3")
        for name, remedy in (
            ("memory", "give a memory above 0, such as 4 GB"),
            ("seconds", "give a time above 0, such as 10 s"),
        ):
            if getattr(self, name) != inf:
                positive(name, getattr(self, name), remedy)


@dataclass(frozen=True)
class Setting:
    """A way to solve a contact, and what to expect of it.

    Attributes
    ----------
    mode
        Name of the padding, see :func:`mode_of`.
    padding, grid, tolerance, edges
        The setting.
    error
        Expected relative error by cause.
    seconds
        Expected seconds on one thread.
    bytes
        Bytes that a solve holds at most.
    """

    mode: str
    padding: cs.Padding | Paddings
    grid: cs.Grid
    tolerance: float
    edges: Edges
    error: ErrorParts
    seconds: float
    bytes: int


@dataclass(frozen=True)
class Recommendation:
    """The best setting within limits, and the best of another mode.

    Attributes
    ----------
    limits
        The requested accuracy and cost.
    best
        The cheapest setting that meets the error; if none does, the one with the least error within memory and time, or
        if there is none either, the quickest.
    runner_up
        The best setting of another mode; None without one.
    meets
        Whether the best setting keeps to all limits.
    affordable
        Whether any setting keeps to memory and time.
    """

    limits: Limits
    best: Setting
    runner_up: Setting | None
    meets: bool
    affordable: bool


@dataclass(frozen=True)
class SmoothContact:
    """A smooth line contact, and the settings to choose from.

    Attributes
    ----------
    half_width
        Half-width of the contact [m].
    period
        Length of the grid [m].
    modes
        Names of paddings; without "line", settings that also hold where something varies along the length.
    across
        Numbers of cells across; as many lie along a period.
    images
        Numbers of images.
    tolerances
        Tolerances of the solver, from the largest.
    convolutions
        Transform pairs of a solve to the default tolerance.
    """

    half_width: float
    period: float
    modes: tuple[str, ...] = (LINE, *PADDINGS)
    across: tuple[int, ...] = ACROSS
    images: tuple[int, ...] = IMAGES
    tolerances: tuple[float, ...] = TOLERANCES
    convolutions: float = field(default=SMOOTH_CONVOLUTIONS, init=False)

    def ways(self, limits: Limits) -> Iterator[tuple[cs.Grid, cs.Padding, Edges]]:
        """Yield every grid, padding and treatment of the edges."""
        extent = 2 * ROOM * self.half_width, self.period
        treatments = tuple(Edges) if limits.metric is Metric.L1 else (Edges.AS_SOLVED,)
        for mode in self.modes:
            padding = "exact" if mode == LINE else mode
            for images in self.images if mode in COUNTS_IMAGES else self.images[:1]:
                for cells in self.across:
                    grid = cs.Grid((cells, 1 if mode == LINE else cells), extent)
                    for edges in treatments:
                        yield grid, padding_at(padding, images), edges

    def error(
        self,
        limits: Limits,
        grid: cs.Grid,
        padding: cs.Padding | Paddings,
        edges: Edges,
        tolerance: float,
    ) -> ErrorParts:
        """Return an upper estimate of the error of a setting, by cause."""
        assert not isinstance(padding, tuple)
        contact = HertzianContact(self.half_width)
        return contact.error(limits.metric, edges, grid, padding, tolerance)


@dataclass(frozen=True)
class RoughContact:
    """A contact with roughness, a roller's ends or a hardness, and the settings to choose from.

    Attributes
    ----------
    needs
        Properties of its scene that determine the grid.
    planned
        The planned grid, with the error and the cost to expect.
    tolerances
        Tolerances of the solver, from the largest.
    convolutions
        Transform pairs of a solve to the default tolerance.
    """

    needs: Needs
    planned: GridForecast
    tolerances: tuple[float, ...] = TOLERANCES
    convolutions: float = field(default=ROUGH_CONVOLUTIONS, init=False)

    def ways(self, limits: Limits) -> Iterator[tuple[cs.Grid, cs.Padding | Paddings, Edges]]:
        """Yield the planned grid and some coarser and finer ones, with every padding that fits."""
        grids = [self.planned.grid]
        if 0 < self.planned.error < inf:
            other_grids = (self.planned.grid_for(limits.error * share) for share in SHARES)
            # the plan has the coarsest grid that meets the error: a coarser one is tried only if it is expected not to
            grids += [
                grid
                for grid in other_grids
                if prod(grid.cells) > prod(self.planned.grid.cells)
                or self.planned.error_of(grid.cell) > limits.error
            ]
        for grid in grids:
            if self.needs.roller or not self.needs.varies:
                yield grid, self.needs.padding(), Edges.AS_SOLVED
                continue
            for mode in PADDINGS:
                for images in IMAGES if mode in COUNTS_IMAGES else IMAGES[:1]:
                    yield grid, padding_at(mode, images), Edges.AS_SOLVED

    def error(
        self,
        limits: Limits,
        grid: cs.Grid,
        padding: cs.Padding | Paddings,
        edges: Edges,
        tolerance: float,
    ) -> ErrorParts:
        """Return the expected L1 error of a setting, by cause."""
        truncation = 0.0
        if not isinstance(padding, tuple):
            truncation = expected_truncation(self.needs.half_width, grid, padding).l1
        residual = L1_LEFT * tolerance if tolerance <= SETTLED else inf
        return ErrorParts(truncation, self.planned.error_of(grid.cell), residual)


def _unjudged(scene: cs.Scene) -> str | None:
    """Return the name of the first field whose errors a recommendation does not know; None if it knows them all."""
    if scene.changing is not None:
        return scene.changing
    later = ("rolling", "lubrication")
    return next((f"Scene.{name}" for name in later if getattr(scene, name, None) is not None), None)


def contact_of(
    scene: cs.Scene, period: float | None, limits: Limits
) -> SmoothContact | RoughContact:
    """Return what a recommendation must know of a scene's contact.

    Parameters
    ----------
    scene
        The scene. One that is not smooth is planned for the error of `limits`, so that plan and recommendation have the
        same grid.
    period
        Length of the grid [m]; chosen if None.
    limits
        The requested accuracy and cost.

    Raises
    ------
    InvalidInput
        If no plan can be made of the scene, see :func:`~contactstudy.plan`, or it is not smooth and the metric is not
        L1.
    NotDefined
        If no grid has a known error.
    """
    if (unknown := _unjudged(scene)) is not None:
        raise cs.NotDefined(
            f"{unknown} is given: a recommendation knows one elastic contact at rest, its error and its cost, "
            "leave it out or call contactstudy.plan."
        )
    needs = needs_of(scene)
    if needs.smooth and scene.hardness > needs.hertz.peak_pressure:
        half_width = needs.hertz.half_width
        return SmoothContact(half_width, period or 2 * ROOM * half_width)
    if limits.metric is not Metric.L1:
        raise cs.InvalidInput(
            f"metric is {limits.metric.name.lower()!r}: give l1, the only error with a law where a contact is "
            "not smooth."
        )
    max_bytes = min(limits.memory, SHARE * available_bytes())
    planned = reaching(scene, needs, limits.error, period, max_bytes)
    planned = cheapest(scene, needs, planned, limits.error)
    if planned.error == inf:
        raise cs.NotDefined(
            f"Scene has no grid whose error can be said: {_obstacle(needs, planned)}"
        )
    return RoughContact(needs, planned)


def _obstacle(needs: Needs, planned: GridForecast) -> str:
    """Return a sentence on why no error is known."""
    if planned.cut_off:
        return (
            f"the contact outgrows the measured surface, which is {needs.widest:.4g} m wide; give a smaller "
            "load or a wider surface."
        )
    return (
        planned.message or "small solutions do not show the surface; give a shape with a `detail`."
    )


def recommend(
    contact: SmoothContact | RoughContact, limits: Limits, costs: CostModel
) -> Recommendation:
    """Return the cheapest setting for `contact` within `limits`, by expected errors and seconds."""
    return choose(list(candidates(contact, limits, costs)), limits)


def choose(settings: list[Setting], limits: Limits) -> Recommendation:
    """Return the cheapest of `settings` within `limits`, with the runner-up."""
    within = [
        setting
        for setting in settings
        if setting.bytes <= limits.memory and setting.seconds <= limits.seconds
    ]
    meeting = [setting for setting in within if setting.error.total <= limits.error]
    if meeting:
        ranked = sorted(meeting, key=lambda setting: (setting.seconds, setting.error.total))
    elif within:
        # to two digits, since more are not worth any price
        ranked = sorted(
            within, key=lambda setting: (float(f"{setting.error.total:.1e}"), setting.seconds)
        )
    else:
        ranked = sorted(settings, key=lambda setting: (setting.seconds, setting.error.total))
    best = ranked[0]
    other_modes = (setting for setting in ranked if setting.mode != best.mode)
    return Recommendation(limits, best, next(other_modes, None), bool(meeting), bool(within))


def candidates(
    contact: SmoothContact | RoughContact, limits: Limits, costs: CostModel
) -> Iterator[Setting]:
    """Yield every setting, with the largest tolerance that keeps to the error, or else the smallest."""
    for grid, padding, edges in contact.ways(limits):
        if prod(grid.cells) > LARGEST:
            continue
        for tolerance in contact.tolerances:
            error = contact.error(limits, grid, padding, edges, tolerance)
            if error.total <= limits.error:
                break
            if error.truncation + error.discretisation > limits.error:
                tolerance = contact.tolerances[-1]
                error = contact.error(limits, grid, padding, edges, tolerance)
                break
        if isfinite(error.total):
            seconds = costs.seconds(grid, padding, convolutions_to(tolerance, contact.convolutions))
            yield Setting(
                mode_of(grid, padding), padding, grid, tolerance, edges, error, seconds,
                memory(grid, padding),
            )  # fmt: skip


def mode_of(grid: cs.Grid, padding: cs.Padding | Paddings) -> str:
    """Return the name that the sweeps give a padding along the length.

    It is "line" for exact periodicity on one cell along, and "free" for a pair of paddings.
    """
    if isinstance(padding, tuple):
        return "free"
    if isinstance(padding, cs.ExactPeriodicity) and grid.cells[1] == 1:
        return LINE
    names = (name for name, make in PADDINGS.items() if type(make(1)) is type(padding))
    return next(names, "")
