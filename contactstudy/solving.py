"""Solve a problem, or a scene on the grid of its plan."""

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.device import Cpu, Device, Precision
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.problem.problem import Problem
from contactstudy.scene.scene import Scene
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, Solver


def solve(
    problem: Problem | Scene,
    grid: Grid | None = None,
    padding: Padding | Paddings | None = None,
    *,
    tolerance: float = 1e-8,
    max_iterations: int = 2000,
    solver: Solver = PreconditionedCG(),  # noqa: B008 (a frozen value)
    precision: Precision | str = Precision.DOUBLE,
    start: Array | None = None,
    on: Device = Cpu(),  # noqa: B008 (a frozen value)
) -> Solution:
    """Solve a problem and say how far the answer can be trusted; a scene is planned first.

    One stopping rule, dimensionless: the largest of complementarity, ``sum(p |gap|) / sum(p)``,
    penetration, ``max(-gap)`` where p = 0, both over the problem's gap scale ``p_H a / E*``, and load,
    ``|sum(p) / total - 1|``, is at most `tolerance`. Under a hardness, cells that yield count by the
    gap they leave open, and complementarity is that of the others.

    Parameters
    ----------
    problem
        A problem, such as ``scene.problem(grid, padding)``, or a scene.
    grid, padding
        Grid and padding of a scene; what is left out is chosen by :func:`~contactstudy.plan`.
    tolerance
        Largest dimensionless residual, above zero.
    max_iterations
        Iterations after which the solve ends with ``Status.ITERATION_LIMIT``.
    solver
        The iteration, such as :class:`~contactstudy.PolonskyKeer`. It gets arrays of the device.
    precision
        Floating-point numbers of the iteration, ``"double"`` or ``"single"``.
    start
        Pressure (x, y) [Pa] to begin with, such as that of a similar scene or of a solution stopped early. It is cut
        off at its limits and scaled to the load. Without it the solve begins on coarser grids.
    on
        Device, ``Cpu(threads=2)`` for two cores or ``Gpu()``. The answer is the same to rounding, and the fields of
        the solution are numpy arrays. Shear is solved on the processor.

    Returns
    -------
    Solution
        Fields, and a :class:`~contactstudy.Status` for the numerical outcome.

    Raises
    ------
    InvalidInput
        For a tolerance that is not above zero, a negative limit, a start that is no pressure, or a grid that does
        not fit in memory.
    """
    options = SolveOptions(tolerance, max_iterations, solver, Precision.named(precision))
    if isinstance(problem, Scene):
        problem = _posed(problem, grid, padding)
    elif grid is not None or padding is not None:
        raise InvalidInput(
            f"solve.{'padding' if grid is None else 'grid'} is for a scene: leave it out, a problem has its own."
        )
    return options.solved(problem, start, on)


def _posed(scene: Scene, grid: Grid | None, padding: Padding | Paddings | None) -> Problem:
    """Return the problem of `scene`, with the grid and the padding of its plan where they are not given."""
    if grid is None or padding is None:
        from contactstudy.planning.plan import plan  # only where something is left to be chosen

        planned = plan(scene, grid=grid)
        grid, padding = planned.grid, padding or planned.padding
    return scene.problem(grid, padding)
