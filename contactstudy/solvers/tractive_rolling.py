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
from contactstudy.solvers.solution import Creepage, RollingErrors, RollingTraction, Solution, TangentialTraction
from contactstudy.solvers.solve import SolveOptions, solve_contact, solve_with_mixing

# Fewest cells along an axis of a coarser grid: from 4 to 32 the work changes by 3 % on lines and on rough contacts.
COARSEST = 8
# Least relative refinement that the change between two grids is divided by: that between nearly equal ones vanishes by
# chance.
LEAST_REFINEMENT = 0.5
# Residual on coarser grids, whose own error is larger. A tenth of it takes up to 8 % more work, ten times it changes the
# estimated errors by up to a fifth.
LEVEL_TOLERANCE = 1e-3
# Most outer iterations between pressure and tangential traction of elastically dissimilar bodies; 5 were seen.
MAX_COUPLED_ITERATIONS = 60
# Distance [cells] within which the stick-slip boundary is found. With it errors were at most 0.96 of the bound in 600
# line contacts of 28 to 90 cells, a third near full sliding and a third near full stick.
STICK_SLIP_BOUNDARY_CELLS = 0.4


@dataclass(frozen=True, eq=False)
class ShearPressureCoupling:
    """Normal displacement by tangential traction, and tangential displacement by pressure, of dissimilar bodies.

    `longitudinal` and `lateral` map traction along x and along y [Pa] to normal displacement [m]; they are odd in x and
    in y. By reciprocity the tangential displacement by pressure is minus that.
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
    """Return the values of a `field` (component, x, y) one cell ahead, zero beyond the leading edge.

    Ahead is at larger x for a `step` above 0, else at smaller x.
    """
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
        Coupling of pressure and traction; None for elastically similar bodies (Dundurs' beta = 0).
    note
        Sentence on the scene for the solution, or empty.
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
        rolling: RollingTraction | None = None
        residual, applications, convolutions = 0.0, 0, 0.0

        def found(pressure: Array) -> RollingTraction:
            """Return the traction under a pressure (x, y) [Pa], from that before on, which becomes `rolling`."""
            nonlocal rolling, residual, applications, convolutions
            rolling, residual, work = self.steady(problem.grid, pressure, options, rolling)
            applications, convolutions = applications + rolling.iterations, convolutions + work
            return rolling

        if (coupling := self.coupling) is None:
            normal = solve_contact(problem, options, start, device)
            if normal.pressure.any():
                found(normal.pressure)
        else:

            def gap(pressure: Array) -> Array:
                """Return the change of the gap (x, y) [m] by the traction under a pressure."""
                return coupling.gap(found(pressure).shear)

            lagged = solve_with_mixing(problem, gap, options, start, device, MAX_COUPLED_ITERATIONS)
            normal, convolutions = lagged.solution_of(problem), convolutions + 2 * lagged.outer_iterations
        if rolling is None:
            acts = transmission_status(self.force_per_length or 0.0, normal.pressure, problem.grid)
            no_shear, no_stick = np.zeros((2, *problem.grid.cells)), np.zeros(problem.grid.cells, dtype=bool)
            traction = TangentialTraction(no_shear, no_stick, "tractive rolling", 0)
            return normal.with_traction(traction, acts, 0.0, 0, 0.0)
        status = shear_status(residual, rolling.iterations, options.tolerance, options.max_iterations)
        normal = replace(normal, note=f"{normal.note} {self.note}".strip())
        return normal.with_traction(rolling, status, residual, applications, convolutions)

    def steady(
        self, grid: Grid, pressure: Array, options: SolveOptions, last: RollingTraction | None = None
    ) -> tuple[RollingTraction, float, float]:
        """Return the steady traction under a `pressure` (x, y) [Pa], its residual, and the convolutions that it took.

        It begins with the `last` one, whose errors it keeps, or on coarser grids, which show them. A given force enters
        the projection as a resultant, whose multiplier corrects the creepage.
        """
        if self.force_per_length is not None:  # refuse a force that friction does not transmit
            transmission_status(self.force_per_length, self.coefficient * pressure, grid)
        shear = np.zeros((2, *grid.cells)) if last is None else last.shear
        by_pressure = np.zeros((2, *grid.cells)) if self.coupling is None else self.coupling.displacement(pressure)
        numbers: list[list[float]] = []
        work, grids = 0.0, coarser_grids(grid) if last is None else [grid]
        for level in grids:
            limit = on_cells(self.coefficient * pressure, level.cells)
            limit = np.where(limit < 1e-12 * limit.max(), 0, limit)  # without the rounding of means over cells
            dx = float(np.copysign(level.cell_size[0], self.speed))
            elastic_slip = ElasticSlip(self.shear_response(level), dx)
            displacement = on_grid(by_pressure, level)
            free_slip = (displacement - ahead(displacement, dx)) / abs(dx) - self.creepage.on(level)
            total = None
            if self.force_per_length is not None:
                total = np.array([self.force_per_length * level.length / level.cell_area, np.nan])
            tolerance = options.tolerance if level is grid else max(LEVEL_TOLERANCE, options.tolerance)
            newton = CoulombNewton(elastic_slip, limit, total)
            found = newton.solve(free_slip, on_grid(shear, level), tolerance, options.max_iterations)
            shear, applications = found.shear, found.applications + 1
            slip = free_slip - found.rigid[:, None, None] + elastic_slip(shear)
            creepage = replace(self.creepage, longitudinal=self.creepage.longitudinal + float(found.rigid[0]))
            # the traction before and after a step: q . s alone misses what the step from cell to cell dissipates
            power = -abs(self.speed) * np.einsum("cxy,cxy->xy", (shear + ahead(shear, dx)) / 2, slip)
            work += 2 * applications * limit.size / pressure.size
            force = self.coefficient * shear.sum(axis=(1, 2)) / limit.sum()
            numbers.append([*force, creepage.longitudinal, float(power.sum()) * level.cell_area])
        whole = float(power.sum())
        traction = RollingTraction(
            shear=shear,
            stick=found.stick,
            method="tractive rolling, Newton",
            iterations=applications,
            slip=slip,
            creepage=creepage,
            power=power,
            power_outside_contact=float(power[pressure == 0].sum()) / whole if whole else 0.0,
            errors=self._errors(np.array(numbers), grids, limit > 0) if last is None else last.errors,
            creepage_given=self.force_per_length is None,
        )
        return traction, found.residual, work

    def _errors(self, levels: Array, grids: list[Grid], touching: NDArray[np.bool_]) -> RollingErrors:
        """Return the errors of the last of `levels`: (grid, number), forces over the load, creepage and power.

        The error is of first order in the cells of the `grids`, coarsest first. The last difference estimates it; half
        of the one before guards against a last one that is small by chance. A single difference counts twice. The
        stick-slip boundary is uncertain by STICK_SLIP_BOUNDARY_CELLS. Its effect on force or creepage is that of
        Carter's closed form, for a contact as long along x as the `touching` cells (x, y) are in the mean.
        """
        if len(levels) == 1:
            return RollingErrors()
        cells = np.array([level.cells for level in grids])
        finer = (cells[1:] / cells[:-1]).max(axis=1)
        starts = np.count_nonzero(np.diff(touching, axis=0, prepend=False) & touching)
        contact_length = np.count_nonzero(touching) / starts
        divisors = np.array([1.0, 2.0])[: len(finer)] if len(finer) > 1 else np.array([0.5])
        changes = np.abs(np.diff(levels, axis=0))[::-1][:2]
        longitudinal, lateral, creepage, power = (
            changes / (divisors * np.maximum(finer[::-1][:2] - 1, LEAST_REFINEMENT))[:, None]
        ).max(axis=0)
        *force, found_creepage, found_power = np.abs(levels[-1])
        size = float(np.hypot(*force))
        # force over that of full sliding, and uncertainty of the boundary over the half-width
        part, edge = size / self.coefficient, 2 * STICK_SLIP_BOUNDARY_CELLS / contact_length
        # creepage over that at which all slides, by Carter: part = 1 - (1 - sliding)^2
        sliding = 1 - sqrt(1 - min(part, 1.0))
        # creepage is known to twice the edge, and force by the derivative of part where twice the edge more sticks
        if self.force_per_length is None:
            found_force = size
            edge_error = 4 * sliding * (1 - sliding + 2 * edge) * edge / part if part else 0.0
        else:
            longitudinal, found_force, edge_error = 0.0, force[1], 2 * edge
        return RollingErrors(
            force=max(float(np.hypot(longitudinal, lateral)), edge_error * found_force),
            creepage=max(float(creepage), edge_error * found_creepage),
            power=max(float(power), edge_error * found_power),
        )


def coarser_grids(grid: Grid) -> list[Grid]:
    """Return `grid` and those with half the cells along each axis that allows it, coarsest first."""
    grids = [grid]
    while (cells := tuple(max(n // 2, min(n, COARSEST)) for n in grids[-1].cells)) != grids[-1].cells:
        grids.append(Grid((cells[0], cells[1]), grid.extent))
    return grids[::-1]


def on_grid(field: Array, grid: Grid) -> Array:
    """Return a `field` (component, x, y) on another grid of the same extent, by its means over the cells."""
    return np.stack([on_cells(component, grid.cells) for component in field])
