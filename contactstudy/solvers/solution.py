"""The result of a solve: fields in SI units, and a status that says how far they can be trusted.

A tangential traction, of friction, and an adhesive one are parts of a solution, each with fields of its own. Numbers and
the bounds of their errors are added by the answers, :mod:`contactstudy.answers.contact`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from math import inf

import numpy as np
from numpy.typing import NDArray

from contactstudy.domain.grid import Array, Grid
from contactstudy.domain.validation import NotDefined
from contactstudy.problem.constraint import largest_of
from contactstudy.problem.problem import Field, Problem

# Dimensions of a field on the surface.
OF_SURFACE = ("x", "y")
# Numbers on the work of a solver, each with its meaning in words, by name.
Counts = Mapping[str, tuple[float, str]]


class Status(Enum):
    """Outcome of a solve; ``str(status)`` is a sentence with cause and remedy.

    The most serious outcomes stand first: those without a pressure, those without an equilibrium, those whose residual
    is above the tolerance, and what a converged contact or film warns of.
    """

    NOT_FINITE = (
        "the iteration left the range of floating-point numbers: "
        "check the heights for nan and for values far beyond the contact's own scale"
    )
    NO_ADMISSIBLE_PRESSURE = (
        "the hardness everywhere would not carry the load: give a larger hardness, a smaller load or a larger width"
    )
    WORN_THROUGH = (
        "a coating is worn through, and what is below it bears the load from here on: end before, or give a body of the "
        "substrate alone"
    )
    SHEAR_BEYOND_YIELD = (
        "no equilibrium: friction is larger than the yield stress in shear of a body that does not harden, which flows "
        "without limit: give a smaller coefficient or load, or a hardening modulus"
    )
    NOT_CONVERGED = (
        "pressure and the displacement, plastic strain or shear that depends on it did not converge together: "
        "the residual says how far; give a larger tolerance or, where a load is applied in steps, shorter steps"
    )
    FILM_NOT_CONVERGED = (
        "the residual of the film stayed above the tolerance: give more cells across where a spike of pressure is "
        "unresolved, more iterations, or start from the film at a higher speed"
    )
    STALLED = (
        "the residual stopped falling above the tolerance: give a tolerance no smaller than the "
        "residual reached, check the heights for values far beyond the contact's own scale, and the grid "
        "for cells a thousand times as long as wide or more"
    )
    ITERATION_LIMIT = "max_iterations was reached before the tolerance: allow more iterations or a larger tolerance"
    PRECISION_LIMIT = (
        "the residual is as small as rounding lets it be, and above the tolerance: "
        "give a tolerance no smaller than the residual reached, or solve in double precision"
    )
    CONTACT_AT_EDGE = (
        "converged, but the contact reaches the edge of the width, or the end of a length that is not periodic, and is "
        "cut off there: give Grid.extent a larger width or length"
    )
    YIELD_AT_EDGE = (
        "converged, but plastic strain reaches the edge of the width and is cut off there: "
        "give Grid.extent a larger width"
    )
    PASS_NOT_STEADY = (
        "converged, but the plastic strain that a pass leaves at the edge of the grid did not become steady: "
        "give a longer Rolling.distance, or none, or a larger Rolling.steady"
    )
    SEVERAL_FILMS = (
        "converged, but the Reynolds equation has another steady solution at the same speed, as the roughness is higher "
        "than the film, and the initial guess decides which one is found: give more cells across"
    )
    FILM_BELOW_CELL = (
        "converged, but the film is thinner than the change of the gap over one cell, in the inlet or beside the "
        "smallest film, which may be more than 10 % off: give more cells across"
    )
    STARVED_INLET = (
        "converged, but the inlet is so short that its film is more than 5 % too thin: give Grid.extent a larger width"
    )
    ATTRACTION_AT_EDGE = (
        "converged, but the attraction reaches the edge of the width and is cut off there: "
        "give Grid.extent a larger width"
    )
    DETACHED = (
        "the bodies do not touch: under this load there is no equilibrium in contact, or at this approach they only "
        "attract each other across the gap, or nothing holds the tangential force: give a larger load or approach"
    )
    CONVERGED = "the residual is below the tolerance"

    def __str__(self) -> str:
        """Return name, cause and remedy as a sentence."""
        return f"{self.name}: {self.value}."

    @property
    def has_converged(self) -> bool:
        """True if the residual of a contact or film is below the tolerance.

        What the status warns of makes no difference, except detachment: without contact there is no pressure to trust.
        """
        order = list(Status)
        return self is not Status.DETACHED and order.index(self) >= order.index(Status.CONTACT_AT_EDGE)

    @property
    def is_failure(self) -> bool:
        """True if there is no pressure, as none is admissible or the iteration left the range of numbers."""
        return self in (Status.NOT_FINITE, Status.NO_ADMISSIBLE_PRESSURE)


def worst(statuses: Sequence[Status]) -> Status:
    """Return the most serious of `statuses`; converged if there is none."""
    return min(statuses, key=list(Status).index, default=Status.CONVERGED)


def worst_until(last: Status, earlier: Sequence[Status]) -> Status:
    """Return the status of the last of successive contacts: the worst of its own and of those `earlier`.

    Earlier contacts that were detached do not count. Where the `last` one is detached, warnings of earlier ones that
    converged do not count either.
    """
    if last is Status.DETACHED:
        return worst([last, *(status for status in earlier if not status.has_converged)])
    return worst([last, *(status for status in earlier if status is not Status.DETACHED)])


@dataclass(frozen=True, eq=False)
class TangentialTraction:
    """Tangential (shear) traction on the first body, whose reaction acts on the second one.

    Parameters
    ----------
    shear
        Traction (component, x, y) [Pa] along x and y.
    stick
        Cells (x, y) that stick.
    method
        Method by which the traction was found, in words, such as "full sliding".
    iterations
        Number of applications of the response to traction. In tractive rolling it counts those on the finest grid in
        the last outer iteration, between pressure and traction. Where the traction follows from pressures alone, it is
        the number of normal contacts solved.
    bulk
        Bulk stress along x of each body [Pa].
    """

    shear: Array
    stick: NDArray[np.bool_]
    method: str
    iterations: int
    bulk: tuple[float, float] = field(default=(0.0, 0.0), kw_only=True)

    def fields(self, _pressure: Array) -> Mapping[str, Field]:
        """Return both components of the traction and the area of stick, as fields by name."""
        on = "on the first body"
        return {
            "shear_x": Field(OF_SURFACE, self.shear[0], "Pa", f"tangential traction along x (longitudinal), {on}"),
            "shear_y": Field(OF_SURFACE, self.shear[1], "Pa", f"tangential traction along y (lateral), {on}"),
            "stick": Field(
                OF_SURFACE, self.stick.astype(np.int8), "1", "1 where the bodies stick, 0 elsewhere"
            ),
        }  # fmt: skip


class Branch(Enum):
    """History of an adhesive contact, which decides between several states of equilibrium."""

    #: Approach (jump-in) branch: the least adhesive state.
    FROM_AFAR = "from afar"
    #: Separation branch: the most adhesive state.
    FROM_FULL_CONTACT = "from full contact"
    #: Bodies that come from the state before.
    CONTINUED = "continued"


@dataclass(frozen=True, eq=False)
class AdhesiveTraction:
    """Adhesive traction between the bodies of a contact with adhesion.

    Parameters
    ----------
    attraction
        Adhesive traction (x, y) [Pa], which is not part of the pressure.
    branch
        History that the state belongs to, in words.
    energies
        Energy [J] of the deformed bodies, the load and the adhesive traction after each outer iteration, relative to
        undeformed bodies far apart. The potential of the load counts from zero approach. Outer iterations are
        accelerated by iterates mixed from earlier ones; a mixed iterate that raises the energy is rejected, and has no
        entry.
    cells_in_zone
        Number of cells in the cohesive zone, over which the traction falls at the edge of a contact.
    tabor
        Tabor's parameter, the elastic deformation over the range of the traction; None without a curved shape.
    regularised
        Whether the range was chosen for the grid, in place of the limit of short ranges (Johnson, Kendall & Roberts
        1971).
    outer_iterations
        Number of contacts solved with a frozen adhesive traction, those of rejected mixed iterates too.
    range
        Range of the traction [m]: the work of adhesion over the largest traction.
    first_unstable_load
        First load [N/m] without equilibrium in contact, where the pull-off load was sought; else None.
    """

    attraction: Array
    branch: str
    energies: tuple[float, ...]
    cells_in_zone: float
    tabor: float | None
    regularised: bool
    outer_iterations: int
    range: float
    first_unstable_load: float | None = None

    @property
    def energy(self) -> float:
        """Energy [J] of the deformed bodies, the load and the adhesive traction, the last of `energies`."""
        return self.energies[-1]

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return the attraction, the net pressure, and the history of the state as a CF flag, as fields by name."""
        meanings = [branch.value for branch in Branch]
        flags = {
            "flag_values": np.arange(len(meanings), dtype=np.int8),
            "flag_meanings": " ".join(meaning.replace(" ", "_") for meaning in meanings),
        }
        branch, net = np.array(meanings.index(self.branch), np.int8), net_pressure(pressure, self)
        return {
            "attraction": Field(OF_SURFACE, self.attraction, "Pa", "adhesive traction"),
            "net_pressure": Field(OF_SURFACE, net, "Pa", "pressure less the attraction"),
            "branch": Field((), branch, "1", "history of the state", flags),
        }


