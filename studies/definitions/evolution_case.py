"""A contact that changes in time, as a computation of a study."""

from collections.abc import Mapping
from dataclasses import dataclass

import xarray as xr

import contactstudy as cs
from studies.model.case import number, solver_status


@dataclass(frozen=True)
class EvolutionCase:
    """A scene marched through ``times`` [s], with steps between them for an ``error`` if one is given."""

    scene: cs.Scene
    grid: cs.Grid
    padding: cs.Padding | cs.Paddings
    times: tuple[float, ...]
    error: float | None = None
    scheme: str = "IMPLICIT"
    step_error: str = "COMPANION"
    tolerance: float = 1e-8

    def prepare(self) -> None:
        """Nothing: a march sets itself up."""

    def run(self, prepared: object = None) -> cs.Evolution:
        """The march."""
        return cs.evolve(
            self.scene,
            self.grid,
            self.padding,
            times=self.times,
            error=self.error,
            scheme=cs.Scheme[self.scheme],
            step_error=cs.StepError[self.step_error],
            tolerance=self.tolerance,
        )

    def record(self, result: cs.Evolution) -> Mapping[str, xr.Variable]:
        """The solver's own numbers, of all steps."""
        return {
            "solver_status": solver_status(result.status, "how the worst step ended"),
            "iterations": number(result.iterations, "solver iterations of all steps"),
            "convolutions": number(result.convolutions, "transform pairs of the full grid"),
            "residual": number(result.residual, "largest residual"),
            "solves": number(result.steps, "solves"),
        }
