"""A contact at one instant of its evolution, as it is recorded."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from contactstudy.domain.fields import Array
from contactstudy.problem.problem import Field
from contactstudy.solvers.solution import Status


@dataclass(frozen=True, eq=False)
class Frame:
    """Fields of shape (x, y) at ``time`` [s] under ``load`` [N/m]: ``pressure`` [Pa], ``gap`` [m].

    ``fields`` are what memories show, such as the worn depth. ``step_error`` is the estimated relative L1
    error of the pressure from the steps in time, ``grid_error`` that from the cells (see
    :func:`~contactstudy.accuracy.discretisation.discretisation`); both are infinite where there is no
    estimate, and relative to the pressure of the largest load where bodies yield.
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

    @property
    def peak_pressure(self) -> float:
        """[Pa]"""
        return float(self.pressure.max())
