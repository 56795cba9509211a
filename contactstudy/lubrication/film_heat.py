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

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve, toeplitz
from scipy.special import k0e, k1e

from contactstudy.domain.grid import Array, Grid
from contactstudy.lubrication.film_equation import FilmScales
from contactstudy.lubrication.lubricated_contact import FilmTemperatures, ShearedFilm
from contactstudy.scene.lubrication import FilmHeat, ThermalBody
from contactstudy.scene.solids.bodies import Body, Layered

Waves = NDArray[np.complex128]
# Temperature rises by heat (x,).
Rises = Callable[[Array], Array]
# Newton's steps at most; relative residual where they stop; difference [K] for the derivative of the heat.
MAX_STEPS, TOLERANCE, TEMPERATURE_STEP = 100, 1e-9, 1e-3
# Passes over temperatures and slip at most, the change of the slip over the sliding speed where they stop, and that
# above which Newton's method begins anew.
MAX_PASSES, SLIP_TOLERANCE, NEW_START = 20, 1e-6, 0.01
# Change of the heat with the temperature over the largest, up to which Newton's method leaves it out, as in the inlet:
# films at slide-roll ratios of 1 to 1.95 and rises of up to 320 K were the same to 1e-11.
NO_SLOPE = 3e-3
# Points in a cell, and widths of the grid, for the waves of heat in a coating.
FINE_CELLS, FINE_PERIODS = 16, 8


def thermal_shear(
    sheared: ShearedFilm, solids: tuple[Body, Body], grid: Grid, reduction: float
) -> tuple[Array, FilmTemperatures]:
    """Return the size of the shear stress (x, y) [Pa] of a heated film, and its temperatures.

    The film is thinner by the factor ``reduction``.
    """
    scales = sheared.scales
    motion = scales.lubrication
    heat = motion.thermal
    assert heat is not None
    influence = [
        moving_source(
            grid,
            body,
            scales.mean_speed * (1 + side * motion.slide_roll_ratio / 2),
            solid.thickness if isinstance(solid, Layered) else 0.0,
        )
        for side, body, solid in zip((1, -1), heat.bodies, solids, strict=True)
    ]
    pressure, contact = sheared.pressure, sheared.contact
    shear, surface = np.zeros_like(pressure), np.zeros((2, *pressure.shape))
    mean, largest_residual = np.zeros_like(pressure), 0.0
    boundary = 0.0 if motion.boundary is None else motion.boundary.film
    for column in range(pressure.shape[1]):
        heated = np.maximum(reduction * sheared.film[:, column], boundary)
        line = replace(
            sheared,
            pressure=pressure[:, column],
            film=heated,
            film_fraction=sheared.film_fraction[:, column],
            contact=None if contact is None else contact[:, column],
        )
        of_surfaces, of_film, active, columns = _temperature_influence(influence, heat.conductivity / heated, line)
        mean[:, column], shear[:, column], slip, residual = _heated_line(of_film, active, columns, line)
        largest_residual = max(largest_residual, residual)
        surface[:, :, column] = of_surfaces(slip * shear[:, column])
    loading = thermal_loading(scales, heat)
    return shear, FilmTemperatures(surface, mean, reduction, loading, largest_residual)


def _heated_line(
    of_film: Rises, active: NDArray[np.intp], columns: Array, line: ShearedFilm
) -> tuple[Array, Array, Array, float]:
    """Return temperature rise [K], stress [Pa] and slip [m/s] (x,) of a line of the film, and the relative residual.

    Temperature and slip are iterated until both hold. The rest is as for :func:`_solve_temperature`.
    """
    rise: Array = np.zeros(len(line.film))
    slip: Array = np.full(len(line.film), line.sliding)
    change = 0.0
    for _ in range(MAX_PASSES):
        if change > NEW_START:  # Newton's method converges from below
            rise = np.zeros_like(rise)
        rise, residual = _solve_temperature(of_film, active, columns, line, slip, rise)
        stress, new_slip = line.stress_and_slip(_viscosity_ratio(line, rise))
        change = float(np.abs(new_slip - slip).max()) / (line.sliding or 1.0)
        slip = new_slip
        if change <= SLIP_TOLERANCE:
            break
    return rise, stress, slip, max(residual, change)


def _viscosity_ratio(line: ShearedFilm, rise: Array) -> Array:
    """Return ``eta(T) / eta``, the viscosity (x,) at a rise (x,) [K] over that at the supply's temperature."""
    oil, heat = line.scales.lubrication.lubricant, line.scales.lubrication.thermal
    assert heat is not None
    factor = oil.law.temperature_factor(line.lubricant_pressure)
    return np.asarray(np.exp(factor * heat.thinning(rise, oil.viscosity)))


