"""Operations on the fields of the conjugate gradients, chosen once for a problem: array library, or compiled loops.

An iteration takes a step from one pressure (x, y) to the next, the trial pressure, along a :class:`Direction`; its
displacement and its gap follow. All fields are dimensionless. The active set is a field that is 1 in its cells and 0
elsewhere.

Both kinds of operations give the same numbers to rounding. :class:`ArrayOperations` serve any device and any
constraint. A compiled loop of :class:`CompiledOperations` reads and writes each field once; on 128 x 128 cells and more
that makes a solve 1.5 to 1.7 times as fast. Where a loop saves less than 3 % of a solve, array operations serve all.
"""

from math import inf, isnan, nan, prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from contactstudy.domain.device import Cpu, Precision, arrays, device
from contactstudy.domain.grid import MIN_COMPILED_CELLS, Array, compiled_loops, device_loops, dot, max_abs, total
from contactstudy.problem.constraint import Constraint, Control, Gap, largest_of, shift_to_load

# Heights beyond this need double precision: squares and sums of them overflow in single precision.
SINGLE_LIMIT = 1e15


class Direction(NamedTuple):
    """Direction of a step: `shift` less the `preconditioned` residual, plus `beta` times the last step.

    It is zero outside the `active` set. The shift is one number for all cells, which keeps the load; `beta` makes the
    direction conjugate to the last step, and is 0 for steepest descent.
    """

    preconditioned: Array
    active: Array
    shift: float
    beta: float


class TrialSums(NamedTuple):
    """Sums over a trial pressure, taken while it is written.

    Attributes
    ----------
    cut
        Whether a limit cuts the pressure off.
    load
        Sum of the pressure.
    slope
        Slope of the complementary energy along the step, before a limit cuts the pressure off.
    loaded, largest
        Number of cells with pressure, and the largest pressure; nan from array operations, which leave tension in
        place.
    """

    cut: bool
    load: float
    slope: float
    loaded: float = nan
    largest: float = nan


class ConjugacySums(NamedTuple):
    """Sums that make a direction conjugate to the last step.

    Attributes
    ----------
    cells
        Number of cells in the active set.
    preconditioned
        Sum of the preconditioned residual.
    gap_preconditioned, preconditioned_response, active_response, gap_step
        Inner products of pairs of fields: the gap, the preconditioned residual, the change of displacement by the last
        step (the response), the active set, and the last step on it.
    step
        Sum of the last step on the active set.
    """

    cells: float
    preconditioned: float
    gap_preconditioned: float
    preconditioned_response: float
    active_response: float
    gap_step: float
    step: float


