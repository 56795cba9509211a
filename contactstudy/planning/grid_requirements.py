"""What a scene asks of a grid: how wide, how long, how fine."""

from dataclasses import dataclass
from fractions import Fraction
from math import acosh, erf, inf, lcm, log2, sqrt

import numpy as np

from contactstudy.accuracy.estimate import IN_COAT, STIFF_COAT
from contactstudy.accuracy.expected_error import l1_factor, smooth_l1
from contactstudy.analytic import HertzLine
from contactstudy.domain.checks import InvalidInput, positive
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import ExactPeriodicity, Padding, Paddings, ZeroPadding
from contactstudy.scene.bodies import Layered
from contactstudy.scene.shapes.shape import Detail

# Relative L1 error of the pressure of a rough contact over (cell / finest wavelength)^1.5, times its contact
# area's share to a power: fitted to 9 %, 30 % and 80 % in contact.
ROUGH, AREA_POWER, RATE = 0.35, -0.65, 1.5
# Where nothing stands out of the surface, the contact ends at a half-width; some room beyond it.
ROOM = 1.2
# A period should hold so many of the longest wavelength, so that one surface stands for others.
WAVES = 4
COARSEST = 32
# Cells along a roller from which small solutions find how many it needs.
ALONG = 64
# A contact wider than this share of the radius is not one of half-spaces.
THIN = 0.1


