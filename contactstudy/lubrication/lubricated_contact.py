"""Result of a lubricated contact: fields, film thickness, friction, and a status that says how far to trust them.

Bounds of its numbers are in ``contactstudy.answers.lubricated_contact``. M and L are the load and the material
parameter of Moes (1992). A lubricated contact may have a second peak of pressure before the outlet, the pressure spike.
Across is along x, in which the surfaces move; along the length is y.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isfinite

import numpy as np

from contactstudy.domain.errors import NO_PEAK
from contactstudy.domain.grid import Array, Grid, Padding, Paddings, across_and_along
from contactstudy.domain.validation import readable
from contactstudy.lubrication.film_equation import INLET_CELLS, FilmScales
from contactstudy.lubrication.film_friction import FilmTemperatures
from contactstudy.problem.problem import DependsOnShear, Field
from contactstudy.scene.lubrication import LimitingShear
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.shape import LengthScales
from contactstudy.solvers.solution import Status

# Largest known shear stress of a lubricant (Bair & Winer 1979, 1992), the sum of two parts: a constant [Pa], and a
# fraction of the pressure. Then the largest fraction of the friction that may be above that stress without a remark. Of
# 72 films under 3e4 to 6e5 N/m with Eyring's and Newton's law, 49 had nothing above it, the others 7 % and more.
SHEAR_LIMIT, SHEAR_LIMIT_OVER_PRESSURE, FRICTION_BEYOND_LIMIT = 1e7, 0.15, 0.01
# A second peak of pressure is a spike if it rises from the valley before it by more than SPIKE of the highest pressure.
# It is not critical: of 38 smooth films at M = 3 to 200, L = 0 to 14 on 200 cells, 20 keep a bound, and 19 and 21 with
# half and twice of it. On four times the cells their peaks grew by less than the bound.
SPIKE = 0.02
OF_SPIKE = f"{NO_PEAK}it may be that of the spike before the outlet, which grows with the number of cells."
# A pressure that falls from one cell to the next by more than this fraction of the highest may hide a spike. With
# Barus' law at M = 5, L = 9 the highest pressure grows from 1.1 to 2.4 p_H on 64 to 1280 cells, steeper on all.
STEEP_FALL = 0.3
# Half of the fraction of a roller's length over which its central film is a mean: there profiles are flat.
MIDDLE_OF_ROLLER = 1 / 16
# Size of the slide-roll ratio, the sliding speed over the mean speed, at which one of the surfaces stands still.
STANDS_STILL = 2.0


@dataclass(frozen=True, eq=False)
class FilmSolution:
    """Fields (x, y) of a lubricated contact, numbers of it, and what the iteration took.

    Attributes
    ----------
    scene, grid, padding, scales
        What was solved: the scene, its cells, the padding along the length or those (across, along), and Hertz's
        contact with Moes' parameters, at the present load and speed.
    pressure
        Pressure [Pa] of lubricant and asperities together.
    film
        Film thickness [m].
    film_fraction
        Fractional film content, the fraction of the gap that lubricant fills: one under pressure, less where the film
        is torn into streamers.
    shear
        Shear stress [Pa] at mid-film by sliding, positive where it retards the first body; of asperities too.
    separation
        Rigid-body separation h_0 [m]: the film thickness less gap and deflection.
    status
        How far the contact can be trusted.
    iterations, linear_iterations
        Steps on this grid from the start that led to the film, and iterations of all their linear systems.
    residual
        The larger of the unbalanced flow over the flow along x, and the error of the load over ``p_H a``. On a boundary
        film, the least film thickness, whose asperities carry the rest of the load, also the violation of its contact
        conditions.
    flow
        Volume flow per length [m^2/s], at the density of zero pressure.
    flux_spread
        Largest less smallest flow over all x, over the mean flow: zero where the flow is conserved. With Reynolds'
        condition for cavitation it is taken up to the end of the pressure.
    contact_pressure
        Pressure [Pa] that asperities carry on a boundary film; None without one.
    temperatures
        Temperatures of a film with ``Lubrication.thermal``. Pressure and film are isothermal, shear is at these
        temperatures.
    wear_depth
        Depth [m] of wear until now, which is part of the gap; None without wear.
    central_weights
        Weights (x,) of the cells in the central film, which add up to 1: those of a cubic through the cells about the
        axis of a smooth contact, or of a mean over the middle where heights vary.
    film_rate
        Rate of the film thickness in time (x, y) [m/s] where there is pressure; None of a steady film.
    creep_loss
        Power lost per length [W/m] in bodies that creep.
    """

    scene: Scene
    grid: Grid
    padding: Padding | Paddings
    scales: FilmScales
    pressure: Array
    film: Array
    film_fraction: Array
    shear: Array
    separation: float
    status: Status
    iterations: int
    linear_iterations: int
    residual: float
    flow: float
    flux_spread: float
    central_weights: Array
    contact_pressure: Array | None = None
    temperatures: FilmTemperatures | None = None
    wear_depth: Array | None = None
    film_rate: Array | None = None
    creep_loss: float = 0.0

    @property
    def mean_speed(self) -> float:
        """Mean speed of the surfaces [m/s] at this instant."""
        return self.scales.mean_speed

    @property
    def central_film(self) -> float:
        """Film thickness on the axis [m], mean over the length; where heights vary, mean over the middle.

        Of a roller it is that of the middle, a mean over an eighth of its length.
        """
        film, roller = self.film, self.scene.roller_length
        if roller is not None:
            in_middle = np.abs(self.grid.y) <= max(MIDDLE_OF_ROLLER * roller, self.grid.cell_size[1])
            film = film[:, in_middle]
        return float(self.central_weights @ film.mean(axis=1))

    @cached_property
    def derived(self) -> Mapping[str, Field]:
        """Fields of the outputs that the scene names, under the pressure and the friction of the film."""
        fields: dict[str, Field] = {}
        for output in self.scene.outputs:
            of_pressure = output.of(self.scene.solids, self.grid, across_and_along(self.padding))
            if isinstance(of_pressure, DependsOnShear):
                # friction across on the first body
                shear = np.stack((-self.shear, np.zeros_like(self.shear)))
                of_pressure = of_pressure.with_shear(shear)
            fields |= of_pressure.fields(self.pressure)
        return fields

    @property
    def minimum_film_position(self) -> dict[str, float]:
        """Coordinates [m] of the cell with the minimum film, along an axis of several cells."""
        row, column = np.unravel_index(np.argmin(self.film), self.film.shape)
        places = {"x": float(self.grid.x[row]), "y": float(self.grid.y[column])}
        return {axis: places[axis] for axis, n in zip("xy", self.grid.cells, strict=True) if n > 1}

    @property
    def minimum_film(self) -> float:
        """Minimum film thickness [m], by a parabola of its logarithm across the lowest cell and its neighbours.

        It is at least the boundary film, and at most the central film.
        """
        boundary = self.scales.lubrication.boundary
        row, column = np.unravel_index(np.argmin(self.film), self.film.shape)
        if not 0 < row < len(self.film) - 1:
            return float(self.film[row, column])
        # by logarithms the minimum is above zero
        before, lowest, after = np.log(self.film[row - 1 : row + 2, column])
        curvature = before + after - 2 * lowest
        drop = (after - before) ** 2 / (8 * curvature) if curvature > 0 else 0.0
        least = min(float(np.exp(lowest - drop)), self.central_film)
        return max(least, 0.0 if boundary is None else boundary.film)

    @property
    def peak_pressure(self) -> float:
        """Largest pressure of a cell [Pa]; beside a spike it depends on the cells."""
        return float(self.pressure.max())

    @property
    def load_per_length(self) -> float:
        """Load [N/m] by the pressure, mean over the length."""
        return float(self.pressure.sum() * self.grid.cell_size[0] / self.grid.cells[1])

    @property
    def sliding_speed(self) -> float:
        """Speed of the first surface less that of the second [m/s]."""
        return self.mean_speed * self.scales.lubrication.slide_roll_ratio

    @property
    def meniscus(self) -> float:
        """Position x [m] of the inlet meniscus, mean over the length; near the edge of the grid if flooded, or dry."""
        full = self.film_fraction[INLET_CELLS:] >= 1  # the flow is not balanced in the cells before
        return float(self.grid.x[INLET_CELLS + np.argmax(full, axis=0)].mean() - self.grid.cell_size[0] / 2)

    @property
    def is_flooded(self) -> bool:
        """True if lubricant fills the gap at the edge of the grid, in any line along x."""
        return bool((self.film_fraction[INLET_CELLS] >= 1).any())

    @property
    def lubricant_pressure(self) -> Array:
        """Pressure [Pa] of the lubricant (x, y); all of the pressure without a boundary film."""
        touching = self.contact_pressure
        return self.pressure if touching is None else self.pressure - touching

    @property
    def contact_load_fraction(self) -> float:
        """Fraction of the load that asperities carry."""
        if self.contact_pressure is None:
            return 0.0
        return float(self.contact_pressure.sum() / self.pressure.sum())

    @property
    def contact_area_ratio(self) -> float:
        """Real contact area, where asperities touch, over that of Hertz's contact."""
        if self.contact_pressure is None:
            return 0.0
        area = np.count_nonzero(self.contact_pressure) * self.grid.cell_area
        return float(area / (2 * self.scales.hertz.half_width * self.grid.length))

    @property
    def flash_temperature(self) -> float:
        """Largest temperature rise of a surface [K]; 0 without heat."""
        return 0.0 if self.temperatures is None else float(self.temperatures.surface.max())

    @property
    def heated_film(self) -> float:
        """Central film thickness with a heated inlet [m]; the isothermal one without heat."""
        return self.central_film * (1.0 if self.temperatures is None else self.temperatures.reduction)

    @property
    def film_temperature(self) -> float:
        """Mean temperature rise of the film by sliding, weighted by the pressure [K]; 0 without heat."""
        if self.temperatures is None:
            return 0.0
        return float((self.temperatures.film * self.pressure).sum() / self.pressure.sum())

    @property
    def friction(self) -> float:
        """Coefficient of friction (traction), negative where the second body is the faster one."""
        return float(self.shear.sum() / self.pressure.sum())

    @property
    def note(self) -> str:
        """Sentences on what stands still: heights while surfaces roll, and a surface that brings no lubricant."""
        motion, sentences = self.scales.lubrication, []
        still = abs(motion.slide_roll_ratio) == STANDS_STILL
        standing = [  # shapes that move with a surface have `gap_after`
            f"Scene.shapes[{number}]"
            for number, shape in enumerate(self.scene.shapes)
            if varies_across(shape) and not hasattr(shape, "gap_after")
        ]
        if standing and not still:
            sentences.append(
                f"The heights of {', '.join(standing)} stand still while both surfaces move: give MovingShape(...) for "
                "heights that a surface carries."
            )
        if still and motion.supply is not None:
            moving = "first" if motion.slide_roll_ratio > 0 else "second"
            sentences.append(
                f"The {moving} surface alone moves and brings lubricant: a layer of {readable(motion.supply / 2)}, half "
                "of Lubrication.supply."
            )
        return " ".join(sentences)

    @property
    def friction_reason(self) -> str:
        """Why the friction cannot be that of a lubricant; empty where it can.

        No lubricant is known to carry a shear stress above 10 MPa plus 0.15 of the pressure (Bair & Winer 1979, 1992).
        A :class:`~contactstudy.LimitingShear` names a limit of its own.
        """
        motion = self.scales.lubrication
        if isinstance(motion.lubricant.shear, LimitingShear):
            return ""
        stress = np.abs(self.shear)
        if self.contact_pressure is not None and motion.boundary is not None:
            stress = stress - motion.boundary.coefficient * self.contact_pressure
        limit = SHEAR_LIMIT + SHEAR_LIMIT_OVER_PRESSURE * self.lubricant_pressure
        total = np.abs(self.shear).sum()
        excess = np.clip(stress - limit, 0, None).sum()
        if excess <= FRICTION_BEYOND_LIMIT * total:
            return ""
        return (
            f"Friction has no bound: {100 * excess / total:.0f} % of it is shear stress above the largest known "
            f"limit of a lubricant, 10 MPa and {SHEAR_LIMIT_OVER_PRESSURE:g} of the pressure. "
            "Give Lubricant.shear a limit, such as LimitingShear(0.07)."
        )

    @property
    def spike_reason(self) -> str:
        """Why the peak pressure has no bound; empty where it has one.

        The mean over the length has a second peak at larger x than a valley, or the pressure falls so steeply between
        two cells that a spike may hide there.
        """
        mean = self.pressure.mean(axis=1)
        falls = np.maximum.accumulate(mean) - mean
        rises = np.maximum.accumulate(mean[::-1])[::-1] - mean
        is_second_peak = np.minimum(falls, rises).max() > SPIKE * mean.max()
        steepest = (self.pressure[:-1] - self.pressure[1:]).max()
        return OF_SPIKE if is_second_peak or steepest > STEEP_FALL * self.pressure.max() else ""

    @property
    def power_loss(self) -> float:
        """Power loss per length [W/m]: by sliding, of the film by rolling and squeeze, and in bodies that creep.

        That of the film is the work ``-int p (u_m dh/dx + dh/dt) dx`` of the lubricant's pressure p on the film
        thickness h at the mean speed u_m. It converges with few cells, where a sum of the dissipation under a spike
        does not.
        """
        squeeze = 0.0 if self.film_rate is None else -self._work(self.film_rate)
        return self.sliding_loss + self._film_force * self.mean_speed + squeeze + self.creep_loss

    @property
    def rolling_resistance(self) -> float:
        """Coefficient of rolling resistance: power loss by rolling, of film and bodies, over load and mean speed.

        Of an isothermal film in pure rolling it is the moment of the pressure over load and radius.
        """
        creep = self.creep_loss / self.mean_speed if self.mean_speed else 0.0
        return (self._film_force + creep) / self.load_per_length

    @property
    def _film_force(self) -> float:
        """Force [N/m] of the lubricant's pressure against rolling.

        With a heated inlet it is that of the isothermal film, times the factor by which heat makes the film thinner.
        """
        force = -self._work(np.gradient(self.film, self.grid.cell_size[0], axis=0))
        return force if self.temperatures is None else self.temperatures.reduction * force

    def _work(self, motion: Array) -> float:
        """Return the lubricant's pressure times a ``motion`` (x, y) of the film, summed across, mean over the length."""
        work = (self.lubricant_pressure * motion).mean(axis=1).sum()
        return float(work) * self.grid.cell_size[0]

    @property
    def sliding_loss(self) -> float:
        """Part of :attr:`power_loss` by sliding friction [W/m]; zero in pure rolling."""
        sheared = float(self.shear.sum()) * self.grid.cell_size[0] / self.grid.cells[1]
        return sheared * self.sliding_speed

    def thinner_than(self, film: float) -> tuple[float, float]:
        """Return the fractions of the area of Hertz's contact and of the load where the film is below ``film`` [m]."""
        thin = self.film < film
        hertz_area = 2 * self.scales.hertz.half_width * self.grid.length
        return (
            float(np.count_nonzero(thin) * self.grid.cell_area / hertz_area),
            float(self.pressure[thin].sum() / self.pressure.sum()),
        )


def varies_across(shape: object) -> bool:
    """Return whether a shape has heights with a wavelength across, by its length scales; False if it has none."""
    scales = getattr(shape, "length_scales", LengthScales())
    return scales.height > 0 and isfinite(scales.shortest_wavelengths[0])


def rise_beside_lowest(film: Array) -> float:
    """Return the relative rise of the film (x, y) from its lowest cell to the higher of its neighbours across."""
    row, column = np.unravel_index(np.argmin(film), film.shape)
    beside = film[max(row - 1, 0) : row + 2, column]
    return float(beside.max() / film[row, column] - 1)
