"""Grid that a lubricated scene needs, and its cost."""

from dataclasses import dataclass
from math import prod

from contactstudy.domain.grid import Grid
from contactstudy.lubrication.posed_film import lubricated_scales
from contactstudy.lubrication.solve_lubricated import PER_WAVE, film_grid
from contactstudy.planning.grid_requirements import Needs
from contactstudy.scene.scene import Scene

# Seconds of a direct step over the cube of the cells across, and steps on all nested grids; seconds a cell for a film
# that varies along its length, with a roughness of 0.3 of the film. All on one core.
DIRECT, STEPS, PER_CELL = 6e-11, 12, 5e-5
# Numbers held a cell, mostly the basis of the Krylov space, and matrices (x, x) of the Fourier stage.
FIELDS, MATRICES = 180, 50


@dataclass(frozen=True)
class FilmNeeds:
    """Grid of a film, and what a solve on it costs.

    Attributes
    ----------
    grid
        The grid.
    seconds
        Seconds of a solve on one core.
    bytes
        Bytes that a solve holds at most.
    reasons
        A sentence for each choice.
    warnings
        A sentence for each unknown error.
    """

    grid: Grid
    seconds: float
    bytes: int
    reasons: tuple[str, ...]
    warnings: tuple[str, ...]


def film_needs(
    scene: Scene, needs: Needs, error: float, period: float | None, grid: Grid | None
) -> FilmNeeds:
    """Return the grid that a lubricated scene needs, and its cost.

    Parameters
    ----------
    scene
        The lubricated scene.
    needs
        Needs of its surfaces.
    error
        Relative error of the central and the smallest film thickness.
    period
        Length of the grid [m]; chosen if None.
    grid
        Grid to keep; chosen if None.
    """
    scales = lubricated_scales(scene)
    warnings = (
        []
        if grid is None
        else ["the grid is given, so that its error is not planned: see film_error"]
    )
    if grid is None:
        width = film_grid(scene, error).extent[0]
        length = needs.length(period, width)
        grid = film_grid(scene, error, length, finest=needs.finest)
    (nx, ny), width = grid.cells, grid.extent[0]
    inlet = width / 2 / scales.hertz.half_width
    reasons = [
        f"the formula of Moes expects a film of {scales.expected_film * scales.film:.3g} m at "
        f"M = {scales.load_parameter:.3g}, L = {scales.viscosity_parameter:.3g}",
        f"the inlet begins {inlet:.2g} half-widths from the axis: its error falls as that distance^-2",
        f"cells of {grid.cell[0]:.2g} m across resolve the pressure's rise in the inlet",
    ]
    if ny == 1:
        return FilmNeeds(
            grid, STEPS * DIRECT * nx**3, 8 * 6 * nx**2, tuple(reasons), tuple(warnings)
        )
    reasons.append(f"{PER_WAVE} cells or more for the shortest wave")
    warnings.append("the error of a film between rough surfaces is not known beforehand")
    numbers = FIELDS * prod(grid.cells) + MATRICES * nx**2
    return FilmNeeds(
        grid, PER_CELL * prod(grid.cells), 8 * numbers, tuple(reasons), tuple(warnings)
    )
