"""Stands for compiled passes: what each is asked, and what it finds in every row."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from contactstudy.problem.passes import ArrayPasses, CompiledPasses


class Kernels:
    """Each pass finds these ``results``, in every row or row by row, and nothing if it is not named."""

    def __init__(self, **results: tuple[float, ...] | list[tuple[float, ...]]) -> None:
        self.results = results
        self.asked: dict[str, tuple[Any, ...]] = {}

    def __getattr__(self, name: str) -> Any:
        def kernel(*arguments: Any) -> None:
            self.asked[name] = arguments
            if name in self.results:
                found, wanted = arguments[-1], np.atleast_2d(self.results[name])
                assert found.shape[1] == wanted.shape[1], name
                found[...] = wanted

        return kernel


def limited(most: float, kernels: Kernels | None = None) -> Any:
    """A problem whose cells bear so much each, with passes over its fields."""
    constraint = SimpleNamespace(
        capacity=lambda cells: cells * most,
        clip=lambda trial: np.clip(trial, 0, most, out=trial),
        cuts=lambda trial: bool(trial.min() < 0 or trial.max() > most),
        free=lambda pressure: ((pressure > 0) & (pressure < most)) * 1.0,
        to_release=lambda pressure, height: ((pressure == 0) & (height < 0)) * 1.0,
    )
    given: Any = constraint
    passes = ArrayPasses(given) if kernels is None else CompiledPasses(given, kernels)
    return SimpleNamespace(constraint=constraint, passes=passes)
