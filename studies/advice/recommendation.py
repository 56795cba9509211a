"""The cheapest setting that meets an error, a memory and a time, and what else would."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import inf, isfinite, prod

import contactstudy as cs
from contactstudy.accuracy.expected_error import L1_LEFT, Contact, Edges, ErrorParts, Metric
from contactstudy.accuracy.truncation import expected_truncation
from contactstudy.domain.checks import positive
from contactstudy.domain.memory import available_bytes
from contactstudy.domain.padding import Paddings
from contactstudy.planning.cost import (
    ROUGH_CONVOLUTIONS,
    SMOOTH_CONVOLUTIONS,
    CostModel,
    convolutions_to,
    memory,
)
from contactstudy.planning.grid_requirements import ROOM, Needs
from contactstudy.planning.plan import SHARE, GridForecast, needs_of, reaching
from studies.reference.line_contact import COUNTS_IMAGES, LINE, PADDINGS, padding_at

# What is tried: cells across that halve again and again, images, and tolerances.
ACROSS = tuple(part * 2**k for k in range(16) for part in (32, 40, 48, 56))
IMAGES = (1, 2, 3, 4, 6, 8, 12, 20, 30, 50, 80, 120, 200)
TOLERANCES = tuple(10.0**-k for k in range(4, 12))
LARGEST = 2**26  # cells
# From this tolerance on the solver knows which cells of a rough contact touch.
SETTLED = 1e-5
# Of the error asked for, what the cells of a rough contact may take; the rest is left to the images.
SHARES = (0.95, 0.8, 0.5, 2.0, 5.0, 20.0, 100.0)


@dataclass(frozen=True)
class Limits:
    """What is asked: a relative ``error`` of a ``metric`` with at most so many bytes and seconds."""

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
    """A way to solve, and what to expect of it: ``error`` by cause, ``seconds`` on one thread, ``bytes``."""

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
    """The ``best`` setting, whether it ``meets`` what was asked, and the ``runner_up`` of another mode.

    Where none meets it, the best is the one with the least error of those within memory and time, or
    where even these are out of reach (``affordable`` is false) the quickest.
    """

    limits: Limits
    best: Setting
    runner_up: Setting | None
    meets: bool
    affordable: bool


@dataclass(frozen=True)
class SmoothContact:
    """A smooth line contact of ``half_width`` [m], over one ``period`` [m] of its length.

    ``modes`` are those to choose from; without "line" as where something varies along the length. As
    many cells lie along a period as across.
    """

    half_width: float
    period: float
    modes: tuple[str, ...] = (LINE, *PADDINGS)
    across: tuple[int, ...] = ACROSS
    images: tuple[int, ...] = IMAGES
    tolerances: tuple[float, ...] = TOLERANCES
    convolutions: float = field(default=SMOOTH_CONVOLUTIONS, init=False)

    def ways(self, limits: Limits) -> Iterator[tuple[cs.Grid, cs.Padding, Edges]]:
        """Every grid, padding and treatment of the edges."""
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
        """The expected error, at most."""
        assert not isinstance(padding, tuple)
        contact = Contact(self.half_width)
        return contact.error(limits.metric, edges, grid, padding, tolerance)


@dataclass(frozen=True)
class RoughContact:
    """A contact with roughness, a roller's ends or a hardness: what its scene asks of a grid, and its plan."""

    needs: Needs
    planned: GridForecast
    tolerances: tuple[float, ...] = TOLERANCES
    convolutions: float = field(default=ROUGH_CONVOLUTIONS, init=False)

    def ways(self, limits: Limits) -> Iterator[tuple[cs.Grid, cs.Padding | Paddings, Edges]]:
        """The grid of the plan and some coarser and finer, with every padding that fits."""
        grids = [self.planned.grid]
        if 0 < self.planned.error < inf:
            others = (self.planned.grid_for(limits.error * share) for share in SHARES)
            # a coarser grid than the plan's would have been the plan's, if it met the error
            grids += [
                grid
                for grid in others
                if grid.cells[0] > self.planned.grid.cells[0]
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
        """The error to expect, in L1."""
        cut = 0.0
        if not isinstance(padding, tuple):
            cut = expected_truncation(self.needs.half_width, grid, padding).l1
        left = L1_LEFT * tolerance if tolerance <= SETTLED else inf
        return ErrorParts(cut, self.planned.error_of(grid.cell), left)


def contact_of(
    scene: cs.Scene, period: float | None, limits: Limits
) -> SmoothContact | RoughContact:
    """What a recommendation must know of ``scene``; ``period`` [m] is chosen where none is given.

    One that is not smooth is planned for the error of ``limits``, so that both give the same grid. Raises
    :class:`~contactstudy.InvalidInput` where no plan can be made of the scene (see :func:`~contactstudy.plan`),
    and for a rough one unless the metric is L1.
    """
    needs = needs_of(scene)
    if needs.smooth and scene.hardness > needs.hertz.peak_pressure:
        a = needs.hertz.half_width
        return SmoothContact(a, period or 2 * ROOM * a)
    if limits.metric is not Metric.L1:
        raise cs.InvalidInput(
            f"metric is {limits.metric.name.lower()!r}: give l1, the only error with a law where a contact is "
            "not smooth."
        )
    most = min(limits.memory, SHARE * available_bytes())
    planned = reaching(scene, needs, limits.error, period, most)
    if planned.error == inf:
        raise cs.NotDefined(
            f"Scene has no grid whose error can be said: {_obstacle(needs, planned)}"
        )
    return RoughContact(needs, planned)


def _obstacle(needs: Needs, planned: GridForecast) -> str:
    """Why no error can be said, in a sentence."""
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
    """The cheapest setting for ``contact`` within ``limits``, by expected errors and seconds."""
    return choose(list(candidates(contact, limits, costs)), limits)


def choose(found: list[Setting], limits: Limits) -> Recommendation:
    """The cheapest of the settings ``found`` within ``limits``."""
    within = [s for s in found if s.bytes <= limits.memory and s.seconds <= limits.seconds]
    meeting = [s for s in within if s.error.total <= limits.error]
    if meeting:
        ranked = sorted(meeting, key=lambda s: (s.seconds, s.error.total))
    elif within:
        # to two digits, since the last of them is not worth every price
        ranked = sorted(within, key=lambda s: (float(f"{s.error.total:.1e}"), s.seconds))
    else:
        ranked = sorted(found, key=lambda s: (s.seconds, s.error.total))
    best = ranked[0]
    others = (setting for setting in ranked if setting.mode != best.mode)
    return Recommendation(limits, best, next(others, None), bool(meeting), bool(within))


def candidates(
    contact: SmoothContact | RoughContact, limits: Limits, costs: CostModel
) -> Iterator[Setting]:
    """Every way with the largest tolerance that keeps it to the error, or else the smallest."""
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
