"""Follow a dry scene whose state depends on its history: bodies that creep or yield, and interfaces that slide and wear.

:func:`evolve` makes of a scene what takes one step (``TimeStepper``), what tells the errors of steps
(:class:`DrySteps`), and the march that takes them (``March``). The march integrates twice: with short steps, whose
instants (`fine`) become the frames, and with steps twice as long (`coarse`). Their difference tells the error by the
steps, by factors that were found for each kind of state. The error by the cells is that of a contact at rest, of each
recorded instant, and grows where the state depends on earlier pressures. In a folder, an integration that was stopped
goes on from its last step.

Here are no contacts that are in equilibrium at each instant, as of elastic bodies that adhere or roll steadily: they are
in ``stationary``.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from io import BytesIO
from math import exp, inf
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_origin
from zipfile import BadZipFile

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.accuracy.error_terms import NO_BOUND_OF_STATES, NO_LIMIT, residual_errors
from contactstudy.accuracy.estimate import error_estimate
from contactstudy.accuracy.hidden_heights import HiddenHeights
from contactstudy.domain.errors import ErrorEstimate, ErrorParts
from contactstudy.domain.files import digest, locked, read_verified, remove_partial_files, write_with_checksum
from contactstudy.domain.grid import Array, Grid, Padding, Paddings
from contactstudy.domain.imports import VERSION, import_for, source_hash
from contactstudy.domain.validation import InvalidInput, NotDefined
from contactstudy.evolution.march import (
    MIN_STEPS_PER_PERIOD,
    Control,
    ErrorEstimator,
    March,
    Method,
    Position,
    Record,
    Scheme,
    schedule,
)
from contactstudy.evolution.time_stepper import (
    Frame,
    Instant,
    TimeStepper,
    Trajectory,
    error_of_peak,
    frame_of,
    time_stepper,
)
from contactstudy.problem.problem import Problem
from contactstudy.scene.friction import Fretting
from contactstudy.scene.loads import ChangingLoad, LoadHistory
from contactstudy.scene.scene import PosedScene, Scene
from contactstudy.solvers.solution import Solution, Status, unloaded, worst_until
from contactstudy.solvers.solve import SolveOptions

# Error over the difference of two integrations, where the steps of one are twice as long. By first order it is 1; it
# was 0.56 to 1.41 in 27 cylinders pressed to 2, 3 and 5 times yield with three hardenings in 2, 4 and 8 steps.
FIRST_ORDER_FACTOR = 1.5
# The same where wear begins: errors are of order 1/2, since the pressure changes at once, so that halving the steps
# leaves 2^-1/2 of them. Where creep is over within a step it was up to 2.34.
HALF_ORDER_FACTOR = 1 / (2**0.5 - 1)
# Largest factor by which the error of a traction falls in a doubled step: at most 3.4 in fretting of creeping bodies.
LARGEST_FALL = 4.0
# Error in the middle of a doubled step over that at its end, where creep is over within a step. Such errors are
# inversely proportional to the length of a step, and the middle comes after half of it.
INSIDE_STIFF_STEP = 2.0
# Load increments of a jump in doubled steps at first, where bodies yield. A sudden load of three times yield has an
# error of 0.6 % with them, 1.0 % with half as many, and 0.3 % with twice as many.
INCREMENTS = 4
# Largest number of halvings of a step in which bodies start to yield. Without them the error of a cylinder at three
# times yield was 2.1 % and its estimate 0.3 %; with 3 the estimate is above the error, and from 6 on both stay.
MAX_HALVINGS = 6
# In the first march, a pair of steps may add this fraction of the allowed error to the difference of two integrations.
# It is not all of it, as errors of several pairs add up, and a march with too large an error starts again.
INITIAL_TOLERANCE_FRACTION = 0.5
# Duration of the first pair of steps over that of all. It decides nothing but work: a pair that is too long is rejected.
INITIAL_STEP = 1e-2
# Least error of the steps over the tolerance of the contacts, whose own errors then count little in the differences.
MIN_ERROR_OVER_TOLERANCE = 100
# Files of a checkpoint: a recorded frame by its index, and the march to go on from.
FRAME_FILE, STATE_FILE = "frame_{:05d}.npz", "state.npz"
NO_ESTIMATE_OF_STEPS = "No bound: the time-discretisation error was not estimated."
CUT_OFF_STRAIN = "No bound: the plastic strain is cut off at the edge of the grid, give Grid.extent a larger one."
# Error by the cells at the end of an integration over that of the last contact alone: by each state variable, which
# depends on earlier pressures, and by plastic strain, whose cells below the surface add to it. With the former all
# bounds held in 238 frames with creep, wear or both, 3 to 4 times too large in the median; with plastic strain the
# ratio was up to 3.6.
GROWTH_PER_STATE_VARIABLE, GROWTH_PLASTIC = 1.2, 4.0


class ErrorsBySteps(NamedTuple):
    """Time-discretisation errors of an instant.

    Attributes
    ----------
    l1, peak_pressure
        Relative errors of the pressure in L1, and of its peak.
    traction
        Error of the tangential traction of fretting, summed over the cells [Pa]; 0 of others.
    """

    l1: float = 0.0
    peak_pressure: float = 0.0
    traction: float = 0.0


@dataclass(eq=False)
class Errors:
    """Errors of a march until now.

    Attributes
    ----------
    by_steps, inside
        Time-discretisation errors after the last doubled step, and in its middle.
    step
        Duration [s] of each of the two short steps beside the last doubled one.
    largest_by_cells
        Largest error by the cells of a recorded contact, summed over the cells [Pa].
    largest_by_residual
        Largest error by the residual of a contact that stopped before the tolerance, recorded or not, summed alike [Pa].
    after_stiff_step
        Time [s] after the last step longer than a retardation time, and errors of the pressure then: summed over the
        cells, and the largest of any cell [Pa]. These errors decay at least as fast as creep in the longest retardation
        time, and count even where the difference of two integrations vanishes on the way.
    """

    by_steps: ErrorsBySteps = field(default_factory=ErrorsBySteps)
    inside: ErrorsBySteps = field(default_factory=ErrorsBySteps)
    step: float = 0.0
    largest_by_cells: float = 0.0
    largest_by_residual: float = 0.0
    after_stiff_step: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(eq=False)
class DrySteps(Method[Instant, Frame]):
    """Steps of a dry scene; errors are relative to the pressure, or where bodies yield to that under the largest load.

    Attributes
    ----------
    stepper
        Takes one step.
    estimator
        How the time-discretisation error is estimated: by "step_doubling", or "none".
    errors
        Errors until now, which :meth:`begin` sets to none and :meth:`accept` and :meth:`recorded` keep up to date.
    """

    stepper: TimeStepper
    estimator: ErrorEstimator
    errors: "Errors" = field(init=False)

    def __post_init__(self) -> None:
        self.increments = 0 if self.stepper.coupled is None else INCREMENTS

    def begin(self, start: Instant) -> tuple[Instant, Instant | None]:
        """Forget all errors, and return the instant before the first load, for short steps and for doubled ones, if any.

        Short steps are halved where bodies start to yield.
        """
        self.errors = Errors()
        if self.estimator == "none":
            return start, None
        return replace(start, max_halvings=MAX_HALVINGS), start

    def step(self, state: Instant, end: float) -> Instant:
        """Return the contact after a step to the time `end` [s], before any jump of the load there."""
        return self.stepper.step(state, end)

    def jump(self, state: Instant, increments: int) -> Instant:
        """Return the contact after the jump of the load at its time in so many increments."""
        return self.stepper.jump(state, increments)

    def error(self, before: tuple[Instant, Instant], middle: Instant, after: tuple[Instant, Instant]) -> float:
        """Return by how much a pair of steps raises the time-discretisation error; infinite without a solution.

        `before` and `after` are the instants (fine, coarse) at the begin and at the end of the pair.
        """
        if inf in (after[0].step_error, after[1].step_error):
            return inf
        change = (after[0].pressure - after[1].pressure) - (before[0].pressure - before[1].pressure)
        of_traction = self._traction_error(*after) - self._traction_error(*before)
        step = (after[0].time - before[0].time) / 2
        total = self._error_over_difference(step) * float(np.abs(change).sum())
        return max(self._relative(total, after[0], before[0]), of_traction)

    def accept(self, before: Instant, middle: Instant, after: tuple[Instant, Instant | None]) -> float:
        """Keep the errors of a pair of steps or a jump, and return the largest relative error in L1.

        `after` are the instants (fine, coarse) at its end. It is called once for each pair or jump, in their order.
        """
        (fine, coarse), errors = after, self.errors
        for instant in {id(instant): instant for instant in (middle, fine, coarse) if instant}.values():
            self._keep_residuals(instant.contacts)
        if coarse is None:
            return 0.0
        if fine.time > before.time:
            errors.step = (fine.time - before.time) / 2
        earlier, errors.by_steps = errors.by_steps, self._update_by_steps(fine, coarse, errors.step)
        # what is recorded in the middle lies between two instants of the doubled step
        factor = INSIDE_STIFF_STEP if self.stepper.creep_ends_within(errors.step) else 1.0
        pairs = zip(earlier, errors.by_steps, strict=True)
        errors.inside = ErrorsBySteps(*(max(at_begin, factor * at_end) for at_begin, at_end in pairs))
        size = self._size_of_traction(fine)
        return max(errors.by_steps.l1, errors.by_steps.traction / size if size else 0.0)

    def recorded(self, record: Record[Instant], *, has_failed: bool) -> Frame:
        """Return what is recorded as a frame; its errors are infinite if the march ends without a solution."""
        instant, stepper = record.state, self.stepper
        variables = stepper.all_state_variables
        solution = instant.contacts[-1] if instant.contacts else unloaded(stepper.problem)
        by_steps = self._errors_by_steps(record, has_failed=has_failed)
        status = worst_until(solution.status, record.statuses)
        shown = {
            name: field
            for variable, state in zip(variables, instant.states, strict=True)
            for name, field in variable.fields(state).items()
        }
        problem, displacement, estimate = solution.problem, solution.displacement, None
        # without state variables the estimate is that of a contact at rest, made from the frame when it is asked for
        if variables or has_failed or not solution.pressure.any():
            problem = stepper.problem
            displacement = solution.gap + solution.approach - problem.undeformed_gap
            estimate = self._estimate(solution, status, by_steps)
        work: Any = {name: record.work[name] for name in ("solves", "iterations", "convolutions")}
        return frame_of(
            solution,
            time=instant.time,
            load=instant.load,
            problem=problem,
            displacement=displacement,
            traction=stepper.traction(instant),
            fields=shown,
            coupled_state={} if stepper.coupled is None else instant.states[-1],
            status=status,
            errors_by_steps=by_steps,
            estimate=estimate,
            adhesion=instant.adhesion,
            **work,
        )

    def _errors_by_steps(self, record: Record[Instant], *, has_failed: bool) -> dict[str, float]:
        """Return the relative time-discretisation errors of a record: "l1", and "peak_pressure" of the peak.

        "l1" is that of the tangential traction of fretting where that is larger. Both are infinite without an estimate.
        """
        errors, fretting = self.errors, self.stepper.fretting
        if has_failed or (self.estimator == "none" and self.stepper.all_state_variables):
            return {"l1": inf, "peak_pressure": inf}
        l1, of_peak, of_traction = errors.inside if record.coarse is None else errors.by_steps
        if fretting is None:
            return {"l1": l1, "peak_pressure": of_peak}
        # what two integrations have in common: errors of the traction, and of a pressure that its slip wears
        common, size = fretting.common_error(record.state.states[-1]), self._size_of_traction(record.state)
        of_pressure = common if fretting.wear else 0.0
        l1 = max(l1 + of_pressure, (of_traction / size if size else 0.0) + common)
        return {"l1": l1, "peak_pressure": of_peak + of_pressure}

    def _update_by_steps(self, fine: Instant, coarse: Instant, step: float) -> ErrorsBySteps:
        """Return the errors of `fine` by the steps, from the errors before.

        Those of the pressure of bodies which are apart in `fine` alone are relative to the pressure of `coarse`. The
        last step of `fine` took the time `step` [s].
        """
        errors, instant = self.errors, fine if fine.pressure.any() else coarse
        time, *earlier = errors.after_stiff_step
        decay = exp(min(time - fine.time, 0.0) / self.stepper.longest_retardation_time)
        sizes = np.abs(fine.pressure - coarse.pressure) * self._error_over_difference(step)
        of_both = float(sizes.sum()), error_of_peak(fine.pressure, sizes)
        total, largest = (max(size, decay * error) for size, error in zip(of_both, earlier, strict=True))
        if self.stepper.creep_ends_within(step):
            errors.after_stiff_step = fine.time, total, largest
        # the difference of two integrations may vanish where the force turns, and their error does not
        of_traction = self._traction_error(fine, coarse) * self._size_of_traction(fine)
        of_traction = max(of_traction, errors.by_steps.traction / LARGEST_FALL)
        peak = float(instant.pressure.max())
        return ErrorsBySteps(self._relative(total, instant), largest / peak if peak else 0.0, of_traction)

    def _size_of_traction(self, instant: Instant) -> float:
        """Return the L1 norm [Pa] that errors of the traction of fretting are relative to; 0 without fretting."""
        fretting = self.stepper.fretting
        return 0.0 if fretting is None else fretting.size(instant.states[-1])

    def _traction_error(self, fine: Instant, coarse: Instant) -> float:
        """Return the relative L1 error of the traction of fretting that two integrations differ by; 0 without it."""
        fretting = self.stepper.fretting
        return 0.0 if fretting is None else fretting.time_discretisation_error(fine.states[-1], coarse.states[-1])

    def _relative(self, norm: float, *instants: Instant) -> float:
        """Return an error summed over the cells [Pa], relative to the largest L1 norm of the pressures of `instants`.

        Beside a coupled state variable it is relative to the pressure under the largest load.
        """
        if self.stepper.coupled is not None:
            return self._relative_to_largest_load(norm)
        total = max(float(instant.pressure.sum()) for instant in instants)
        return norm / total if total else 0.0

    def _error_over_difference(self, step: float) -> float:
        """Return the largest error over the difference of two integrations, after a `step` [s].

        It is 1.5 where bodies yield, 2.41 where they wear, fret, or creep within a step, else 1.
        """
        if self.stepper.coupled is not None:
            return FIRST_ORDER_FACTOR
        return HALF_ORDER_FACTOR if self.stepper.is_half_order(step) else 1.0

    def _keep_residuals(self, contacts: Iterable[Solution]) -> None:
        """Keep the errors of contacts that stopped before the tolerance, on whose pressure later states depend."""
        for contact in contacts if self.stepper.all_state_variables else ():
            if not contact.status.has_converged and contact.pressure.any():
                total = residual_errors(contact).l1 * float(contact.pressure.sum())
                self.errors.largest_by_residual = max(self.errors.largest_by_residual, total)

    @cached_property
    def _heights(self) -> HiddenHeights | None:
        """Heights inside the cells, which all instants share."""
        return HiddenHeights.from_problem(self.stepper.problem)

    def _estimate(self, solution: Solution, status: Status, by_steps: Mapping[str, float]) -> ErrorEstimate:
        """Return the errors of a recorded contact, with the `status` and the errors `by_steps` of its frame.

        Those of the pressure and its peak are known. The bound of the peak is by each cause the larger one of both, but
        by the steps its own.
        """
        l1, of_peak, warnings = self._update_by_grid(solution)
        reason = next(iter(warnings), "")
        l1 = replace(l1, steps=by_steps["l1"])
        if status is Status.YIELD_AT_EDGE:
            l1, reason = replace(l1, discretisation=inf), CUT_OFF_STRAIN
        if by_steps["l1"] == inf:
            reason = reason or NO_ESTIMATE_OF_STEPS
        larger: Any = {cause: max(part, of_peak.by_cause.get(cause, 0.0)) for cause, part in l1.by_cause.items()}
        peak = replace(l1, **larger | {"steps": by_steps["peak_pressure"]})
        l1, peak = (replace(parts, reason=reason if parts.total == inf else "") for parts in (l1, peak))
        if l1.range is not None:
            peak = replace(peak, range=inf, reason=NO_LIMIT)
        unknown = ErrorParts(discretisation=inf, reason=NO_BOUND_OF_STATES)
        return ErrorEstimate(
            l1=l1,
            peak_pressure=peak,
            contact_area=unknown if solution.pressure.any() else l1,  # separated bodies have no area
            mean_gap=unknown,
            approach=unknown,
            stress=unknown if solution.problem.outputs else None,
            warnings=warnings,
        )

    def _update_by_grid(self, solution: Solution) -> tuple[ErrorParts, ErrorParts, tuple[str, ...]]:
        """Return errors of a contact on this grid by cause, and keep the largest ones, which later frames inherit.

        They are those in L1, those of its peak pressure, and the reasons why any is infinite.
        """
        unknown, none = ErrorParts(images=0.0, discretisation=inf, residual=0.0), ErrorParts(0.0, 0.0, 0.0)
        pressure, stepper, errors = solution.pressure, self.stepper, self.errors
        if not np.isfinite(solution.residual):
            return unknown, unknown, (f"No bound: {solution.status}",)
        if not pressure.any():
            return none, none, ()
        try:
            estimate = error_estimate(solution, heights=self._heights)
        except NotDefined as reason:
            return unknown, unknown, (f"No bound: {reason}",)
        total = float(pressure.sum())
        # creep and wear keep the errors of earlier pressures, so that they enter later frames
        cells, residual = (estimate.l1.by_cause[cause] for cause in ("discretisation", "residual"))
        errors.largest_by_cells = max(errors.largest_by_cells, cells * total)
        if not solution.status.has_converged:
            errors.largest_by_residual = max(errors.largest_by_residual, residual * total)
        residual = max(residual, errors.largest_by_residual / total)
        factor = 1.0
        if stepper.coupled is not None:
            cells *= GROWTH_PLASTIC
            factor = self._relative_to_largest_load(total)
        elif stepper.state_variables:
            growth = GROWTH_PER_STATE_VARIABLE ** len(stepper.state_variables)
            cells = growth * errors.largest_by_cells / total
        parts = ErrorParts(estimate.l1.images, cells, residual, range=estimate.l1.range)
        assert estimate.peak_pressure is not None
        return parts.scaled(factor), estimate.peak_pressure, estimate.warnings

    def _relative_to_largest_load(self, pressures: float) -> float:
        """Return a sum of cell pressures [Pa] divided by the sum under the largest load."""
        largest = self.stepper.load.largest * self.stepper.loaded_length
        return pressures * self.stepper.problem.grid.cell_area / largest


def evolve(
    scene: Scene,
    grid: Grid,
    padding: Padding | Paddings,
    *,
    times: ArrayLike,
    error: float | None = None,
    error_estimator: ErrorEstimator = "step_doubling",
    scheme: Scheme = "implicit",
    options: SolveOptions = SolveOptions(),  # noqa: B008 (a frozen value)
    folder: str | PathLike[str] | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> Trajectory:
    """Follow `scene` through time, from the start of its load.

    The time-discretisation error follows from the difference of two integrations, one with steps twice as long. Of a
    method of order p the difference is ``2^p - 1`` times the error of the shorter steps, which are recorded: an upper
    estimate for order 2, the error itself for order 1. It is multiplied by 1.5 where bodies yield (first order), else
    by 2.41 where contacts wear or fret (order 1/2 at the onset of wear), or creep is over within a step. After such a
    step the error falls no faster than creep in the longest retardation time.

    The error is relative to the pressure at the same instant; where bodies yield, to the pressure under the largest
    load, as is the error by the cells. In fretting it is the larger one of the pressure and of the tangential traction.
    Where bodies yield, a load jump is applied in increments.

    Parameters
    ----------
    scene
        The scene. A :class:`~contactstudy.LineLoad` is applied suddenly at 0 s, or at the first of `times` if that is
        earlier.
    grid, padding
        Cells and boundary conditions, as for :func:`~contactstudy.solve`.
    times
        Recorded instants [s], which do not decrease. Steps end there, and wherever the load or its rate jumps; where
        bodies yield or fret, also where it turns. A time given twice is recorded before and after a jump of the load.
    error
        Allowed relative L1 time-discretisation error, for which steps are chosen. None steps from one of `times` to the
        next, at most a quarter of the load's period at a time; two steps that differ much in length are halved each.
    error_estimator
        How the time-discretisation error is estimated.
    scheme
        How sliding wear is stepped.
    options
        How each contact is solved.
    folder
        Folder for frames and states. An integration that was stopped continues from there.
    progress
        Called with the time since the start and that of the whole [s].

    Returns
    -------
    Trajectory
        The recorded frames, with their estimated errors.

    Raises
    ------
    InvalidInput
        If times decrease, the error is too close to the solver's tolerance, or the folder is of another integration.
    """
    load = _load(scene, times)
    end = schedule(load, times)[-1].time
    if error is not None and error < MIN_ERROR_OVER_TOLERANCE * options.tolerance:
        raise InvalidInput(
            f"solve.error or TimeSteps.error leaves {error!r} to the steps in time: give at least "
            f"{MIN_ERROR_OVER_TOLERANCE} times the tolerance of the contacts, or a smaller tolerance."
        )
    stepper = time_stepper(scene, grid, padding, load, end - load.start, scheme, options)
    keeps_states = bool(stepper.all_state_variables)
    breakpoints = schedule(
        load,
        times,
        turns=load.turning_points(end) if stepper.depends_on_path else (),
        history=scene.friction.history if isinstance(scene.friction, Fretting) else None,
        # steps of whole periods would meet the load at the same place of each, and not see that it changes
        longest=getattr(load, "period", inf) / MIN_STEPS_PER_PERIOD if keeps_states else inf,
    )
    control = None
    if keeps_states and error is not None:
        limit, first = INITIAL_TOLERANCE_FRACTION * error, INITIAL_STEP * (end - load.start)
        control = Control(limit, DrySteps.order, first, allowed=error)
    steps = DrySteps(stepper, error_estimator if keeps_states else "none")
    start = stepper.start(breakpoints[0].time)
    march = March(steps, start, breakpoints, control, progress)
    if folder is None:
        march.run()
    else:
        instants = tuple(np.asarray(times, float).ravel().tolist())
        request = scene, grid, padding, instants, error, error_estimator, scheme, options
        with Checkpoint.open(Path(folder), request) as checkpoint:
            _run_in(checkpoint, march, steps)
    return Trajectory(tuple(march.results), march.position.total, PosedScene(scene, grid, padding), stepper.coupled)


T = TypeVar("T")
# Key in JSON of the name of an array, which is stored beside it.
ARRAY = "array"


@dataclass(frozen=True)
class Checkpoint:
    """Folder of one integration, in which values are kept: made by :meth:`open`.

    Beside ``request.json``, which says of what integration the folder is, each value has a file, such as
    ``frame_00000.npz``. Each file has a checksum and is replaced in one step, so that a killed integration leaves the
    previous one and damage is detected.

    Attributes
    ----------
    folder
        The folder.
    request_hash
        Hash of the request and of this program, which every file names.
    """

    folder: Path
    request_hash: str

    @classmethod
    @contextmanager
    def open(cls, folder: Path, request: object) -> "Iterator[Checkpoint]":
        """Make the folder of an integration, or check that it is of this one, and lock it as long as the block lasts.

        Parameters
        ----------
        folder
            The folder; it need not exist.
        request
            Scene, grid and options that identify the integration.

        Raises
        ------
        InvalidInput
            If the folder holds another integration, one of another version of this program or in another process, or
            damaged files.
        """
        folder.mkdir(parents=True, exist_ok=True)
        identity = {"request": digest(request), "version": VERSION, "source": source_hash()}
        checkpoint, path = cls(folder, digest(identity)), folder / "request.json"
        with locked(folder / ".integration.lock", f"solve.folder {str(folder)!r}"):
            remove_partial_files(folder)
            if path.exists():
                checkpoint._check_identity(identity)
            elif any(not entry.name.startswith(".") for entry in folder.iterdir()):
                raise InvalidInput(f"solve.folder is {str(folder)!r}, which holds other files: give an empty folder.")
            else:
                write_with_checksum(path, json.dumps(identity, indent=1).encode())
            yield checkpoint

    def _check_identity(self, identity: Mapping[str, Any]) -> None:
        """Raise InvalidInput if ``request.json`` in the folder has another identity: "request", "version", "source"."""
        with self._report_damage():
            content = read_verified(self.folder / "request.json")
            stored = json.loads(content or b"")
            stored_identity = [stored[name] for name in identity]
        what = "an integration of another version of this program"
        if stored_identity[0] != identity["request"]:
            what = "the integration of another scene, grid or request"
        if stored_identity != list(identity.values()):
            raise InvalidInput(f"solve.folder is {str(self.folder)!r}, which holds {what}: give another folder.")

    @contextmanager
    def _report_damage(self) -> Iterator[None]:
        """Convert an error that shows a damaged file into an InvalidInput that names the folder."""
        try:
            yield
        except (OSError, LookupError, TypeError, ValueError, EOFError, BadZipFile) as error:
            raise InvalidInput(
                f"solve.folder is {str(self.folder)!r}, which is damaged ({type(error).__name__}): remove it, or give "
                "another folder."
            ) from None

    def write(self, name: str, value: object) -> None:
        """Replace the file called `name` by one with `value`: its arrays beside all else as JSON, which names them."""
        arrays: dict[str, Array] = {}

        def name_array(values: object) -> dict[str, str]:
            if not isinstance(values, np.ndarray):
                raise TypeError(f"{type(values).__name__} cannot be stored in {name}")
            array = f"array_{len(arrays)}"
            arrays[array] = values
            return {ARRAY: array}

        tree = {"request": self.request_hash, "file": name}
        tree["value"] = _converter().unstructure(value)
        content = BytesIO()
        header = json.dumps(tree, default=name_array)
        np.savez(content, header=np.array(header), **arrays)  # type: ignore[arg-type]
        write_with_checksum(self.folder / name, content.getvalue())

    def read(self, name: str, kind: type[T]) -> T:
        """Return the value of that `kind` in the file called `name`."""
        path = self.folder / name
        with self._report_damage(), np.load(BytesIO(read_verified(path) or b"")) as file:

            def with_arrays(item: dict[str, Any]) -> Any:
                return file[item[ARRAY]] if ARRAY in item else item

            header = json.loads(str(file["header"]), object_hook=with_arrays)
            if (header["request"], header["file"]) != (self.request_hash, name):
                raise ValueError("a file of another integration")
            value: T = _converter().structure(header["value"], kind)
            return value


@cache
def _converter() -> Any:
    """Return a converter between dataclasses and values for JSON, which leaves arrays as they are, and problems out."""
    converter = import_for("solve.folder", "cattrs").Converter(detailed_validation=False)

    def is_array(kind: Any) -> bool:
        return np.ndarray in (kind, get_origin(kind))

    def is_counter(kind: Any) -> bool:
        return get_origin(kind) is Counter

    converter.register_unstructure_hook_func(is_array, lambda values: values)
    converter.register_structure_hook_func(is_array, lambda values, _: values)
    # counts are structured as they are, not as whole numbers: a convolution of half the grid counts as a half
    converter.register_structure_hook_func(is_counter, lambda values, _: Counter(values))
    converter.register_unstructure_hook(Problem, lambda _: None)
    converter.register_structure_hook(Problem, lambda values, _: values)
    return converter


@dataclass(frozen=True)
class _Saved:
    """Position of a march to go on from, the errors of its method there, and the number of its frames until there."""

    position: Position[Instant]
    errors: Errors
    frames: int


def _run_in(checkpoint: Checkpoint, march: March[Instant, Frame], steps: DrySteps) -> None:
    """Run a march from where the folder of a checkpoint holds it, or else from its start, and keep it there."""
    if (checkpoint.folder / STATE_FILE).exists():
        saved = checkpoint.read(STATE_FILE, _Saved)
        march.position, steps.errors = saved.position, saved.errors
        frames = (checkpoint.read(FRAME_FILE.format(n), Frame) for n in range(saved.frames))
        march.results += [replace(frame, problem=steps.stepper.problem) for frame in frames]
    written = list(march.results)

    def save() -> None:
        """Write the frames that are new, and then the position, which counts them, without the solutions on the way.

        A march that has started again has new frames from the first on.
        """
        frames, position = march.results, march.position
        for number, frame in enumerate(frames):
            if number >= len(written) or written[number] is not frame:
                checkpoint.write(FRAME_FILE.format(number), frame)
        written[:] = frames
        coarse = None if position.coarse is None else position.coarse.without_solutions()
        bare = replace(position, fine=position.fine.without_solutions(), coarse=coarse)
        checkpoint.write(STATE_FILE, _Saved(bare, steps.errors, len(frames)))

    march.run(save)


def _load(scene: Scene, times: ArrayLike) -> ChangingLoad:
    """Return the load of `scene` over time; a constant one is applied at 0 s, or at the first of `times` [s] before."""
    if isinstance(scene.load, ChangingLoad):
        return scene.load
    start = min(0.0, float(np.min(times)))
    return LoadHistory((start,), (scene.largest_load,))
