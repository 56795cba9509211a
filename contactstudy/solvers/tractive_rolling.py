"""Steady rolling with creepage: tangential traction, stick and slip, their power, and the creepage of a given force.

The contact moves to larger x, material enters it at the largest x. Under the traction q on the first body its surface is
displaced by ``A q`` against the second one. The slip of the first against the second body, per distance rolled, is

    ``s = -c + D q``,  ``(D q)(x) = [(A q)(x) - (A q)(x + dx)] / dx``,  ``c = (xi - phi y, eta + phi x)``,

with the creepages xi and eta of the second against the first body and the spin phi. Coulomb's law is ``|q| <= mu p``,
``s = 0`` where the inequality is strict, and else ``q = -mu p s / |s|``. A is self-adjoint and positive definite, and so
is the symmetric part of D: a monotone variational inequality, whose solution is unique. It is solved on coarser
grids first, each by :class:`~contactstudy.solvers.coulomb.CoulombNewton`.

Source: Carter (1926), Proc. R. Soc. A 112, 151; Kalker (1990), ch. 4.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.device import Device
from contactstudy.domain.grid import Array, Grid, on_cells
from contactstudy.elasticity.convolution import GeneralConvolution
from contactstudy.elasticity.tangential import ShearResponse
from contactstudy.problem.problem import Problem
from contactstudy.solvers.coulomb import CoulombNewton, ElasticSlip, shear_status
from contactstudy.solvers.fretting import transmission_status
from contactstudy.solvers.solution import (
    UNKNOWN,
    Creepage,
    RollingErrors,
    RollingTraction,
    Solution,
    TangentialTraction,
    with_traction,
)
from contactstudy.solvers.solve import SolveOptions, solve_contact, solve_with_mixing

# Fewest cells along an axis of a coarser grid.
COARSEST = 8
# Least relative refinement that the change between two grids is divided by: that between nearly equal ones vanishes by
# chance.
LEAST_REFINEMENT = 0.5
# Residual on coarser grids, whose own error is larger.
LEVEL_TOLERANCE = 1e-3
# Outer iterations between pressure and tangential traction of elastically dissimilar bodies.
MAX_COUPLED_ITERATIONS = 60
# Distance [cells] within which the stick-slip boundary is found: errors were at most 0.96 of the bound in 600 line
# contacts of 28 to 90 cells, a third of them near full sliding and a third near full stick.
STICK_SLIP_BOUNDARY_CELLS = 0.4


@dataclass(frozen=True, eq=False)
class ShearPressureCoupling:
    """Normal displacement by tangential traction along both axes [m/Pa], odd in x or y.

    By reciprocity the tangential displacement by pressure is minus this.
    """

    longitudinal: GeneralConvolution
    lateral: GeneralConvolution

    def gap(self, shear: Array) -> Array:
        """Return the change of the gap (x, y) [m] by `shear` (component, x, y) [Pa]."""
        return self.longitudinal(shear[0]) + self.lateral(shear[1])

    def displacement(self, pressure: Array) -> Array:
        """Return the tangential displacement (component, x, y) [m] under `pressure` (x, y) [Pa]."""
        return -np.stack([self.longitudinal(pressure), self.lateral(pressure)])


def ahead(field: Array, step: float) -> Array:
    """Return the values of a `field` (component, x, y) one cell ahead, zero beyond the leading edge."""
    shifted = np.zeros_like(field)
    if step > 0:
        shifted[:, :-1] = field[:, 1:]
    else:
        shifted[:, 1:] = field[:, :-1]
    return shifted


@dataclass(frozen=True, eq=False)
class TractiveShear:
    """Tangential traction of steady rolling, added to the pressure of a frictionless contact.

    Parameters
    ----------
    coefficient
        Coefficient of friction mu.
    creepage
        Creepage and spin; the longitudinal creepage is found if `force_per_length` is given.
    force_per_length
        Tangential force along x [N/m], less than friction transmits, or None.
    speed
        Speed of rolling [m/s], negative to smaller x.
    shear_response
        Function that returns the response to traction on a grid.
    coupling
        Of pressure and traction; None for elastically similar bodies (Dundurs' beta = 0).
    note
        Sentence on the scene, or empty.
    """

    coefficient: float
    creepage: Creepage
    force_per_length: float | None
    speed: float
    shear_response: Callable[[Grid], ShearResponse]
    coupling: ShearPressureCoupling | None
    note: str = ""

    def solve(self, problem: Problem, options: SolveOptions, start: Array | None, device: Device) -> Solution:
        """Return the normal contact with its traction; for dissimilar bodies, iterated until neither changes."""
        state: SteadyShear | None = None
        applications, convolutions = 0, 0.0

        def gap_change(pressure: Array) -> Array:
            """Return the change of the gap by the tangential traction that belongs to a pressure."""
            nonlocal state, applications, convolutions
            state = self.steady(problem.grid, pressure, options, state)
            applications += state.applications
            convolutions += state.convolutions
            if self.coupling is None:
                return np.zeros_like(pressure)
            convolutions += 2
            return self.coupling.gap(state.shear)

        if self.coupling is not None:
            lagged = solve_with_mixing(problem, gap_change, options, start, device, MAX_COUPLED_ITERATIONS)
            normal = lagged.of(problem)
        else:
            normal = solve_contact(problem, options, start, device)
            if normal.pressure.any():
                gap_change(normal.pressure)
        if state is None:
            zeros = np.zeros((2, *normal.pressure.shape))
            stick = np.zeros(normal.pressure.shape, dtype=bool)
            traction = TangentialTraction(zeros, stick, "tractive rolling", 0)
            acts = transmission_status(self.force_per_length or 0.0, normal.pressure, problem.grid)
            return with_traction(normal, acts, 0.0, 0, 0.0, traction)
        status = shear_status(state.residual, state.applications, options.tolerance, options.max_iterations)
        normal = replace(normal, note=f"{normal.note} {self.note}".strip())
        rolling = self._traction(problem.grid, normal.pressure, state)
        return with_traction(normal, status, state.residual, applications, convolutions, rolling)

    def _traction(self, grid: Grid, pressure: Array, state: "SteadyShear") -> RollingTraction:
        """Return the traction of a steady state with its power."""
        power = self._power(grid, state)
        total = float(power.sum())
        return RollingTraction(
            shear=state.shear,
            stick=state.stick,
            method="tractive rolling, Newton",
            iterations=state.applications,
            slip=state.slip,
            creepage=state.creepage,
            power=power,
            power_outside_contact=float(power[pressure == 0].sum()) / total if total else 0.0,
            errors=state.errors,
            creepage_given=self.force_per_length is None,
        )

    def _power(self, grid: Grid, state: "SteadyShear") -> Array:
        """Return the frictional power per area (x, y) [W/m^2] of a steady state."""
        # the tangential traction before and after a step: q . s alone misses what the step from cell to cell dissipates
        mean = (state.shear + ahead(state.shear, np.copysign(grid.cell_size[0], self.speed))) / 2
        return np.asarray(-abs(self.speed) * np.einsum("cxy,cxy->xy", mean, state.slip))

    def steady(
        self, grid: Grid, pressure: Array, options: SolveOptions, last: "SteadyShear | None" = None
    ) -> "SteadyShear":
        """Return the steady state under `pressure` (x, y), from the `last` one or from those on coarser grids."""
        if self.force_per_length is not None:
            transmission_status(self.force_per_length, self.coefficient * pressure, grid)
        creepage, work, steady = self.creepage, 0.0, None
        levels: list[list[float]] = []
        shear: Array = np.zeros((2, *grid.cells)) if last is None else last.shear
        by_pressure: Array = np.zeros((2, *grid.cells))
        if self.coupling is not None:
            by_pressure = self.coupling.displacement(pressure)
        for level in [grid] if last is not None else coarser_grids(grid):
            fine = level is grid
            limit = on_cells(self.coefficient * pressure, level.cells)
            limit = np.where(limit < 1e-12 * limit.max(), 0, limit)
            step = float(np.copysign(level.cell_size[0], self.speed))
            slip = ElasticSlip(self.shear_response(level), step)
            displacement = on_grid(by_pressure, level)
            free_slip = (displacement - ahead(displacement, step)) / abs(step) - creepage.on(level)
            total = None
            if self.force_per_length is not None:
                total = np.array([self.force_per_length * level.length / level.cell_area, np.nan])
            newton = CoulombNewton(slip, limit, total)
            steady = _steady(
                newton,
                creepage,
                free_slip,
                on_grid(shear, level),
                options.tolerance if fine else max(LEVEL_TOLERANCE, options.tolerance),
                options.max_iterations,
            )
            shear = steady.shear
            work += 2 * newton.applications * limit.size / pressure.size
            force = self.coefficient * shear.sum(axis=(1, 2)) / limit.sum()
            power = float(self._power(level, steady).sum()) * level.cell_area
            levels.append([*force, steady.creepage.longitudinal, power])
        assert steady is not None
        if last is not None:
            return replace(steady, convolutions=work, errors=last.errors)
        touching = np.pad(limit > 0, ((1, 0), (0, 0)))
        contact_length = np.count_nonzero(touching) / np.count_nonzero(touching[1:] & ~touching[:-1])
        cells = np.array([level.cells for level in coarser_grids(grid)])
        finer = (cells[1:] / cells[:-1]).max(axis=1)
        errors = self._errors(np.array(levels), finer, contact_length)
        return replace(steady, convolutions=work, errors=errors)

    def _errors(self, levels: Array, finer: Array, contact_length: float) -> RollingErrors:
        """Return the errors of the last of `levels`: (grid, number), forces over the load, creepage and power.

        Each grid is `finer` than the one before by these factors, and the error is of first order: the last difference
        estimates it, and half of the one before guards against a last one that is small by chance; a single one counts
        twice. The stick-slip boundary is uncertain by STICK_SLIP_BOUNDARY_CELLS, with the effect on force or creepage
        of Carter's closed form for a contact of `contact_length` cells along x.
        """
        if len(levels) == 1:
            return UNKNOWN
        orders = np.array([1.0, 2.0])[: len(finer)] if len(finer) > 1 else np.array([0.5])
        changes = np.abs(np.diff(levels, axis=0))[::-1][:2]
        longitudinal, lateral, creepage, power = (
            changes / (orders * np.maximum(finer[::-1][:2] - 1, LEAST_REFINEMENT))[:, None]
        ).max(axis=0)
        *force, found_creepage, found_power = np.abs(levels[-1])
        size = float(np.hypot(*force))
        part, edge = size / self.coefficient, 2 * STICK_SLIP_BOUNDARY_CELLS / contact_length
        sliding = 1 - sqrt(1 - min(part, 1.0))  # creepage over that at which all slides
        if self.force_per_length is None:
            free = size
            edge_error = 4 * sliding * (1 - sliding + 2 * edge) * edge / part if part else 0.0
        else:
            longitudinal, free, edge_error = 0.0, force[1], 2 * edge
        return RollingErrors(
            force=max(float(np.hypot(longitudinal, lateral)), edge_error * free),
            creepage=max(float(creepage), edge_error * found_creepage),
            power=max(float(power), edge_error * found_power),
        )


@dataclass(frozen=True, eq=False)
class SteadyShear:
    """Steady state on one grid: tangential traction and slip (component, x, y), where it sticks, and what it took."""

    shear: Array
    slip: Array
    stick: NDArray[np.bool_]
    creepage: Creepage
    residual: float
    applications: int
    convolutions: float = 0.0
    errors: RollingErrors = UNKNOWN


def _steady(
    newton: CoulombNewton, creepage: Creepage, free_slip: Array, shear: Array, tolerance: float, max_applications: int
) -> SteadyShear:
    """Return the steady state on one grid, with the longitudinal creepage that a given force asks for.

    `free_slip` (component, x, y) is the slip without tangential traction, under the given `creepage`. A force enters the
    projection as a resultant, whose multiplier corrects the creepage.
    """
    first = newton.gathered(shear)
    values, _, creepage_correction, residual = newton.solve(free_slip, first, tolerance, max_applications)
    values = newton.project(values)
    slip = free_slip - creepage_correction[:, None, None] + newton.slip_field(values)
    creepage = replace(creepage, longitudinal=creepage.longitudinal + float(creepage_correction[0]))
    stick = newton.sticks(values, newton.gathered(slip))
    return SteadyShear(newton.field(values), slip, stick, creepage, residual, newton.applications)


def coarser_grids(grid: Grid) -> list[Grid]:
    """Return `grid` and those with half the cells along each axis that allows it, coarsest first."""
    grids = [grid]
    while (cells := tuple(max(n // 2, min(n, COARSEST)) for n in grids[-1].cells)) != grids[-1].cells:
        grids.append(Grid((cells[0], cells[1]), grid.extent))
    return grids[::-1]


def on_grid(field: Array, grid: Grid) -> Array:
    """Return a `field` (component, x, y) on another grid of the same extent, by its means over the cells."""
    return np.stack([on_cells(component, grid.cells) for component in field])
