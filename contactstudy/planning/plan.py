"""Plans: the grid and padding that a scene needs, found by solutions on coarse grids, with expected error and cost."""

from dataclasses import dataclass, field, replace
from math import inf, isclose, pi, prod
from time import perf_counter
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from contactstudy.accuracy.plausibility import beyond_half_space
from contactstudy.domain.device import ONE_THREAD, Device, available_bytes, checked
from contactstudy.domain.errors import DEFAULT_ERROR, InNotebook, Request, pressure_request
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings, across_and_along
from contactstudy.domain.validation import InvalidInput, Metres, checked_errors, readable, set_fields, valid
from contactstudy.elasticity.convolution import padded_cells
from contactstudy.planning.grid_requirements import CONSTANTS as GRID
from contactstudy.planning.grid_requirements import (
    flat_grid,
    grid_requirements,
    measured_length_scales,
    period_fault,
    with_requirements,
)
from contactstudy.planning.refinement import MOST_CELLS, FirstGrids, first_grids, with_width
from contactstudy.problem.problem import Problem, solve_bytes
from contactstudy.scene import scene as methods
from contactstudy.scene.loads import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.roller import Cylinder
from contactstudy.scene.shapes.shape import LengthScales, left_out
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.solvers.solve import SolveOptions, solve_contact

if TYPE_CHECKING:
    from contactstudy.evolution.time_steps import TimeSteps
    from contactstudy.planning.transient_requirements import TransientRequirements

# Largest number of cells along an axis of the solve that is timed on a device, its tolerance, and the seconds for which
# quick solves are repeated, since the first fills caches and other processes interrupt.
LARGE_SAMPLE, TOLERANCE, MIN_TOTAL_SECONDS = 512, 1e-8, 0.02
# Extent of that solve.
SAMPLE_EXTENT = 2.4, 2.4
# Fraction of the machine's free memory that a plan may take.
MEMORY_FRACTION = 0.8


def _smooth_contact() -> Scene:
    """Return a smooth line contact of modulus 1, 3.4 half-widths of which are in the sampled extent."""
    solids = HalfSpace(1.0, 0.0), HalfSpace(inf, 0.0)
    return Scene(LineLoad(pi / 800), solids, (Cylinder(100.0),))


def speedup(grid: Grid, padding: Padding | Paddings, device: Device) -> float:
    """Measure how many times faster a solve is on `device` than on one thread; 1 for one thread.

    A smooth line contact is solved on as many cells, at most 512 along either axis.
    """
    if device == ONE_THREAD:
        return 1.0
    across, along = (min(count, LARGE_SAMPLE) for count in grid.cells)
    problem = _smooth_contact().problem(Grid((across, along), SAMPLE_EXTENT), padding)
    return _seconds(problem, ONE_THREAD) / _seconds(problem, device)


def _seconds(problem: Problem, device: Device) -> float:
    """Return the wall time [s] of a solve on a device: the least of several, after a first one that fills caches."""
    durations = list[float]()
    while len(durations) < 4 or sum(durations[1:]) < MIN_TOTAL_SECONDS:
        start = perf_counter()
        solve_contact(problem, SolveOptions(TOLERANCE), device=device)
        durations.append(perf_counter() - start)
    return min(durations[1:])


def memory(grid: Grid, padding: Padding | Paddings) -> int:
    """Return the bytes that a solve holds at most."""
    return solve_bytes(grid, prod(padded_cells(grid, across_and_along(padding))))


def within_memory(grid: Grid, padding: Padding | Paddings, bytes_at_most: float) -> Grid:
    """Return `grid`, or the finest of the same extent and aspect ratio whose solve holds within `bytes_at_most`."""
    needed = memory(grid, padding)
    while needed > bytes_at_most and max(grid.cells) > 2:
        shrink = (bytes_at_most / needed) ** (1 if grid.cells[1] == 1 else 0.5) * 0.99
        across, along = (max(2, int(count * shrink)) for count in grid.cells)
        grid = Grid((across, along if grid.cells[1] > 1 else 1), grid.extent)
        needed = memory(grid, padding)
    return grid