class ArrayOperations:
    """Operations on fields by the device's array library, in blocks of rows."""

    def __init__(self, constraint: Constraint, shape: tuple[int, ...]) -> None:
        self.constraint = constraint
        large_for_cpu = prod(shape) >= MIN_COMPILED_CELLS and isinstance(device(), Cpu)
        self._is_large = large_for_cpu or device_loops() is not None

    def preconditioner_precision(self, undeformed_gap: Array) -> Precision | None:
        """Return single precision for the preconditioner on large fields whose largest height it can hold, else None.

        It takes half the time and no more iterations. None is the precision of the problem.
        """
        fits = self._is_large and -SINGLE_LIMIT < float(undeformed_gap.max()) < SINGLE_LIMIT
        return Precision.SINGLE if fits else None

    def gap(
        self, undeformed: Array, displacement: Array, pressure: Array, height: Array,
        prescribed_approach: float | None = None,
    ) -> Gap:  # fmt: skip
        """Return the gap, whose heights are written to `height`.

        They count from the approach: the prescribed one, else the mean height over the active set.
        """
        active = self.constraint.active(pressure)
        height[...] = undeformed + displacement
        if prescribed_approach is not None:
            approach = prescribed_approach
        elif cells := total(active):
            approach = dot(height, active) / cells
        else:
            approach = self.constraint.approach_without_active_cells(pressure, height)
        height -= approach
        return Gap(
            height, approach, self.constraint.violation(pressure, height), total(pressure), max_abs(displacement)
        )

    def active_set(self, pressure: Array, height: Array, real: DTypeLike) -> tuple[Array, Array]:
        """Return the active set of the constraint (1, others 0) and its gap, zero elsewhere, in `real` numbers."""
        active = self.constraint.active(pressure)
        return arrays().astype(active, real, copy=False), arrays().astype(height * active, real, copy=False)

    def add_entering(
        self, pressure: Array, height: Array, extended: Array, step_length: float, active: Array,
        active_gap: Array,
    ) -> bool:  # fmt: skip
        """Add to an active set the cells that enter it after a step, and return whether there are any.

        Cells at a limit enter that should leave it. `active_gap`, the gap of the set, gets theirs. The step subtracts
        from the gap `step_length` times the `extended` one: that of the set, extended to all cells by an `Extension`.
        """
        released = self.constraint.to_release(pressure, height - step_length * extended)
        if not arrays().any(released):
            return False
        active[...] = active + released
        active_gap[...] = active_gap + height * released
        return True

    def direction_sums(self, active: Array, preconditioned: Array) -> tuple[float, ...]:
        """Return the number of cells in the `active` set, and the sum of the `preconditioned` residual."""
        return _sum(active), _sum(preconditioned)

    def conjugacy_sums(
        self, height: Array, preconditioned: Array, active: Array, before: Array, after: Array,
        displacement_before: Array, displacement_after: Array,
    ) -> ConjugacySums:  # fmt: skip
        """Return the sums that make a direction conjugate to the last step.

        `height` is that of the gap; the pressure is given `before` and `after` the step, and so is the displacement.
        """
        step, response = active * (after - before), displacement_after - displacement_before
        return ConjugacySums(
            _sum(active),
            _sum(preconditioned),
            dot(height, preconditioned),
            dot(preconditioned, response),
            dot(active, response),
            dot(height, step),
            _sum(step),
        )

    def trial(
        self, pressure: Array, height: Array, direction: Direction, step_length: float, buffer: Array
    ) -> TrialSums:
        """Write the trial pressure into the `buffer`, which holds the pressure before the last step.

        It is the `pressure`, under which the gap has this `height`, plus `step_length` times the `direction`.
        """
        preconditioned, active, shift, beta = direction
        if beta:
            buffer -= pressure  # the buffer is then the last step, reversed
            buffer *= -beta
            buffer -= preconditioned
            buffer += shift
        else:
            buffer[...] = shift - preconditioned
        buffer *= active
        if step_length != 1:
            buffer *= step_length
        slope = dot(height, buffer)
        buffer += pressure
        return TrialSums(self.constraint.exceeded_by(buffer), total(buffer), slope)

    def project_to_load(
        self, trial: Array, trial_sums: TrialSums, active: Array, control: Control,
        pressure: Array, height: Array,
    ) -> float:  # fmt: skip
        """Cut a trial pressure off at the limits and shift it on the `active` set to meet the `control`, in place.

        `trial_sums` are those of the trial. Returns the slope of the complementary energy along the step from
        `pressure`, under which the gap has this `height`.
        """
        self.constraint.project_to_load(trial, active, control.total)
        return self.slope(trial, pressure, height)

    def slope(self, trial: Array, pressure: Array, height: Array) -> float:
        """Return the slope of the complementary energy along the step to `trial`."""
        return dot(height, trial - pressure)

    def curvature(self, trial: Array, pressure: Array, trial_displacement: Array, displacement: Array) -> float:
        """Return the inner product of the step to `trial` with the change of displacement that it makes."""
        return dot(trial - pressure, trial_displacement - displacement)

    def crosses_a_limit(self, trial: Array, pressure: Array, factor: float) -> bool:
        """Return whether `factor` times the step takes a cell beyond a limit."""
        return self.constraint.exceeded_by(pressure + factor * (trial - pressure))

    def take_fraction(
        self, trial: Array, pressure: Array, trial_displacement: Array, displacement: Array,
        fraction: float,
    ) -> None:  # fmt: skip
        """Take a `fraction` of a step: the trial fields become the pressure and displacement at its end, in place."""
        for before, after in ((displacement, trial_displacement), (pressure, trial)):
            after -= before
            after *= fraction
            after += before
        self.constraint.clip(trial)


