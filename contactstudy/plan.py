"""Which grid and padding a scene calls for, and what that will cost, said before anything runs."""

from dataclasses import dataclass
from math import log2, prod
from time import perf_counter

import numpy as np

from contactstudy.checks import InvalidInput, positive
from contactstudy.convolution import convolution
from contactstudy.grid import Grid
from contactstudy.needs import Needs
from contactstudy.padding import Padding, Paddings
from contactstudy.scene import Scene

# Influence coefficients, found in columns and rows by turns, cost less than in proportion to the cells.
SETUP = 0.8
# Iterations of a smooth and a rough contact, coarser grids included, and what one costs in convolutions.
SMOOTH_ITERATIONS, ROUGH_ITERATIONS, ITERATION = 10, 20, 3.5
# Arrays of the grid's size that a solve holds beside the transform pair.
FIELDS = 16
# What is timed, to say how long the rest will take.
SAMPLE = 128


@dataclass(frozen=True)
class Plan:
    """A ``grid`` and a ``padding`` for ``scene.problem(plan.grid, plan.padding)``, and what to expect of them.

    ``dimension`` is 1 where nothing varies along the length, else 2. ``error`` is the relative L1 error of
    the pressure to expect, by the measured laws of the cell size; ``seconds`` on one thread of this
    machine, from a transform timed just now, within a factor of some two; ``bytes`` at the most.
    ``period_check`` says how the period suits the scene, ``reasons`` a sentence for each choice, and
    ``warnings`` what is wrong with a grid that was given.
    """

    grid: Grid
    padding: Padding | Paddings
    dimension: int
    error: float
    seconds: float
    bytes: int
    period_check: str
    reasons: tuple[str, ...]
    warnings: tuple[str, ...] = ()


def plan(
    scene: Scene, *, error: float = 1e-3, period: float | None = None, grid: Grid | None = None
) -> Plan:
    """A grid and a padding that solve ``scene`` to a relative L1 ``error`` of the pressure.

    ``period`` [m] is chosen where none is given. With a ``grid``, that one is kept, and the plan says
    what is wrong with it. Raises :class:`~contactstudy.InvalidInput` where a scene leaves open what a
    plan needs: without a curved shape there is no width of contact, without a roller's length no grid.
    """
    error = positive("plan.error", error, "give a relative error above 0, such as 1e-3")
    if scene.hertz is None:
        raise InvalidInput(
            "Scene.shapes have no curvature, so that the contact has no width of its own: "
            "give a Cylinder, or choose the grid yourself."
        )
    for number, shape in enumerate(scene.shapes):
        if not hasattr(shape, "detail"):
            raise InvalidInput(
                f"Scene.shapes[{number}] is {shape!r}, which does not say how fine it is: give it a "
                "`detail`, or choose the grid yourself."
            )
    details = tuple(shape.detail for shape in scene.shapes if hasattr(shape, "detail"))
    needs = Needs(scene.hertz, details, scene.hardness)
    if grid is None:
        grid = needs.grid(error, period)
    elif period is not None and period != grid.period:
        raise InvalidInput(f"plan.period is {period!r}: leave it out, since the grid has its own.")
    padding = needs.padding()
    return Plan(
        grid=grid,
        padding=padding,
        dimension=1 if grid.cells[1] == 1 else 2,
        error=needs.error(grid.cell),
        seconds=_seconds(grid, padding, ROUGH_ITERATIONS if needs.rough else SMOOTH_ITERATIONS),
        bytes=_bytes(grid, padding),
        period_check=needs.period_check(grid.period),
        reasons=needs.reasons(grid),
        warnings=needs.warnings(grid),
    )


def _padded(grid: Grid, padding: Padding | Paddings) -> int:
    wraps = padding[1].wraps if isinstance(padding, tuple) else padding.wraps
    return prod(grid.cells) * 2 * (1 if wraps else 2)


def _bytes(grid: Grid, padding: Padding | Paddings) -> int:
    return 8 * (FIELDS * prod(grid.cells) + 2 * _padded(grid, padding))


def _seconds(grid: Grid, padding: Padding | Paddings, iterations: int) -> float:
    """From a set-up and a convolution timed here: in proportion to N, and to N log N."""
    sample = Grid((SAMPLE, 1 if grid.cells[1] == 1 else SAMPLE), grid.extent)
    setups, convolutions = [], []
    for _ in range(3):
        start = perf_counter()
        operator = convolution(1.0, sample, padding, 1.0)
        ready = perf_counter()
        operator(np.ones(sample.cells))
        convolutions.append(perf_counter() - ready)
        setups.append(ready - start)
    count = _padded(grid, padding)
    one = min(convolutions) * count * log2(count) / (operator.work * log2(operator.work))
    setup = min(setups) * max(prod(grid.cells) / prod(sample.cells), 1) ** SETUP
    return float(setup + one * ITERATION * iterations)
