"""The bare contact problem: a gap, an operator, an admissible set. The waist between scene and solver."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from contactstudy.arrays import Array
from contactstudy.grid import Grid
from contactstudy.pressures import AdmissiblePressures


@dataclass(frozen=True)
class Scales:
    """What the solver divides by, so that no unit can change an answer: [m], [Pa], [m]."""

    length: float
    pressure: float
    gap: float


@dataclass(frozen=True, eq=False)
class Problem:
    """Find p in ``pressures`` with ``gap = undeformed_gap + displacement(p) - approach >= 0``, ``p gap = 0``.

    ``undeformed_gap`` (width, length) [m]; ``displacement`` maps pressure [Pa] to displacement [m],
    both (width, length). ``open_edges`` are the rows, counted across, that contact should not reach,
    since the surface goes on beyond them. ``attributes`` describe where the problem came from, for
    the record only.
    """

    grid: Grid
    undeformed_gap: Array
    displacement: Callable[[Array], Array]
    pressures: AdmissiblePressures
    scales: Scales
    open_edges: tuple[int, ...] = ()
    attributes: Mapping[str, str | float] = field(default_factory=dict)
