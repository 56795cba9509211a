"""Small solutions of a scene, which show the error, the width and the time of a larger one."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import ceil, inf, log2, prod

import numpy as np

from contactstudy.accuracy.estimate import SHARP_EDGE, ErrorEstimate, error_estimate
from contactstudy.domain.checks import InvalidInput, NotDefined, positive
from contactstudy.domain.device import ONE_THREAD, Device, checked
from contactstudy.domain.grid import Grid
from contactstudy.domain.memory import available_bytes
from contactstudy.domain.padding import Padding, Paddings, across_and_along
from contactstudy.planning.cost import (
    SMOOTH_CONVOLUTIONS,
    CostModel,
    Timing,
    convolutions_to,
    memory,
    timed,
    times_faster,
)
from contactstudy.planning.grid_requirements import RATE, Needs, halvable
from contactstudy.scene.bodies import Layered
from contactstudy.scene.scene import Scene
from contactstudy.solvers.solution import Solution, Status

# Cells of a pilot at most, in one and in two dimensions, and the digits that it needs.
LINE, PLANE, TOLERANCE, DEFAULT = 2**13, 2**16, 1e-5, 1e-8
# Powers of the cell with which an error falls: a step's, and a smooth contact's.
SLOWEST, FASTEST = 0.5, 1.5
# A bound over the error that it stands for: less than in all but a few cases of the accuracy matrix.
BOUND = 1.5
# Cells less than these show nothing.
FEWEST = 8


@dataclass(frozen=True)
class Forecast:
    """What pilots say of a solve on ``grid``.

    ``error`` is the relative L1 error to expect there, infinite where the pilots do not show the
    surface; it falls with the cell to the power ``rate``. ``cut_off`` says that the contact outgrows the grid;
    ``said`` is a sentence about what no grid mends, such as an infinite pressure, or
    empty; ``seconds`` of set-up and solve.
    """

    grid: Grid
    error: float
    rate: float
    cut_off: bool
    said: str
    seconds: float

    def error_of(self, cell: tuple[float, float]) -> float:
        """The error to expect of another ``cell`` (dx, dy) [m]."""
        steps = (size / own for size, own in zip(cell, self.grid.cell, strict=True))
        larger = max(steps) if self.grid.cells[1] > 1 else cell[0] / self.grid.cell[0]
        return float(self.error * larger**self.rate)

    def grid_for(self, error: float) -> Grid:
        """The coarsest grid of the same extent and elongation that keeps to ``error``."""
        return finer(self.grid, (self.error / error) ** (1 / self.rate))


def forecast(scene: Scene, grid: Grid, padding: Padding | Paddings) -> Forecast:
    """Solve ``scene`` on two coarse grids of the extent of ``grid``, and extrapolate to ``grid``."""
    most = LINE if grid.cells[1] == 1 else PLANE
    halvings = 0
    while prod(_coarsened(grid, halvings).cells) > most:
        halvings += 1
    fine, estimate, timing = _pilot(scene, _coarsened(grid, halvings), padding)
    timings = [timing]
    cut_off = fine.status is Status.CONTACT_AT_EDGE
    sharp = next((said for said in estimate.warnings if SHARP_EDGE in said), "")
    error, rate = estimate.l1.discretisation / BOUND, 1.0
    if halvings and error < inf:
        _, coarser, timing = _pilot(scene, _coarsened(grid, halvings + 1), padding)
        before = coarser.l1.discretisation / BOUND
        if before < inf:
            rate = float(np.clip(log2(before / error), SLOWEST, FASTEST))
        error *= 2 ** (-rate * halvings)
        timings.append(timing)
    convolutions = convolutions_to(
        DEFAULT, max(one.convolutions for one in timings)
    ) / convolutions_to(TOLERANCE, 1.0)
    seconds = CostModel(timings).seconds(grid, padding, convolutions)
    return Forecast(grid, error, rate, cut_off, sharp, seconds)


def _pilot(
    scene: Scene, grid: Grid, padding: Padding | Paddings
) -> tuple[Solution, ErrorEstimate, Timing]:
    solution, timing = timed(lambda small: scene.problem(small, padding), grid, TOLERANCE)
    return solution, error_estimate(solution), timing


def _coarsened(grid: Grid, halvings: int) -> Grid:
    across, along = (ceil(count / 2**halvings) for count in grid.cells)
    least = FEWEST if grid.cells[1] > 1 else 1
    return Grid((max(across, FEWEST), max(along, min(least, grid.cells[1]))), grid.extent)


def finer(grid: Grid, times: float) -> Grid:
    """``grid`` with so many ``times`` as many cells along each axis, or a few more that halve often."""
    across, along = grid.cells
    return Grid(
        (halvable(across * times), halvable(along * times) if along > 1 else 1), grid.extent
    )


def affordable(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """``grid``, or the finest of its extent that a solve holds in so many bytes."""
    needed = memory(grid, padding)
    while needed > bytes_at_most:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid


# Pilots show a grid that is too narrow or too coarse; each round mends it, the width by so much.
ROUNDS, WIDER = 6, 1.5
# A grid this many times more accurate than asked for is made coarser.
WASTE = 3.0
# Of the error asked for, what the cells may take; the rest is the solver's.
ALMOST = 0.95
# Where pilots do not show the surface, the law of rough contacts, a mean over surfaces, counts so often.
TRUSTED = 2.0
# Of the machine's memory, what a plan may take.
SHARE = 0.8


@dataclass(frozen=True)
class Plan:
    """A ``grid`` and a ``padding`` for ``scene.problem(plan.grid, plan.padding)``, and what to expect of them.

    ``dimension`` is 1 where nothing varies along the length, else 2. ``error`` is the relative L1 error of
    the pressure to expect: of a smooth contact by a law, else as small solutions on two coarse grids show it.
    ``seconds`` of a solve ``on`` that device, from what ran just now, within a factor of some two;
    ``bytes`` at the most. ``period_check`` says how the period suits the scene,
    ``reasons`` a sentence for each choice, and ``warnings`` what is wrong with a grid that was given, or why
    the error asked for is out of reach and which one is not. ``steps`` are the solves of a scene that changes in
    time or rolls.
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
    error: float = 1e-3,
    period: float | None = None,
    grid: Grid | None = None,
    on: Device = ONE_THREAD,
) -> Plan:
    """A grid and a padding that solve ``scene`` to a relative L1 ``error`` of the pressure.

    Takes small solutions of up to some ten thousand cells, unless the contact is smooth.
    ``period`` [m] is chosen where none is given. With a ``grid``, that one is kept, and the plan says
    what is wrong with it. ``on`` is the device that ``seconds`` are for; a scene that changes in time is
    solved on one thread. Raises :class:`~contactstudy.InvalidInput` where a scene leaves open what a
    plan needs: without a curved shape there is no width of contact, without a roller's length no grid.
    """
    checked(on, "plan.on")
    error = positive("plan.error", error, "give a relative error above 0, such as 1e-3")
    if scene.changing is not None or scene.rolling is not None:
        return _plan_in_time(scene, error=error, period=period, grid=grid)
    needs = needs_of(scene)
    padding = needs.padding()
    if grid is not None and period is not None and period != grid.period:
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    given, limit = grid is not None, SHARE * min(available_bytes(), on.available_bytes)
    if grid is None:
        seen = reaching(scene, needs, error, period, limit)
        grid = seen.grid
    else:
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
        reasons=needs.reasons(grid, reached),
        warnings=(
            *needs.warnings(grid),
            *_warnings(needs, seen, grid, limit, error=inf if given else error),
        ),
        on=on,
    )


