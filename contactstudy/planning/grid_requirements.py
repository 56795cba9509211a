"""Requirements of a scene on its grid: width, length, least cells and padding, with the reasons and the faults in words.

Across is x, over the width of the grid, along is y, over its length, which is a period, or ends with a roller. Hertz's
contact is the smooth line contact of the same load, curvature and materials.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from math import acosh, ceil, inf, lcm, log2, sqrt
from operator import is_

import numpy as np

from contactstudy.accuracy.estimate import CELL_AT_INTERFACE
from contactstudy.analytic import HertzLine
from contactstudy.domain.grid import ExactPeriodicity, Grid, Padding, Paddings, ZeroPadding
from contactstudy.domain.validation import InvalidInput, Metres, NotDefined, readable, valid
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import LengthScales, Shape, length_scales_of
from contactstudy.scene.solids.bodies import Layered, is_layered

# Effects of constants, where stated, are those on plans of a smooth, a rough, a rolling and a changing contact, each to
# an error of 1 %.
# Width of the grid over that of the contact. With 1.1 to 1.4 plans have 0.9 to 2.2 times the cells.
WIDTH_FACTOR = 1.2
# Number of longest wavelengths in a period with which one surface is representative. The number of cells is
# proportional to it.
WAVES_PER_PERIOD = 4
# Minimum number of cells along an axis. With half or twice as many, plans change by 2 % of the cells at most.
MIN_CELLS = 32
# Fraction of the requested error for the cells where a scene changes in time; the rest is for the time steps.
CELL_FRACTION = 0.5
# Factor on the expected half-width of a roller's contact, since its middle, or its ends, carry more than the mean. The
# width is later fitted to the contact: with half or twice the factor, three crowned rollers took 0.6 to 1.5 times the
# cells.
CROWN_FACTOR = 1.5
# Cells in the shortest wavelength of flats with waves along one axis, and along both. No solve tells their error before:
# the grid is the largest on which a solve takes tenths of a second.
CELLS_PER_WAVE = 1024, 128


@dataclass(frozen=True)
class GridRequirements:
    """Properties of a scene that determine its grid.

    Attributes
    ----------
    hertz
        Hertz's contact under the largest load of the scene, with adhesion under a load larger by that of the
        attraction.
    length_scales
        Wavelengths, heights and extents of each shape.
    hardness
        Largest pressure of the softer body [Pa].
    coatings
        Coated bodies.
    given_padding
        Boundary conditions that are given, or None.
    stress_cell
        Largest cell across with which the stress at the interface of a coating is resolved [m]; infinite where that is
        not asked for.
    body
        What ends within the grid and carries the whole load, as sentences call it.
    """

    hertz: HertzLine
    length_scales: tuple[LengthScales, ...]
    hardness: float
    coatings: tuple[Layered, ...] = ()
    given_padding: Padding | Paddings | None = None
    stress_cell: float = inf
    body: str = "roller"

    @property
    def point_spacing(self) -> tuple[float, float] | None:
        """Spacing (across, along) of the points of a measured surface [m]; None without one."""
        return next((scales.spacing for scales in self.length_scales if scales.spacing is not None), None)

    def grid_on_measured_points(self, period: float | None) -> Grid:
        """Return a grid whose cells are the points of a measured surface, as wide as the contact may become.

        Its length is a `period` [m], chosen if that is None.
        """
        assert self.point_spacing is not None
        width = min(self.width_of_contact, self.known_width)
        length = self.length(period, width)
        # whole points: as many as the surface has, or one more than the width takes
        across = max(round(width / self.point_spacing[0] - 0.5 + 1e-9), 2)
        if width < self.known_width:
            across += 1
        along = max(round(length / self.point_spacing[1]), 1) if self.varies else 1
        return Grid((across, along), (across * self.point_spacing[0], length))

    @property
    def shortest_wavelengths(self) -> tuple[float, float]:
        """The shortest wavelengths (across, along) of all shapes [m]; infinite where there are none."""
        across, along = zip((inf, inf), *(scales.shortest_wavelengths for scales in self.length_scales), strict=True)
        return min(across), min(along)

    @property
    def is_rough(self) -> bool:
        """True if any shape has waves, random or regular."""
        return min(self.shortest_wavelengths) < inf

    @property
    def roller_length(self) -> float:
        """The shortest length of a roller that shapes name [m]; infinite if none gives a length, 0 without rollers."""
        return min((scales.roller for scales in self.length_scales if scales.roller), default=0.0)

    @property
    def varies(self) -> bool:
        """True if anything varies along the length."""
        return self.shortest_wavelengths[1] < inf or self.roller_length > 0

    @property
    def height(self) -> float:
        """The largest height of all shapes together [m]."""
        return sum(scales.height for scales in self.length_scales)

    @property
    def longest_wavelength(self) -> float:
        """The longest wavelength along the length [m]."""
        return max((scales.longest_wavelength for scales in self.length_scales), default=0.0)

    @property
    def known_width(self) -> float:
        """Largest width at which all shapes are known [m]."""
        return min((scales.known_width for scales in self.length_scales), default=inf)

    @property
    def half_width(self) -> float:
        """Expected half-width of the contact [m].

        It is where Hertz's gap equals the largest height, of rollers times `CROWN_FACTOR`, or what carries the load at
        the hardness where that is wider. At t half-widths a the gap is ``a^2 / (2 R) (t (t^2 - 1)^(1/2) - arcosh t)``
        (Johnson 1985, sect. 4.2(c)).
        """
        hertz = self.hertz
        scale = hertz.half_width**2 / (2 * hertz.radius)
        relative_half_width = 1.0
        if self.height > 0:
            from scipy.optimize import brentq  # imported late, since it is slow

            def residual_gap(t: float) -> float:
                return scale * (t * sqrt((t - 1) * (t + 1)) - acosh(t)) - self.height

            # the gap is at least scale (t - 1)^2
            relative_half_width = float(brentq(residual_gap, 1.0, 2 + sqrt(2 * self.height / scale)))
        crown_factor = CROWN_FACTOR if self.roller_length else 1.0
        hardness_limited = hertz.load_per_length / (2 * self.hardness)
        return max(hertz.half_width * relative_half_width * crown_factor, hardness_limited)

    @property
    def width_of_contact(self) -> float:
        """Width [m] of a grid that holds the contact that is expected."""
        return 2 * WIDTH_FACTOR * self.half_width

    def extent(self, period: float | None) -> tuple[float, float]:
        """Return the width and the length [m] of the grid to begin with; the length is a `period` if that is given."""
        width = self.width(self.width_of_contact)
        return width, self.length(period, width)

    def width(self, least: float) -> float:
        """Return the width of the grid [m]: at least `least` [m], unless the shapes are known over less.

        A random surface without an extent has that of the grid. The grid is then wide enough to be representative, and
        grows by factors of two, so that a somewhat larger load leaves the surface as it is.
        """
        unit = WAVES_PER_PERIOD * max((scales.longest_across for scales in self.length_scales), default=0.0)
        if unit:
            least = unit * 2 ** max(0, int(np.ceil(log2(least / unit) - 1e-9)))
        return min(least, self.known_width)

    def length(self, period: float | None, width: float) -> float:
        """Return the length of the grid [m]: the period if given, else that of the roller or of the repeating shapes.

        Parameters
        ----------
        period
            Length [m]; chosen if None.
        width
            Width of the grid [m], for a length that nothing else determines.

        Raises
        ------
        InvalidInput
            If the period is not above 0, a roller has no length, or the shapes share no period.
        """
        if period is not None:
            return float(valid("plan.period", period, Metres))
        if self.roller_length == inf:
            raise InvalidInput("Scene.shapes crown a roller without a length: add FiniteLength, or give plan a period.")
        if self.roller_length:
            return self.roller_length
        if not self.varies:
            return width
        repeats = {scales.period for scales in self.length_scales if scales.period}
        waves = WAVES_PER_PERIOD
        unit = _common_period(repeats) if repeats else (self.longest_wavelength or width) / waves
        return unit * max(1, int(np.ceil(waves * self.longest_wavelength / unit * (1 - 1e-12))))

    def padding(self) -> Padding | Paddings:
        """Return the given padding, else zeros along both axes for a roller that ends, and for others periodic along."""
        if self.given_padding is not None:
            return self.given_padding
        return (ZeroPadding(), ZeroPadding()) if self.roller_length else ExactPeriodicity()

    def period_fault(self, period: float) -> str:
        """Return why `period` [m] does not suit the scene, with a remedy; empty if it does."""
        if 0 < period < self.roller_length * (1 - 1e-9) < inf:
            return (
                f"The length {readable(period)} is shorter than the {self.body}, which ends there and carries the whole "
                f"load: give {readable(self.roller_length)} or more."
            )
        if self.roller_length or not self.varies:
            return ""
        if fault := period_fault(period, self.length_scales):
            return fault
        if 0 < period < WAVES_PER_PERIOD * self.longest_wavelength * (1 - 1e-9):
            return (
                f"The period {readable(period)} is only {period / self.longest_wavelength:.2g} longest wavelengths "
                f"({readable(self.longest_wavelength)}) long, too short to be representative: give "
                f"{readable(np.ceil(WAVES_PER_PERIOD * self.longest_wavelength / period) * period)}."
            )
        return ""

    def reasons(self, grid: Grid) -> tuple[str, ...]:
        """Return a sentence each on the width, cells, length and padding of `grid`, and on the coatings."""
        a = self.hertz.half_width
        width = (
            f"width {readable(grid.extent[0])}: {grid.extent[0] / 2 / a:.3g} half-widths of Hertz (a = {readable(a)}) "
            "on either side."
        )
        nx, ny = grid.cells
        cell = f"{nx} x {ny} cells: {a / grid.cell_size[0]:.3g} in a half-width"
        if self.is_rough:
            steps = zip(self.shortest_wavelengths, grid.cell_size, strict=True)
            cell += f", {min(wave / step for wave, step in steps):.3g} in the shortest wavelength"
        length = "nothing varies along it, so that one cell is enough"
        if self.varies:
            length = f"that of the {self.body}" if self.roller_length else "a period of the surface"
        coatings = (
            f"coating {readable(coating.thickness)}: {coating.thickness / a:.3g} half-widths and "
            f"{coating.thickness / grid.cell_size[0]:.3g} cells across thick."
            for coating in self.coatings
        )
        padding = f"padding {self.padding()!r}."
        return width, f"{cell}.", f"length {readable(grid.length)}: {length}.", padding, *coatings

    def warnings(self, grid: Grid) -> tuple[str, ...]:
        """Return a sentence for each fault of `grid`."""
        messages = []
        for axis, (cell, wave) in enumerate(zip(grid.cell_size, self.shortest_wavelengths, strict=True)):
            if cell > wave / 2 * (1 + 1e-9):
                messages.append(
                    f"Grid.cells[{axis}] is {grid.cells[axis]}: its cells of {readable(cell)} do not resolve the "
                    f"shortest wavelength, {readable(wave)}, give {int(np.ceil(2 * grid.extent[axis] / wave))} or more."
                )
        if fault := self.period_fault(grid.length):
            messages.append(fault)
        return tuple(messages)


def grid_requirements(scene: Scene, padding: Padding | Paddings | None = None) -> GridRequirements:
    """Return the properties of `scene` that determine its grid, with its `padding` if that is given.

    Raises
    ------
    InvalidInput
        If a shape has no length scales.
    NotDefined
        If the scene has no Hertz contact: no shape is curved across alone, so that no width is known.
    """
    if scene.hertz is None:
        if min(scene.curvatures) > 0:
            raise NotDefined(
                "Scene.shapes are curved both ways, and the width of such a point contact is known under a TotalLoad "
                "alone, without adhesion, films and rolling with hysteresis: give that, a Cylinder in place of the "
                "ball, or choose grid and padding yourself."
            )
        raise NotDefined(
            "Scene.shapes have no curvature that is the same all along, so that no width of the contact is known: "
            "give a Cylinder, a MeasuredSurface with its extent, or choose grid and padding yourself."
        )
    for number, shape in enumerate(scene.shapes):
        if not hasattr(shape, "length_scales"):
            raise InvalidInput(
                f"Scene.shapes[{number}] is {shape!r}, which has no length scales: give it "
                "`length_scales`, or choose grid and padding yourself."
            )
    length_scales = tuple(length_scales_of(scene.shapes))
    length = scene.roller_length
    if scene.free_length < inf:  # a body with free faces ends the contact, whatever length a profile is made for
        length_scales = tuple(replace(scales, roller=0.0) for scales in length_scales)
    if scene.free_length < inf or (length is not None and any(scales.roller for scales in length_scales)):
        length_scales += (LengthScales(roller=length or inf),)
    coatings = tuple(solid for solid in scene.solids if isinstance(solid, Layered))
    asked = (scene.solids[output.body] for output in scene.outputs if hasattr(output, "body"))
    layers = (layer for body in filter(is_layered, asked) for layer in body.layers)
    thickness = min((layer.thickness for layer in layers), default=inf)
    return GridRequirements(
        scene.hertz,
        length_scales,
        scene.hardness,
        coatings,
        given_padding=padding,
        stress_cell=thickness * CELL_AT_INTERFACE,
        body="roller" if scene.ellipse is None else "point contact",
    )


def with_requirements(
    scene: Scene, padding: Padding | Paddings | None, period: float | None
) -> tuple[Scene, GridRequirements]:
    """Return `scene` with the extent of its first grid for random surfaces, and its requirements.

    On narrower grids the surfaces then stay as they are. Padding and `period` [m] are chosen if None.
    """
    scene = with_random_extents(scene, grid_requirements(scene, padding).extent(period))
    return scene, grid_requirements(scene, padding)


def with_random_extents(scene: Scene, extent: tuple[float, float]) -> Scene:
    """Return `scene`, whose random surfaces without an extent get this one (width, length) [m]."""
    shapes = tuple(
        shape.with_extent_of(Grid((2, 1), extent))  # type: ignore[attr-defined]
        if any(scales.longest_across for scales in length_scales_of([shape]))
        else shape
        for shape in scene.shapes
    )
    return scene if all(map(is_, shapes, scene.shapes)) else replace(scene, shapes=shapes)


def measured_length_scales(scene: Scene) -> LengthScales | None:
    """Return the length scales of the first measured surface of `scene` that has a size; None without such a surface."""
    length_scales = length_scales_of(scene.shapes)
    return next((scales for scales in length_scales if scales.spacing is not None), None)


def flat_grid(scales: LengthScales, period: float | None) -> Grid:
    """Return the points of a measured surface as cells, over its whole width and a period of its length.

    Parameters
    ----------
    scales
        Length scales of the surface.
    period
        Length of the grid [m]; that after which the surface repeats if None.
    """
    assert scales.spacing is not None
    length = period or scales.period or scales.known_width
    along = round(length / scales.spacing[1]) if scales.period else 1
    return Grid((round(scales.known_width / scales.spacing[0]), along), (scales.known_width, length))


def grid_of_waves(shapes: Iterable[Shape]) -> Grid | None:
    """Return a grid of one common period of waves and textures each way; None of shapes that do not repeat.

    It has `CELLS_PER_WAVE` in the shortest wavelength. Raises :class:`~contactstudy.InvalidInput` if the shapes share
    no period.
    """
    length_scales = list(length_scales_of(shapes))
    across = {scales.period_across for scales in length_scales if scales.period_across}
    along = {scales.period for scales in length_scales if scales.period}
    if not across and not along:
        return None
    width, length = (_common_period(periods) if periods else 0.0 for periods in (across, along))
    extent = width or length, length or width
    per_wave = CELLS_PER_WAVE[1 if across and along else 0]
    waves = (min(scales.shortest_wavelengths[axis] for scales in length_scales) for axis in (0, 1))
    nx, ny = (ceil(per_wave * side / wave) for side, wave in zip(extent, waves, strict=True))
    return Grid((max(nx, 2), max(ny, 1)), extent)


def period_fault(period: float, length_scales: Iterable[LengthScales]) -> str:
    """Return why `period` [m] is no multiple of the repeat lengths in `length_scales`, with a remedy; empty if it is."""
    for scales in length_scales:
        if scales.period and _whole_parts(period, scales.period) is None:
            return (
                f"The period {readable(period)} is not a multiple of {readable(scales.period)}, the repeat length of a "
                "shape: give a multiple of it."
            )
    return ""


def _whole_parts(total: float, part: float) -> int | None:
    """Return how many times `part` goes into `total`, None if that is no whole number but for rounding."""
    count = round(total / part)
    return count if count and abs(total / part - count) <= 1e-9 * count else None


def _common_period(lengths: set[float]) -> float:
    """Return the shortest length that is a whole multiple of each of `lengths` [m], in ratios of whole numbers up to 64.

    Raises :class:`~contactstudy.InvalidInput` if there is none.
    """
    first = max(lengths)
    ratios = [Fraction(first / length).limit_denominator(64) for length in lengths]
    multiple = lcm(*(ratio.denominator for ratio in ratios))
    common = first * multiple
    if any(_whole_parts(common, length) is None for length in lengths):
        raise InvalidInput(
            f"Scene.shapes repeat after {sorted(lengths)} m, which share no period: "
            "give wavelengths and pitches in ratios of small whole numbers."
        )
    return common


def halvable_count(count: float) -> int:
    """Return `count` rounded up to a number that can be halved down to `MIN_CELLS` to twice as many; at least that."""
    count = max(count, MIN_CELLS)
    step = 2 ** int(log2(count / MIN_CELLS))
    return int(np.ceil(count / step * (1 - 1e-12)) * step)