@dataclass(frozen=True)
class Needs:
    """What a scene asks of a grid."""

    hertz: HertzLine
    details: tuple[Detail, ...]
    hardness: float
    coats: tuple[Layered, ...] = ()
    shear: str = ""

    @property
    def points(self) -> tuple[float, float] | None:
        """Spacing (across, along) of the points of a measured surface [m]; None without one."""
        return next((d.spacing for d in self.details if d.spacing is not None), None)

    def grid_of_points(self, period: float | None) -> Grid:
        """Return a grid whose cells are the points of a measured surface, as wide as the contact may become."""
        assert self.points is not None
        width = min(2 * ROOM * self.half_width, self.widest)
        length = self.length(period, width)
        across = max(round(width / self.points[0] - 0.5 + 1e-9), 2)
        if width < self.widest:
            across += 1
        along = max(round(length / self.points[1]), 1) if self.varies else 1
        return Grid((across, along), (across * self.points[0], length))

    @property
    def finest(self) -> tuple[float, float]:
        """The shortest wavelengths (across, along) of all shapes [m]."""
        return (
            min((d.finest[0] for d in self.details), default=inf),
            min((d.finest[1] for d in self.details), default=inf),
        )

    @property
    def rough(self) -> bool:
        """Whether any shape has wavelengths."""
        return min(self.finest) < inf

    @property
    def smooth(self) -> bool:
        """Whether this is Hertz's contact: nothing stands out of the cylinder, ends it, coats it or drags it aside."""
        return not (self.rough or self.roller or self.height or self.coats or self.shear)

    @property
    def roller(self) -> float:
        """The shortest length of a roller that a shape names; infinite where one has no length, 0 for none."""
        return min((d.roller for d in self.details if d.roller), default=0.0)

    @property
    def varies(self) -> bool:
        """Whether anything varies along the length."""
        return self.finest[1] < inf or self.roller > 0

    @property
    def height(self) -> float:
        """The largest height of all shapes together [m]."""
        return sum(d.height for d in self.details)

    @property
    def longest(self) -> float:
        """The longest wavelength along the length [m]."""
        return max((d.longest for d in self.details), default=0.0)

    @property
    def widest(self) -> float:
        """The width over which all shapes are known [m]."""
        return min((d.widest for d in self.details), default=inf)

    @property
    def half_width(self) -> float:
        """Where Hertz's gap is as wide as the highest stands out, or what a hardness needs for the load."""
        hertz = self.hertz
        scale = hertz.half_width**2 / (2 * hertz.radius)
        reach = 1.0
        if self.height > 0:
            far = 2 + sqrt(2 * self.height / scale)

            def open_by(t: float) -> float:
                return scale * (t * sqrt((t - 1) * (t + 1)) - acosh(t)) - self.height

            from scipy.optimize import brentq  # as heavy as all else together

            reach = float(brentq(open_by, 1.0, far))
        crowned = 1.5 if self.roller else 1.0  # the middle or the ends bear more than the mean
        bearing = hertz.load_per_length / (2 * self.hardness)
        return max(hertz.half_width * reach * crowned, bearing)

    def coefficient(self) -> float:
        """The error law's, of the finest wavelength."""
        slope = sqrt(sum(d.slope**2 for d in self.details))
        if slope == 0:
            return ROUGH
        # the mean pressure over the rms slope tells the share in contact (Persson 2001)
        mean = np.pi / 4 * self.hertz.peak_pressure / self.hertz.contact_modulus
        return float(ROUGH * max(erf(sqrt(2) * mean / slope), 1e-3) ** AREA_POWER)

    def error(self, cell: tuple[float, float]) -> float:
        """Relative L1 error of the pressure to expect of a cell (dx, dy) [m]."""
        smooth = smooth_l1(cell[0] / self.hertz.half_width)
        steps = (size / wave for size, wave in zip(cell, self.finest, strict=True))
        return float(smooth + self.coefficient() * max(steps) ** RATE)

    def errors(self, cell: tuple[float, float]) -> tuple[float, float]:
        """Return the shares (across, along) of :meth:`error`."""
        total = self.error(cell)
        rough = [(size / wave) ** RATE for size, wave in zip(cell, self.finest, strict=True)]
        if not self.rough:
            return total, 0.0
        return total * rough[0] / sum(rough), total * rough[1] / sum(rough)

    def grid(self, error: float, period: float | None) -> Grid:
        """The coarsest grid that keeps to ``error``."""
        width = min(2 * ROOM * self.half_width, self.widest)
        length = self.length(period, width)
        # as if each source of error stood alone, then both brought down to the error asked for
        step = self.hertz.half_width / l1_factor() ** (1 / RATE)
        share = self.coefficient() ** (-1 / RATE)
        across = min(step, self.finest[0] * share)
        along = self.finest[1] * share
        down = 1.0
        for _ in range(4):  # the smooth part's second term falls faster than the rate
            expected = self.error((across * down, along * down))
            if not 0 < expected < inf:  # beyond any grid: what it takes is said by whoever makes it
                break
            down *= (error / expected) ** (1 / RATE)
        least = ALONG if self.roller else COARSEST
        cells = halvable(length / (along * down), least) if self.varies else 1
        return Grid((halvable(width / (across * down)), cells), (width, length))

    def length(self, period: float | None, width: float) -> float:
        """Return the length of the grid [m]: ``period`` if given, else a roller's own or that of what repeats."""
        if period is not None:
            return positive("plan.period", period, "give a period above 0 m")
        if self.roller == inf:
            raise InvalidInput(
                "Scene.shapes crown a roller without a length: add FiniteLength, or give plan a period."
            )
        if self.roller:
            return self.roller
        if not self.varies:
            return width
        repeats = {d.repeat for d in self.details if d.repeat}
        unit = _common(repeats) if repeats else max(self.longest, width) / WAVES
        return unit * max(1, int(np.ceil(WAVES * self.longest / unit * (1 - 1e-12))))

    def padding(self) -> Padding | Paddings:
        """Free where a roller ends, else all images."""
        return (ZeroPadding(), ZeroPadding()) if self.roller else ExactPeriodicity()

    def period_check(self, period: float) -> str:
        """How ``period`` [m] suits the scene, in a sentence."""
        if self.roller:
            return f"The length is free, from end to end {period:.4g} m."
        if not self.varies:
            return "Nothing varies along the length, so any period gives the same pressure."
        broken = [d.repeat for d in self.details if d.repeat and _parts(period, d.repeat) is None]
        if broken:
            return (
                f"The period {period:.4g} m is no whole number of {broken[0]:.4g} m, after which a shape "
                "repeats: give a multiple of that."
            )
        if 0 < period < WAVES * self.longest * (1 - 1e-9):
            return (
                f"The period {period:.4g} m holds {period / self.longest:.2g} of the longest wavelength "
                f"{self.longest:.4g} m: give {WAVES * self.longest:.4g} m, or the answer is that of one "
                "short sample."
            )
        return f"The period {period:.4g} m holds what repeats along it a whole number of times."

    def reasons(self, grid: Grid, error: float) -> tuple[str, ...]:
        """Why the width, the cells, the dimension and the padding, a sentence each."""
        a = self.hertz.half_width
        width = (
            f"width {grid.extent[0]:.4g} m: the contact is expected to end within "
            f"{self.half_width / a:.3g} half-widths of Hertz (a = {a:.4g} m) from the axis."
        )
        cell = f"{grid.cells[0]} x {grid.cells[1]} cells: {a / grid.cell[0]:.3g} in a half-width"
        cell += f", {_in_waves(grid, self.finest):.3g} in the finest wavelength" * self.rough
        cell += f", for an error of {error:.1g}."
        if not self.varies:
            dimension = (
                "dimension 1: nothing varies along the length, so one cell stands for all of it."
            )
        else:
            dimension = "dimension 2: the gap varies along the length."
        if not self.varies and grid.cells[1] > 1:
            dimension = (
                "dimension 2: as asked, though nothing varies along the length: one cell would do."
            )
        if self.roller:
            padding = "padding zero along both axes: the roller ends, and nothing presses beyond its ends."
        else:
            padding = (
                "padding exact: all images in closed form, so that no error is left of them, at half the "
                "transform of a padded length."
            )
        coats = (self._coat(coat, grid) for coat in self.coats)
        return width, cell, dimension, padding, *coats, *filter(None, (self.shear,))

    def _coat(self, coat: Layered, grid: Grid) -> str:
        """What a coat does to the plan."""
        own, below = 1 / coat.compliance, coat.substrate.compliance
        base = f"{1 / below:.3g} Pa" if below else "infinite, a rigid substrate"
        felt = 1 / coat.compliance_at(self.hertz.half_width)
        return (
            f"coat {coat.thickness:.4g} m: {coat.thickness / self.hertz.half_width:.3g} half-widths and "
            f"{coat.thickness / grid.cell[0]:.3g} cells across thick. Its coefficients are exact at any thickness; "
            f"a smooth contact feels a modulus of about {felt:.3g} Pa, between {own:.3g} Pa of the coating and "
            f"{base}. Width and error are those of small solutions with the coat."
        )

    def warnings(self, grid: Grid) -> tuple[str, ...]:
        """What is wrong with ``grid``, a sentence each."""
        said = []
        for coat in self.coats:
            stiffer = coat.substrate.compliance / coat.compliance
            if stiffer > STIFF_COAT and grid.cell[0] > coat.thickness / IN_COAT:
                said.append(
                    f"Grid.cells[0] is {grid.cells[0]}: {coat.thickness / grid.cell[0]:.2g} cells in a coat "
                    f"{stiffer:.3g} times as stiff as its substrate, where little is known of the error, give "
                    f"{int(np.ceil(IN_COAT * grid.extent[0] / coat.thickness))} for a bound."
                )
        hertz = self.hertz
        if hertz.half_width > THIN * hertz.radius:
            said.append(
                f"The half-width of Hertz is {hertz.half_width:.3g} m on a radius of {hertz.radius:.3g} m, too "
                "large a share for half-spaces: give loads and radii in N/m and m, and "
                "HalfSpace.youngs_modulus in Pa (steel has 210e9)."
            )
        for axis, (cell, wave) in enumerate(zip(grid.cell, self.finest, strict=True)):
            if cell > wave / 2:
                said.append(
                    f"Grid.cells[{axis}] is {grid.cells[axis]}: its cells of {cell:.4g} m do not show the "
                    f"finest wavelength, {wave:.4g} m, give {int(np.ceil(2 * grid.extent[axis] / wave))} "
                    "or more."
                )
        if self.varies and ": give" in (check := self.period_check(grid.period)):
            said.append(check)
        return tuple(said)


def _in_waves(grid: Grid, finest: tuple[float, float]) -> float:
    return min(wave / cell for wave, cell in zip(finest, grid.cell, strict=True))


def _parts(whole: float, part: float) -> int | None:
    """How many times ``part`` goes into ``whole``, if that is a whole number."""
    times = round(whole / part)
    return times if times and abs(whole / part - times) <= 1e-9 * times else None


def _common(lengths: set[float]) -> float:
    """The shortest length that is a whole number of each."""
    first = max(lengths)
    ratios = [Fraction(first / length).limit_denominator(64) for length in lengths]
    multiple = lcm(*(ratio.denominator for ratio in ratios))
    common = first * multiple
    if any(_parts(common, length) is None for length in lengths):
        raise InvalidInput(
            f"Scene.shapes repeat after {sorted(lengths)} m, which share no period: "
            "give wavelengths and pitches in ratios of small whole numbers."
        )
    return common


def halvable(count: float, least: int = COARSEST) -> int:
    """Return at least ``count`` cells, and at least ``least``, that halve again and again down to a coarse grid's."""
    step = 2 ** max(0, int(log2(max(count, COARSEST) / COARSEST)))
    return int(np.ceil(max(count, least) / step * (1 - 1e-12)) * step)
