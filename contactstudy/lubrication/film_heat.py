"""Temperatures of a sheared film and of its surfaces, and the friction at these temperatures.

1. Each surface moves under the heat that flows into it. Its flash temperature is a sum of moving line sources
   (Jaeger 1942), ``dT(x) = 1 / (pi k) int q(x') exp(z) K0(|z|) dx'`` with ``z = u (x - x') rho c / (2 k)``.
2. Heat ``q = tau du`` is generated uniformly over the thickness, and the film conducts it across: it gives
   ``q / 2 + k_f (T2 - T1) / h`` to the first surface and the remainder to the second. This is the heat partition of Blok
   (1937) at each point. The mean over the thickness is ``(T1 + T2) / 2 + q h / (12 k_f)``.
3. The viscosity falls with that mean by the law of Roelands (1966), at first by the factor ``exp(-beta T)``, then less.
   With his law of pressure the logarithm of that factor grows by ``(1 + p / p0)^z``, threefold at 1 GPa. Newton's method
   makes stress and temperature consistent, line by line along the motion: conduction along the length is neglected.
4. The inlet is heated by its own shear. The film that is sheared and conducts is thinner by the factor of Gupta et al.
   (1992), of the load ``p_H / E'``, the slide-roll ratio S and the thermal loading parameter
   ``L = beta eta0 u_m^2 / k_f``, but no thinner than a boundary film. Beyond L = 10 friction and temperatures
   have no bound. A starved film is as thick as its supply, unless a flooded film with a heated inlet were thinner.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import toeplitz
from scipy.special import k0e, k1e

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.lubrication.film_equation import FilmScales
from contactstudy.lubrication.lubricated_contact import (
    FilmTemperatures,
    shear_stress,
)
from contactstudy.scene.lubrication.film_heat import FilmHeat, ThermalBody

# Newton's steps at most; relative residual where they stop; difference [K] for the derivative of the heat.
MAX_STEPS, TOLERANCE, TEMPERATURE_STEP = 100, 1e-9, 1e-3


def thermal_shear(
    scales: FilmScales,
    grid: Grid,
    mean_speed: float,
    pressure: Array,
    film: Array,
    film_fraction: Array,
    contact: Array | None,
    reduction: float,
) -> tuple[Array, FilmTemperatures]:
    """Return the shear stress (x, y) [Pa] of a heated film, and its temperatures.

    Fields are those of :func:`~contactstudy.lubrication.lubricated_contact.shear_stress`. The film is thinner by the
    factor ``reduction``.
    """
    motion = scales.lubrication
    heat = motion.thermal
    assert heat is not None
    ratio = motion.slide_roll_ratio
    sliding = abs(mean_speed * ratio)
    influence = [
        moving_source(grid, body, mean_speed * (1 + side * ratio / 2))
        for side, body in ((1, heat.first), (-1, heat.second))
    ]
    shear, surface = np.zeros_like(pressure), np.zeros((2, *pressure.shape))
    mean, largest_residual = np.zeros_like(pressure), 0.0
    boundary = 0.0 if motion.boundary is None else motion.boundary.film
    for column in range(pressure.shape[1]):
        heated = np.maximum(reduction * film[:, column], boundary)
        line = _Line(
            scales,
            mean_speed,
            pressure[:, column],
            heated,
            film_fraction[:, column],
            None if contact is None else contact[:, column],
        )
        surfaces, of_film = _temperature_influence(influence, heat.conductivity / heated)
        mean[:, column], residual = _solve_temperature(of_film, sliding, line)
        shear[:, column] = line.stress(mean[:, column])
        largest_residual = max(largest_residual, residual)
        surface[:, :, column] = surfaces @ (sliding * np.abs(shear[:, column]))
    loading = thermal_loading(scales, heat)
    return shear, FilmTemperatures(surface, mean, reduction, loading, largest_residual)


class _Line(NamedTuple):
    """Fields (x,) of a line along the motion, from which its shear stress follows."""

    scales: FilmScales
    mean_speed: float
    pressure: Array
    film: Array
    film_fraction: Array
    contact: Array | None

    def stress(self, rise: Array) -> Array:
        """Return the shear stress (x,) [Pa] at a temperature rise (x,) [K]."""
        motion = self.scales.lubrication
        assert motion.thermal is not None
        pressure = self.pressure if self.contact is None else self.pressure - self.contact
        factor = motion.lubricant.law.temperature_factor(pressure)
        thinning = motion.thermal.thinning(rise, motion.lubricant.viscosity)
        return shear_stress(*self, np.exp(factor * thinning))


def thermal_loading(scales: FilmScales, heat: FilmHeat) -> float:
    """Return the thermal loading parameter ``L = beta eta0 u_m^2 / k_f`` of the inlet."""
    motion = scales.lubrication
    power = motion.lubricant.viscosity * motion.largest_speed**2
    return float(heat.temperature_viscosity * power / heat.conductivity)


def thermal_reduction(scales: FilmScales, heat: FilmHeat, *, starved: bool = False) -> float:
    """Return the film thickness with a heated inlet over that of an isothermal inlet, by Gupta et al. (1992).

    An approximation, whose factor of the load is at least 0.1 here. Zhou & Hoeprich (1991), eq. 21, and Arana et al.
    (2019), eq. 24, give the same coefficients. A ``starved`` film is thinned down to the flooded one of Moes alone.
    """
    loading = thermal_loading(scales, heat)
    load = scales.hertz.half_width / (4 * scales.hertz.radius)  # p_H / E'
    slide = abs(scales.lubrication.slide_roll_ratio)
    heating = 0.213 * (1 + 2.23 * slide**0.83) * loading**0.64
    reduction = float(max(1 - 13.2 * load * loading**0.42, 0.1) / (1 + heating))
    supply = scales.lubrication.supply
    if not starved or supply is None:
        return reduction
    return min(1.0, reduction * max(1.0, scales.expected_film * scales.film / supply))


def moving_source(grid: Grid, body: ThermalBody, speed: float) -> Array:
    """Return the temperature rise (x, x') [K] at x by a unit heat flux [W/m^2] into the cell at x'.

    The surface moves at ``speed`` [m/s] towards larger x.
    """
    nx, cell = grid.cells[0], grid.cell_size[0]
    rate = speed * body.heat_capacity / (2 * body.conductivity)
    edges = (np.arange(-nx, nx) + 0.5) * cell
    between = np.diff(_source_integral(rate * edges)) / (np.pi * body.conductivity * rate)
    return np.asarray(toeplitz(between[nx - 1 :], between[nx - 1 :: -1]))


def _source_integral(distance: Array) -> Array:
    """Return ``int_0^z exp(t) K0(|t|) dt`` in closed form."""
    size = np.abs(distance)
    downstream = size * (k0e(size) + k1e(size)) - 1
    # exp(-s) K0(s) = exp(-2 s) k0e(s)
    upstream = 1 + size * np.exp(-2 * size) * (k0e(size) - k1e(size))
    return np.asarray(np.where(distance > 0, downstream, -upstream))


def _temperature_influence(influence: list[Array], conductance: Array) -> tuple[Array, Array]:
    """Return the temperature rises of both surfaces (2, x, x') and of the film (x, x') by unit heat in the film at x'.

    ``influence`` are those of both surfaces by heat into them, ``conductance`` (x,) is ``k_f / h``.
    """
    first, second = influence
    n = len(conductance)
    # T1 - T2, with the heat that the film conducts from the warmer surface to the other
    conducted = np.eye(n) + (first + second) * conductance
    difference = np.linalg.solve(conducted, (first - second) / 2)
    exchanged = conductance[:, None] * difference
    half = np.eye(n) / 2
    surfaces = np.stack((first @ (half - exchanged), second @ (half + exchanged)))
    return surfaces, surfaces.mean(axis=0) + np.diag(1 / (12 * conductance))


def _solve_temperature(of_film: Array, sliding: float, line: _Line) -> tuple[Array, float]:
    """Return the temperature rise (x,) [K] of a film that slides [m/s], consistent with its heat, and the residual.

    The residual is relative. Newton's method from no rise converges from below, as the heat is a convex function of it.
    """
    rise = np.zeros(len(of_film))

    def heat(rise: Array) -> Array:
        return sliding * np.abs(line.stress(rise))

    for _ in range(MAX_STEPS):
        made = heat(rise)
        residuals = of_film @ made - rise
        slope = (heat(rise + TEMPERATURE_STEP) - made) / TEMPERATURE_STEP
        rise = rise + np.linalg.solve(np.eye(len(rise)) - of_film * slope, residuals)
        largest = float(np.abs(rise).max())
        if float(np.abs(residuals).max()) <= TOLERANCE * largest:
            break
    residual = float(np.abs(of_film @ heat(rise) - rise).max())
    return rise, residual / largest if largest else 0.0
