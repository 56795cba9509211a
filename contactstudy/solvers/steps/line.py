"""The line from a pressure to a trial: how the energy changes along it, and how far to go."""

from contactstudy.domain.devices.arrays import Array, inner
from contactstudy.domain.devices.device import fused
from contactstudy.domain.devices.rows import compiled, in_blocks
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.gap import Gap


def slope_to(trial: Array, pressure: Array, gap: Gap) -> float:
    """How fast the energy grows along the step to ``trial``."""
    kernels, height = fused(), gap.height
    if kernels is not None:
        return float(compiled(kernels.slope, trial, pressure, height, results=1).sum())
    return sum(
        in_blocks(
            lambda rows: inner(height[rows, :], trial[rows, :] - pressure[rows, :]), trial.shape
        )
    )


def curvature_to(trial: Array, pressure: Array, ahead: Array, moved: Array) -> float:
    """The work of the step to ``trial`` on the change of displacement that it makes."""
    kernels = fused()
    if kernels is not None:
        return float(compiled(kernels.curvature, trial, pressure, ahead, moved, results=1).sum())

    def some(rows: slice) -> float:
        return inner(trial[rows, :] - pressure[rows, :], ahead[rows, :] - moved[rows, :])

    return sum(in_blocks(some, trial.shape))


def meets_a_limit(problem: BareProblem, trial: Array, pressure: Array, factor: float) -> bool:
    """Whether a cell is beyond a limit so many steps ahead."""
    kernels, most = fused(), problem.constraint.capacity(1)
    if kernels is not None:
        return bool(compiled(kernels.beyond, trial, pressure, factor, most, results=1).any())

    def some(rows: slice) -> bool:
        step = trial[rows, :] - pressure[rows, :]
        return problem.constraint.cuts(pressure[rows, :] + factor * step)

    return any(in_blocks(some, pressure.shape))


def advance(
    problem: BareProblem, trial: Array, pressure: Array, ahead: Array, moved: Array, taken: float
) -> None:
    """So much of a step: pressure and displacement in place of those ahead, their changes in place of those before."""
    kernels, most = fused(), problem.constraint.capacity(1)
    if kernels is not None:
        compiled(kernels.advance, trial, pressure, ahead, moved, taken, most)
        return

    def some(rows: slice) -> None:
        step, response = trial[rows, :] - pressure[rows, :], ahead[rows, :] - moved[rows, :]
        if taken != 1:
            step *= taken
            response *= taken
            trial[rows, :] = problem.constraint.clip(pressure[rows, :] + step)
            ahead[rows, :] = moved[rows, :] + response
        pressure[rows, :], moved[rows, :] = step, response

    in_blocks(some, trial.shape)
