"""How a measured surface is made periodic along the length."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from contactstudy.domain.checks import InvalidInput, positive, set_fields
from contactstudy.domain.fields import Array


class Seam(Protocol):
    """How the end of a surface is joined to its beginning."""

    @property
    def lengths(self) -> int:
        """The period, in lengths of the surface."""
        ...

    def close(self, heights: Array) -> Array:
        """One period (width, points along) [m] of the surface ``heights`` (x, y)."""
        ...


@dataclass(frozen=True)
class AsMeasured:
    """No change: the step between the end and the beginning stays."""

    @property
    def lengths(self) -> int:
        """One."""
        return 1

    def close(self, heights: Array) -> Array:
        """The surface as it is."""
        return heights


@dataclass(frozen=True)
class Mirrored:
    """The surface is followed by its mirror image: no step, twice the period, all heights unchanged."""

    @property
    def lengths(self) -> int:
        """Two."""
        return 2

    def close(self, heights: Array) -> Array:
        """The surface and its mirror image."""
        return np.concatenate([heights, heights[:, ::-1]], axis=1)


@dataclass(frozen=True)
class Tapered:
    """Heights fall to the surface's mean at both ends, as a cosine: Tukey's window.

    ``share`` of the length, above 0 and up to 1, is tapered, half of it at each end; there the surface is
    smoother than measured.

    Source: Harris (1978), Proceedings of the IEEE 66, eq. 38.
    """

    share: float = 0.1

    def __post_init__(self) -> None:
        remedy = "give a share of the length above 0 and up to 1"
        share = positive("Tapered.share", self.share, remedy)
        if share > 1:
            raise InvalidInput(f"Tapered.share is {self.share!r}: {remedy}.")
        set_fields(self, share=share)

    @property
    def lengths(self) -> int:
        """One."""
        return 1

    def close(self, heights: Array) -> Array:
        """The windowed surface."""
        count = heights.shape[1]
        from_end = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5) / count
        window = (1 - np.cos(np.pi * np.minimum(from_end / (self.share / 2), 1))) / 2
        mean = heights.mean()
        return np.asarray(mean + (heights - mean) * window)
