"""Plan of a lubricated scene: the grid that it needs, and its cost."""

from math import inf, prod

from contactstudy.domain.errors import DEFAULT_ERROR
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings, across_and_along
from contactstudy.domain.validation import readable
from contactstudy.lubrication.posed_film import check_film_padding, lubricated_scales
from contactstudy.lubrication.steady_film import MAX_CELLS, MAX_REQUESTED_CELLS, PERIOD, expected_error, film_grid
from contactstudy.planning.grid_requirements import grid_requirements
from contactstudy.planning.planned import Plan
from contactstudy.scene.scene import Scene

# Factor on the error that the most cells reach, which is then said in two digits.
ROUNDED_UP = 1.1
# Matrices (x, x) held in plane strain, and of a film that varies along its length in the Fourier stage.
LINE_MATRICES, FOURIER_MATRICES = 6, 50
# Floats held per cell, mostly the basis of the Krylov space.
FLOATS_PER_CELL = 180


def plan_of_film(
    scene: Scene,
    error: float | None,
    period: float | None,
    grid: Grid | None,
    padding: Padding | Paddings | None = None,
) -> Plan:
    """Return the plan of a lubricated scene.

    Parameters
    ----------
    scene
        The lubricated scene.
    error
        Relative error of the central and the minimum film thickness, friction, temperatures and the fraction of
        the load that asperities carry. None is DEFAULT_ERROR, on MAX_CELLS across at most, not MAX_REQUESTED_CELLS.
    period
        Length of the grid [m]; chosen if None.
    grid
        Grid to keep; chosen if None.
    padding
        Boundary conditions to keep; all images are summed if None.

    Raises
    ------
    InvalidInput
        For a padding on which a film cannot be solved.
    """
    padding = padding or ExactPeriodicity()
    requirements, scales = grid_requirements(scene, padding), lubricated_scales(scene)
    warnings = []
    most_cells = MAX_CELLS if error is None else MAX_REQUESTED_CELLS
    error = error or DEFAULT_ERROR
    if grid is not None:
        warnings.append("The grid is given, so its error is not predicted: solve, and read answer.error.")
    else:
        if not requirements.varies and period is None:
            period = PERIOD
        inlet_width = film_grid(scene, error, requirements.extent(period)[1]).extent[0]
        width = requirements.width(inlet_width)
        grid = film_grid(
            scene,
            error,
            requirements.length(period, width),
            shortest_wavelengths=requirements.shortest_wavelengths,
            longer=width / inlet_width,
            most_cells=most_cells,
        )
        if grid.cells[0] >= most_cells:
            warnings.append(
                f"plan.error is {error:.2g}: a film has {most_cells} cells across at most, give about "
                f"{ROUNDED_UP * expected_error(scene, grid):.2g}, which they reach."
            )
    (nx, ny), width = grid.cells, grid.extent[0]
    check_film_padding(padding, ny)
    if across_and_along(padding)[1].window is not None:
        warnings.append(
            f"padding is {padding!r}: the error of a film by the images that it leaves out is not predicted, give "
            "ExactPeriodicity()."
        )
    reasons = [
        f"the formula of Moes gives a film of {readable(scales.expected_film * scales.film)} at "
        f"M = {scales.load_parameter:.3g}, L = {scales.viscosity_parameter:.3g}",
        f"the inlet begins {width / 2 / scales.hertz.half_width:.2g} half-widths from the axis: the error of cutting it "
        "off there falls with the square of the distance",
    ]
    floats = LINE_MATRICES * nx**2
    if ny > 1:
        warnings.append(
            "The error of a film that varies along its length is not predicted: solve, and read answer.error."
        )
        floats = FLOATS_PER_CELL * prod(grid.cells) + FOURIER_MATRICES * nx**2
    is_predicted = not warnings  # each of them says why the film may not have the error requested
    return Plan(
        scene=scene,
        grid=grid,
        padding=padding,
        error=error if is_predicted else inf,
        bytes=8 * floats,
        reasons=tuple(reasons),
        warnings=tuple(warnings),
    )
