"""Plans without a forecast: the grid and padding that a scene needs, and the bytes of its solve.

Each kind of scene has its plan: a static contact by solutions on coarse grids (`_plan_static`), a measured flat on its
own points (`_plan_of_flat`), films and adhesion in files of their own. A scene that changes in time or rolls is planned
as the static contact that needs the finest cells, on the width of the widest one. Error and seconds follow elsewhere
(``forecast.py``).
"""

from dataclasses import replace
from math import inf, isclose, prod
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from contactstudy.accuracy.plausibility import beyond_half_space
from contactstudy.domain.device import ONE_THREAD, Device, available_bytes, checked
from contactstudy.domain.errors import DEFAULT_ERROR, Request, pressure_request
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput, Metres, checked_errors, readable, valid
from contactstudy.planning.grid_requirements import (
    CELL_FRACTION,
    flat_grid,
    grid_requirements,
    measured_length_scales,
    period_fault,
    with_requirements,
)
from contactstudy.planning.planned import MEMORY_FRACTION, Plan, memory, plan_on
from contactstudy.planning.refinement import FirstGrids, first_grids, with_width
from contactstudy.scene import combinations as methods
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import LengthScales, left_out

if TYPE_CHECKING:
    from contactstudy.evolution.march import TimeSteps
    from contactstudy.planning.transient_requirements import TransientRequirements


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
    # a load history with adhesion alone changes nothing but the load, and is planned as one load
    is_followed = scene.adhesion is None or scene.method is methods.TIME_DEPENDENT
    if scene.method is not methods.STATIC and is_followed:
        # imported only for scenes that change in time or roll
        from contactstudy.evolution.march import TimeSteps
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
    else:  # one that rolls steadily has no error by steps in time
        error = (1.0 if scene.rolls else CELL_FRACTION) * (error or DEFAULT_ERROR)
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
    """Return the plan of a flat: the points of its measured surface as cells, and both axes periodic.

    The surface has the length `scales`; the length of the grid is its own, or a `period` [m]. Grid and padding are
    others if they are given. The requested `error` is not predicted, which a warning says.
    """
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
    points = f"points: those of the surface, which is not curved, or of a given grid, with padding {padding!r}."
    return plan_on(scene, grid, padding, (points,), warnings, device=device)


def _plan_static(
    scene: Scene,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None,
    device: Device,
    width: float = 0.0,
) -> Plan:
    """Return the plan of a scene that neither changes in time nor rolls, on a grid of at least this `width` [m].

    A measured surface is solved on its own points if no `error` is requested; other scenes are refined to it, the
    default error if it is None. The `period` [m], grid and padding are chosen if None.
    """
    if grid is None:
        scene, requirements = with_requirements(scene, padding, period)
    else:
        requirements = grid_requirements(scene, padding)
    padding = requirements.padding()
    reasons = list[str]()
    warnings = list[str]()
    first: FirstGrids | None = None
    if grid is None and error is None and requirements.point_spacing is not None:
        grid = requirements.grid_on_measured_points(period)
        reasons.append(
            "points: the measured surface is solved on its own points; give an error for cells that resolve what is "
            "interpolated between them."
        )
    if grid is None:
        error = error or DEFAULT_ERROR
        first = first_grids(scene, requirements, error, period)
        grid = first.grid
        if prod(grid.cells) < 0.99 * first.required < inf:
            warnings.append(
                f"plan.error is {error:.2g}, which takes about {first.required:.2g} cells, and {prod(grid.cells):,} are "
                "taken: give a larger error, and see whether the radii and the wavelengths are those that are meant."
            )
        if width > grid.extent[0]:
            grid = with_width(grid, requirements.width(width))
    # where the first grids have a bound, it counts the waves between cells
    is_bounded = first is not None and first.levels[-1].discretisation_error < inf and not warnings
    of_grid = requirements.warnings(grid) if not is_bounded else (requirements.period_fault(grid.length),)
    needed, free = memory(grid, padding), min(available_bytes(), device.available_bytes)
    if needed > MEMORY_FRACTION * free:
        warnings.append(
            f"Grid.cells is {grid.cells}: a solve needs {needed / 1e9:.3g} GB of the {free / 1e9:.3g} GB that are free, "
            "give a larger error, or a grid of fewer cells."
        )
    warnings = [*filter(None, (*of_grid, beyond_half_space(scene))), *left_out(scene.shapes, grid), *warnings]
    reasons = [*requirements.reasons(grid), *reasons]
    return plan_on(scene, grid, padding, reasons, warnings, device=device, first_grids=first)


def _with_states(planned: Plan, transient: "TransientRequirements") -> Plan:
    """Return a `planned` scene with the bytes of its states in time, and warnings of a grid too small for the contact.

    Both follow from the `transient` requirements.
    """
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
