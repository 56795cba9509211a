"""Film equation of a scene in Hertz units, its coarser grids, and films to start from.

Hertz units are those of :mod:`~contactstudy.lubrication.film_equation`: [a] is a length over Hertz's half-width. The
dry contact is that of the same bodies without lubricant. Across is along x, in which the surfaces move; along the
length is y, and one cell along it is plane strain.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, inf

import numpy as np

from contactstudy.domain.grid import Array, Grid, Padding, Paddings, across_and_along
from contactstudy.domain.validation import InvalidInput, NotDefined, readable
from contactstudy.elasticity.convolution import Coefficients, GeneralConvolution, by_symmetry, general_convolutions
from contactstudy.lubrication.film_equation import Deflection, Film, FilmEquation, FilmScales, Mask
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.pseudo_time import FilmIteration
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads import ConstantLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import length_scales_of
from contactstudy.scene.solids.bodies import creeps, hertz_line, instantaneous, response
from contactstudy.scene.solids.inelastic import rolling_bodies
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Distance of the outlet from the end of the dry contact, or of the half-width that carries load, over that half-width.
# Cells further downstream only cost time: where the pressure reaches the outlet, it is moved to the end of the grid.
OUTLET = 0.5
# Tolerance of the dry contact that a film starts from; with 1e-6 and 1e-2 films take as many steps.
DRY_TOLERANCE = 1e-4
# The central film is a mean to MIDDLE half-widths from the middle of the contact, if the gap there differs from a
# parabola by more than SMOOTH times the film, which is far below the error of a film on usual cells.
MIDDLE, SMOOTH = 0.5, 1e-3
# Least width of a grid over that of the pressure: room for a short inlet, whose error the answer states.
MIN_WIDTH = 1.2
# A gap that varies along the length by more than CROWNED [a^2 / R] is that of a crowned roller. Across, the gap of a
# cylinder rises by as much from its axis to the edge of Hertz's contact. From the start of a cylinder, the film of a
# crowned roller took nine times as long.
CROWNED = 0.5
# The end of a roller is sharp where the gap varies along the length by more than SHARP_END [a^2 / R], or the fraction
# CLIFF of the roller's length: no profile is as deep.
SHARP_END, CLIFF = 300.0, 0.5
# Least cells of the coarsest grid: across in plane strain, else across and along. With twice COARSEST smooth films took
# 1.5 times the steps; half and twice the others change the time of rough films by less than a fifth. The number of
# cells across is a multiple of ROW_MULTIPLE, so that it can be halved three times.
COARSEST, COARSEST_ROUGH, COARSEST_ALONG, ROW_MULTIPLE = 200, 48, 16, 8


def lubricated_scales(scene: Scene, mean_speed: float | None = None) -> FilmScales:
    """Return Hertz's units and Moes' parameters of a lubricated ``scene`` at its largest load and at a mean speed [m/s].

    The ``mean_speed`` is the largest of the scene if None; bodies that creep always have the modulus at the largest.

    Raises :class:`~contactstudy.NotDefined` for a scene without curvature.
    """
    assert scene.lubrication is not None
    if scene.hertz is None:
        raise NotDefined("Scene.shapes have no curvature, so that no inlet draws lubricant in: give a Cylinder.")
    hertz = scene.hertz
    if any(map(creeps, scene.solids)):
        bodies = rolling_bodies(scene.solids, scene.lubrication.contact_speeds)
        hertz = hertz_line(hertz.load_per_length, hertz.radius, bodies)
    speed = scene.lubrication.largest_speed if mean_speed is None else mean_speed
    return FilmScales(hertz, scene.lubrication, speed)


@dataclass(frozen=True, eq=False)
class PosedFilm:
    """Film equation in Hertz units on the ``upstream`` part of a grid, beyond which the outlet is cavitated throughout.

    Attributes
    ----------
    equation, upstream, x
        The equation, its grid [m], and the positions (x,) across of its cells [a].
    scales, instant
        Units of the equation, those of the largest load and speed; and the scales of the present load and speed.
    operator_on
        Function from a grid to the deflection in Hertz units on it.
    problem, dry_pressure
        The dry contact on the whole grid, and its pressure (x, y) [Pa].
    displacement
        Displacement [m] under a pressure [Pa] on the whole grid; its even part is the operator of the dry contact.
    creep
        The odd part of the displacement, that of each body times minus the speed [m/s] of its surface: its slope is a
        rate of indentation [m/s]. None without creep.
    """

    equation: FilmEquation
    upstream: Grid
    x: Array
    scales: FilmScales
    operator_on: Callable[[Grid], Deflection]
    problem: Problem
    displacement: Deflection
    dry_pressure: Array
    instant: FilmScales
    creep: GeneralConvolution | None

    @property
    def middle(self) -> float:
        """Middle of the dry contact [m]: the centroid of its pressure, or zero if that is within a cell of zero."""
        grid, load = self.problem.grid, self.dry_pressure.sum(axis=1)
        middle = float(grid.x @ load / load.sum())
        return middle if abs(middle) > grid.cell_size[0] else 0.0

    @property
    def upstream_reach(self) -> float:
        """Distance from the axis to which the dry contact reaches upstream [a], at least one."""
        return max(1.0, -float(self.problem.grid.x[self.dry_pressure.any(axis=1)][0]) / self.scales.hertz.half_width)

    @property
    def _from_middle(self) -> Array:
        """Distance (x,) of the cells of the whole grid from the middle of the dry contact [a]."""
        return np.asarray((self.problem.grid.x - self.middle) / self.scales.hertz.half_width)

    def _heights(self, distance: float) -> Array:
        """Return what the gap (x, y) [m] has above a parabola within a ``distance`` [a] of the middle."""
        x = self._from_middle
        inside = np.abs(x) < distance
        if np.count_nonzero(inside) <= 3:
            return np.zeros((1, 1))
        powers, gap = np.vander(x[inside], 3), self.problem.undeformed_gap[inside]
        return np.asarray(gap - powers @ np.linalg.lstsq(powers, gap, rcond=None)[0])

    def central_weights(self, film: float) -> Array:
        """Return the weights (x,) of the cells in the central film, if that is about ``film`` [m].

        On the axis of a smooth contact they are those of a cubic. Where heights vary, they are a mean over the middle
        of the contact, in which a wave of any phase hardly counts.
        """
        x = self._from_middle
        if np.abs(self._heights(MIDDLE)).max() > SMOOTH * film:
            weights = np.clip(1 - (x / MIDDLE) ** 2, 0, None)
            return np.asarray(weights / weights.sum())
        first = min(max(int(np.searchsorted(x, 0.0)) - 2, 0), len(x) - 4)
        near = x[first : first + 4]
        weights = np.zeros_like(x)
        for i, node in enumerate(near):
            others = np.delete(near, i)
            weights[first + i] = np.prod(others / (others - node))
        return weights

    @property
    def is_crowned(self) -> bool:
        """True if the gap varies along the length as on a crowned roller, by more than the deflection in the contact."""
        return bool(np.ptp(self.equation.gap, axis=1).max() > CROWNED)

    @property
    def relative_roughness(self) -> float:
        """Rms height in the contact over the film of Moes; zero where lubricant can flow around heights."""
        if self.upstream.cells[1] > 1:
            return 0.0
        heights = self._heights(1.0)
        return float(heights.std()) / self.scales.film / self.scales.expected_film

    def at(self, speed_parameter: float) -> "PosedFilm":
        """Return the same at another speed, to which the speed parameter is proportional, in the same units."""
        return replace(self, equation=replace(self.equation, speed_parameter=speed_parameter))

    def with_gap(self, gap: Array) -> "PosedFilm":
        """Return the same with another undeformed gap (x, y) [m] of the whole grid."""
        rows = self.upstream.cells[0]
        equation = replace(self.equation, gap=gap[:rows] / self.scales.film)
        return replace(self, equation=equation, problem=replace(self.problem, undeformed_gap=gap))

    def coarser(self) -> "PosedFilm | None":
        """Return the same with half the cells along each axis whose number is large and even, at last in plane strain.

        None where nothing is left to coarsen. The gap of a cell is the mean over the finer cells.
        """
        (nx, ny), equation = self.upstream.cells, self.equation
        least = COARSEST if ny == 1 else COARSEST_ROUGH
        across = 2 if nx % 2 == 0 and nx >= 2 * least else 1
        along = 2 if ny % 2 == 0 and ny >= 2 * COARSEST_ALONG else 1
        if across * along == 1 and not self.is_crowned:
            along = ny
        if across * along == 1:
            return None
        nx, ny = nx // across, ny // along
        grid = Grid((nx, ny), self.upstream.extent)
        coarse = replace(
            equation,
            gap=equation.gap.reshape(nx, across, ny, along).mean(axis=(1, 3)),
            deflection=self.operator_on(grid),
            cell=(equation.cell[0] * across, equation.cell[1] * along),
        )
        x = self.x.reshape(nx, across).mean(axis=1)
        return replace(self, equation=coarse, upstream=grid, x=x)


def check_film_padding(padding: Padding | Paddings, cells_along: int) -> Paddings:
    """Return the paddings (across, along) of a film; raise :class:`~contactstudy.InvalidInput` for others.

    A film of one cell along the length is one of endless bodies: with fewer images its length would act on it.
    """
    paddings = across_and_along(padding)
    is_strip = cells_along == 1 and paddings[1].window is not None
    if paddings[0].wraps or not paddings[1].wraps or is_strip:
        raise InvalidInput(
            f"padding is {padding!r}: a film flows in at one side and out at the other, and is periodic along the "
            "length, with all images where one cell has the whole of it: give ExactPeriodicity()."
        )
    return paddings


def pose(scene: Scene, grid: Grid, padding: Padding | Paddings, outlet: float = OUTLET) -> PosedFilm:
    """Return the film equation of ``scene`` on ``grid``, up to an outlet beyond which there is no pressure.

    The outlet begins ``outlet`` half-widths downstream of the dry contact.

    Raises :class:`~contactstudy.InvalidInput` for a grid or a padding on which a film cannot be solved.
    """
    scales = lubricated_scales(scene)
    paddings = check_film_padding(padding, grid.cells[1])
    half_width = pressure_half_width = scales.relative_half_width * scales.hertz.half_width
    if grid.cell_size[0] > pressure_half_width:
        least = ceil(grid.extent[0] / pressure_half_width)
        raise InvalidInput(
            f"Grid.cells[0] is {grid.cells[0]}, of cells wider than half the contact: give {least} at the least."
        )
    assert isinstance(scene.load, ConstantLoad)
    sudden = instantaneous(scene.solids)
    problem = replace(scene, lubrication=None, outputs=(), solids=sudden).problem(grid, paddings)
    bodies = rolling_bodies(scene.solids, scales.lubrication.contact_speeds)
    weights = response(bodies, problem.scales.length)
    displacement = Deflection.on(grid, paddings, weights, 1.0)
    problem = replace(problem, operator=displacement.even)
    opening = float(np.ptp(problem.undeformed_gap, axis=1).max())
    lengths = [scale.roller for scale in length_scales_of(scene.shapes) if scale.roller > 0]
    sharp = min(SHARP_END * scales.film, *(CLIFF * length for length in lengths), inf)
    if opening > sharp or (lengths and not opening):  # a roller without an opening ends where the period does
        raise InvalidInput(
            "Scene.shapes have a roller's sharp end: a film that ends there is not supported, give a Crown or a "
            "LundbergProfile, and a longer period."
        )
    smooth = np.repeat(scales.hertz.pressure(grid.x)[:, None], grid.cells[1], axis=1)
    # a contact may be narrower than a cell
    start, options = smooth if smooth.any() else None, SolveOptions(tolerance=DRY_TOLERANCE)
    dry_pressure = solve_contact(problem, options, start).pressure
    touching = grid.x[dry_pressure.any(axis=1)]
    end = max(half_width, float(touching.max()))
    half_width = max(half_width, float(np.abs(touching).max()))
    if grid.extent[0] < 2 * MIN_WIDTH * half_width:
        raise InvalidInput(
            f"Grid.extent[0] is {readable(grid.extent[0])}, too narrow for a film that carries load over "
            f"{readable(2 * half_width)}: "
            f"give {readable(2 * MIN_WIDTH * half_width)} at the least, or take contactstudy.plan(scene).grid."
        )
    hertz = scales.hertz
    upstream_cells = np.count_nonzero(grid.x < end + outlet * pressure_half_width)
    rows = min(ROW_MULTIPLE * ceil(upstream_cells / ROW_MULTIPLE), grid.cells[0])
    oil, peak = scales.lubrication.lubricant, hertz.peak_pressure

    def operator_on(upstream: Grid) -> Deflection:
        return Deflection.on(upstream, paddings, weights, peak / scales.film)

    def log_viscosity(pressure: Array) -> tuple[Array, Array]:
        value, slope = oil.law.log_ratio(peak * pressure, oil.pressure_viscosity)
        return value, peak * slope

    def density(pressure: Array) -> tuple[Array, Array]:
        value, slope = oil.density.ratio(peak * pressure)
        return value, peak * slope

    creep = None
    if displacement.odd is not None:
        of_bodies: dict[Coefficients, float] = defaultdict(float)
        for body, speed in zip(bodies, scales.lubrication.contact_speeds, strict=True):
            for coefficients, weight in response((body,), problem.scales.length).items():
                of_bodies[coefficients] -= weight * speed  # the contact moves against the surface
        (creep,) = general_convolutions([by_symmetry(of_bodies)[1]], grid, paddings)
    boundary, supply = scales.lubrication.boundary, scales.lubrication.supply
    upstream = Grid((rows, grid.cells[1]), (rows * grid.cell_size[0], grid.length))
    equation = FilmEquation(
        gap=problem.undeformed_gap[:rows] / scales.film,
        deflection=operator_on(upstream),
        cell=(grid.cell_size[0] / hertz.half_width, grid.cell_size[1] / hertz.half_width),
        speed_parameter=scales.speed_parameter,
        load=scene.mean_load(grid, paddings) / (hertz.half_width * peak),
        log_viscosity=log_viscosity,
        density=density,
        cavitation=scales.lubrication.cavitation,
        boundary_film=0.0 if boundary is None else boundary.film / scales.film,
        supplied_film=inf if supply is None else supply / scales.film,
    )
    x = grid.x[:rows] / hertz.half_width
    return PosedFilm(equation, upstream, x, scales, operator_on, problem, displacement, dry_pressure, scales, creep)


def prolongated(posed: PosedFilm, coarser: PosedFilm, coarse: FilmIteration) -> tuple[Film, Mask]:
    """Return a film on a finer grid and its cavitated cells, from that on a `coarser` one.

    It is raised to half the minimum thickness on the coarse grid, as an interpolated film may be negative. Cavitated
    cells keep the content of the coarser ones.
    """
    equation, (x, y) = posed.equation, (posed.upstream.x, posed.upstream.y)
    blocks = [fine // wide for fine, wide in zip(equation.gap.shape, coarse.cavitated.shape, strict=True)]
    cavitated = coarse.cavitated.repeat(blocks[0], axis=0).repeat(blocks[1], axis=1) & ~equation.fixed
    void = coarse.film.void.repeat(blocks[0], axis=0).repeat(blocks[1], axis=1)
    pressure = interpolated(coarse.film.pressure, coarser.upstream, x, y)
    pressure[cavitated | equation.fixed] = 0
    lowest = float(coarse.film.thickness.min()) / 2
    film = equation.film_of(pressure, void, coarse.film.separation, least=lowest)
    if equation.conserves:
        content = interpolated((1 - coarse.film.void) * coarse.film.thickness, coarser.upstream, x, y)
        void = np.maximum(1 - content / film.thickness, 0)
    return replace(film, void=np.where(cavitated, void, 0)), cavitated


def hertz_start(posed: PosedFilm) -> Film:
    """Return a film of Hertz's pressure, or that of the dry contact under a crown, without contact of asperities.

    Its minimum is Moes' film, or the boundary film where that is thicker. Hertz's pressure is as wide as the part of a
    thick film that carries load.
    """
    equation = posed.equation
    if posed.is_crowned:
        nx, ny = posed.upstream.cells
        across = round(posed.upstream.cell_size[0] / posed.problem.grid.cell_size[0])
        dry = posed.dry_pressure[: nx * across].reshape(nx, across, ny, -1)
        pressure = np.asarray(dry.mean(axis=(1, 3)) / posed.scales.hertz.peak_pressure)
    else:
        hertz = np.sqrt(np.clip(1 - (posed.x / posed.scales.relative_half_width) ** 2, 0, None))
        pressure = np.repeat(hertz[:, None], equation.gap.shape[1], axis=1)
    pressure[equation.fixed] = 0
    pressure *= equation.load / (pressure.sum() * equation.cell[0] / pressure.shape[1])
    void = np.zeros_like(pressure)
    below = (equation.gap + equation.deflection(pressure)).min()
    return equation.film_of(pressure, void, max(posed.scales.expected_film, equation.boundary_film) - below)


def start_from(posed: PosedFilm, contact: FilmSolution) -> tuple[Film, Mask]:
    """Return the film of another contact on this grid and in these units, and its cavitated cells.

    Fields are interpolated linearly, periodic along the length, and zero beyond the width of the other grid.
    """
    scales, fixed = posed.scales, posed.equation.fixed
    x, y = posed.x * scales.hertz.half_width, posed.upstream.y
    peak = scales.hertz.peak_pressure
    pressure = interpolated(contact.lubricant_pressure, contact.grid, x, y) / peak
    pressure[fixed] = 0
    void = interpolated(1 - contact.film_fraction, contact.grid, x, y)
    void = np.where(pressure > 0, 0.0, void)
    lowest = float(contact.film.min()) / scales.film / 2
    asperities = None
    if boundary := posed.equation.boundary_film:
        lowest = boundary
        if contact.contact_pressure is not None:
            asperities = interpolated(contact.contact_pressure, contact.grid, x, y) / peak
    separation = contact.separation / scales.film
    film = posed.equation.film_of(pressure, void, separation, asperities, least=lowest)
    # beyond the other grid's inlet the film is full
    inside = (x > contact.grid.x[1])[:, None]
    return film, (pressure == 0) & ~fixed & inside


def interpolated(values: Array, grid: Grid, x: Array, y: Array) -> Array:
    """Return values (x, y) on ``grid`` at other positions, linear between cells, and zero beyond its width."""
    columns = [np.interp(x, grid.x, column, left=0, right=0) for column in values.T]
    if len(columns) == 1:
        return np.repeat(columns[0][:, None], len(y), axis=1)
    if np.array_equal(y, grid.y):
        return np.stack(columns, axis=1)
    rows = [np.interp(y, grid.y, row, period=grid.length) for row in np.stack(columns, axis=1)]
    return np.stack(rows)
