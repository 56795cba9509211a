"""Plans: the grid and padding that a scene needs, with error and cost, found by small solutions beforehand."""

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

# Relative L1 error of the pressure that is planned where none is requested.
DEFAULT_ERROR = 1e-3
# Relative error of the film of a lubricated scene that is planned where none is requested.
FILM_ERROR = 1e-2
# Cells of a small solution at most, in one and in two dimensions, more of them where the surface is finer; and the
# tolerance that it is solved to.
LINE, PLANE, MOST, TOLERANCE = 2**13, 2**16, 2**19, 1e-5
# Powers of the cell with which an error falls: at a step in height, where it is not observed, and of a smooth contact.
SLOWEST, USUAL, FASTEST = 0.5, 1.0, 1.5
# Ratio of an error's upper estimate to the error expected: exceeded in all but a few cases of the accuracy matrix.
BOUND = 1.5
# Least cells along an axis of a small solution, and of a roller.
FEWEST, ROLLER = 8, 16
# Rounds in which small solutions correct the grid, and the factor on a width that is too narrow.
ROUNDS, WIDER = 6, 1.5
# A grid with this many times the cells that are needed is made coarser, and a width this many times that of the contact
# and its room is made narrower.
WASTE = 1.25
# Largest factor by which the cells along an axis are extrapolated at once.
FURTHEST = 16.0
# Share of the requested error for the cells; the remainder is for the solver.
ALMOST = 0.95
# The law of rough contacts, a mean over surfaces, is multiplied by this where small solutions do not show the surface.
TRUSTED = 2.0
# The share of the machine's memory that a plan may take.
SHARE = 0.8


