"""Repeated rolling in plane strain: the plastic strain and residual stress that passes of a contact leave behind."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from math import inf

import numpy as np

from contactstudy.accuracy.coarser import coarsened
from contactstudy.domain.grid import Array, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput
from contactstudy.elasticity.eigenstrain.half_space_wave import Volume
from contactstudy.elasticity.eigenstrain.plane_strain_operator import PlaneStrainOperator
from contactstudy.evolution.states.plastic import YieldingBody, check_paddings, embedded, layers, step_solution
from contactstudy.evolution.states.state_variables import solved_or_unloaded
from contactstudy.evolution.track import (
    ContactWithAddedGap,
    DepthProfile,
    FixedContact,
    SolvedContact,
    Track,
    with_zero_layers,
)
from contactstudy.problem.problem import Problem
from contactstudy.scene.loads import ConstantLoad
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.solids.bodies import creeps, instantaneous
from contactstudy.solvers.solution import Counts, Solution, Status, unloaded, worst
from contactstudy.solvers.solve import SolveOptions

# Numbers of these components in a symmetric tensor xx, yy, zz, yz, xz, xy.
XX, YY, XZ = 0, 1, 4


@dataclass(frozen=True, eq=False)
class RollingPass:
    """A pass of a contact over a half-space.

    Attributes
    ----------
    profile
        Plastic strain that the pass leaves behind.
    distance
        Distance rolled [m].
    solution
        The contact at the end of the pass.
    status
        The worst status of its steps; PASS_NOT_STEADY where what it leaves behind did not become steady, as in a given
        distance of little more than a width of the grid or less, and YIELD_AT_EDGE where yield reaches an edge.
    steps
        Number of steps.
    iterations
        Iterations of Newton's method in all steps.
    """

    profile: DepthProfile
    distance: float
    solution: Solution
    status: Status
    steps: int
    iterations: int


@dataclass(frozen=True, eq=False)
class RepeatedRolling:
    """Passes of a contact over an elastic-plastic half-space.

    Arrays are (pass, z) or (pass, component, z): components xx, yy, zz, yz, xz, xy with x in the direction of travel
    and z into the body, stress tension positive. Each is taken at the left edge of the
    grid after the pass: far behind the contact, where nothing changes along x, unless the status is PASS_NOT_STEADY.

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
        """The same passes on cells of twice the size, which estimate the errors; rolled on first access."""
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
        return np.asarray(np.einsum("ct,ncl->ntl", basis, self._per_pass("strain")))

    @property
    def equivalent_plastic_strain(self) -> Array:
        """Equivalent plastic strain (pass, z) that each pass leaves behind."""
        return self._per_pass("equivalent")

    @property
    def residual_stress(self) -> Array:
        """Residual stress (pass, component, z) [Pa] after each pass.

        Only xx and yy differ from zero: equilibrium of an infinite half-space that does not vary along x and y.
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

        The integral of :attr:`shear_strain_increment` over depth. On a disc that turns below a contact that stays in
        place, it is forwards (Crook 1957, Proc. Inst. Mech. Eng. 171).
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

    def _per_pass(self, name: str) -> Array:
        """Return the profiles called `name` of all passes (pass, ..., z), with layers of zeros below shallow ones."""
        profiles = (getattr(each_pass.profile, name) for each_pass in self.passes)
        return np.stack([with_zero_layers(profile, len(self.depths)) for profile in profiles])

    def _added_per_pass(self, kept: Array) -> Array:
        """Return the increase by each pass of a quantity (pass, ...) that is zero before the first."""
        return np.diff(kept, axis=0, prepend=np.zeros_like(kept[:1]))


# Depth of the first layers, in length scales of the contact; more are added where the last one yields.
INITIAL_DEPTH = 2.0
# The longest pass, in widths of the moving grid, in which the mean strain behind forgets that before to exp(-40).
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
    _check_grid(problem)
    length, cell = problem.scales.length, grid.cell_size[0]
    volume = Volume(grid, 0, grid.cells[0], layers(grid, length, INITIAL_DEPTH * length))
    operator = PlaneStrainOperator(volume, body.moduli)
    solution = solved_or_unloaded(options, problem)
    settled = SolvedContact(problem, options, solution.pressure)
    roller = _Rolling(
        FixedContact(solution) if rolling.pressure == "elastic" else settled,
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
    released, _ = track.solve_step(FixedContact(unloaded(problem)), options.tolerance, length)
    solve_on = partial(roll_repeatedly, scene, padding=padding, options=options)
    posed = PosedScene(scene, grid, padding)
    return RepeatedRolling(tuple(finished), track, released, posed, solve_on)


# The strain behind the moving grid is a mean over about half of its width: the distance from the contact to its edge.
AVERAGES_PER_WIDTH = 2
# The contact at the end of a step, and the iterations of Newton's method that the step took.
SolvedStep = tuple[Solution, int]


@dataclass(frozen=True, eq=False)
class _Rolling:
    """Steps of a rolling contact.

    Attributes
    ----------
    contact
        Solves the contact with a field added to its gap.
    tolerance
        Largest relative residual.
    length
        Length scale of the contact [m].
    lag
        The same length in cells, over which changes of the plastic strain are judged.
    max_steps
        Steps of a pass; None takes as many as it needs to become steady.
    steady
        Largest change of plastic strain that counts as steady.
    """

    contact: ContactWithAddedGap
    tolerance: float
    length: float
    lag: int
    max_steps: int | None
    steady: float

    def one_pass(
        self, track: Track, first: tuple[SolvedStep, ...], report: Callable[[float], None]
    ) -> tuple[Track, RollingPass]:
        """Roll one pass from the present position of the contact.

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
            if len(profiles) > grid.cells[0] + self.lag:
                strain = track.left_profile.strain
                references = profiles[-1 - self.lag].strain, track.mean_strain_behind
                earlier = np.stack([with_zero_layers(reference, strain.shape[1]) for reference in references])
                change = float(np.abs(strain - earlier).max(initial=0.0))
                if self.max_steps is None and change < self.steady:
                    break
        statuses = [solution.status for solution, _ in steps]
        if change >= self.steady:
            statuses.append(Status.PASS_NOT_STEADY)
        # checked at the end only: until the strain is steady, the mean strain behind differs from the strain that leaves
        # the moving grid
        flow = track.equivalent - embedded(before.equivalent, 0, track.operator.volume)
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
        """Return the track after a step, with the contact at its end and the iterations of Newton's method."""
        after, step = track.solve_step(self.contact, self.tolerance, self.length)
        solution = step_solution(step, self.tolerance)
        return after, (solution, step.iterations)


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


def _check_grid(problem: Problem) -> None:
    """Raise InvalidInput for a grid or a padding on which repeated rolling has no operator."""
    if problem.grid.cells[1] > 1:
        raise InvalidInput(
            f"Grid.cells[1] is {problem.grid.cells[1]}: repeated rolling is supported in plane strain only, "
            "give 1 cell along."
        )
    check_paddings(problem)
