"""Anderson's acceleration of a fixed-point iteration."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from contactstudy.domain.fields import Array

# Singular values of the changes below this fraction of the largest are noise of the solves.
CUT_OFF = 1e-8


def anderson_mixture(guesses: Sequence[Array], steps: Sequence[Array]) -> Array:
    """Return the combination of the last `guesses` with the smallest step, moved by that step.

    `steps` are what the fixed-point map adds to each guess. Source: Anderson (1965), in the form of Walker & Ni (2011),
    eq. 2.2.
    """
    guess, step = guesses[-1], steps[-1]
    if len(steps) == 1:
        return guess + step
    changes = np.stack([(b - a).ravel() for a, b in pairwise(steps)], axis=1)
    moves = np.stack([(b - a).ravel() for a, b in pairwise(guesses)], axis=1)
    weights = np.linalg.lstsq(changes, step.ravel(), rcond=CUT_OFF)[0]
    return guess + step - ((moves + changes) @ weights).reshape(step.shape)