@dataclass(frozen=True)
class GridForecast:
    """Error and cost to expect of a solve on a grid.

    Attributes
    ----------
    grid
        The grid.
    errors
        Shares (across, along) of the relative L1 error of the pressure; infinite if they are not known.
    rates
        Powers of the cell along each axis with which they fall.
    fewest
        Least cells along each axis that show the surface at all.
    cut_off
        Whether the contact outgrows the grid.
    message
        A fault that no grid corrects, such as an infinite pressure; empty without one.
    seconds
        Seconds of a solve on one thread.
    contact_width
        Width [m] about the axis that holds the contact.
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
        """Return the relative L1 error of the pressure to expect of another cell (dx, dy) [m]."""
        parts = zip(self.errors, self.rates, cell, self.grid.cell, strict=True)
        return float(
            sum(error * (size / present) ** rate for error, rate, size, present in parts if error)
        )

    def grid_for(self, error: float) -> Grid:
        """Return the grid of fewest cells and the same extent whose expected error is `error`.

        With errors ``e_x n_x^-r_x + e_y n_y^-r_y``, the product of both counts is least where ``r_x`` times the error
        across equals ``r_y`` times that along. An axis at its fewest cells leaves the remaining error to the other.
        """
        (across, along), (rate_x, rate_y) = self.errors, self.rates
        if self.grid.cells[1] == 1 or not along:
            return self._with(self._count(0, error), self.grid.cells[1])
        nx = self._count(0, error * rate_y / (rate_x + rate_y))
        ny = self._count(1, error - across * (self.grid.cells[0] / nx) ** rate_x)
        return self._with(self._count(0, error - along * (self.grid.cells[1] / ny) ** rate_y), ny)

    def _count(self, axis: int, error: float) -> float:
        """Return the cells along an axis for the share `error` of the error."""
        count, share, rate = self.grid.cells[axis], self.errors[axis], self.rates[axis]
        needed = count * (share / error) ** (1 / rate) if error > 0 else inf
        return max(min(needed, FURTHEST * count), self.fewest[axis])

    def _with(self, across: float, along: float) -> Grid:
        """Return a grid of at least these cells and the same extent."""
        ny = 1 if self.grid.cells[1] == 1 else halvable(along, self.fewest[1])
        return Grid((halvable(across, self.fewest[0]), ny), self.grid.extent)


def forecast(scene: Scene, needs: Needs, grid: Grid) -> GridForecast:
    """Return the error and the cost to expect of `grid`, extrapolated from solutions on coarser grids.

    The estimated error of the finest of them is shared between the axes in proportion to the changes of the pressure
    when the cells are halved along one axis alone, which also show the rates.

    Parameters
    ----------
    scene
        The scene.
    needs
        Its requirements.
    grid
        The grid.
    """
    padding = needs.padding()
    fewest = _fewest(needs, grid)
    small = _coarse(grid, fewest)
    # to the default tolerance, so that its time shows the cost of a solve
    fine, timing = timed(lambda grid: scene.problem(grid, padding), small, 10.0**-DIGITS)
    estimate = error_estimate(fine)
    sharp = next((warning for warning in estimate.warnings if SHARP_EDGE in warning), "")
    error = estimate.l1.discretisation / BOUND
    changes, rates = [0.0, 0.0], [USUAL, USUAL]
    for axis in range(2 if error < inf else 0):
        solutions = [fine]
        while len(solutions) < 3 and small.cells[axis] >= FEWEST * 2 ** len(solutions):
            halved = list(small.cells)
            halved[axis] = ceil(halved[axis] / 2 ** len(solutions))
            coarser = Grid((halved[0], halved[1]), small.extent)
            solutions.append(SolveOptions(TOLERANCE).solved(scene.problem(coarser, padding)))
        steps = [change(fine, coarse).l1 for fine, coarse in pairwise(solutions)]
        changes[axis] = steps[0] if steps else 0.0
        is_resolved = small.cells[axis] >= 4 * fewest[axis] or not needs.rough
        if len(steps) > 1 and min(steps) > 0 and is_resolved:
            rates[axis] = float(np.clip(log2(steps[1] / steps[0]), SLOWEST, FASTEST))
    shares = np.array(changes) / sum(changes) if sum(changes) else np.array([1.0, 0.0])
    coarse_forecast = GridForecast(
        small,
        (error, 0.0) if error == inf else (error * shares[0], error * shares[1]),
        (rates[0], rates[1]),
        fewest,
        fine.status is Status.CONTACT_AT_EDGE,
        sharp,
        CostModel((timing,)).seconds(grid, padding, timing.convolutions),
        _contact_width(fine),
    )
    parts = zip(coarse_forecast.errors, coarse_forecast.rates, grid.cell, small.cell, strict=True)
    across, along = (
        part * (size / coarse) ** rate if part else 0.0 for part, rate, size, coarse in parts
    )
    return replace(coarse_forecast, grid=grid, errors=(across, along))


def _fewest(needs: Needs, grid: Grid) -> tuple[int, int]:
    """Return the cells (across, along) below which a grid does not show the surface."""
    least = ROLLER if needs.roller else COARSEST
    across, along = (
        max(least, ceil(extent / length * (1 - 1e-9)))
        for extent, length in zip(grid.extent, needs.finest, strict=True)
    )
    return across, along if grid.cells[1] > 1 else 1


def _coarse(grid: Grid, fewest: tuple[int, int]) -> Grid:
    """Return `grid` with few enough cells to be solved quickly, if so few show the surface."""
    max_cells = LINE if grid.cells[1] == 1 else PLANE
    counts = [float(count) for count in grid.cells]
    # both axes alike; then each makes up for cells that the other cannot lose
    for axis, power in ((0, 0.5 if grid.cells[1] > 1 else 1.0), (1, 1.0), (0, 1.0)):
        excess = max(prod(counts) / max_cells, 1.0)
        counts[axis] = max(counts[axis] / excess**power, min(fewest[axis], counts[axis]))
    shrink = sqrt(max(prod(counts) / MOST, 1.0))
    across, along = (
        max(ceil(count / shrink), min(2, present))
        for count, present in zip(counts, grid.cells, strict=True)
    )
    return Grid((max(across, min(FEWEST, grid.cells[0])), along), grid.extent)


def _contact_width(solution: Solution) -> float:
    """Return the width [m] about the axis within which all cells in contact lie."""
    grid = solution.problem.grid
    touching = np.abs(grid.x[solution.pressure.any(axis=1)])
    return float(2 * touching.max(initial=0.0)) + grid.cell[0]


def expected(scene: Scene, needs: Needs, grid: Grid) -> GridForecast:
    """Return the error and the cost to expect of `grid`: by the law of a smooth contact, else by small solutions.

    Parameters
    ----------
    scene
        The scene.
    needs
        Its requirements.
    grid
        The grid.
    """
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
        result = forecast(scene, needs, grid)
    except InvalidInput as error:  # such as a period that is no whole number of a shape's
        rates = RATE, RATE
        return GridForecast(
            grid, (inf, 0.0), rates, fewest, cut_off=False, message=str(error), seconds=inf
        )
    if result.error == inf and not result.cut_off:
        across, along = needs.errors(grid.cell)
        return replace(result, errors=(TRUSTED * across, TRUSTED * along), rates=(RATE, RATE))
    return result


def reaching(
    scene: Scene, needs: Needs, error: float, period: float | None, limit: float
) -> GridForecast:
    """Return the forecast of the cheapest grid whose error is `error`, or of the nearest within the memory.

    Parameters
    ----------
    scene
        The scene.
    needs
        Its requirements.
    error
        Relative L1 error of the pressure.
    period
        Length of the grid [m]; chosen if None.
    limit
        Bytes that a solve may hold.
    """
    grid = needs.grid(error, period)
    padding, target = needs.padding(), ALMOST * error
    best = None
    for _ in range(ROUNDS):
        current = expected(scene, needs, affordable(grid, padding, limit))
        width = current.grid.extent[0]
        if current.cut_off:
            best = current
            if width >= needs.widest:
                break
            grid = _as_wide(current.grid, min(WIDER * width, needs.widest))
            continue
        if best is None or best.cut_off or _is_better(current, best, error):
            best = current
        if current.error == inf:
            break
        if needs.roller and ROOM * WASTE * current.contact_width < width:
            grid = _as_wide(current.grid, ROOM * current.contact_width)
            current = replace(current, grid=grid, contact_width=inf)
            best = None
        grid = _fitting(current, target, padding, limit)
        growth = prod(grid.cells) / prod(current.grid.cells)
        is_final = grid == current.grid or (current.error <= error and growth >= 1 / WASTE)
        if best is not None and is_final:
            break
    assert best is not None
    return best


def _is_better(candidate: GridForecast, best: GridForecast, error: float) -> bool:
    """Return whether `candidate` keeps to `error` with fewer cells than `best`, or is more accurate if neither does."""
    if (candidate.error <= error) != (best.error <= error):
        return candidate.error <= error
    if candidate.error <= error:
        return prod(candidate.grid.cells) < prod(best.grid.cells)
    return candidate.error < best.error


def _as_wide(grid: Grid, width: float) -> Grid:
    """Return a grid with cells of the same size over the width `width` [m]."""
    across = halvable(grid.cells[0] * width / grid.extent[0])
    return Grid((across, grid.cells[1]), (width, grid.period))


def _fitting(
    current: GridForecast, error: float, padding: Padding | Paddings, limit: float
) -> Grid:
    """Return the grid for `error`, or for the least error whose solve holds within `limit` bytes."""
    grid = current.grid_for(error)
    while memory(grid, padding) > limit and error < 1:
        error *= WASTE
        grid = current.grid_for(error)
    return affordable(grid, padding, limit)


def affordable(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """Return `grid`, or the finest of the same extent and elongation whose solve holds within `bytes_at_most`."""
    needed = memory(grid, padding)
    while needed > bytes_at_most:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid


@dataclass(frozen=True)
class Plan:
    """A grid and a padding for a scene, and what to expect of them.

    Solve the plan with ``scene.problem(plan.grid, plan.padding)``.

    Attributes
    ----------
    grid
        The grid.
    padding
        The boundary conditions.
    dimension
        1 if nothing varies along the length, else 2.
    error
        Relative L1 error of the pressure to expect: of a smooth contact by a law, else from small solutions.
    seconds
        Seconds of a solve, or of all steps, from solves timed just now.
    bytes
        Bytes that a solve holds at most.
    period_check
        A sentence on how the period suits the scene.
    reasons
        A sentence for each choice.
    warnings
        A sentence for each fault of a grid that was given, and on a requested error that is out of reach.
    steps
        Number of solves of a scene that changes in time or rolls.
    on
        Device that the seconds are for.
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
    if scene.lubrication is not None:
        return _plan_of_film(scene, needs_of(scene), error or FILM_ERROR, period, grid)
    if scene.changing is not None or scene.rolling is not None:
        return _plan_in_time(scene, error or DEFAULT_ERROR, period, grid, end)
    needs = needs_of(scene)
    padding = needs.padding()
    if grid is not None and period is not None and period != grid.period:
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    limit = SHARE * min(available_bytes(), on.available_bytes)
    own_points = grid is None and error is None and needs.points is not None
    if own_points:
        grid = needs.grid_of_points(period)
    if grid is None:
        requested_error = error or DEFAULT_ERROR
        grid_forecast = reaching(scene, needs, requested_error, period, limit)
        grid = grid_forecast.grid
    else:
        requested_error = inf
        grid_forecast = expected(scene, needs, affordable(grid, padding, limit))
    expected_error = grid_forecast.error_of(grid.cell)
    return Plan(
        grid=grid,
        padding=padding,
        dimension=1 if grid.cells[1] == 1 else 2,
        error=expected_error,
        seconds=grid_forecast.seconds / times_faster(grid, padding, on),
        bytes=memory(grid, padding),
        period_check=needs.period_check(grid.period),
        reasons=(
            *needs.reasons(grid, expected_error),
            *_reasons(grid_forecast, own_points=own_points),
        ),
        warnings=(
            *needs.warnings(grid),
            *_warnings(needs, grid_forecast, grid, limit, error=requested_error),
        ),
        on=on,
    )


