"""Friction of a film: shear stress by sliding, and in a heated film the temperatures of film and surfaces.

An isothermal film needs :class:`ShearedFilm` alone. The steps of a heated one:

1. Each surface moves at its speed u under the heat q that flows into it. Its flash temperature is a sum of moving line
   sources (Jaeger 1942), ``dT(x) = 1 / (pi k) int q(x') exp(z) K0(|z|) dx'`` with ``z = u (x - x') rho c / (2 k)``, the
   body's conductivity k and its heat capacity per volume, rho c.
2. Heat q, the shear stress times the slip, is generated uniformly over the thickness h. The film of conductivity k_f
   conducts ``q / 2 + k_f (T2 - T1) / h`` of it to the first surface, of the temperature rise T1, and the remainder to
   the second, of T2. This is the heat partition of Blok (1937) at each point. The mean rise over the thickness is
   ``(T1 + T2) / 2 + q h / (12 k_f)``.
3. The viscosity falls with that mean by the law of Roelands (1966), at first by the factor ``exp(-beta T)``, then less.
   With his law of pressure the logarithm of that factor grows by ``(1 + p / p0)^z``, threefold at 1 GPa. Newton's
   method makes stress and temperature consistent, line by line along the motion: conduction along the length is
   neglected.
4. The inlet is heated by its own shear, which makes the film that is sheared and conducts thinner by the factor of
   Gupta et al. (1992). That depends on the load ``p_H / E'``, the slide-roll ratio S and the thermal loading parameter
   ``L = beta eta0 u_m^2 / k_f``; a boundary film is the least. Beyond L = 10 friction and temperatures have no bound.
   A starved film is as thick as its supply, unless a flooded film with a heated inlet were thinner.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve, solve_banded, toeplitz
from scipy.special import k0e, k1e

from contactstudy.domain.grid import Array, Grid
from contactstudy.lubrication.film_equation import FilmScales
from contactstudy.scene.lubrication import FilmHeat, ThermalBody
from contactstudy.scene.solids.bodies import Body, Layered

# Least slip at which a stress is evaluated, over the sliding speed. Below it the stress is linear, for a slip may be
# zero or, between Newton's steps, negative.
LEAST_SLIP = 1e-9
# Slip below which asperities stick, over the sliding speed. Their friction grows linearly up to it, which makes the
# stress a continuous function of the slip. The friction of a mixed film is the same with 1e-7 and 1e-3.
STICK = 1e-6
# Relative step of the slip for the derivative of the stress, by which only the number of Newton's steps changes.
SLIP_STEP = 1e-5
# Largest number of Newton's steps, for the stress and for the temperature, after which the last values are taken; and
# the relative change of the stress where they stop.
MAX_STEPS, SHEAR_TOLERANCE = 100, 1e-7
# Largest logarithm of the viscosity over that at zero pressure that enters the friction: exp(300) is 1e130, and the
# product with a slip remains a number.
MAX_GROWTH = 300.0
# Largest thermal loading ``L = beta eta0 u_m^2 / k_f`` at which the formula of Gupta et al. (1992) gives the heating of
# the inlet. Largest residual of temperatures that count as converged. Here beta is the temperature coefficient of the
# viscosity eta0, u_m the mean speed, and k_f the thermal conductivity of the lubricant.
MAX_THERMAL_LOADING, TEMPERATURE_RESIDUAL = 10.0, 1e-6
# Relative residual of the temperature where Newton's steps stop, and the difference [K] for the derivative of the heat.
RISE_TOLERANCE, TEMPERATURE_STEP = 1e-9, 1e-3
# Most passes over temperatures and slip, the change of the slip over the sliding speed where they stop, and that above
# which Newton's method begins anew. With NEW_START from 0.003 to 0.3 friction and temperatures are the same.
MAX_PASSES, SLIP_TOLERANCE, NEW_START = 20, 1e-6, 0.01
# Newton's method leaves out a change of the heat with the temperature below this fraction of the largest, as in the
# inlet. Films at slide-roll ratios of 1 to 1.95 and rises of up to 320 K were the same to 1e-11.
NO_SLOPE = 3e-3
# Points in a cell, and widths of the grid in a period, for the waves of heat in a coating. With glass on steel the
# points leave out 4e-4 of the largest temperature rise, half as many 2e-3; half or twice the period change it by 3e-7.
FINE_CELLS, FINE_PERIODS = 16, 8


@dataclass(frozen=True, eq=False)
class ShearedFilm:
    """Fields (x,) or (x, y) of a film, from which its shear stress by sliding follows, by the lubricant's shear law.

    The ``scales`` have the speeds and the lubricant. ``pressure`` [Pa] is that of lubricant and asperities together, of
    which asperities carry ``contact`` [Pa]; they add their boundary friction. Only the fraction ``film_fraction`` of
    the gap ``film`` [m] that lubricant fills is sheared. ``cell`` is the size of a cell across [m].
    """

    scales: FilmScales
    cell: float
    pressure: Array
    film: Array
    film_fraction: Array
    contact: Array | None = None

    @property
    def sliding(self) -> float:
        """Size of the sliding speed of the surfaces [m/s]."""
        return abs(self.scales.mean_speed * self.scales.lubrication.slide_roll_ratio)

    @property
    def lubricant_pressure(self) -> Array:
        """Pressure [Pa] of the lubricant."""
        return self.pressure if self.contact is None else self.pressure - self.contact

    @cached_property
    def _unit_stress(self) -> Array:
        """Newtonian stress over the slip [Pa s/m]."""
        oil = self.scales.lubrication.lubricant
        growth = oil.law.log_ratio(self.lubricant_pressure, oil.pressure_viscosity)[0]
        # Barus' law leaves the range of numbers
        return np.asarray(oil.viscosity * np.exp(np.minimum(growth, MAX_GROWTH)) / self.film)

    def stress(self, slip: Array | float, viscosity_ratio: Array | float = 1.0) -> Array:
        """Return the size of the stress [Pa] where the surfaces move past each other by a ``slip`` [m/s], at least zero.

        ``viscosity_ratio`` is the viscosity over that at the temperature of the supply.
        """
        motion = self.scales.lubrication
        newtonian = viscosity_ratio * self._unit_stress * slip
        lubricant = self.film_fraction * motion.lubricant.shear.stress(newtonian, self.lubricant_pressure)
        if self.contact is None or motion.boundary is None:
            return np.asarray(lubricant)
        sticking = np.minimum(1, slip / (STICK * (self.sliding or 1.0)))  # without sliding there is no slip
        return np.asarray(lubricant + motion.boundary.coefficient * self.contact * sticking)

    def stress_and_slip(self, viscosity_ratio: Array | float = 1.0) -> tuple[Array, Array]:
        """Return stress [Pa] and slip [m/s], both at least zero, in series with the bodies' tangential compliance.

        Surfaces enter unsheared, and ``slip = du - u_m C dtau/dx`` (Johnson & Tevaarwerk 1977), with the sliding speed
        du, the mean speed u_m, the shear stress tau and the compliance C. With the half-width a, C is
        ``4 a / (pi E*)``, that of a Winkler foundation. On it bodies of the radius R that stick at the slide-roll ratio
        S have Carter's (1926) coefficient of friction, 2 S R / a.

        Newton's method converges from above, as the stress is a concave function of the slip; after `MAX_STEPS` its last
        values are returned.
        """
        hertz, sliding = self.scales.hertz, self.sliding
        if not sliding:
            return np.zeros_like(self.pressure), np.zeros_like(self.pressure)
        compliance = 4 * hertz.half_width / (np.pi * hertz.contact_modulus)
        rate = self.scales.mean_speed * compliance / self.cell
        # first guess: the bodies stick everywhere, so that the stress grows linearly from the inlet
        cells = np.arange(1, len(self.pressure) + 1).reshape(-1, *[1] * (self.pressure.ndim - 1))
        shear, least = sliding / rate * cells + 0 * self.pressure, LEAST_SLIP * sliding
        for _ in range(MAX_STEPS):
            slip = sliding - rate * np.diff(shear, axis=0, prepend=0)
            at = np.maximum(slip, least)
            stress = self.stress(at, viscosity_ratio)
            slope = (self.stress(at * (1 + SLIP_STEP), viscosity_ratio) - stress) / (SLIP_STEP * at)
            # linear below the least slip, also where it is below zero
            slope = np.where(slip > least, slope, stress / at)
            residual = shear - np.where(slip > least, stress, slope * slip)
            weight = rate * slope
            below = np.roll(-weight, -1, axis=0)
            below[-1] = 0
            # lines along x one after another; the last entry of each, 0, keeps them apart
            bands = np.stack([(1 + weight).T.ravel(), below.T.ravel()])
            change = solve_banded((1, 0), bands, -residual.T.ravel())
            change = change.reshape(shear.T.shape).T
            shear = shear + change
            if np.abs(change).max() <= SHEAR_TOLERANCE * np.abs(shear).max():
                break
        return shear, np.maximum(sliding - rate * np.diff(shear, axis=0, prepend=0), 0)


@dataclass(frozen=True, eq=False)
class FilmTemperatures:
    """Temperature rises [K] over the temperature of the lubricant's supply.

    ``surface`` (body, x, y) is that of the surfaces, ``film`` (x, y) the mean over the thickness. ``reduction`` is the
    film thickness with a heated inlet over that without, ``loading`` the thermal loading parameter of the inlet.
    ``residual`` is the relative difference between the temperatures and those by the heat that is generated at them.
    """

    surface: Array
    film: Array
    reduction: float
    loading: float
    residual: float

    @property
    def reason(self) -> str:
        """Why temperatures have no bound; empty where they can have one."""
        if self.residual > TEMPERATURE_RESIDUAL:
            return f"Heat and temperature of the film disagree by {100 * self.residual:.2g} %."
        if self.loading <= MAX_THERMAL_LOADING:
            return ""
        return (
            f"The inlet's thermal loading is {self.loading:.3g}: its heating is known up to {MAX_THERMAL_LOADING:g}. "
            "Give a lower Lubrication.mean_speed, or leave Lubrication.thermal out."
        )


def film_friction(
    sheared: ShearedFilm, solids: tuple[Body, Body], grid: Grid, supply: float
) -> tuple[Array, FilmTemperatures | None]:
    """Return the size of the shear stress (x, y) [Pa] of a film, and its temperatures; None if it is isothermal.

    The ``supply`` [m] is the layer that a starved film is as thick as, infinite for a flooded one.
    """
    scales, motion = sheared.scales, sheared.scales.lubrication
    if (heat := motion.thermal) is None:
        return sheared.stress_and_slip()[0], None
    influence = [
        moving_source(
            grid,
            body,
            scales.mean_speed * (1 + side * motion.slide_roll_ratio / 2),
            solid.thickness if isinstance(solid, Layered) else 0.0,
        )
        for side, body, solid in zip((1, -1), heat.bodies, solids, strict=True)
    ]
    reduction, loading = thermal_reduction(scales, heat, supply), thermal_loading(scales, heat)
    heated = np.maximum(reduction * sheared.film, 0.0 if motion.boundary is None else motion.boundary.film)
    columns = []
    for column in range(grid.cells[1]):
        contact = None if sheared.contact is None else sheared.contact[:, column]
        pressure, fraction = sheared.pressure[:, column], sheared.film_fraction[:, column]
        line = ShearedFilm(scales, sheared.cell, pressure, heated[:, column], fraction, contact)
        columns.append(_HeatedLine(line, heat, *influence).solved())
    shear, surface, film, residuals = zip(*columns, strict=True)
    temperatures = FilmTemperatures(
        np.stack(surface, axis=2), np.stack(film, axis=1), reduction, loading, max(residuals)
    )
    return np.stack(shear, axis=1), temperatures


@dataclass(frozen=True, eq=False)
class _HeatedLine:
    """Line along the motion of a film that is heated by its shear.

    ``sheared`` has fields (x,); ``first`` and ``second`` (x, x') are the temperature rises of both surfaces at x by a
    unit heat flux into them at x' [K m^2/W].
    """

    sheared: ShearedFilm
    heat: FilmHeat
    first: Array
    second: Array

    @cached_property
    def conductance(self) -> Array:
        """Heat flux (x,) that the film conducts from surface to surface over their difference, ``k_f / h``."""
        return np.asarray(self.heat.conductivity / self.sheared.film)

    @cached_property
    def conducted(self) -> tuple[Array, Array]:
        """LU factors of the system for ``T1 - T2``, with the heat that the film conducts to the colder surface."""
        factors, pivots = lu_factor(np.eye(len(self.first)) + (self.first + self.second) * self.conductance)
        return factors, pivots

    def of_surfaces(self, generated: Array) -> Array:
        """Return the temperature rises (2, x) [K] of both surfaces by the heat (x,) [W/m^2] generated in the film."""
        half = generated / 2
        exchanged = self.conductance * lu_solve(self.conducted, (self.first - self.second) @ half)
        return np.stack((self.first @ (half - exchanged), self.second @ (half + exchanged)))

    def of_film(self, generated: Array) -> Array:
        """Return the mean temperature rise (x,) [K] over the thickness by the heat (x,) [W/m^2]."""
        return np.asarray(self.of_surfaces(generated).mean(axis=0) + generated / (12 * self.conductance))

    @cached_property
    def active(self) -> NDArray[np.intp]:
        """Cells in which the heat changes with the temperature."""
        slope = np.abs(self.generated_slope(np.full(len(self.first), self.sheared.sliding), np.zeros(len(self.first))))
        return np.flatnonzero(slope > NO_SLOPE * slope.max())

    @cached_property
    def columns(self) -> Array:
        """Temperature rise (x, cell) of the film by unit heat in each of the `active` cells."""
        opposed, active = self.first - self.second, self.active
        exchanged = self.conductance[:, None] * lu_solve(self.conducted, opposed[:, active])
        columns = (self.first[:, active] + self.second[:, active] - opposed @ exchanged) / 4
        columns[active, range(len(active))] += 1 / (12 * self.conductance[active])
        return np.asarray(columns)

    def viscosity_ratio(self, rise: Array) -> Array:
        """Return ``eta(T) / eta``, the viscosity (x,) at a rise (x,) [K] over that at the supply's temperature."""
        oil = self.sheared.scales.lubrication.lubricant
        factor = oil.law.temperature_factor(self.sheared.lubricant_pressure)
        return np.asarray(np.exp(factor * self.heat.thinning(rise, oil.viscosity)))

    def generated(self, slip: Array, rise: Array) -> Array:
        """Return the heat (x,) [W/m^2] of a film that slips [m/s] at a temperature rise (x,) [K]."""
        return np.asarray(slip * self.sheared.stress(slip, self.viscosity_ratio(rise)))

    def generated_slope(self, slip: Array, rise: Array) -> Array:
        """Return the derivative (x,) of the generated heat by the temperature rise."""
        return (self.generated(slip, rise + TEMPERATURE_STEP) - self.generated(slip, rise)) / TEMPERATURE_STEP

    def temperature(self, slip: Array, rise: Array) -> tuple[Array, float]:
        """Return the temperature rise (x,) [K] consistent with the heat at a slip [m/s], and the relative residual.

        Newton's method from a ``rise`` of zero converges from below, as the heat is a convex function of it.
        """
        for _ in range(MAX_STEPS):
            residuals = self.of_film(self.generated(slip, rise)) - rise
            sloping = self.columns * self.generated_slope(slip, rise)[self.active]
            system = np.eye(len(self.active)) - sloping[self.active]
            rise = rise + residuals + sloping @ np.linalg.solve(system, residuals[self.active])
            largest = float(np.abs(rise).max())
            if float(np.abs(residuals).max()) <= RISE_TOLERANCE * largest:
                break
        residual = float(np.abs(self.of_film(self.generated(slip, rise)) - rise).max())
        return rise, residual / largest if largest else 0.0

    def solved(self) -> tuple[Array, Array, Array, float]:
        """Return stress (x,) [Pa], temperature rises of surfaces (2, x) and film (x,) [K], and the relative residual.

        Temperature and slip are iterated until both hold.
        """
        rise: Array = np.zeros(len(self.first))
        change = 0.0
        slip: Array = np.full(len(self.first), self.sheared.sliding)
        for _ in range(MAX_PASSES):
            if change > NEW_START:  # Newton's method converges from below
                rise = np.zeros_like(rise)
            rise, residual = self.temperature(slip, rise)
            stress, new_slip = self.sheared.stress_and_slip(self.viscosity_ratio(rise))
            change = float(np.abs(new_slip - slip).max()) / (self.sheared.sliding or 1.0)
            slip = new_slip
            if change <= SLIP_TOLERANCE:
                break
        return stress, self.of_surfaces(slip * stress), rise, max(residual, change)


def thermal_loading(scales: FilmScales, heat: FilmHeat) -> float:
    """Return the thermal loading parameter ``L = beta eta0 u_m^2 / k_f`` of the inlet, with the mean speed u_m.

    Source: Gupta et al. (1992). A heated film is steady, so that its largest mean speed is the mean speed.
    """
    motion = scales.lubrication
    power = motion.lubricant.viscosity * motion.largest_speed**2
    return float(heat.temperature_viscosity * power / heat.conductivity)


def thermal_reduction(scales: FilmScales, heat: FilmHeat, supply: float = inf) -> float:
    """Return the film thickness with a heated inlet over that of an isothermal inlet, by Gupta et al. (1992).

    An approximation. Its factor of the load, ``1 - 13.2 p_H / E' L^0.42``, is at least 0.1 here: up to L = 10 it is
    above that for ``p_H`` below 0.025 E', 5.7 GPa of steel. Zhou & Hoeprich (1991), eq. 21, and Arana et al.
    (2019), eq. 24, give the same coefficients. A starved film is as thick as its ``supply`` [m], unless the flooded
    film by Moes with a heated inlet is thinner; the supply is infinite for a flooded film.
    """
    loading = thermal_loading(scales, heat)
    load = scales.hertz.half_width / (4 * scales.hertz.radius)  # p_H / E'
    slide = abs(scales.lubrication.slide_roll_ratio)
    heating = 0.213 * (1 + 2.23 * slide**0.83) * loading**0.64
    reduction = float(max(1 - 13.2 * load * loading**0.42, 0.1) / (1 + heating))
    if supply == inf:
        return reduction
    return min(1.0, reduction * max(1.0, scales.expected_film * scales.film / supply))


def moving_source(grid: Grid, body: ThermalBody, speed: float, thickness: float = 0.0) -> Array:
    """Return the temperature rise (x, x') [K] at x by a unit heat flux [W/m^2] into the cell at x'.

    The surface moves at ``speed`` [m/s], not 0, towards larger x. A coating has a ``thickness`` [m].
    """
    nx, cell = grid.cells[0], grid.cell_size[0]
    rate = speed * body.heat_capacity / (2 * body.conductivity)
    edges = (np.arange(-nx, nx) + 0.5) * cell
    between = np.diff(_source_integral(rate * edges)) / (np.pi * body.conductivity * rate)
    if body.coating is not None:
        between += _of_coating(grid, body, body.coating, speed, thickness)
    return np.asarray(toeplitz(between[nx - 1 :], between[nx - 1 :: -1]))


def _of_coating(grid: Grid, body: ThermalBody, coating: ThermalBody, speed: float, thickness: float) -> Array:
    """Return what a coating adds to the temperature rise (2 nx - 1,) [K] of a substrate around a unit heat flux.

    In each wave along x heat is conducted as ``exp(-m z)``, ``m^2 = w^2 + i w u rho c / k``, through coating and
    substrate, with flux and temperature continuous between them (Carslaw & Jaeger 1959).
    """
    (nx, _), (cell, _) = grid.cells, grid.cell_size
    fine = FINE_CELLS * FINE_PERIODS * nx
    # the rise times exp(-shift x), so that what the period wraps is small. The mean has m^2 = shift (rate - shift) > 0,
    # since shift is at most a quarter of the slowest rate. A half or an eighth changes the result by 2e-5
    slowest = min(abs(speed) * material.heat_capacity / material.conductivity for material in (body, coating))
    shift = np.sign(speed) * min(1 / (nx * cell), slowest / 4)
    wave = 2 * np.pi * np.fft.rfftfreq(fine, cell / FINE_CELLS) - 1j * shift

    def admittance(material: ThermalBody) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the decay ``m`` [1/m] of each wave in a material, and its flux over its rise, ``k m`` [W/(m^2 K)]."""
        rate = speed * material.heat_capacity / material.conductivity
        decay = np.sqrt(wave**2 + 1j * wave * rate)
        return decay, material.conductivity * decay

    (decay, of_coating), (_, of_body) = admittance(coating), admittance(body)
    reflected = (of_coating - of_body) / (of_coating + of_body) * np.exp(-2 * decay * thickness)
    added = (1 + reflected) / (1 - reflected) / of_coating - 1 / of_body
    # of a unit flux over a cell, which has FINE_CELLS points
    added *= np.sinc(wave * cell / (2 * np.pi)) * FINE_CELLS
    rise = np.roll(np.fft.irfft(added, fine)[::FINE_CELLS], nx - 1)[: 2 * nx - 1]
    return np.asarray(rise * np.exp(shift * cell * np.arange(1 - nx, nx)))


def _source_integral(distance: Array) -> Array:
    """Return ``int_0^z exp(t) K0(|t|) dt`` in closed form."""
    size = np.abs(distance)
    downstream = size * (k0e(size) + k1e(size)) - 1
    # exp(-s) K0(s) = exp(-2 s) k0e(s)
    upstream = 1 + size * np.exp(-2 * size) * (k0e(size) - k1e(size))
    return np.asarray(np.where(distance > 0, downstream, -upstream))