@dataclass(frozen=True, eq=False)
class Solution:
    """Solved contact: fields (x, y) and a status.

    ``gap = undeformed gap + displacement - approach`` holds to rounding, so that `gap` in the contact shows the
    remaining error of the solver. The exception are cells that yield, where a hardness limits the pressure: there the
    right side is minus the depth of yielding, `dent`, and `gap` is 0.

    Parameters
    ----------
    problem
        The problem that was solved.
    pressure
        Contact pressure [Pa]; with adhesion its repulsive part alone, see `net_pressure`.
    displacement
        Normal displacement of both bodies together [m].
    gap
        Gap between the deformed bodies [m].
    approach
        Approach of the bodies [m], as in the equation of the gap. The operator gives the displacement relative to that
        at a certain distance, its datum, so that the approach is relative to it too.
    status
        Outcome of the solve, with cause and remedy.
    iterations
        Number of iterations.
    convolutions
        Number of FFT convolutions of the full grid; smaller ones count in proportion.
    residual
        Dimensionless residual, see :class:`~contactstudy.SolveOptions`.
    note
        Empty, or sentences on how the solution was found, such as how the solver went on after a stall.
    traction
        Tangential traction of a scene with friction; None without.
    adhesion
        Adhesive traction of a scene with adhesion; None without.
    """

    problem: Problem
    pressure: Array
    displacement: Array
    gap: Array
    approach: float
    status: Status
    iterations: int
    convolutions: float
    residual: float
    note: str = ""
    traction: TangentialTraction | None = None
    adhesion: AdhesiveTraction | None = None

    @property
    def parts(self) -> tuple[TangentialTraction | AdhesiveTraction, ...]:
        """Tangential and adhesive traction, as far as effects add them to the pressure."""
        return tuple(part for part in (self.traction, self.adhesion) if part is not None)

    @property
    def attraction(self) -> Array | None:
        """Adhesive traction (x, y) [Pa]; None without adhesion."""
        return None if self.adhesion is None else self.adhesion.attraction

    @property
    def load_per_length(self) -> float:
        """Load that the pressure carries, less the adhesive traction, per length that both bodies share [N/m]."""
        grid, covered = self.problem.grid, self.problem.covered_fractions
        load = self.pressure.sum()
        if self.attraction is not None:
            load -= self.attraction.sum()
        rows = grid.cells[1] if covered is None else covered.sum()
        return float(load * grid.cell_size[0] / rows)

    @property
    def net_pressure(self) -> Array:
        """Pressure less the adhesive traction (x, y) [Pa], which the bodies transmit and deform under."""
        return net_pressure(self.pressure, self.adhesion)

    @property
    def peak_pressure(self) -> float:
        """Largest net pressure in contact [Pa], below zero where all of it is tensile; 0 without contact."""
        touching = self.pressure > 0
        return float(self.net_pressure[touching].max()) if touching.any() else 0.0

    @property
    def regularised(self) -> bool:
        """True where the range of adhesion was chosen for the grid, in place of the limit of short ranges."""
        return self.adhesion is not None and self.adhesion.regularised

    @property
    def dent(self) -> Array:
        """Depth (x, y) [m] by which a body yields where a hardness limits the pressure, else 0."""
        overlap = self.approach - self.problem.undeformed_gap - self.displacement
        return np.where(self.problem.constraint.yielded(self.pressure), np.maximum(overlap, 0.0), 0.0)

    @property
    def mean_gap(self) -> float:
        """Mean gap [m] over the length that both bodies have in common."""
        covered = self.problem.covered_fractions
        return float(self.gap.mean() if covered is None else np.average(self.gap.mean(axis=0), weights=covered))

    def with_traction(
        self, traction: TangentialTraction, status: Status, residual: float, iterations: int, convolutions: float
    ) -> "Solution":
        """Return this normal solution with a `traction`, whose solve ended with this status and residual.

        The status is the more serious one, the residual the larger one. The `iterations` and `convolutions` of the
        traction are added.
        """
        return replace(
            self,
            traction=traction,
            status=worst([self.status, status]),
            residual=largest_of(self.residual, residual),
            iterations=self.iterations + iterations,
            convolutions=self.convolutions + convolutions,
        )

    @property
    def shear(self) -> Array:
        """Tangential traction on the first body (component, x, y) [Pa], along x and y.

        Raises
        ------
        NotDefined
            If the scene has no friction.
        """
        return self._traction.shear

    @property
    def stick(self) -> NDArray[np.bool_]:
        """Cells (x, y) in contact that stick.

        Raises
        ------
        NotDefined
            If the scene has no friction.
        """
        return self._traction.stick

    @property
    def _traction(self) -> TangentialTraction:
        """Tangential traction of the solution; raises NotDefined without friction."""
        if self.traction is None:
            raise NotDefined("This solution has no shear: give Scene.friction, such as Sliding(coefficient=0.1).")
        return self.traction