def _reasons(expectation: GridForecast, *, own_points: bool) -> Iterator[str]:
    """Yield a sentence for each choice of cells along an axis."""
    if own_points:
        yield (
            "points: the measured surface is solved on its own points; give an error for cells that resolve what is "
            "interpolated between them."
        )
    across, along = expectation.errors
    if expectation.grid.cells[1] > 1 and 0 < expectation.error < inf:
        yield (
            f"axes: of the error expected, {across / expectation.error:.0%} falls with the cells across to the power "
            f"{expectation.rates[0]:.2g}, {along / expectation.error:.0%} with those along to the power "
            f"{expectation.rates[1]:.2g}."
        )


def _plan_in_time(
    scene: Scene, error: float, period: float | None, grid: Grid | None, end: float | None
) -> Plan:
    """Plan a scene that changes in time: wide enough for its widest contact, fine enough for its narrowest."""

    # imported only for scenes that change in time
    from contactstudy.planning.in_time import extremes as extremes_of

    extremes = extremes_of(scene, error, end)
    plastic = extremes.plastic
    error_factor = plastic.cells_error if plastic else 1.0
    cells_error = error / error_factor
    if grid is not None:
        narrow_plan = plan(extremes.narrow, error=cells_error, period=period, grid=grid)
    else:
        narrow = plan(extremes.narrow, error=cells_error, period=period)
        width = max(narrow.grid.extent[0], extremes.width)
        narrow_plan = plan(extremes.narrow, error=cells_error, grid=_as_wide(narrow.grid, width))
    # a step starts from the last one: without coarser grids, with fewer iterations
    narrow_plan = replace(
        narrow_plan,
        seconds=narrow_plan.seconds * extremes.steps,
        bytes=narrow_plan.bytes + 8 * extremes.fields * prod(narrow_plan.grid.cells),
        reasons=(*narrow_plan.reasons, *extremes.reasons),
        warnings=(*narrow_plan.warnings, *extremes.warnings),
        steps=extremes.steps,
    )
    if plastic is None:
        return narrow_plan
    return replace(
        narrow_plan,
        error=narrow_plan.error * error_factor,
        seconds=narrow_plan.seconds * plastic.contacts(narrow_plan.grid),
        bytes=narrow_plan.bytes + plastic.bytes(narrow_plan.grid),
        reasons=(*narrow_plan.reasons, plastic.reason(narrow_plan.grid)),
    )