class CompiledOperations(ArrayOperations):
    """Compiled loops over fields, for numpy arrays and constraints ``0 <= p <= limit``.

    A loop returns its sums and maxima over each part of the field (`results`, parts), in the order of its docstring.
    """

    def __init__(self, constraint: Constraint, shape: tuple[int, ...], loops: Any) -> None:
        super().__init__(constraint, shape)
        self._loops, self._limit = loops, constraint.hardness

    def gap(
        self, undeformed: Array, displacement: Array, pressure: Array, height: Array,
        prescribed_approach: float | None = None,
    ) -> Gap:  # fmt: skip
        """Return the gap, as :meth:`ArrayOperations.gap` does."""
        fields, limit = (undeformed, displacement, pressure), self._limit
        if prescribed_approach is not None:
            approach = prescribed_approach
        else:
            heights, cells = self._loops.active_gap_sums(*fields, limit, results=2).sum(axis=1).tolist()
            at_limits = self.constraint.approach_without_active_cells
            approach = heights / cells if cells else at_limits(pressure, undeformed + displacement)
        sums = self._loops.gap(*fields, approach, limit, height, results=5)
        load, moment, active_load = sums[:3].sum(axis=1).tolist()
        complementarity = moment / active_load if active_load > 0 else 0.0
        violation = largest_of(complementarity, sums[3].max())
        return Gap(height, approach, violation, load, float(sums[4].max()))

    def active_set(self, pressure: Array, height: Array, real: DTypeLike) -> tuple[Array, Array]:
        """Return the active set (1, others 0), and its gap, in `real` numbers."""
        active, active_gap = (arrays().empty(pressure.shape, dtype=real) for _ in range(2))
        self._loops.active_set(pressure, height, self._limit, active, active_gap)
        return active, active_gap

    def add_entering(
        self, pressure: Array, height: Array, extended: Array, step_length: float, active: Array,
        active_gap: Array,
    ) -> bool:  # fmt: skip
        """Add to an active set the cells that enter it after a step, as :meth:`ArrayOperations.add_entering` does."""
        fields = pressure, height, extended, step_length, self._limit, active, active_gap
        return bool(self._loops.add_entering(*fields, results=1).any())

    def trial(
        self, pressure: Array, height: Array, direction: Direction, step_length: float, buffer: Array
    ) -> TrialSums:
        """Write the trial pressure as :meth:`ArrayOperations.trial` does, and cut tension off at once."""
        fields = pressure, height, *direction, step_length, self._limit, buffer
        sums = self._loops.trial(*fields, results=5)
        cut, load, loaded, slope = sums[:4].sum(axis=1).tolist()
        return TrialSums(cut > 0, load, slope, loaded, float(sums[4].max()))

    def project_to_load(
        self, trial: Array, trial_sums: TrialSums, active: Array, control: Control,
        pressure: Array, height: Array,
    ) -> float:  # fmt: skip
        """Cut a trial pressure off at the limits and shift it on the `active` set, in place.

        Without an upper limit, other cells have no pressure.
        """
        if (
            self._limit < inf
            or control.total is None
            or trial_sums.largest > control.total  # rounding of such pressures would exceed the load
        ):
            self.constraint.project_to_load(trial, active, control.total)
            return self.slope(trial, pressure, height)
        return self._projected(trial, trial_sums, control.total, pressure, height)

    def _projected(self, trial: Array, sums: TrialSums, load: float, pressure: Array, height: Array) -> float:
        """Shift a trial pressure to a `load`, in place, and return the slope of the energy along the step to it."""

        def load_above(shift: float) -> tuple[float, float]:
            """Return the sum of the pressure above a shift, and the number of cells there."""
            above, loaded = self._loops.load_above(trial, shift, results=2).sum(axis=1).tolist()
            return above, loaded

        epsilon = float(np.finfo(trial.dtype).eps)
        shift, factor = shift_to_load(load, sums.load, sums.loaded, load_above, epsilon)
        fields = trial, shift, factor, pressure, height
        return float(self._loops.project(*fields, results=1).sum())

    def direction_sums(self, active: Array, preconditioned: Array) -> tuple[float, ...]:
        """Return the number of cells in the `active` set, and the sum of the `preconditioned` residual."""
        return tuple(self._loops.direction_sums(active, preconditioned, results=2).sum(axis=1).tolist())

    def conjugacy_sums(self, *fields: Array) -> ConjugacySums:
        """Return the sums that make a direction conjugate, as :meth:`ArrayOperations.conjugacy_sums` does."""
        rows = self._loops.conjugacy_sums(*fields, results=7)
        return ConjugacySums(*rows.sum(axis=1).tolist())

    def curvature(self, trial: Array, pressure: Array, trial_displacement: Array, displacement: Array) -> float:
        """Return the inner product of the step to `trial` with the change of displacement that it makes."""
        fields = trial, pressure, trial_displacement, displacement
        return float(self._loops.curvature(*fields, results=1).sum())

    def crosses_a_limit(self, trial: Array, pressure: Array, factor: float) -> bool:
        """Return whether `factor` times the step takes a cell beyond a limit."""
        fields = trial, pressure, factor, self._limit
        return bool(self._loops.outside_limits(*fields, results=1).any())

    def take_fraction(
        self, trial: Array, pressure: Array, trial_displacement: Array, displacement: Array,
        fraction: float,
    ) -> None:  # fmt: skip
        """Take a `fraction` of a step, in place, as :meth:`ArrayOperations.take_fraction` does."""
        fields = trial, pressure, trial_displacement, displacement
        self._loops.take_fraction(*fields, fraction, self._limit)