def thermal_loading(scales: FilmScales, heat: FilmHeat) -> float:
    """Return the thermal loading parameter ``L = beta eta0 u_m^2 / k_f`` of the inlet, with the mean speed u_m.

    Source: Gupta et al. (1992). A heated film is steady, so that its largest mean speed is the mean speed.
    """
    motion = scales.lubrication
    power = motion.lubricant.viscosity * motion.largest_speed**2
    return float(heat.temperature_viscosity * power / heat.conductivity)


def thermal_reduction(scales: FilmScales, heat: FilmHeat, *, starved: bool = False) -> float:
    """Return the film thickness with a heated inlet over that of an isothermal inlet, by Gupta et al. (1992).

    An approximation, whose factor of the load is at least 0.1 here. Zhou & Hoeprich (1991), eq. 21, and Arana et al.
    (2019), eq. 24, give the same coefficients. A ``starved`` film is as thick as its supply, unless
    the flooded film by Moes with a heated inlet is thinner.
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
    # the rise times exp(-shift x), so that what the period wraps is small; the mean has m^2 = shift (rate - shift) > 0
    slowest = min(abs(speed) * material.heat_capacity / material.conductivity for material in (body, coating))
    shift = np.sign(speed) * min(1 / (nx * cell), slowest / 4)
    wave = 2 * np.pi * np.fft.rfftfreq(fine, cell / FINE_CELLS) - 1j * shift

    def admittance(material: ThermalBody) -> tuple[Waves, Waves]:
        rate = speed * material.heat_capacity / material.conductivity
        decay: Waves = np.sqrt(wave**2 + 1j * wave * rate)
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


def _temperature_influence(
    influence: list[Array], conductance: Array, line: ShearedFilm
) -> tuple[Rises, Rises, NDArray[np.intp], Array]:
    """Return how temperatures rise by the heat in a film, for :func:`_solve_temperature`.

    These are functions of the heat (x,) that give the rises of both surfaces (2, x) and of the film (x,), the cells in
    which the heat changes with the temperature, and the rise (x, cell) of the film by unit heat in each of them.
    ``influence`` are those of both surfaces by heat into them, ``conductance`` (x,) is ``k_f / h``.
    """
    first, second = influence
    opposed, no_rise = first - second, np.zeros(len(conductance))
    # T1 - T2, with the heat that the film conducts from the warmer surface to the other
    conducted = lu_factor(np.eye(len(conductance)) + (first + second) * conductance)

    def of_surfaces(made: Array) -> Array:
        half = made / 2
        exchanged = conductance * lu_solve(conducted, opposed @ half)
        return np.stack((first @ (half - exchanged), second @ (half + exchanged)))

    def of_film(made: Array) -> Array:
        return np.asarray(of_surfaces(made).mean(axis=0) + made / (12 * conductance))

    slope = np.abs(_heat_slope(line, np.full(len(conductance), line.sliding), no_rise))
    active = np.flatnonzero(slope > NO_SLOPE * slope.max())
    exchanged = conductance[:, None] * lu_solve(conducted, opposed[:, active])
    columns = (first[:, active] + second[:, active] - opposed @ exchanged) / 4
    columns[active, range(len(active))] += 1 / (12 * conductance[active])
    return of_surfaces, of_film, active, columns


def _heat(line: ShearedFilm, slip: Array, rise: Array) -> Array:
    """Return the heat (x,) [W/m^2] of a film that slips [m/s] at a temperature rise (x,) [K]."""
    return np.asarray(slip * line.stress(slip, _viscosity_ratio(line, rise)))


def _heat_slope(line: ShearedFilm, slip: Array, rise: Array) -> Array:
    """Return the derivative (x,) of that heat by the temperature rise."""
    return (_heat(line, slip, rise + TEMPERATURE_STEP) - _heat(line, slip, rise)) / TEMPERATURE_STEP


def _solve_temperature(
    of_film: Rises, active: NDArray[np.intp], columns: Array, line: ShearedFilm, slip: Array, rise: Array
) -> tuple[Array, float]:
    """Return the temperature rise (x,) [K] of a film that slips [m/s], consistent with its heat, and the residual.

    The residual is relative. Newton's method from no rise converges from below, as the heat is a convex function of it.
    Its matrix has the ``columns`` of ``of_film``, the rise by heat, in the ``active`` cells.
    """
    for _ in range(MAX_STEPS):
        residuals = of_film(_heat(line, slip, rise)) - rise
        sloping = columns * _heat_slope(line, slip, rise)[active]
        change = np.linalg.solve(np.eye(len(active)) - sloping[active], residuals[active])
        rise = rise + residuals + sloping @ change
        largest = float(np.abs(rise).max())
        if float(np.abs(residuals).max()) <= TOLERANCE * largest:
            break
    residual = float(np.abs(of_film(_heat(line, slip, rise)) - rise).max())
    return rise, residual / largest if largest else 0.0
