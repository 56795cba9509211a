"""Compiled loops over waves."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest

pytest.importorskip("numba")
compiled: Any = import_module("contactstudy.domain.compiled")


def test_waves_are_scaled() -> None:
    real, imaginary, factors = np.random.default_rng(7).standard_normal((3, 5, 4))
    waves = real + 1j * imaginary
    compiled.scale(waves, factors)
    np.testing.assert_array_equal(waves, (real * factors) + 1j * (imaginary * factors))
