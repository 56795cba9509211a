"""Anderson's acceleration of a fixed-point iteration."""

from itertools import pairwise

import numpy as np

from contactstudy.domain.fields import Array

# Singular values of the changes below this fraction of the largest are noise of the solves.
CUT_OFF = 1e-8


class AndersonMixing:
    """Mixing of the last iterates of a fixed-point iteration.

    Source: Anderson (1965), in the form of Walker & Ni (2011), eq. 2.2.

    Parameters
    ----------
    depth
        Number of iterates before the last that enter a mixture.
    """

    def __init__(self, depth: int) -> None:
        self._depth = depth
        self.restart()

    def restart(self) -> None:
        """Forget all iterates."""
        self._iterates: list[Array] = []
        self._steps: list[Array] = []

    def record(self, iterate: Array, step: Array) -> None:
        """Record an `iterate` and the `step` that the fixed-point map adds to it."""
        self._iterates = [*self._iterates, iterate][-self._depth - 1 :]
        self._steps = [*self._steps, step][-self._depth - 1 :]

    @property
    def mixes(self) -> bool:
        """True if there are several iterates, so that a mixture differs from the plain next one."""
        return len(self._steps) > 1

    def mixture(self) -> Array:
        """Return the combination of the iterates with the smallest step, moved by that step."""
        iterate, step = self._iterates[-1], self._steps[-1]
        if not self.mixes:
            return iterate + step
        changes = np.stack([(b - a).ravel() for a, b in pairwise(self._steps)], axis=1)
        moves = np.stack([(b - a).ravel() for a, b in pairwise(self._iterates)], axis=1)
        weights = np.linalg.lstsq(changes, step.ravel(), rcond=CUT_OFF)[0]
        return iterate + step - ((moves + changes) @ weights).reshape(step.shape)
