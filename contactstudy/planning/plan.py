"""Which grid and padding a scene calls for, and what that will cost, found by small solutions before anything runs."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from math import ceil, inf, log2, prod, sqrt

import numpy as np

from contactstudy.accuracy.coarser import change
from contactstudy.accuracy.estimate import SHARP_EDGE, error_estimate
from contactstudy.domain.checks import InvalidInput, NotDefined, positive
from contactstudy.domain.device import ONE_THREAD, Device, checked
from contactstudy.domain.grid import Grid
from contactstudy.domain.memory import available_bytes
from contactstudy.domain.padding import ExactPeriodicity, Padding, Paddings, across_and_along
from contactstudy.planning.cost import (
    DIGITS,
    SMOOTH_CONVOLUTIONS,
    CostModel,
    memory,
    timed,
    times_faster,
)
from contactstudy.planning.grid_requirements import COARSEST, RATE, ROOM, Needs, halvable
from contactstudy.scene.bodies import Layered
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions

# The error that a plan keeps to if none is asked for.
DEFAULT_ERROR = 1e-3
# Relative error of the film of a lubricated scene that is planned where none is asked for.
FILM_ERROR = 1e-2
# Cells of a small solution at most, in one and in two dimensions, more of them where the surface is finer; and the
# tolerance that it is solved to.
LINE, PLANE, MOST, TOLERANCE = 2**13, 2**16, 2**19, 1e-5
# Powers of the cell with which an error falls: of a step, of one that is not observed, and of a smooth contact.
SLOWEST, USUAL, FASTEST = 0.5, 1.0, 1.5
# Ratio of an error's upper estimate to the error expected: exceeded in all but a few cases of the accuracy matrix.
BOUND = 1.5
# A solution on fewer cells along an axis shows nothing, and a roller is planned with no fewer than the second.
FEWEST, ROLLER = 8, 16
# Small solutions show a grid that is too narrow or too coarse; each round mends it, a width by such a factor.
ROUNDS, WIDER = 6, 1.5
# A grid with so many times the cells that are needed is made coarser, and a width so many times that of the contact
# and its room is made narrower.
WASTE = 1.25
# Cells along an axis are extrapolated by no more than such a factor at once.
FURTHEST = 16.0
# The share of the error asked for that the cells may take; the solver takes the rest.
ALMOST = 0.95
# The law of rough contacts, a mean over surfaces, is multiplied by this where small solutions do not show the surface.
TRUSTED = 2.0
# The share of the machine's memory that a plan may take.
SHARE = 0.8


@dataclass(frozen=True)
class GridForecast:
    """The error and the cost to expect of a solve on ``grid``.

    ``errors`` are the shares (across, along) of the relative L1 error of the pressure, infinite if they are not known.
    They fall with the cell along their axis to the powers ``rates``. ``fewest`` are the cells along each axis that show
    the surface at all. ``cut_off`` says that the contact outgrows the grid; ``contact_width`` [m] is that about the
    axis within which all contact lies. ``message`` names what no grid mends, such as an infinite pressure, or is empty.
    """

    grid: Grid
    errors: tuple[float, float]
    rates: tuple[float, float]
    fewest: tuple[int, int]
    cut_off: bool
    message: str
    seconds: float
    contact_width: float = inf

    @property
    def error(self) -> float:
        """Relative L1 error of the pressure to expect on the grid."""
        return sum(self.errors)

    def error_of(self, cell: tuple[float, float]) -> float:
        """Relative L1 error of the pressure to expect of another ``cell`` (dx, dy) [m]."""
        parts = zip(self.errors, self.rates, cell, self.grid.cell, strict=True)
        return float(sum(error * (size / own) ** rate for error, rate, size, own in parts if error))

    def grid_for(self, error: float) -> Grid:
        """Return the grid of fewest cells and the same extent that keeps to ``error``.

        With errors ``e_x n_x^-r_x + e_y n_y^-r_y``, the product of both counts is least where ``r_x`` times the error
        across equals ``r_y`` times that along. An axis at its fewest cells leaves the rest of the error to the other.
        """
        (across, along), (rate_x, rate_y) = self.errors, self.rates
        if self.grid.cells[1] == 1 or not along:
            return self._with(self._count(0, error), self.grid.cells[1])
        nx = self._count(0, error * rate_y / (rate_x + rate_y))
        ny = self._count(1, error - across * (self.grid.cells[0] / nx) ** rate_x)
        return self._with(self._count(0, error - along * (self.grid.cells[1] / ny) ** rate_y), ny)

    def _count(self, axis: int, error: float) -> float:
        """Cells along an axis for a share of the error."""
        count, share, rate = self.grid.cells[axis], self.errors[axis], self.rates[axis]
        wanted = count * (share / error) ** (1 / rate) if error > 0 else inf
        return max(min(wanted, FURTHEST * count), self.fewest[axis])

    def _with(self, across: float, along: float) -> Grid:
        ny = 1 if self.grid.cells[1] == 1 else halvable(along, self.fewest[1])
        return Grid((halvable(across, self.fewest[0]), ny), self.grid.extent)


def forecast(scene: Scene, needs: Needs, grid: Grid) -> GridForecast:
    """Solve ``scene`` on a coarse grid of the extent of ``grid`` and on coarser ones, and extrapolate to ``grid``.

    The error's estimate on the coarse grid is shared between the axes in proportion to the changes of the pressure
    when the cells are halved along one axis alone, which also show the rates.
    """
    padding = needs.padding()
    fewest = _fewest(needs, grid)
    small = _coarse(grid, fewest)
    # to the default tolerance, since it shows what a solve costs
    fine, timing = timed(lambda one: scene.problem(one, padding), small, 10.0**-DIGITS)
    estimate = error_estimate(fine)
    sharp = next((warning for warning in estimate.warnings if SHARP_EDGE in warning), "")
    error = estimate.l1.discretisation / BOUND
    changes, rates = [0.0, 0.0], [USUAL, USUAL]
    for axis in range(2 if error < inf else 0):
        seen = [fine]
        while len(seen) < 3 and small.cells[axis] >= FEWEST * 2 ** len(seen):
            halved = list(small.cells)
            halved[axis] = ceil(halved[axis] / 2 ** len(seen))
            coarser = Grid((halved[0], halved[1]), small.extent)
            seen.append(SolveOptions(TOLERANCE).solved(scene.problem(coarser, padding)))
        steps = [change(one, other).l1 for one, other in pairwise(seen)]
        changes[axis] = steps[0] if steps else 0.0
        shown = small.cells[axis] >= 4 * fewest[axis] or not needs.rough
        if len(steps) > 1 and min(steps) > 0 and shown:
            rates[axis] = float(np.clip(log2(steps[1] / steps[0]), SLOWEST, FASTEST))
    shares = np.array(changes) / sum(changes) if sum(changes) else np.array([1.0, 0.0])
    known = GridForecast(
        small,
        (error, 0.0) if error == inf else (error * shares[0], error * shares[1]),
        (rates[0], rates[1]),
        fewest,
        fine.status is Status.CONTACT_AT_EDGE,
        sharp,
        CostModel((timing,)).seconds(grid, padding, timing.convolutions),
        _contact_width(fine),
    )
    parts = zip(known.errors, known.rates, grid.cell, small.cell, strict=True)
    across, along = (
        part * (size / own) ** rate if part else 0.0 for part, rate, size, own in parts
    )
    return replace(known, grid=grid, errors=(across, along))


def _fewest(needs: Needs, grid: Grid) -> tuple[int, int]:
    """Return the cells (across, along) below which a grid does not show the surface."""
    least = ROLLER if needs.roller else COARSEST
    across, along = (
        max(least, ceil(extent / length * (1 - 1e-9)))
        for extent, length in zip(grid.extent, needs.finest, strict=True)
    )
    return across, along if grid.cells[1] > 1 else 1


def _coarse(grid: Grid, fewest: tuple[int, int]) -> Grid:
    """Return ``grid`` with few enough cells to be solved quickly, if so few show the surface."""
    most = LINE if grid.cells[1] == 1 else PLANE
    counts = [float(count) for count in grid.cells]
    # both axes alike, and what one of them cannot give the other does
    for axis, power in ((0, 0.5 if grid.cells[1] > 1 else 1.0), (1, 1.0), (0, 1.0)):
        too_many = max(prod(counts) / most, 1.0)
        counts[axis] = max(counts[axis] / too_many**power, min(fewest[axis], counts[axis]))
    shrink = sqrt(max(prod(counts) / MOST, 1.0))
    across, along = (
        max(ceil(count / shrink), min(2, own))
        for count, own in zip(counts, grid.cells, strict=True)
    )
    return Grid((max(across, min(FEWEST, grid.cells[0])), along), grid.extent)


def _contact_width(solution: Solution) -> float:
    """Width about the axis within which all cells in contact lie [m]."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell[0]


