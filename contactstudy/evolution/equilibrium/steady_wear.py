"""Wear of contacts that are steady at each instant: in steady or tractive rolling, or on a boundary film.

The wear depth w adds to the gap, and its rate follows from the contact on that gap: ``dw/dt = f(w)``. Heun's method
takes a step by the rates at its start and at the end of Euler's step; the change of the pressure from one to the other
controls its length. A body that turns wears alike all round, by the mean of Archard's law over its circumference.

Source of the wear law: Archard (1953).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.checks import InvalidInput, finite
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.evolution.equilibrium.quasi_static import frame_in_equilibrium
from contactstudy.evolution.equilibrium.surface_depth import SurfaceDepth
from contactstudy.evolution.rolling.steady_rolling import SteadyRolling, solve_rolling
from contactstudy.evolution.trajectory import Trajectory
from contactstudy.lubrication.film_trajectory import FilmTrajectory, errors_from_longer_steps
from contactstudy.lubrication.lubricated_contact import FilmSolution
from contactstudy.lubrication.solve_lubricated import solve_lubricated
from contactstudy.problem.problem import Field
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.scene.solids.bodies import instantaneous
from contactstudy.scene.wear import Wear
from contactstudy.solvers.friction.rolling_traction import RollingTraction
from contactstudy.solvers.solution import Solution, Status, worst
from contactstudy.solvers.solve import SolveOptions, solve_contact

# Largest depth of the first step, over the scale of the gap or the boundary film: if it is too long, it is rejected.
FIRST_DEPTH = 0.01
# Smallest and largest factor on the length of a step, and the fraction of the allowed length that is aimed at.
MIN_FACTOR, MAX_FACTOR, SAFETY = 0.1, 2.0, 0.8
# A step shorter than this, over the time between two instants, is never rejected.
SHORTEST = 1e-6
# Largest change of the pressure by the correction of a step, relative in L1, where none is asked for.
STEP_ERROR = 1e-3
# Work: steps, contact solves, their iterations, their FFT convolutions or linear iterations, rejected pairs of steps.
NO_WORK, REJECTED = np.zeros(5), np.array((0.0, 0.0, 0.0, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class _DryContact:
    """A dry contact, with its rolling resistance where it rolls."""

    solution: Solution
    rolling: SteadyRolling | None

    @property
    def pressure(self) -> Array:
        return self.solution.pressure

    @property
    def status(self) -> Status:
        return self.solution.status

    def time_discretisation_errors(self, coarse: "_DryContact") -> dict[str, float]:
        """Return relative differences to the contact after longer steps, by quantity.

        That of the peak pressure is the largest of any cell. That of the area counts cells in contact in one of both
        alone, and is at least that in L1, since a small change may move no edge to another cell.
        """
        if not self.pressure.any():  # no solution
            return dict.fromkeys(("l1", "peak_pressure", "contact_area"), inf)
        touching, change = self.pressure > 0, np.abs(self.pressure - coarse.pressure)
        moved = np.count_nonzero(touching ^ (coarse.pressure > 0)) / np.count_nonzero(touching)
        l1 = change.sum() / self.pressure.sum()
        errors = {
            "l1": l1,
            "peak_pressure": change.max() / self.pressure.max(),
            "contact_area": max(l1, moved),
        }
        if self.rolling is not None and coarse.rolling is not None:
            resistance = self.rolling.resistance_coefficient
            difference = abs(resistance - coarse.rolling.resistance_coefficient)
            errors["rolling_resistance"] = difference / abs(resistance) if difference else 0.0
        return {name: float(error) for name, error in errors.items()}


class _Worn(Protocol):
    """Protocol of a steady contact on a worn gap."""

    @property
    def pressure(self) -> Array: ...

    @property
    def status(self) -> Status: ...


Contact = TypeVar("Contact", bound=_Worn)


@dataclass(frozen=True, eq=False)
class _Instant(Generic[Contact]):
    """A contact at one time.

    Attributes
    ----------
    time
        Time [s].
    contact
        The contact on the worn gap.
    depth
        Depth (x, y) [m] worn until then.
    coarse
        The same of the integration with steps twice as long; None where it is not at hand.
    status
        The worst status of the accepted steps, each with its predictor, since the instant before.
    work
        Steps, solves, their iterations, their FFT convolutions or linear iterations, and rejected pairs of steps, since
        the instant before.
    change
        Change of the pressure by the correction of the last step, relative in L1; infinite where a solve failed.
    """

    time: float
    contact: Contact
    depth: Array
    status: Status
    coarse: "_Instant[Contact] | None" = None
    work: Array = field(default_factory=NO_WORK.copy)
    change: float = 0.0


@dataclass(frozen=True, eq=False)
class _WearingContact(Generic[Contact]):
    """A contact that wears.

    Attributes
    ----------
    solved
        Solves the contact with a wear depth (x, y) [m], from the one before if there is one.
    rate
        Wear rate (x, y) [m/s] of a contact.
    solves_and_iterations
        Number of solves of a contact, of their iterations, and of their FFT convolutions (dry) or linear iterations
        (film).
    first_depth
        Largest depth [m] of the first step.
    """

    solved: Callable[[Array, Contact | None], Contact]
    rate: Callable[[Contact], Array]
    solves_and_iterations: Callable[[Contact], tuple[float, float, float]]
    first_depth: float

    def step(self, now: _Instant[Contact], duration: float) -> _Instant[Contact]:
        """Return the contact after a step of Heun's method of that `duration` [s], and the pressure's change by it.

        The change is that from Euler's predictor to the corrected step, relative in L1.
        """
        rate = self.rate(now.contact)
        predicted = self.solved(now.depth + duration * rate, now.contact)
        depth = now.depth + duration / 2 * (rate + self.rate(predicted))
        after = self.solved(depth, predicted)
        change = np.abs(after.pressure - predicted.pressure).sum() / now.contact.pressure.sum()
        failed = after.status.is_failure or predicted.status.is_failure
        solves = np.add(self.solves_and_iterations(predicted), self.solves_and_iterations(after))
        return _Instant(
            now.time + duration,
            after,
            depth,
            worst((predicted.status, after.status)),
            work=np.array((1.0, *solves, 0.0)),
            change=inf if failed else float(change),
        )

    def integrate(
        self,
        cells: tuple[int, int],
        times: Sequence[float],
        error: float,
        progress: Callable[[float, float], None] | None = None,
    ) -> list[_Instant[Contact]]:
        """Return the contact at each of `times`, or up to one without a solution, by step doubling.

        Parameters
        ----------
        cells
            Number of cells (x, y).
        times
            Times [s], ascending.
        error
            Largest relative L1 change of the pressure by the correction of a step.
        progress
            Called with the time since the start and that of the whole [s], after each pair of steps.
        """
        start, depth = min(0.0, times[0]), np.zeros(cells)
        first = self.solved(depth, None)
        fine = coarse = _Instant(start, first, depth, first.status)
        rate = float(self.rate(fine.contact).max())
        length = self.first_depth / rate if rate else inf
        work = np.array((0.0, *self.solves_and_iterations(first), 0.0))
        if first.status.is_failure:
            return [replace(fine, coarse=coarse, work=work)]
        instants: list[_Instant[Contact]] = []
        status = first.status
        for target in times:
            span = target - fine.time
            while (remaining := target - fine.time) > SHORTEST * span:
                duration = (
                    remaining / np.ceil(remaining / min(2 * length, remaining) - SHORTEST) / 2
                )
                middle = self.step(fine, duration)
                end, double = self.step(middle, duration), self.step(coarse, 2 * duration)
                work = work + middle.work + end.work + double.work
                change = max(middle.change, end.change, double.change / 4)
                factor = SAFETY * np.sqrt(error / max(change, SHORTEST * error))
                next_length = duration * float(np.clip(factor, MIN_FACTOR, MAX_FACTOR))
                if change > error and duration > SHORTEST * span:
                    work, length = work + REJECTED, next_length
                    continue
                fine, coarse = end, double
                status = worst((status, middle.status, end.status, double.status))
                if not np.isfinite(change):
                    return [*instants, replace(fine, status=status, coarse=coarse, work=work)]
                # a step shortened to end at an instant does not limit the next one
                length = max(next_length, length if duration < length else 0.0)
                if progress is not None:
                    progress(fine.time - start, times[-1] - start)
            instants.append(replace(fine, time=target, status=status, coarse=coarse, work=work))
            work, status = NO_WORK, fine.contact.status
        return instants


def follow_wear(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike | None,
    error: float | None = None,
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    progress: Callable[[float, float], None] | None = None,
) -> Trajectory:
    """Follow the wear of a contact in steady or tractive rolling.

    Parameters
    ----------
    scene
        A scene with wear, and with steady or tractive rolling.
    grid, padding
        Cells and boundary conditions, as for :func:`~contactstudy.solve`.
    times
        Recorded instants [s], ascending. Wear begins at 0 s, or at the first of them if that is earlier.
    error
        Largest relative L1 change of the pressure from Euler's step to that of Heun's method; 1e-3 if None.
    options
        How each contact is solved.
    progress
        Called with the time since the start and that of the whole [s], after each pair of steps.

    Returns
    -------
    Trajectory
        The recorded frames. Their time-discretisation error is the change from an evolution with steps twice as long.

    Raises
    ------
    InvalidInput
        If no times are given, or they do not ascend.
    """
    wear, unworn = scene.wear, replace(scene, wear=None)
    assert wear is not None
    elastic = replace(unworn, rolling=None, solids=instantaneous(scene.solids))
    problem = elastic.problem(grid, padding)

    def solved(depth: Array, before: _DryContact | None) -> _DryContact:
        worn = replace(unworn, shapes=(*unworn.shapes, SurfaceDepth(depth, grid)))
        if worn.rolls:
            rolling = solve_rolling(worn, grid, padding, options=options)
            return _DryContact(rolling.solution, rolling)
        start = None if before is None else before.pressure
        return _DryContact(solve_contact(worn.problem(grid, padding), options, start), None)

    def rate(contact: _DryContact) -> Array:
        traction = contact.solution.traction
        if isinstance(traction, RollingTraction):
            # where it slips, friction times slip is the coefficient of friction times pressure times slip
            pv = traction.power / getattr(scene.friction, "coefficient", 1.0)
            return _wear_rate(wear, pv, grid)
        return _wear_rate(wear, wear.speed * contact.pressure, grid)

    def solves_and_iterations(contact: _DryContact) -> tuple[float, float, float]:
        solves = 1 if contact.rolling is None else contact.rolling.lagged.outer_iterations
        return solves, contact.solution.iterations, contact.solution.convolutions

    contact = _WearingContact(solved, rate, solves_and_iterations, FIRST_DEPTH * problem.scales.gap)
    instants = contact.integrate(grid.cells, *_instants(times, error), progress)
    frames = []
    for instant in instants:
        assert instant.coarse is not None
        solution, errors = (
            instant.contact.solution,
            instant.contact.time_discretisation_errors(instant.coarse.contact),
        )
        # the plot of an instant names the scene, not the surface that is worn by now
        posed = PosedScene(scene, grid, padding)
        solution = replace(solution, problem=replace(solution.problem, description=posed))
        wear_depth = Field(("x", "y"), instant.depth, "m", "wear depth")
        frames.append(
            replace(
                frame_in_equilibrium(
                    instant.time,
                    scene.largest_load,
                    solution,
                    instant.contact.rolling,
                ),
                status=instant.status,
                fields={"wear_depth": wear_depth},
                time_discretisation_error=errors.pop("l1"),
                time_discretisation_errors=errors,
                solves=int(instant.work[1]),
                iterations=int(instant.work[2]),
                convolutions=float(instant.work[3]),
            )
        )
    rejected = sum(instant.work[4] for instant in instants)
    return Trajectory(problem, tuple(frames), int(rejected), 0, PosedScene(scene, grid, padding))


def follow_film_wear(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike | None,
    error: float | None = None,
    options: SolveOptions,
    progress: Callable[[float, float], None] | None = None,
) -> FilmTrajectory:
    """Follow the wear of asperities on the boundary film of `scene`; the arguments are those of :func:`follow_wear`.

    The film is steady at each instant, solved from that before. Wear follows from the pressure that asperities carry,
    not from that of the lubricant.
    """
    wear, lubrication, unworn = scene.wear, scene.lubrication, replace(scene, wear=None)
    assert wear is not None
    assert lubrication is not None
    assert lubrication.boundary is not None

    def solved(depth: Array, before: FilmSolution | None) -> FilmSolution:
        worn = replace(unworn, shapes=(*unworn.shapes, SurfaceDepth(depth, grid)))
        film = solve_lubricated(
            worn,
            grid,
            padding,
            tolerance=options.tolerance,
            max_iterations=options.max_iterations,
            start=before,
        )
        return replace(film, scene=scene, wear_depth=depth)

    def rate(film: FilmSolution) -> Array:
        assert film.contact_pressure is not None
        return _wear_rate(wear, abs(film.sliding_speed) * film.contact_pressure, grid)

    def solves_and_iterations(film: FilmSolution) -> tuple[float, float, float]:
        return 1, film.iterations, film.linear_iterations

    contact = _WearingContact(
        solved, rate, solves_and_iterations, FIRST_DEPTH * lubrication.boundary.film
    )
    instants = contact.integrate(grid.cells, *_instants(times, error), progress)
    steps, _, first, second, _ = np.sum([instant.work for instant in instants], axis=0)
    films = FilmTrajectory(
        tuple(instant.time for instant in instants),
        tuple(replace(instant.contact, status=instant.status) for instant in instants),
        int(steps),
        int(first),
        int(second),
    )
    coarse = tuple(instant.coarse.contact for instant in instants if instant.coarse is not None)
    return replace(films, time_discretisation_errors=errors_from_longer_steps(films, coarse))


def _wear_rate(wear: Wear, pv: Array, grid: Grid) -> Array:
    """Return the wear rate (x, y) [m/s] where the product of pressure and sliding speed is `pv` (x, y) [W/m^2]."""
    if wear.circumference is None:
        return wear.coefficient * pv
    around = pv.sum(axis=0) * grid.cell_size[0] / wear.circumference
    return np.broadcast_to(wear.coefficient * around, pv.shape)


def _instants(times: ArrayLike | None, error: float | None) -> tuple[list[float], float]:
    """Return the instants [s] to record, once they are checked, and the error of a step."""
    if times is None:
        raise InvalidInput("solve.times is None, and wear has no end: give times [s].")
    instants = [finite("solve.times", time, "give times in s") for time in np.ravel(times).tolist()]
    if not instants or sorted(set(instants)) != instants:
        raise InvalidInput(f"solve.times is {times!r}: give one or more, ascending.")
    return instants, STEP_ERROR if error is None else error