@dataclass(frozen=True, kw_only=True)
class Plan(InNotebook):
    """A grid and a padding for a scene, with expected error and cost.

    Solve it with ``solve(plan.scene, plan.grid, plan.padding)``.

    Attributes
    ----------
    scene
        The scene. Its random surfaces have an extent: where the contact is narrower than they are, the grid is too.
    grid
        The grid on which a solve to the error is expected to end; a reason may name that on which it begins.
    padding
        The boundary conditions.
    dimension
        Dimension of the surface grid: 1 in plane strain, where nothing varies along the length; 2 of a contact in three
        dimensions.
    error
        Bound of the relative L1 error of the pressure to expect, with all its causes but the steps in time, from
        solutions on coarse grids. Of a film, the error requested. Infinite where they give none.
    seconds
        Seconds of processor time (with a device, of wall time) of a solve to the error: its plan, all grids and steps,
        their estimates, and the stress that a steady scene names, from solves on coarser grids just now. Imports,
        compilation, tables of a material, files and plots are not counted. Infinite where no coarser grid can be solved.
    bytes
        Bytes that a solve holds at most.
    period_check
        A sentence on how the period suits the scene.
    reasons
        A sentence for each choice.
    warnings
        A sentence for each fault of a grid that was given, and on a requested error that is out of reach.
    solves
        Number of contacts or films that are solved one after the other, where a scene changes in time or
        rolls.
    device
        Device that the seconds are for.
    first_grids
        Solutions of a static contact on the grids with which its solve begins; None of others, or on a given grid.
    """

    scene: Scene = field(repr=False)
    grid: Grid
    padding: Padding | Paddings
    dimension: int = field(init=False)
    error: float = inf
    seconds: float = inf
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    solves: int = 1
    device: Device = ONE_THREAD
    first_grids: "FirstGrids | None" = field(default=None, repr=False)

    def __post_init__(self) -> None:
        set_fields(self, dimension=1 if self.grid.cells[1] == 1 else 2)


def plan_grid(
    scene: Scene,
    *,
    error: Request | str | None = None,
    period: float | None = None,
    grid: Grid | None = None,
    padding: Padding | Paddings | None = None,
    times: "ArrayLike | TimeSteps | None" = None,
    device: Device = ONE_THREAD,
) -> Plan:
    """Return the plan as :func:`~contactstudy.plan` does, for the same arguments, without a forecast.

    Its error and seconds are infinite. A dry scene without a grid is solved on coarse grids, to find the cells.
    """
    checked(device, "plan.device")
    valid("plan.scene", scene, Scene)
    valid("grid", grid, Grid | None)
    if error is not None:
        error = pressure_request(checked_errors("plan.error", error))
    if grid is not None and period is not None and not isclose(period, grid.length):
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    if times is not None and not scene.method.takes_times:
        raise InvalidInput(
            "plan.times is given, and nothing of the scene changes in time: leave it out, in a file [time_steps]."
        )
    if scene.lubrication is not None:
        # imported only for lubricated scenes
        from contactstudy.planning.film_plan import plan_of_film

        return plan_of_film(scene, error, period, grid, padding)
    transient: TransientRequirements | None = None
    is_followed = scene.adhesion is None or scene.method is methods.TIME_DEPENDENT
    if scene.method is not methods.STATIC and is_followed:
        # imported only for scenes that change in time or roll
        from contactstudy.evolution.time_steps import TimeSteps
        from contactstudy.planning.transient_requirements import transient_requirements

        transient = transient_requirements(scene, TimeSteps.of(times).last)
    scales = measured_length_scales(scene)
    if scales is None and grid is not None and scene.adhesion is None:
        scales = LengthScales()  # a flat on the grid that is given
    if scene.hertz is None and scales is not None:
        planned = _plan_of_flat(scene, scales, error, period, grid, padding, device)
        if transient is not None:  # the cells are the points of the surface under any load
            transient = replace(transient, warnings=())
    elif scene.adhesion is not None:
        # imported only for scenes with adhesion
        from contactstudy.planning.transient_requirements import plan_of_adhesion

        planned = plan_of_adhesion(scene, error or DEFAULT_ERROR, period, grid, padding, transient)
    elif transient is None:
        planned = _plan_static(scene, error, period, grid, padding, device)
    else:
        error = (1.0 if scene.rolls else GRID.cell_fraction) * (error or DEFAULT_ERROR)
        width, length = transient.width, period or transient.length or None
        planned = _plan_static(transient.narrow, error, length, grid, padding, ONE_THREAD, width)
        planned = replace(planned, scene=scene, first_grids=None)
    return planned if transient is None else _with_states(planned, transient)


