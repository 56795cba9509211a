"""The gap between the bodies under a pressure, split by what it should be."""

from dataclasses import dataclass

from contactstudy.arrays import Array


@dataclass(frozen=True, eq=False)
class Gap:
    """Fields (width, length) and their level, all in units of the gap scale.

    ``free`` is 1 in cells whose pressure is at no limit and 0 in the others. ``held`` is the gap of those,
    which should be zero, ``overlap`` the depth of penetration of the others (below zero where they are
    apart); each is zero where the other belongs. Both count from the ``approach``, which is such that
    ``held`` has no mean.
    """

    free: Array
    held: Array
    overlap: Array
    approach: float
