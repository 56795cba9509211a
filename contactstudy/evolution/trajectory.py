"""Results of an integration in time: recorded frames."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.grid import Array
from contactstudy.evolution.steady_rolling import SteadyRolling
from contactstudy.problem.problem import Field, Problem
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Counts, Solution, Status, worst

if TYPE_CHECKING:  # imported only for scenes with a body that yields
    from contactstudy.evolution.states.plastic import PlasticState

# Errors of a contact by images, cells and residual, where that by cells is not known.
UNKNOWN = ErrorParts(images=0.0, discretisation=inf, residual=0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Frame(Solution):
    """A contact at one recorded instant: its :class:`~contactstudy.Solution`, and what it keeps from earlier instants.

    Solves, iterations and convolutions are counted since the previous frame, and include rejected steps and the
    integration with doubled steps. The status is the worst one of the contacts since the previous frame, without those
    of rejected or halved steps and of replaced iterates; it is DETACHED where the last contact is. The displacement is
    all by which the surfaces have moved: elastically, by creep, wear and yielding. Errors are relative L1 errors of the
    pressure, infinite where there is no estimate; where bodies yield, relative to the pressure under the largest load.

    Attributes
    ----------
    time
        Time [s].
    load
        Load [N/m].
    fields
        Fields (x, y) of the state variables, such as the wear depth, by name.
    solves
        Number of contacts solved, of which a step may take several; contact and plastic strain together count as one.
    errors_by_steps
        Estimated time-discretisation errors by name: ``l1`` of the pressure, or of the tangential traction where that of
        fretting is larger, the peak pressure, and further quantities of a contact that has worn while it rolls. An
        error that is not named is 0.
    coupled_state
        State solved for together with the pressure, such as plastic strain, as arrays by name.
    grid_error_parts
        Estimated error of the contact on this grid by cause, without that by the steps, see
        :func:`~contactstudy.accuracy.estimate.error_estimate`; None for a contact in equilibrium that keeps no state
        variable from earlier instants, whose errors are those of one at rest.
    peak_grid_error_parts
        The same of the peak pressure.
    warnings
        A sentence for each error that has no bound.
    rolling
        Rolling resistance and centroid of a steadily rolling contact; None for others.
    """

    time: float
    load: float
    fields: Mapping[str, Field] = field(default_factory=dict)
    solves: int = 1
    errors_by_steps: Mapping[str, float] = field(default_factory=dict)
    coupled_state: Mapping[str, Array] = field(default_factory=dict)
    grid_error_parts: ErrorParts | None = None
    peak_grid_error_parts: ErrorParts = UNKNOWN
    warnings: tuple[str, ...] = ()
    rolling: SteadyRolling | None = None

    @property
    def time_discretisation_error(self) -> float:
        """Estimated time-discretisation error in L1."""
        return self.errors_by_steps.get("l1", 0.0)


def frame_of(solution: Solution, **further_fields: Any) -> Frame:
    """Return `solution` as a frame, with `further_fields` of :class:`Frame`, or others in place of its own."""
    values = {each.name: getattr(solution, each.name) for each in fields(Solution)}
    return Frame(**values | further_fields)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Frames of a scene that was followed through time.

    Attributes
    ----------
    problem
        The contact under the largest load, before anything has changed.
    frames
        The recorded instants, in the order of time.
    rejected
        Number of pairs of steps that were rejected as too long, and of load jumps repeated with more increments.
    restarts
        Number of restarts, because the time-discretisation error grew beyond the allowed one.
    description
        The scene, grid and padding.
    coupled
        State variable that derives fields from the frames' coupled states; None if no body yields.
    """

    problem: Problem
    frames: tuple[Frame, ...]
    rejected: int
    restarts: int
    description: PosedScene
    coupled: "PlasticState | None" = None

    @property
    def times(self) -> Array:
        """Time (time,) [s] of each frame."""
        return np.array([frame.time for frame in self.frames])

    @property
    def status(self) -> Status:
        """The worst status of all steps."""
        return worst([frame.status for frame in self.frames])

    @property
    def solves(self) -> int:
        """Number of contacts solved, see :class:`Frame`."""
        return sum(frame.solves for frame in self.frames)

    @property
    def counts(self) -> Counts:
        """Number of instants, and of what the integration took."""
        iterations = sum(frame.iterations for frame in self.frames)
        convolutions = sum(frame.convolutions for frame in self.frames)
        return {
            "instants": (len(self.frames), "instants recorded"),
            "solves": (self.solves, "contact solves"),
            "iterations": (iterations, "solver iterations of all steps"),
            "convolutions": (convolutions, "FFT convolutions of the full grid"),
            "rejected": (self.rejected, "rejected pairs of steps and load jumps"),
            "restarts": (self.restarts, "restarts with shorter steps"),
        }

    @property
    def time_discretisation_error(self) -> float:
        """The largest time-discretisation error of all frames, see :class:`Frame`."""
        return max(frame.time_discretisation_error for frame in self.frames)


def error_of_peak(pressure: Array, errors: Array) -> float:
    """Return the error [Pa] of the peak of a `pressure` (x, y) [Pa] whose cells have these `errors` [Pa], at least 0.

    It is as far as the peak moves where each cell has its error: cells at the edge of a contact that wears have large
    errors, and pressures far below the peak. As the error of a cell may vanish by chance, it is at least the relative
    mean error times the peak, or the largest error where that is less.
    """
    peak, total = float(pressure.max()), float(pressure.sum())
    moved = max(float((pressure + errors).max()) - peak, peak - float((pressure - errors).max()))
    mean = float(errors.sum()) / total * peak if total else 0.0
    return max(moved, min(mean, float(errors.max())))
