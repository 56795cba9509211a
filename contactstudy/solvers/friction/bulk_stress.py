"""Bulk stress of one body along x, which stretches its surface below the contact."""

from dataclasses import dataclass

from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid


@dataclass(frozen=True)
class BulkStress:
    """Stress of a whole body along x, whose strain along y is prevented.

    Parameters
    ----------
    size
        Stress [Pa], tension positive.
    body
        Index of the body.
    compliance
        Strain over stress [1/Pa], ``(1 - nu^2) / E``.
    """

    size: float = 0.0
    body: int = 0
    compliance: float = 0.0

    def stretch(self, grid: Grid, before: float, after: float) -> Array:
        """Return the displacement (x, 1) [m] of the first against the second body, as a stress of `before` changes."""
        strain = (1 - 2 * self.body) * self.compliance * (after - before)
        return strain * grid.x[:, None]

    def of_bodies(self, size: float) -> tuple[float, float]:
        """Return the stress of each body [Pa]."""
        return (0.0, size) if self.body else (size, 0.0)