def expected(scene: Scene, needs: Needs, grid: Grid) -> GridForecast:
    """Return what to expect of ``grid``: by the law of a smooth contact, else by small solutions."""
    padding = needs.padding()
    if needs.smooth and scene.hardness > needs.hertz.peak_pressure:
        seconds = CostModel().seconds(grid, padding, SMOOTH_CONVOLUTIONS)
        width = 2 * needs.hertz.half_width
        return GridForecast(
            grid,
            (needs.error(grid.cell), 0.0),
            (RATE, RATE),
            (COARSEST, 1),
            grid.extent[0] < width,
            "",
            seconds,
        )
    fewest = _fewest(needs, grid)
    try:
        seen = forecast(scene, needs, grid)
    except InvalidInput as error:  # such as a period that is no whole number of a shape's
        rates = RATE, RATE
        return GridForecast(
            grid, (inf, 0.0), rates, fewest, cut_off=False, message=str(error), seconds=inf
        )
    if seen.error == inf and not seen.cut_off:
        across, along = needs.errors(grid.cell)
        return replace(seen, errors=(TRUSTED * across, TRUSTED * along), rates=(RATE, RATE))
    return seen


def reaching(
    scene: Scene, needs: Needs, error: float, period: float | None, limit: float
) -> GridForecast:
    """Return what to expect of the cheapest grid that keeps to ``error``, or comes as near as ``limit`` bytes allow.

    ``period`` [m] is chosen if none is given.
    """
    grid = needs.grid(error, period)
    padding, target = needs.padding(), ALMOST * error
    best = None
    for _ in range(ROUNDS):
        seen = expected(scene, needs, affordable(grid, padding, limit))
        width = seen.grid.extent[0]
        if seen.cut_off:
            best = seen
            if width >= needs.widest:
                break
            grid = _as_wide(seen.grid, min(WIDER * width, needs.widest))
            continue
        if best is None or best.cut_off or _better(seen, best, error):
            best = seen
        if seen.error == inf:
            break
        if needs.roller and ROOM * WASTE * seen.contact_width < width:
            grid = _as_wide(seen.grid, ROOM * seen.contact_width)
            seen = replace(seen, grid=grid, contact_width=inf)
            best = None
        grid = _fitting(seen, target, padding, limit)
        more = prod(grid.cells) / prod(seen.grid.cells)
        stays = grid == seen.grid or (seen.error <= error and more >= 1 / WASTE)
        if best is not None and stays:
            break
    assert best is not None
    return best


