import numpy as np
import pytest

from studies.advice.settings_table import Settings


def listed(*rows: tuple[str, float, float]) -> Settings:
    modes, cost, error = (np.array(column) for column in zip(*rows, strict=True))
    return Settings(cost, np.stack([cost, cost]), error, {"padding": modes})


def test_the_cheapest_setting_meets_the_target() -> None:
    every = listed(("exact", 3.0, 1e-4), ("exact", 2.0, 1e-3), ("zero", 1.0, 0.3))
    assert [every.cheapest(target) for target in (1.0, 1e-3, 1e-4, 1e-5)] == [2, 1, 0, None]


def test_a_mode_saves_what_the_next_best_as_accurate_costs_more() -> None:
    saved = listed(
        ("exact", 3.0, 1e-4), ("copied", 1.0, 1e-2), ("summed", 2.0, 2e-2), ("exact", 2.5, 1e-2)
    ).savings()  # fmt: skip
    assert saved["copied"] == (2.5, 1e-2)
    # another is cheaper and more accurate
    assert saved["summed"] == (0.5, 2e-2)
    assert saved["exact"][0] == np.inf
    assert saved["exact"][1] == pytest.approx(1e-4)