def _plan_of_flat(
    scene: Scene,
    scales: LengthScales,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None,
    device: Device,
) -> Plan:
    """Plan a flat with a measured surface: its points are the cells and both axes periodic, if no others are given."""
    if period is not None:
        period = valid("plan.period", period, Metres)
    warnings = []
    if error is not None:
        warnings.append(
            f"plan.error is {error:.2g}: no shape is curved, so that the error is not predicted, solve, and read "
            "answer.error."
        )
    grid = grid or flat_grid(scales, period)
    padding = padding or (ExactPeriodicity(), ExactPeriodicity())
    if fault := period_fault(grid.length, (scales,)):
        warnings.append(fault)
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        bytes=memory(grid, padding),
        period_check=fault or f"The surface repeats over the length {readable(grid.length)}.",
        reasons=(f"points: those of the surface, which is not curved, or of a given grid, with padding {padding!r}.",),
        warnings=tuple(warnings),
        device=device,
    )


def _plan_static(
    scene: Scene,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None,
    device: Device,
    width: float = 0.0,
) -> Plan:
    """Plan a scene that neither changes in time nor rolls, on a grid of at least this `width` [m]."""
    if grid is None:
        scene, requirements = with_requirements(scene, padding, period)
    else:
        requirements = grid_requirements(scene, padding)
    padding = requirements.padding()
    limit = MEMORY_FRACTION * min(available_bytes(), device.available_bytes)
    may_take = f"{MEMORY_FRACTION:.0%} of the {limit / MEMORY_FRACTION / 1e9:.3g} GB that are free"
    reasons: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    first: FirstGrids | None = None
    if grid is None and error is None and requirements.point_spacing is not None:
        grid = requirements.grid_on_measured_points(period)
        reasons = (
            "points: the measured surface is solved on its own points; give an error for cells that resolve what is "
            "interpolated between them.",
        )
    if grid is None:
        error = error or DEFAULT_ERROR
        first = first_grids(scene, requirements, error, period)
        grid = within_memory(first.grid, padding, limit)
        if prod(grid.cells) < 0.99 * first.required < inf:
            gigabytes = memory(grid, padding) * first.required / prod(grid.cells) / 1e9
            warnings = (
                f"plan.error is {error:.2g}, which takes about {first.required:.2g} cells and {gigabytes:.3g} GB, and "
                f"{MOST_CELLS:,} and {may_take} are taken at most: give a larger error, and see whether the radii and "
                "the wavelengths are those that are meant.",
            )
        if width > grid.extent[0]:
            grid = with_width(grid, requirements.width(width))
    of_grid = requirements.warnings(grid)
    if first is not None and first.levels[-1].discretisation_error < inf and not warnings:
        # its bound counts the waves between cells
        of_grid = tuple(filter(None, (requirements.period_fault(grid.length),)))
    needed = memory(grid, padding)
    if needed > limit:
        warnings = (
            f"Grid.cells is {grid.cells}: a solve needs {needed / 1e9:.3g} GB, and a plan takes {may_take}, give fewer "
            "cells.",
        )
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        first_grids=first,
        bytes=needed,
        period_check=requirements.period_check(grid.length),
        reasons=(*requirements.reasons(grid), *reasons),
        warnings=(*of_grid, *filter(None, (beyond_half_space(scene),)), *left_out(scene.shapes, grid), *warnings),
        device=device,
    )


def _with_states(planned: Plan, transient: "TransientRequirements") -> Plan:
    """Return a plan with the bytes of what a contact keeps in time, and what is said of it."""
    grid, plastic = planned.grid, transient.plastic
    bytes_of_states = 8 * transient.fields * prod(grid.cells)
    warnings = (*planned.warnings, *transient.warnings)
    if plastic is not None:
        bytes_of_states += plastic.bytes(grid)
    for axis, least in enumerate((transient.least_width, transient.length)):
        if least > grid.extent[axis] * (1 + 1e-9):
            warnings = (
                *warnings,
                f"Grid.extent[{axis}] is {readable(grid.extent[axis])}: the contact, as it grows or rolls, or its "
                f"plastic zone may need {readable(least)}, give a grid or a measured surface of that size.",
            )
    return replace(planned, bytes=planned.bytes + bytes_of_states, warnings=warnings)
