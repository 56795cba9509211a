"""A pytest plugin, ``-p tests.other_rounding``: transforms that round otherwise, as on another machine.

Each field that comes back from a transform is off by about two machine epsilons of its largest value, which is
what another FFT library or other instructions change. The same field is always off by the same, so that
equal solves stay equal to the last bit. ``OTHER_ROUNDING=7`` is another machine than ``OTHER_ROUNDING=8``.
"""

import os
from collections.abc import Callable
from functools import lru_cache, wraps

import numpy as np

from contactstudy.elasticity import transforms

SEED = int(os.environ.get("OTHER_ROUNDING", "1"))


@lru_cache(maxsize=256)
def _error(shape: tuple[int, ...]) -> np.ndarray:
    return np.random.default_rng(SEED).standard_normal(shape)


def _rounded_otherwise(backward: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    @wraps(backward)
    def other(*arguments: object) -> np.ndarray:
        field = backward(*arguments)
        unit = 2 * np.finfo(field.dtype).eps * np.abs(field).max()
        return field + (unit * _error(field.shape)).astype(field.dtype)

    return other


for library in (transforms.Transforms, transforms.Ducc):
    library.backward = _rounded_otherwise(library.backward)  # type: ignore[method-assign]
