"""What the built-in studies sweep unless told otherwise: the numbers that the report's figures stand on."""

import pytest

from studies.registry import BUILT_IN, load

PERIODIC = {"images": (6,), "period": (2.4,), "grid": (128,)}
# Axes of numbers alone; names are of what the studies compare.
NUMBERS: dict[str, dict[str, tuple[float, ...]]] = {
    "paper": {"images": (1, 6)},
    "padding": {"images": (1, 6, 20), "period": (0.6, 2.4), "grid": (32, 64, 128, 256)},
    "images": PERIODIC | {"images": (0, 1, 2, 3, 4, 6, 8, 10, 20, 50), "period": (0.6, 2.4, 9.6)},
    "period": PERIODIC | {"period": (0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6)},
    "grid": PERIODIC | {"grid": (16, 24, 32, 48, 64, 96, 128, 192, 256)},
    "kernels": PERIODIC | {"images": (0, 1, 2, 4, 6, 10, 30), "period": (0.15, 0.6, 2.4, 9.6)},
    "solvers": {"grid": (128, 256, 512)},
    "speed": {
        "hurst": (0.2, 0.8),
        "cut_off": (2.0,),
        "share": (0.2,),
        "threads": (1, 2),
        "grid": (32, 64, 128, 256, 512),
    },
    "roughness": {
        "rms": (0.0, 0.03, 0.1, 0.3),
        "hurst": (0.3, 0.8),
        "peklenik": (0.5, 1.0, 2.0),
        "seed": (1, 2),
        "images": (6,),
        "period": (2.4,),
        "grid": (160,),
    },
    "creep": {"steps": (10, 20, 40, 80, 160), "grid": (64, 256)},
    "wear": {"steps": (8, 16, 32, 64, 128), "grid": (64,)},
    "coating": {
        "ratio": (0.25, 0.5, 2.0, 4.0),
        "thickness": (0.03, 0.1, 0.3, 1.0, 3.0, 10.0),
        "grid": (512,),
    },
    "plastic": {"pressure": (2, 3, 4), "hardening": (0.1,), "steps": (2, 8), "grid": (24, 48)},
    "friction": {"poisson_ratio": (0.0, 0.15, 0.3, 0.45), "grid": (401,), "rough_grid": (48,)},
    "effect_cost": {"grid": (512,)},
    "pareto": {
        "images": (1, 6),
        "period": (1,),
        "grid": (24, 36, 48, 72, 96, 144),
        "solver_tolerance": (1e-2, 1e-4),
    },
    "peers": {"threads": (1,), "grid": (128, 256, 512)},
    "lubrication": {
        "load": (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000),
        "viscosity": (0, 1, 2.5, 5, 7.5, 10, 12.5, 15, 17.5, 20),
        "rms": (0.0,),
        "grid": (100, 200, 400),
    },
    "stability": {},
    "accuracy": {"seed": (1,)},
}


@pytest.mark.parametrize("name", [*BUILT_IN, "peers"])
def test_a_study_sweeps_these_numbers_by_default(name: str) -> None:
    axes = load(name).points
    found = {axis.name: axis.values for axis in axes if not isinstance(axis.values[0], str)}
    assert found == NUMBERS[name]