def _better(one: GridForecast, other: GridForecast, error: float) -> bool:
    """Whether ``one`` keeps to ``error`` with fewer cells than ``other``, or is more accurate where neither does."""
    if (one.error <= error) != (other.error <= error):
        return one.error <= error
    if one.error <= error:
        return prod(one.grid.cells) < prod(other.grid.cells)
    return one.error < other.error


def _as_wide(grid: Grid, width: float) -> Grid:
    """Return a grid of cells of the same size over another width [m]."""
    across = halvable(grid.cells[0] * width / grid.extent[0])
    return Grid((across, grid.cells[1]), (width, grid.period))


def _fitting(seen: GridForecast, error: float, padding: Padding | Paddings, limit: float) -> Grid:
    """Return the grid for ``error``, or for the least error of which a solve holds within ``limit`` bytes."""
    grid = seen.grid_for(error)
    while memory(grid, padding) > limit and error < 1:
        error *= WASTE
        grid = seen.grid_for(error)
    return affordable(grid, padding, limit)


def affordable(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """Return ``grid``, or the finest of its extent and elongation that a solve holds in so many bytes."""
    needed = memory(grid, padding)
    while needed > bytes_at_most:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid


@dataclass(frozen=True)
class Plan:
    """A ``grid`` and a ``padding`` for ``scene.problem(plan.grid, plan.padding)``, and what to expect of them.

    ``dimension`` is 1 if nothing varies along the length, else 2. ``error`` is the relative L1 error of the pressure to
    expect: of a smooth contact by a law, else as small solutions on coarse grids show it. ``seconds`` are those of a
    solve ``on`` that device, from what ran just now, and ``bytes`` those that it holds at the most. ``period_check``
    says how the period suits the scene, ``reasons`` a sentence for each choice, and ``warnings`` what is wrong with a
    grid that was given, or why the error asked for is out of reach and which one is not. ``steps`` are the solves of a
    scene that changes in time or rolls.
    """

    grid: Grid
    padding: Padding | Paddings
    dimension: int
    error: float
    seconds: float
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    steps: int = 1
    on: Device = ONE_THREAD


def plan(
    scene: Scene,
    *,
    error: float | None = None,
    period: float | None = None,
    grid: Grid | None = None,
    end: float | None = None,
    on: Device = ONE_THREAD,
) -> Plan:
    """Choose a grid and a padding that solve a scene to a relative L1 error of the pressure.

    Takes small solutions of up to some ten thousand cells, unless the contact is smooth.

    Parameters
    ----------
    scene
        The scene, which may change in time or roll.
    error
        Relative L1 error of the pressure, above 0. If it is None, a measured surface is solved at its own points, and
        any other scene to 1e-3.
    period
        Length of the grid [m]; chosen if None.
    grid
        Grid to keep. The plan then says what is wrong with it.
    end
        Time [s] up to which a scene is followed whose load has no end of its own.
    on
        Device that the seconds are for. A scene that changes in time is solved on one thread.

    Raises
    ------
    InvalidInput
        If the scene leaves open what a plan needs: without a curved shape there is no width of contact, without a
        roller's length no grid.
    """
    checked(on, "plan.on")
    if error is not None:
        error = positive("plan.error", error, "give a relative error above 0, such as 1e-3")
    if scene.changing is not None or scene.rolling is not None:
        return _plan_in_time(scene, error or DEFAULT_ERROR, period, grid, end)
    needs = needs_of(scene)
    if scene.lubrication is not None:
        return _plan_of_film(scene, needs, error or FILM_ERROR, period, grid)
    padding = needs.padding()
    if grid is not None and period is not None and period != grid.period:
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    limit = SHARE * min(available_bytes(), on.available_bytes)
    own_points = grid is None and error is None and needs.points is not None
    if own_points:
        grid = needs.grid_of_points(period)
    if grid is None:
        asked = error or DEFAULT_ERROR
        seen = reaching(scene, needs, asked, period, limit)
        grid = seen.grid
    else:
        asked = inf
        seen = expected(scene, needs, affordable(grid, padding, limit))
    reached = seen.error_of(grid.cell)
    return Plan(
        grid=grid,
        padding=padding,
        dimension=1 if grid.cells[1] == 1 else 2,
        error=reached,
        seconds=seen.seconds / times_faster(grid, padding, on),
        bytes=memory(grid, padding),
        period_check=needs.period_check(grid.period),
        reasons=(*needs.reasons(grid, reached), *_reasons(seen, own_points=own_points)),
        warnings=(*needs.warnings(grid), *_warnings(needs, seen, grid, limit, error=asked)),
        on=on,
    )


def _reasons(seen: GridForecast, *, own_points: bool) -> Iterator[str]:
    """Why there are so many cells along each axis, a sentence each."""
    if own_points:
        yield (
            "points: the measured surface is solved on its own points; give an error for cells that resolve what is "
            "interpolated between them."
        )
    across, along = seen.errors
    if seen.grid.cells[1] > 1 and 0 < seen.error < inf:
        yield (
            f"axes: of the error expected, {across / seen.error:.0%} falls with the cells across to the power "
            f"{seen.rates[0]:.2g}, {along / seen.error:.0%} with those along to the power {seen.rates[1]:.2g}."
        )


def _plan_in_time(
    scene: Scene, error: float, period: float | None, grid: Grid | None, end: float | None
) -> Plan:
    """Plan a scene that changes in time: wide enough for its widest contact, fine enough for its narrowest."""
    # here, for those whose scene changes in time
    from contactstudy.planning.in_time import extremes as extremes_of

    extremes = extremes_of(scene, error, end)
    plastic = extremes.plastic
    coarser = plastic.cells_error if plastic else 1.0
    cells = error / coarser
    if grid is not None:
        found = plan(extremes.narrow, error=cells, period=period, grid=grid)
    else:
        narrow = plan(extremes.narrow, error=cells, period=period)
        width = max(narrow.grid.extent[0], extremes.width)
        found = plan(extremes.narrow, error=cells, grid=_as_wide(narrow.grid, width))
    # a warm start takes no coarser grids and fewer iterations
    found = replace(
        found,
        seconds=found.seconds * extremes.steps,
        bytes=found.bytes + 8 * extremes.fields * prod(found.grid.cells),
        reasons=(*found.reasons, *extremes.reasons),
        warnings=(*found.warnings, *extremes.warnings),
        steps=extremes.steps,
    )
    if plastic is None:
        return found
    return replace(
        found,
        error=found.error * coarser,
        seconds=found.seconds * plastic.contacts(found.grid),
        bytes=found.bytes + plastic.bytes(found.grid),
        reasons=(*found.reasons, plastic.reason(found.grid)),
    )


def _warnings(
    needs: Needs, seen: GridForecast, grid: Grid, limit: float, *, error: float
) -> Iterator[str]:
    """What stands between the grid and the ``error`` asked for, a sentence each."""
    if seen.cut_off:
        remedy = "give a width of "
        width = WIDER * grid.extent[0]
        if width > needs.widest:
            remedy = (
                f"the surface is known over {needs.widest:.4g} m only; give a smaller load, or "
            )
            remedy += "a surface as wide as "
        yield f"Grid.extent[0] is {grid.extent[0]:.4g} m: the contact outgrows it, {remedy}{width:.4g} m."
    needed = memory(grid, needs.padding())
    if needed > limit:
        yield (
            f"Grid.cells is {grid.cells}: a solve needs {needed / 1e9:.3g} GB, and this machine has "
            f"{limit / SHARE / 1e9:.3g} GB, give fewer cells."
        )
    reached = seen.error_of(grid.cell)
    if error < reached < inf:
        better = seen.grid_for(error)
        bytes_of_better = memory(better, needs.padding())
        why = (
            f"that takes {better.cells[0]} x {better.cells[1]} cells and {bytes_of_better / 1e9:.3g} GB, and this "
            f"machine has {limit / SHARE / 1e9:.3g} GB"
            if bytes_of_better > limit
            else "the error of this surface falls slowly"
        )
        yield f"plan.error is {error:.2g}: this grid reaches {reached:.2g}; {why}."
    if seen.message:
        yield seen.message


def _plan_of_film(
    scene: Scene, needs: Needs, error: float, period: float | None, grid: Grid | None
) -> Plan:
    from contactstudy.planning.film_needs import film_needs  # a dry scene imports nothing of films

    film = film_needs(scene, needs, error, period, grid)
    smooth = film.grid.cells[1] == 1
    return Plan(
        grid=film.grid,
        padding=ExactPeriodicity(),
        dimension=1 if smooth else 2,
        error=error if smooth and grid is None else inf,
        seconds=film.seconds,
        bytes=film.bytes,
        period_check=needs.period_check(film.grid.period),
        reasons=film.reasons,
        warnings=film.warnings,
    )


def needs_of(scene: Scene) -> Needs:
    """What ``scene`` asks of a grid; :class:`~contactstudy.InvalidInput` as for :func:`plan`."""
    if scene.hertz is None:
        raise NotDefined(
            "Scene.shapes have no curvature, so that the contact has no width of its own: "
            "give a Cylinder, or choose the grid yourself."
        )
    for number, shape in enumerate(scene.shapes):
        if not hasattr(shape, "detail"):
            raise InvalidInput(
                f"Scene.shapes[{number}] is {shape!r}, which does not say how fine it is: give it a "
                "`detail`, or choose the grid yourself."
            )
    details = tuple(shape.detail for shape in scene.shapes if hasattr(shape, "detail"))
    coats = tuple(solid for solid in scene.solids if isinstance(solid, Layered))
    needs = Needs(scene.hertz, details, scene.hardness, coats)
    if scene.friction is None:
        return needs
    said = scene.friction.said(
        scene, varies=needs.varies, paddings=across_and_along(needs.padding())
    )
    return replace(needs, shear=said)
