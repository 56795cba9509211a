"""Repeated rolling in plane strain: the plastic strain and residual stress that passes of a contact leave behind.

A contact rolls to larger x over a half-space that yields, the :class:`Track`, in steps of one cell. Grid and volume of
plastic strain move with the contact: strain enters them on the right and leaves them on the left. A pass ends when the
profile of strain over depth that leaves no longer changes, or after a given distance. Contacts that vary along the
length, and friction, are left out.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf

import numpy as np

from contactstudy.accuracy.coarser import coarsened
from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Array, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput
from contactstudy.elasticity.eigenstrain.plane_strain_operator import OuterStrain, PlaneStrainOperator, Volume
from contactstudy.evolution.states.plastic import (
    Contact,
    YieldingBody,
    check_paddings,
    embedded,
    enlarged,
    layers,
    step_solution,
)
from contactstudy.evolution.states.state_variables import WarmStartedContact, solved_or_unloaded, with_added_gap
from contactstudy.scene.loads import ConstantLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.solids.bodies import creeps, instantaneous
from contactstudy.solvers.conjugate_gradients import contact_tangent
from contactstudy.solvers.plasticity import Hardening, Tangent, YieldingBodies, solve_elastoplastic_step
from contactstudy.solvers.solution import Counts, Solution, Status, unloaded, worst
from contactstudy.solvers.solve import SolveOptions


def with_zero_layers(field: Array, layers: int) -> Array:
    """Return a field (..., layers) with zeros appended up to `layers` layers."""
    shape = *field.shape[:-1], layers - field.shape[-1]
    return np.concatenate((field, np.zeros(shape)), axis=-1)


@dataclass(frozen=True, eq=False)
class Track:
    """A half-space in plane strain over which a contact rolls, seen on a grid that moves with the contact.

    Fields and profiles over depth have four components: the three of plastic strain in the basis of its operator,
    ``(xx - zz) / sqrt(2)``, ``(2 yy - xx - zz) / sqrt(6)`` and ``sqrt(2) xz``, and the equivalent plastic strain.

    Attributes
    ----------
    outer_strain
        Influence of the half-space outside the moving grid.
    hardening
        Yield stress and hardening moduli [Pa].
    plastic
        Plastic strain and its equivalent (4, layers, x, 1) in the moving grid.
    behind
        Profile (4, layers) from the left edge of the moving grid to infinity: a running mean of the profiles that left
        the moving grid. The last one alone would make it oscillate with the period of the moving grid.
    front
        Profile (4, layers) on the right of the moving grid.
    """

    outer_strain: OuterStrain
    hardening: Hardening
    plastic: Array
    behind: Array
    front: Array

    @classmethod
    def virgin(cls, operator: PlaneStrainOperator, hardening: Hardening) -> "Track":
        """Return a virgin track, without plastic strain."""
        plastic = np.zeros((len(operator.basis) + 1, *operator.volume.shape))
        return cls(OuterStrain(operator), hardening, plastic, plastic[..., 0, 0], plastic[..., 0, 0])

    @property
    def operator(self) -> PlaneStrainOperator:
        """Operator on plastic strain in the moving grid."""
        return self.outer_strain.operator

    @property
    def strain(self) -> Array:
        """Plastic strain (3, layers, x, 1) in the moving grid."""
        return self.plastic[:-1]

    @property
    def left_profile(self) -> Array:
        """Profile (4, layers) at the left edge of the moving grid, which leaves it in the next step."""
        return self.plastic[..., 0, 0]

    @property
    def outside(self) -> tuple[Array, Array]:
        """Profiles of plastic strain (3, layers) behind the moving grid and in front of it."""
        return self.behind[:-1], self.front[:-1]

    def rolled(self, weight: float) -> "Track":
        """Return the track after the contact has rolled by one cell.

        Parameters
        ----------
        weight
            Weight, from 0 to 1, of the profile that leaves the moving grid in the mean behind it.
        """
        plastic = np.roll(self.plastic, -1, axis=2)
        plastic[:, :, -1, 0] = self.front
        return replace(self, plastic=plastic, behind=self.behind + weight * (self.left_profile - self.behind))

    def deeper(self, volume: Volume) -> "Track":
        """Return the track in a larger `volume`, whose added layers have not yielded."""
        operator = PlaneStrainOperator(volume, self.operator.moduli)
        behind, front = (with_zero_layers(profile, volume.shape[0]) for profile in (self.behind, self.front))
        return Track(OuterStrain(operator), self.hardening, embedded(self.plastic, 0, volume), behind, front)

    def residual_stress(self) -> Array:
        """Return the residual stress (6, layers, x, 1) [Pa] in the moving grid, tension positive."""
        return self.operator.residual_stress_tensor(self.strain) + self.outer_strain.tensor(*self.outside)


# Numbers of these components in a symmetric tensor xx, yy, zz, yz, xz, xy.
XX, YY, XZ = 0, 1, 4


@dataclass(frozen=True, eq=False)
class RollingPass:
    """Pass of a contact over a half-space: the strain that it leaves behind, and how it ended.

    Attributes
    ----------
    profile
        Plastic strain and its equivalent (4, layers) that the pass leaves behind.
    distance
        Distance rolled [m].
    solution
        The contact at the end of the pass.
    status
        The worst status of its steps. It is PASS_NOT_STEADY where what the pass leaves behind did not become steady, as
        in a given distance of little more than the width of the grid or less. It is YIELD_AT_EDGE where yield reaches
        the left or right edge of the moving grid.
    steps
        Number of steps; in the first pass with the one that applies the load.
    iterations
        Iterations of Newton's method in these steps.
    """

    profile: Array
    distance: float
    solution: Solution
    status: Status
    steps: int
    iterations: int


@dataclass(frozen=True, eq=False)
class RepeatedRolling:
    """Passes of a contact over an elastic-plastic half-space.

    Arrays are (pass, z) or (pass, component, z): components xx, yy, zz, yz, xz, xy with x in the direction of travel
    and z into the body, stress positive in tension. Each is taken at the left edge of the grid after the pass: far
    behind the contact, where nothing changes along x, unless the status is PASS_NOT_STEADY.

    Attributes
    ----------
    passes
        The passes, in order.
    track
        The half-space in the moving grid of the last pass.
    unloaded
        The half-space after the last pass, with the load removed.
    description
        The scene, grid and padding.
    solve_on
        Rolls the same scene on another grid.
    """

    passes: tuple[RollingPass, ...]
    track: Track
    unloaded: Track
    description: PosedScene
    solve_on: "Callable[[Grid], RepeatedRolling]"

    @cached_property
    def coarse(self) -> "RepeatedRolling":
        """Passes on cells of twice the size, by which errors are estimated; rolled on first access."""
        return self.solve_on(coarsened(self.grid, 2))

    @property
    def grid(self) -> Grid:
        """Grid that moves with the contact."""
        return self.track.operator.volume.grid

    @property
    def depths(self) -> Array:
        """Depths of the middles of the layers (z,) [m]."""
        return self.track.operator.volume.depths

    @property
    def plastic_strain(self) -> Array:
        """Plastic strain (pass, component, z) that each pass leaves behind."""
        basis = self.track.operator.basis
        return np.asarray(np.einsum("ct,ncl->ntl", basis, self._profiles[:, :-1]))

    @property
    def equivalent_plastic_strain(self) -> Array:
        """Equivalent plastic strain (pass, z) that each pass leaves behind."""
        return self._profiles[:, -1]

    @property
    def residual_stress(self) -> Array:
        """Residual stress (pass, component, z) [Pa] far behind the contact after each pass, tension positive.

        Only xx and yy differ from zero, by equilibrium of an infinite half-space that does not vary along x and y.
        They are those of plane stress, with total strains xx and yy of zero.
        """
        moduli = self.track.operator.moduli
        strain, nu = self.plastic_strain, moduli.poisson_ratio
        stress = np.zeros_like(strain)
        stress[:, XX] = -moduli.plane_strain * (strain[:, XX] + nu * strain[:, YY])
        stress[:, YY] = -moduli.plane_strain * (strain[:, YY] + nu * strain[:, XX])
        return stress

    @property
    def plastic_strain_increment(self) -> Array:
        """Largest equivalent plastic strain (pass,) that each pass adds; 0 where nothing yields any more."""
        return np.asarray(self._added_per_pass(self.equivalent_plastic_strain).max(axis=-1))

    @property
    def shear_strain_increment(self) -> Array:
        """Engineering plastic shear strain ``2 e_xz`` (pass, z) that each pass adds."""
        return 2 * self._added_per_pass(self.plastic_strain[:, XZ])

    @property
    def forward_displacement(self) -> Array:
        """Distance (pass,) [m] by which each pass moves the surface over deep material, against the direction of travel.

        It is the integral of :attr:`shear_strain_increment` over depth. On a disc that turns below a contact that stays
        in place, it is forwards (Crook 1957, Proc. Inst. Mech. Eng. 171).
        """
        return self.shear_strain_increment @ self.track.operator.volume.thicknesses

    @property
    def peak_pressure(self) -> Array:
        """Peak pressure (pass,) [Pa] at the end of each pass."""
        return np.array([each_pass.solution.pressure.max() for each_pass in self.passes])

    @property
    def shakedown_pass(self) -> int | None:
        """Number of the first pass, counted from 1, from which on nothing yields; None if the last pass still yields."""
        still = np.flatnonzero(self.plastic_strain_increment > 0)
        last = int(still[-1]) + 1 if still.size else 0
        return None if last == len(self.passes) else last + 1

    @property
    def status(self) -> Status:
        """The worst status of all passes."""
        return worst([each_pass.status for each_pass in self.passes])

    @property
    def counts(self) -> Counts:
        """Number of passes, and of the steps and iterations in them."""
        return {
            "passes": (len(self.passes), "passes"),
            "steps": (sum(each_pass.steps for each_pass in self.passes), "steps"),
            "iterations": (
                sum(each_pass.iterations for each_pass in self.passes), "iterations of all steps"
            ),
        }  # fmt: skip

    @property
    def _profiles(self) -> Array:
        """Profiles that the passes leave behind (pass, 4, z), with layers of zeros below shallow ones."""
        return np.stack([with_zero_layers(each_pass.profile, len(self.depths)) for each_pass in self.passes])

    def _added_per_pass(self, kept: Array) -> Array:
        """Return the increase by each pass of a quantity (pass, ...) that is zero before the first."""
        return np.diff(kept, axis=0, prepend=np.zeros_like(kept[:1]))


# Depth of the first layers, in length scales of the contact, such as its half-width: Hertz's contact yields first at 0.7
# of it. More are added where the last one yields, so that this changes the time alone.
INITIAL_DEPTH = 2.0
# The longest pass, in widths of the moving grid. At its end the strain before the pass has the weight
# exp(-20 AVERAGES_PER_WIDTH) = exp(-40) in the mean strain behind.
MAX_PASS_WIDTHS = 20


def roll_repeatedly(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    options: SolveOptions,
    progress: Callable[[float, int], object] | None = None,
) -> RepeatedRolling:
    """Roll the contact of `scene` to larger x over an elastic-plastic half-space, as its ``rolling`` says.

    The half-space is infinite: in front of the moving grid it is as the previous pass left it, behind the moving grid
    as this pass leaves it. The full load is applied at once, then the contact rolls by one cell in each step, from one
    pass to the next. The heights of the other body move with the contact. The error is of first order in the cell
    width: the change on cells of half the width estimates the error that remains.

    Parameters
    ----------
    scene
        The contact, with the ``passes`` of a :class:`~contactstudy.Rolling`; one body yields, the other is elastic or
        rigid.
    grid
        Grid that moves with the contact, of one cell along the length. Everything that yields below the contact must
        be in it.
    padding
        Boundary conditions: an infinite surface across, periodic along.
    options
        How each contact is solved.
    progress
        Called after each step with the number of passes done and the number in all. A pass without a given distance is
        done in part by its steps over the fewest that show that it is steady.

    Returns
    -------
    RepeatedRolling
        Plastic strain and residual stress after each pass.

    Raises
    ------
    InvalidInput
        Unless exactly one body yields and the other is elastic or rigid; for a load that changes, more than one cell
        along the length, or a surface that ends or wraps across.
    """
    rolling = scene.rolling
    assert rolling is not None
    passes = rolling.passes
    assert passes is not None
    body = _single_yielding_body(scene)
    elastic = replace(scene, solids=instantaneous(scene.solids), rolling=None)
    problem = elastic.problem(grid, padding)
    if grid.cells[1] > 1:
        raise InvalidInput(
            f"Grid.cells[1] is {grid.cells[1]}: repeated rolling is supported in plane strain only, give 1 cell along."
        )
    check_paddings(problem)
    length, cell = problem.scales.length, grid.cell_size[0]
    volume = Volume(grid, 0, grid.cells[0], layers(grid, length, INITIAL_DEPTH * length))
    operator = PlaneStrainOperator(volume, body.moduli)
    solution = solved_or_unloaded(options, problem)
    contact: Contact = partial(_unchanged, solution)
    tangent = None
    if rolling.pressure != "elastic":  # else the pressure of the elastic contact is kept
        contact = WarmStartedContact(problem, options, solution.pressure)
        tangent = partial(contact_tangent, precision=Precision(options.precision))
    roller = _Rolling(
        contact,
        tangent,
        options.tolerance,
        length,
        lag=max(round(length / cell), 1),
        max_steps=None if rolling.distance is None else max(round(rolling.distance / cell), 1),
        steady=rolling.steady * body.hardening.yield_stress / body.moduli.youngs_modulus,
    )

    track, pressed = roller.step(Track.virgin(operator, body.hardening))
    finished: list[RollingPass] = []

    def report(fraction: float) -> None:
        if progress is not None:
            progress(len(finished) + fraction, passes)

    for _ in range(passes):
        if finished:
            track = replace(track, front=track.left_profile)
        track, rolling_pass = roller.one_pass(track, () if finished else (pressed,), report)
        finished.append(rolling_pass)
    released, _ = replace(roller, contact=partial(_unchanged, unloaded(problem)), tangent=None).step(track)
    solve_on = partial(roll_repeatedly, scene, padding=padding, options=options)
    posed = PosedScene(scene, grid, padding)
    return RepeatedRolling(tuple(finished), track, released, posed, solve_on)


# The strain behind the moving grid is a running mean over half of its width, the distance from the contact to its edge.
AVERAGES_PER_WIDTH = 2
# The contact at the end of a step, and the number of iterations of Newton's method that the step took.
SolvedStep = tuple[Solution, int]


@dataclass(frozen=True, eq=False)
class _Rolling:
    """Rolling of a contact over a :class:`Track`, step by step.

    Attributes
    ----------
    contact
        Function that returns the contact with a field (x, y) [m] added to its gap.
    tangent
        Linearisation of the contact at a solution; None if its pressure never changes.
    tolerance
        Largest relative residual.
    length
        Length scale of the contact [m].
    lag
        The same length in cells, over which changes of the plastic strain are judged.
    max_steps
        Steps of a pass; None takes as many as it needs to become steady.
    steady
        Largest change of a component of plastic strain at the left edge that counts as none: against the profile `lag`
        steps before, and against the mean behind.
    """

    contact: Contact
    tangent: Callable[[Solution], Tangent] | None
    tolerance: float
    length: float
    lag: int
    max_steps: int | None
    steady: float

    def one_pass(
        self, track: Track, first: tuple[SolvedStep, ...], report: Callable[[float], None]
    ) -> tuple[Track, RollingPass]:
        """Return the track after one more pass from the present position of the contact, and the pass.

        Parameters
        ----------
        track
            The half-space before the pass.
        first
            Steps that applied the load, which count as part of the pass.
        report
            Called after each step with the fraction of the pass that is done.
        """
        grid = track.operator.volume.grid
        steps, profiles, change = list(first), [track.left_profile], inf
        least_steps = self.max_steps or grid.cells[0] + self.lag
        max_profiles = MAX_PASS_WIDTHS * grid.cells[0] if self.max_steps is None else self.max_steps
        while len(profiles) <= max_profiles:
            before = track.rolled(AVERAGES_PER_WIDTH / grid.cells[0])
            track, step = self.step(before)
            steps.append(step)
            profiles.append(track.left_profile)
            report(min((len(profiles) - 1) / least_steps, 1.0))
            # both profiles entered the grid in this pass
            if len(profiles) > grid.cells[0] + self.lag:
                references = profiles[-1 - self.lag], track.behind
                earlier = [with_zero_layers(profile, track.operator.volume.shape[0]) for profile in references]
                change = float(np.abs(track.left_profile - earlier)[:, :-1].max())
                if self.max_steps is None and change < self.steady:
                    break
        statuses = [solution.status for solution, _ in steps]
        if change >= self.steady:
            statuses.append(Status.PASS_NOT_STEADY)
        # checked at the end only: until the strain is steady, the mean strain behind differs from the strain that leaves
        # the moving grid
        flow = (track.plastic - embedded(before.plastic, 0, track.operator.volume))[-1]
        if flow[:, [0, -1]].max() > self.steady:
            statuses.append(Status.YIELD_AT_EDGE)
        return track, RollingPass(
            track.left_profile,
            distance=(len(profiles) - 1) * grid.cell_size[0],
            solution=steps[-1][0],
            status=worst(statuses),
            steps=len(steps),
            iterations=sum(iterations for _, iterations in steps),
        )

    def step(self, track: Track) -> tuple[Track, SolvedStep]:
        """Return the track after a step, with the contact at its end and the iterations of Newton's method.

        Layers are added while the last one yields.
        """
        while True:
            bodies = YieldingBodies((track.operator,), (track.hardening,))
            outer_gap = track.outer_strain.residual_displacement(*track.outside)
            step = solve_elastoplastic_step(
                bodies,
                partial(self._pressed, outer_gap),
                self.tangent,
                bodies.concatenated([track.strain]),
                bodies.concatenated([track.plastic[-1]]),
                self.tolerance,
                bodies.concatenated([track.outer_strain.stress(*track.outside)]),
            )
            (flow,), (strain,) = bodies.split(step.equivalent_increment), bodies.split(step.strain)
            if not flow[-1].any():
                break
            track = track.deeper(enlarged(track.operator.volume, self.length, flow > 0))
        plastic = np.concatenate((strain, track.plastic[-1:] + flow))
        return replace(track, plastic=plastic), (step_solution(step, self.tolerance), step.iterations)

    def _pressed(self, outer_gap: Array, added_gap: Array) -> Solution:
        """Return the contact with the gap by the strain outside the moving grid and another one (x, y) [m] added."""
        return self.contact(outer_gap + added_gap)


def _unchanged(solution: Solution, added_gap: Array) -> Solution:
    """Return the `solution`, with the same pressure and `added_gap` (x, y) [m] added to its undeformed gap."""
    return replace(solution, problem=with_added_gap(solution.problem, added_gap))


def _single_yielding_body(scene: Scene) -> YieldingBody:
    """Return the one yielding body of `scene`; refuse a load that changes, creep, and none or two such bodies."""
    if not isinstance(scene.load, ConstantLoad):
        raise InvalidInput("Scene.load changes in time together with repeated rolling: give a LineLoad.")
    bodies = YieldingBody.in_scene(scene)
    if len(bodies) != 1 or any(map(creeps, scene.solids)):
        raise InvalidInput(
            f"Scene.solids are {scene.solids!r}: give one body that yields, an ElasticPlasticHalfSpace, and an "
            "elastic or rigid HalfSpace that rolls on it."
        )
    return bodies[0]
