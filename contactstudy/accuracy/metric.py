"""What of a solution an error may be asked of."""

from enum import Enum


class Metric(Enum):
    """What of a solution is to be accurate."""

    PEAK_PRESSURE = "peak pressure"
    L1 = "pressure in L1"
    HALF_WIDTH = "half-width"


class Edges(Enum):
    """Which pressure counts: as the cells have it, or :func:`~contactstudy.accuracy.contact_edge.corrected_pressure`."""

    AS_SOLVED = "as solved"
    CORRECTED = "corrected"