def _warnings(
    needs: Needs, grid_forecast: GridForecast, grid: Grid, limit: float, *, error: float
) -> Iterator[str]:
    """Yield a sentence for each reason why the grid does not reach the requested `error`."""
    if grid_forecast.cut_off:
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
    expected_error = grid_forecast.error_of(grid.cell)
    if error < expected_error < inf:
        finer = grid_forecast.grid_for(error)
        bytes_of_finer = memory(finer, needs.padding())
        reason = (
            f"that takes {finer.cells[0]} x {finer.cells[1]} cells and {bytes_of_finer / 1e9:.3g} GB, and this "
            f"machine has {limit / SHARE / 1e9:.3g} GB"
            if bytes_of_finer > limit
            else "the error of this surface falls slowly"
        )
        yield f"plan.error is {error:.2g}: this grid reaches {expected_error:.2g}; {reason}."
    if grid_forecast.message:
        yield grid_forecast.message


def _plan_of_film(
    scene: Scene, needs: Needs, error: float, period: float | None, grid: Grid | None
) -> Plan:
    """Plan a lubricated scene."""
    from contactstudy.planning.film_needs import film_needs  # imported only for lubricated scenes

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
    """Return the properties of `scene` that determine its grid.

    Raises
    ------
    InvalidInput
        If a shape does not say how fine it is.
    NotDefined
        If no shape is curved, so that the contact has no width of its own.
    """
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
    shear = scene.friction.said(
        scene, varies=needs.varies, paddings=across_and_along(needs.padding())
    )
    return replace(needs, shear=shear)