def _plan_in_time(scene: Scene, *, error: float, period: float | None, grid: Grid | None) -> Plan:
    """Of a scene that changes in time: wide enough for its widest contact, fine enough for its narrowest."""
    # here, for those whose scene changes in time
    from contactstudy.planning.in_time import extremes as extremes_of

    extremes = extremes_of(scene, error)
    plastic = extremes.plastic
    coarser = plastic.cells_error if plastic else 1.0
    cells = error / coarser
    if grid is not None:
        found = plan(extremes.narrow, error=cells, period=period, grid=grid)
    else:
        narrow = plan(extremes.narrow, error=cells, period=period)
        width = max(narrow.grid.extent[0], extremes.width)
        across = halvable(narrow.grid.cells[0] * width / narrow.grid.extent[0])
        wide = Grid((across, narrow.grid.cells[1]), (width, narrow.grid.period))
        found = plan(extremes.narrow, error=cells, grid=wide)
    # a warm start takes no coarser grids and fewer iterations
    found = replace(
        found,
        seconds=found.seconds * extremes.steps,
        bytes=found.bytes + 8 * extremes.fields * prod(found.grid.cells),
        reasons=(*found.reasons, *extremes.reasons),
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


def expected(scene: Scene, needs: Needs, grid: Grid) -> Forecast:
    """What to expect of ``grid``: by the law of a smooth contact, else by pilots."""
    padding = needs.padding()
    if needs.smooth and scene.hardness > needs.hertz.peak_pressure:
        seconds = CostModel().seconds(grid, padding, SMOOTH_CONVOLUTIONS)
        narrow = grid.extent[0] < 2 * needs.hertz.half_width
        return Forecast(
            grid, needs.error(grid.cell), RATE, cut_off=narrow, said="", seconds=seconds
        )
    try:
        seen = forecast(scene, grid, padding)
    except InvalidInput as error:  # such as a period that is no whole number of a shape's
        return Forecast(grid, inf, RATE, cut_off=False, said=str(error), seconds=inf)
    if seen.error == inf and not seen.cut_off:
        return replace(seen, error=TRUSTED * needs.error(grid.cell), rate=RATE)
    return seen


def reaching(
    scene: Scene, needs: Needs, error: float, period: float | None, limit: float
) -> Forecast:
    """What to expect of a grid that keeps to ``error``, or comes as near as ``limit`` bytes and the surface let it.

    ``period`` [m] is chosen where none is given.
    """
    grid = needs.grid(error, period)
    padding, refined = needs.padding(), False
    for _ in range(ROUNDS):
        within = affordable(grid, padding, limit)
        seen = expected(scene, needs, within)
        if seen.cut_off and grid.extent[0] < needs.widest:
            width = min(WIDER * grid.extent[0], needs.widest)
            across = halvable(grid.cells[0] * width / grid.extent[0])
            grid = Grid((across, grid.cells[1]), (width, grid.period))
        elif seen.cut_off or error / WASTE <= seen.error <= ALMOST * error:
            break
        elif seen.error <= ALMOST * error:
            # the first guess was too careful
            most = min(
                wave / cell / 2 for wave, cell in zip(needs.finest, within.cell, strict=True)
            )
            fewer = finer(within, max((seen.error / error) ** (1 / seen.rate), 1 / most))
            if refined or fewer.cells[0] >= within.cells[0]:
                break
            grid = fewer
        elif within != grid:
            break
        else:
            grid, refined = seen.grid_for(ALMOST * error), True
    return seen


def _warnings(
    needs: Needs, seen: Forecast, grid: Grid, limit: float, *, error: float
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
    if seen.said:
        yield seen.said


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
