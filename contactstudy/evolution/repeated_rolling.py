"""What passes of a contact leave in a half-space."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.domain.checks import InvalidInput, positive, whole
from contactstudy.domain.device import Precision
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.imports import presentation
from contactstudy.domain.padding import Padding, Paddings
from contactstudy.elasticity.eigenstrain.plane_strain import PlaneStrainOperator
from contactstudy.elasticity.eigenstrain.volume import Volume
from contactstudy.evolution.march import worst
from contactstudy.evolution.plastic import YieldingBody, concluded, layers, spread
from contactstudy.evolution.track import (
    Contact,
    Profile,
    RollingPressure,
    Track,
    nothing,
    padded,
    rolling_contact,
)
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import sudden
from contactstudy.scene.load import ConstantLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import SolveOptions, Solver

if TYPE_CHECKING:
    import xarray as xr


XX, YY, XZ = 0, 1, 4


@dataclass(frozen=True, eq=False)
class RollingPass:
    """One pass: the plastic strain that it has ``left`` behind, over a ``distance`` [m], and the contact at its end.

    ``status`` is the worst of its ``steps``, which took so many ``iterations`` of Newton's method; it is
    NOT_CONVERGED, too, where the plastic strain did not become steady.
    """

    left: Profile
    distance: float
    solution: Solution
    status: Status
    steps: int
    iterations: int


@dataclass(frozen=True, eq=False)
class RepeatedRolling:
    """The ``passes`` of a contact over a half-space, in order, and the ``track`` in the window of the last one.

    Arrays are (pass, z) or (pass, component, z): components xx, yy, zz, yz, xz, xy with x in the direction of travel
    and z into the body, stress tension positive, each after the pass and far behind the contact, where nothing
    changes along x. ``removed`` is the track after the last contact has been lifted off.
    """

    passes: tuple[RollingPass, ...]
    track: Track
    removed: Track
    description: PosedScene

    @property
    def grid(self) -> Grid:
        """The window."""
        return self.track.operator.volume.grid

    @property
    def depths(self) -> Array:
        """Middles of the layers (z,) [m]."""
        return self.track.operator.volume.depths

    @property
    def plastic_strain(self) -> Array:
        """(pass, component, z)"""
        basis = self.track.operator.basis
        return np.asarray(np.einsum("ct,ncl->ntl", basis, self._each(_strain)))

    @property
    def equivalent_plastic_strain(self) -> Array:
        """(pass, z)"""
        return self._each(_equivalent)

    @property
    def residual_stress(self) -> Array:
        """(pass, component, z) [Pa]: xx and yy alone, which balance in a body that goes on to infinity."""
        moduli = self.track.operator.moduli
        strain, nu = self.plastic_strain, moduli.poisson_ratio
        stress = np.zeros_like(strain)
        stress[:, XX] = -moduli.plane_strain * (strain[:, XX] + nu * strain[:, YY])
        stress[:, YY] = -moduli.plane_strain * (strain[:, YY] + nu * strain[:, XX])
        return stress

    @property
    def yielding(self) -> Array:
        """(pass,) The largest equivalent plastic strain that a pass adds; 0 where nothing yields any more."""
        return np.asarray(self._added(self.equivalent_plastic_strain).max(axis=-1))

    @property
    def shear(self) -> Array:
        """(pass, z) The shear strain ``2 e_xz`` that a pass adds."""
        return 2 * self._added(self.plastic_strain[:, XZ])

    @property
    def forward_displacement(self) -> Array:
        """(pass,) [m] How far a pass moves the surface over what lies deep, against the direction of travel.

        The integral of :attr:`shear`. On a disc that turns below a contact which stays, it is forwards
        (Crook 1957, Proc. Inst. Mech. Eng. 171).
        """
        return self.shear @ self.track.operator.volume.thicknesses

    @property
    def peak_pressure(self) -> Array:
        """(pass,) [Pa] at the end of each."""
        return np.array([one.solution.pressure.max() for one in self.passes])

    @property
    def shaken_down(self) -> int | None:
        """The first pass, counted from 1, from which on nothing yields; None where the last one yields still."""
        still = np.flatnonzero(self.yielding > 0)
        last = int(still[-1]) + 1 if still.size else 0
        return None if last == len(self.passes) else last + 1

    @property
    def status(self) -> Status:
        """The worst of all passes."""
        return worst([one.status for one in self.passes])

    def summary(self) -> str:
        """What was found, in a few lines."""
        stress = self.residual_stress[-1, XX]
        lowest = int(stress.argmin())
        down = self.shaken_down
        return "\n".join(
            (
                f"{self.status}",
                f"  {len(self.passes)} passes, {sum(one.steps for one in self.passes)} steps, "
                f"{sum(one.iterations for one in self.passes)} iterations",
                "  the last pass yields still"
                if down is None
                else f"  nothing yields from pass {down} on",
                f"  lowest residual stress along the way {stress[lowest]:.4g} Pa at a depth of "
                f"{self.depths[lowest]:.4g} m; the last pass moves the surface by "
                f"{self.forward_displacement[-1]:.4g} m",
            )
        )

    def to_dataset(self) -> "xr.Dataset":
        """By pass and depth, and the window after the last pass, with units and long names."""
        dataset: xr.Dataset = presentation("RepeatedRolling.to_dataset")(self)
        return dataset

    def _each(self, of: Callable[[Profile], Array]) -> Array:
        layers = len(self.depths)
        return np.stack([of(one.left.deeper(layers)) for one in self.passes])

    def _added(self, kept: Array) -> Array:
        return np.diff(kept, axis=0, prepend=np.zeros_like(kept[:1]))


def _strain(profile: Profile) -> Array:
    return profile.strain


def _equivalent(profile: Profile) -> Array:
    return profile.equivalent


# Layers reach so many lengths of the contact deep at first; they are made deeper where that yields.
DEPTH = 2.0
# A pass goes on for no longer than so many widths of the window.
LONGEST = 20


def roll_repeatedly(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    passes: int,
    pressure: RollingPressure = RollingPressure.SETTLED,
    distance: float | None = None,
    steady: float = 5e-3,
    tolerance: float = 1e-8,
    max_iterations: int = 2000,
    solver: Solver = PreconditionedCG(),  # noqa: B008 (a frozen value)
    precision: Precision = Precision.DOUBLE,
) -> RepeatedRolling:
    """Roll the contact of ``scene`` to larger x over an elastic-plastic half-space, ``passes`` times, in plane strain.

    ``grid`` is a window that moves with the contact; all that yields below the contact must be in it. The half-space
    has no end: ahead of the window it is as the pass before has left it, behind as this one leaves it. The
    contact is pressed at once, then it rolls by one cell in each step. A pass ends when the plastic strain that
    it leaves changes by less than ``steady`` yield strains (Y / E) while the contact rolls by its half-width, or
    after a ``distance`` [m]. The next pass follows on. The other body is elastic or rigid, and heights move with the
    contact.

    Steps are as long as cells are wide: halve the cells, and the change is about the error that is left, which
    is of first order. ``tolerance`` and what follows are those of :func:`~contactstudy.solve`.
    Raises :class:`~contactstudy.InvalidInput` unless one body of the scene yields and the other is elastic, and for
    a load that changes, wear, more than one cell along the length, or a surface that ends or wraps across.
    """
    count = whole("roll_repeatedly.passes", passes, 1, "give a whole number of passes from 1 on")
    positive("roll_repeatedly.steady", steady, "give a part of the yield strain, such as 5e-3")
    if distance is not None:
        positive("roll_repeatedly.distance", distance, "give a distance above 0 m, or None")
    body = _yielding(scene)
    problem = replace(scene, solids=sudden(scene.solids)).problem(grid, padding)
    _check_grid(problem)
    length, cell = problem.scales.length, grid.cell[0]
    options = SolveOptions(tolerance, max_iterations, solver, precision)
    volume = Volume(grid, 0, grid.cells[0], layers(grid, length, DEPTH * length))
    operator = PlaneStrainOperator(volume, body.moduli)
    rolling = _Rolling(
        rolling_contact(problem, options, pressure),
        tolerance,
        length,
        lag=max(round(length / cell), 1),
        steps=None if distance is None else max(round(distance / cell), 1),
        steady=steady * body.hardening.yield_stress / body.moduli.youngs_modulus,
    )
    track, pressed = rolling.step(Track.fresh(operator, body.hardening))
    found: list[RollingPass] = []
    for _ in range(count):
        if found:
            track = replace(track, ahead=track.left)
        track, one = rolling.one_pass(track, () if found else (pressed,))
        found.append(one)
    lifted, _ = track.settled(nothing(problem), tolerance, length)
    return RepeatedRolling(tuple(found), track, lifted, PosedScene(scene, grid, padding))


# What is behind is a mean over some half of the window: as far as the contact is from its edge.
MEAN = 2
# The contact at the end of a step, and the iterations of Newton's method.
Step = tuple[Solution, int]


@dataclass(frozen=True, eq=False)
class _Rolling:
    """Steps of a ``contact`` to the ``tolerance``; ``length`` [m] is that of the contact, ``lag`` the same in cells.

    ``steps`` of a pass; None, as many as it takes until its plastic strain is ``steady``.
    """

    contact: Contact
    tolerance: float
    length: float
    lag: int
    steps: int | None
    steady: float

    def one_pass(self, track: Track, first: tuple[Step, ...]) -> tuple[Track, RollingPass]:
        """From where the contact is on ``track``; ``first`` are the steps that have pressed it there."""
        grid = track.operator.volume.grid
        taken, left, change = list(first), [track.left], inf
        most = LONGEST * grid.cells[0] if self.steps is None else self.steps
        while len(left) <= most:
            before = track.rolled(MEAN / grid.cells[0])
            track, step = self.step(before)
            taken.append(step)
            left.append(track.left)
            if self.steps is None and len(left) > grid.cells[0] + self.lag:
                change = _change(left[-1 - self.lag].strain, track.left.strain)
                change = max(change, _change(track.behind, track.left.strain))
                if change < self.steady:
                    break
        statuses = [solution.status for solution, _ in taken]
        if self.steps is None and change >= self.steady:
            statuses.append(Status.NOT_CONVERGED)
        # at the end alone: what is behind is not like what is left there until all is steady
        flow = track.equivalent - spread(before.equivalent, 0, track.operator.volume)
        if flow[:, [0, -1]].max() > self.steady:
            statuses.append(Status.YIELD_AT_EDGE)
        return track, RollingPass(
            track.left,
            distance=(len(left) - 1) * grid.cell[0],
            solution=taken[-1][0],
            status=worst(statuses),
            steps=len(taken),
            iterations=sum(iterations for _, iterations in taken),
        )

    def step(self, track: Track) -> tuple[Track, Step]:
        """``track`` after the contact has settled on it."""
        after, settled = track.settled(self.contact, self.tolerance, self.length)
        solution = concluded(settled, self.tolerance)
        return after, (solution, settled.iterations)


def _change(one: Array, other: Array) -> float:
    """The largest of plastic strain (component, layers), to one that may be deeper."""
    return float(np.abs(other - padded(one, other.shape[1])).max(initial=0.0))


def _yielding(scene: Scene) -> YieldingBody:
    """The one body of ``scene`` that yields, where it is the only one that keeps anything."""
    if scene.wear is not None or not isinstance(scene.load, ConstantLoad):
        field = "Scene.load" if scene.wear is None else "Scene.wear"
        raise InvalidInput(
            f"{field} changes in time beside repeated rolling: leave it out or give a LineLoad."
        )
    bodies = YieldingBody.all_of(scene)
    if len(bodies) != 1:
        raise InvalidInput(
            f"Scene.solids are {scene.solids!r}: give one body that yields, an ElasticPlasticHalfSpace, and an "
            "elastic or rigid HalfSpace that rolls on it."
        )
    return bodies[0]


def _check_grid(problem: Problem) -> None:
    """Refuse what has no operator here."""
    if problem.grid.cells[1] > 1:
        raise InvalidInput(
            f"Grid.cells[1] is {problem.grid.cells[1]}: repeated rolling is known in plane strain, give 1 cell along."
        )
    assert problem.paddings is not None
    across, along = problem.paddings
    if not problem.open_edges or along.window is not None:
        raise InvalidInput(
            f"roll_repeatedly.padding is {across!r} across and {along!r} along: the half-space goes on across and "
            "repeats along, give ExactPeriodicity()."
        )