def unloaded(problem: Problem) -> Solution:
    """Return the bodies of `problem` as they just touch, without pressure."""
    gap = problem.undeformed_gap
    no_pressure = np.zeros_like(gap)
    approach = float(gap.min())
    return Solution(
        problem=problem,
        pressure=no_pressure,
        displacement=no_pressure.copy(),
        gap=gap - approach,
        approach=approach,
        status=Status.CONVERGED,
        iterations=0,
        convolutions=0.0,
        residual=0.0,
    )


def net_pressure(pressure: Array, adhesion: AdhesiveTraction | None) -> Array:
    """Return the `pressure` (x, y) [Pa] less the attraction, under which the bodies deform."""
    return pressure if adhesion is None else pressure - adhesion.attraction


@dataclass(frozen=True, eq=False)
class FrettingTraction(TangentialTraction):
    """Tangential traction on the first body after the last of several forces, and the slip of the last whole cycle.

    A whole cycle goes from a reversal of the force to the next but one, at the same force. Without one, slip and energy
    are those of the whole history.

    Parameters
    ----------
    forces
        Tangential forces (steps + 1,) [N] on the grid, starting from 0 N.
    rigid_displacement
        Rigid displacement along x (steps + 1,) [m] of the second body against the first, from 0 m on.
    shears
        Traction after each force (step, component, x, y) [Pa].
    slip_distance
        Distance slipped in the last whole cycle (x, y) [m].
    energy
        Energy lost to friction in the last whole cycle, per area (x, y) [J/m^2].
    cycle
        Indices in `forces` at which the last whole cycle starts and ends, the first also that of its first step in
        `shears`; None if no cycle is whole.
    """

    forces: Array
    rigid_displacement: Array
    shears: Array
    slip_distance: Array
    energy: Array
    cycle: tuple[int, int] | None

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return traction, area of stick, slip and energy, and the force from the start on, as fields by name."""
        counted = "so far" if self.cycle is None else "in the last whole cycle"
        slid = "rigid-body displacement of the second against the first body along x"
        return {
            **super().fields(pressure),
            "slip_distance": Field(OF_SURFACE, self.slip_distance, "m", f"distance slipped {counted}"),
            "friction_energy": Field(OF_SURFACE, self.energy, "J m-2", f"energy lost {counted} per area"),
            "tangential_force": Field(("step",), self.forces, "N", "tangential force at the start and after each step"),
            "rigid_displacement": Field(("step",), self.rigid_displacement, "m", slid),
        }  # fmt: skip


@dataclass(frozen=True)
class Creepage:
    """Creepage: relative rigid-body velocity of the second against the first body over the rolling speed.

    The slip of the first against the second body is the change of the elastic displacement per distance, less the
    creepage: a positive creepage makes a positive traction on the first body.

    Parameters
    ----------
    longitudinal, lateral
        Creepage along x and along y.
    spin
        Angular velocity about z over the rolling speed [1/m].
    """

    longitudinal: float
    lateral: float
    spin: float

    def on(self, grid: Grid) -> Array:
        """Return the creepage (component, x, y) in the cells of `grid`, with that by the spin about x = y = 0."""
        creepage = np.empty((2, *grid.cells))
        creepage[0] = self.longitudinal - self.spin * grid.y
        creepage[1] = self.lateral + self.spin * grid.x[:, None]
        return creepage


@dataclass(frozen=True)
class RollingErrors:
    """Errors by the size of the cells, estimated by coarser grids; infinite where nothing estimates them.

    Parameters
    ----------
    force
        Absolute error of the ratio of tangential force to load.
    creepage
        Absolute error of a longitudinal creepage that is found.
    power
        Absolute error of the frictional power on the grid [W].
    """

    force: float = inf
    creepage: float = inf
    power: float = inf


@dataclass(frozen=True, eq=False)
class RollingTraction(TangentialTraction):
    """Tangential traction of steady rolling on the first body, with its slip and its power.

    Parameters
    ----------
    slip
        Slip of the first against the second body per distance rolled (component, x, y).
    creepage
        Rigid slip of the second against the first body; found where the tangential force is given.
    power
        Frictional power per area (x, y) [W/m^2], of the slip in a step of one cell under the mean of the traction before
        and after it: the traction after it alone would leave out what the step dissipates.
    power_outside_contact
        Fraction of the power in cells just outside the contact, which have the mean of their traction and that of a
        neighbour: an error by the cells that one grid shows. `errors` has the error that coarser grids show; the bound
        of the power is their sum.
    errors
        Estimated errors of force, creepage and power.
    creepage_given
        Whether the creepage was given, and not the force.
    """

    slip: Array
    creepage: Creepage
    power: Array
    power_outside_contact: float
    errors: RollingErrors
    creepage_given: bool

    def fields(self, pressure: Array) -> Mapping[str, Field]:
        """Return traction, area of stick, slip and frictional power, as fields by name."""
        slip = "slip of the first body against the second over the distance rolled"
        return {
            **super().fields(pressure),
            "slip_x": Field(OF_SURFACE, self.slip[0], "1", f"{slip}, along x (longitudinal)"),
            "slip_y": Field(OF_SURFACE, self.slip[1], "1", f"{slip}, along y (lateral)"),
            "power_density": Field(OF_SURFACE, self.power, "W m-2", "frictional power per area"),
        }
