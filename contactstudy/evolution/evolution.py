"""A contact at one instant of its evolution, as it is recorded."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from contactstudy.accuracy.expected_error import ErrorParts
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.imports import presentation
from contactstudy.evolution.march import worst
from contactstudy.evolution.memory import JointMemory
from contactstudy.problem.problem import Derived, Field
from contactstudy.scene.scene import PosedScene
from contactstudy.solvers.solution import Status

if TYPE_CHECKING:
    import xarray as xr


UNKNOWN = ErrorParts(0.0, inf, 0.0)


@dataclass(frozen=True, eq=False)
class Frame:
    """Fields of shape (x, y) at ``time`` [s] under ``load`` [N/m]: ``pressure`` [Pa], ``gap`` [m].

    ``fields`` are what memories show, such as the worn depth. ``step_error`` is the estimated relative L1
    error of the pressure from the steps in time, ``grid_error`` that of the contact on this grid (see
    :func:`~contactstudy.error_estimate`), with its parts by cause and ``warnings`` about what has no bound; both are
    infinite where there is no estimate, and relative to the pressure of the largest load where bodies yield.
    ``status`` is the worst of the steps since the frame before. ``steps``, ``iterations`` and
    ``convolutions`` are counted since then, with those of rejected steps and of the companion march.
    ``residual`` is that of the last solve. ``kept`` is what was found together with the pressure, such as plastic
    strain, in arrays of its own.
    """

    time: float
    load: float
    pressure: Array
    gap: Array
    approach: float
    fields: Mapping[str, Field]
    status: Status
    residual: float
    step_error: float
    grid_error: float
    steps: int
    iterations: int
    convolutions: float
    kept: Mapping[str, Array] = field(default_factory=dict)
    grid_error_parts: ErrorParts = UNKNOWN
    warnings: tuple[str, ...] = ()

    @property
    def peak_pressure(self) -> float:
        """[Pa]"""
        return float(self.pressure.max())


@dataclass(frozen=True, eq=False)
class Evolution:
    """The ``frames`` of a scene on ``grid``, in the order of time.

    ``outputs`` are found from the pressures when they are labelled; ``description`` is the scene they
    are of. ``rejected`` counts pairs of steps that were tried and found too long,
    ``restarts`` marches that were given up since their steps added up to too large an error. ``joint`` says what
    follows from what frames have ``kept``.
    """

    grid: Grid
    frames: tuple[Frame, ...]
    rejected: int
    restarts: int
    outputs: tuple[Derived, ...]
    description: PosedScene
    joint: JointMemory | None = None

    @property
    def times(self) -> Array:
        """(time,) [s]"""
        return np.array([frame.time for frame in self.frames])

    @property
    def loads(self) -> Array:
        """(time,) [N/m]"""
        return np.array([frame.load for frame in self.frames])

    @property
    def pressure(self) -> Array:
        """(time, x, y) [Pa]"""
        return np.stack([frame.pressure for frame in self.frames])

    @property
    def gap(self) -> Array:
        """(time, x, y) [m]"""
        return np.stack([frame.gap for frame in self.frames])

    @property
    def peak_pressure(self) -> Array:
        """(time,) [Pa]"""
        return np.array([frame.peak_pressure for frame in self.frames])

    @property
    def contact_area(self) -> Array:
        """(time,) [m^2] over the grid."""
        cells = [np.count_nonzero(frame.pressure) for frame in self.frames]
        return np.array(cells) * self.grid.cell_area

    @property
    def status(self) -> Status:
        """The worst of all steps."""
        return worst([frame.status for frame in self.frames])

    @property
    def steps(self) -> int:
        """Solves, with those of rejected steps and of the companion march."""
        return sum(frame.steps for frame in self.frames)

    @property
    def iterations(self) -> int:
        """Of all steps."""
        return sum(frame.iterations for frame in self.frames)

    @property
    def convolutions(self) -> float:
        """Transform pairs of the full grid, of all steps."""
        return sum(frame.convolutions for frame in self.frames)

    @property
    def residual(self) -> float:
        """The largest of the recorded solves."""
        return max(frame.residual for frame in self.frames)

    @property
    def step_error(self) -> float:
        """The largest estimated relative L1 error of the pressure from the steps in time."""
        return max(frame.step_error for frame in self.frames)

    @property
    def grid_error(self) -> float:
        """The largest estimated relative L1 error of the pressure from the cells."""
        return max(frame.grid_error for frame in self.frames)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Each warning about an error of the frames once, in the order of time."""
        return tuple(dict.fromkeys(warning for frame in self.frames for warning in frame.warnings))

    def summary(self) -> str:
        """What was found, in a few lines."""
        first, last = self.frames[0], self.frames[-1]
        return "\n".join(
            (
                f"{self.status}",
                f"  {len(self.frames)} instants from {first.time:.4g} s to {last.time:.4g} s, {self.steps} "
                f"solves, {self.iterations} iterations, {self.rejected} pairs of steps rejected, "
                f"{self.restarts} marches started again",
                f"  at the end: peak pressure {last.pressure.max():.4g} Pa, in contact "
                f"{np.mean(last.pressure > 0) * self.grid.extent[0]:.4g} m of the width on average, approach "
                f"{last.approach:.4g} m",
                f"  estimated error of the pressure in L1, at most: steps in time {self.step_error:.1g}, "
                f"grid {self.grid_error:.1g}",
                *(f"  warning: {warning}" for warning in self.warnings),
            )
        )

    def to_dataset(self) -> "xr.Dataset":
        """Fields over (time, x, y), numbers over (time,), with units, long names, and where they came from."""
        dataset: xr.Dataset = presentation("Evolution.to_dataset")(self)
        return dataset