class DeviceOperations(CompiledOperations):
    """Loops of a device that sum over whole fields: the gap, and a projection to the load, are one launch each.

    A field is then one part, and a launch returns ``(results, 1)`` in the order of ``loops.cu``.
    """

    def gap(
        self, undeformed: Array, displacement: Array, pressure: Array, height: Array,
        prescribed_approach: float | None = None,
    ) -> Gap:  # fmt: skip
        """Return the gap, as :meth:`ArrayOperations.gap` does."""
        given = nan if prescribed_approach is None else prescribed_approach
        fields = undeformed, displacement, pressure
        sums = self._loops.gap(*fields, given, self._limit, height, results=7)
        approach, cells, load, moment, active_load, violation, largest = sums[:, 0].tolist()
        if prescribed_approach is None and not cells:
            at_limits = self.constraint.approach_without_active_cells
            approach = at_limits(pressure, undeformed + displacement)
            if not isnan(approach):
                return self.gap(*fields, height, approach)
        complementarity = moment / active_load if active_load > 0 else 0.0
        return Gap(height, approach, largest_of(complementarity, violation), load, largest)

    def slope(self, trial: Array, pressure: Array, height: Array) -> float:
        """Return the slope of the complementary energy along the step to `trial`."""
        return float(self._loops.slope(trial, pressure, height, results=1)[0, 0])

    def _projected(self, trial: Array, sums: TrialSums, load: float, pressure: Array, height: Array) -> float:
        """Shift a trial pressure to a `load` as :func:`shift_to_load` does, with its 16 epsilons, by one launch."""
        rounding = 16 * float(np.finfo(trial.dtype).eps)
        numbers = load, sums.load, sums.loaded, rounding
        return float(self._loops.project(trial, *numbers, pressure, height, results=1)[0, 0])


def _sum(field: Array) -> float:
    """Return the sum of a field in double precision: single precision's rounding would seem an error of the load."""
    xp = arrays()
    return float(xp.sum(field, dtype=xp.float64))


def operations_for(constraint: Constraint, shape: tuple[int, ...]) -> ArrayOperations:
    """Return the operations over fields of that `shape` (x, y): compiled ones where numba is installed and they pay."""
    loops = compiled_loops(shape)
    if loops is not None and type(constraint) is Constraint:
        kind = CompiledOperations if device_loops() is None else DeviceOperations
        return kind(constraint, shape, loops)
    return ArrayOperations(constraint, shape)
