"""What the findings on the effects say of numbers that are written here."""

import numpy as np
import xarray as xr

from studies.registry import load_drawing

SPACE = "\u00a0"


def said(name: str, dataset: xr.Dataset) -> str:
    [finding] = load_drawing(name).findings(dataset)
    return f"{finding.claim} {finding.measured}".replace(SPACE, " ")


STEPS, GRID = [10, 20, 40], [64, 96, 128]


def wear() -> xr.Dataset:
    """The explicit limit is at 10 / 0.4 = 25 steps."""
    schemes, distance = ["implicit", "explicit"], [0.0, 1.0]
    error = np.array([[0.1, 0.05, 0.02], [9.0, 5.0, 0.01]])
    width = np.arange(12.0).reshape(2, 3, 2)
    return xr.Dataset(
        {
            "half_width": (("scheme", "steps", "grid", "distance"), width[:, :, None]),
            "pressure_error_l1": (("scheme", "steps", "grid"), error[:, :, None]),
            "solves": (("scheme", "steps", "grid"), 3 * np.full((2, 3, 1), STEPS[1])),
            "longest_explicit": (
                ("scheme", "steps", "grid"),
                np.tile([0.4, 0.8, 1.6], (2, 1))[:, :, None],
            ),
        },
        coords={"scheme": schemes, "steps": STEPS, "grid": [64], "distance": distance},
    )


def test_wear_says_what_implicit_steps_save() -> None:
    text = said("wear", wear())
    assert "With 20 steps of wear the error is 5.0 % (implicit) and 500 % (explicit)." in text
    assert "needs 25 steps" in text
    assert not load_drawing("wear").findings(wear().isel(steps=[0, 1]))
    assert not load_drawing("wear").findings(wear().isel(scheme=[0]))


def creep() -> xr.Dataset:
    """The error by the steps falls as their square, down to four times that of the cells."""
    time = [0.0, 1.0]
    by_steps = np.array([0.64, 0.16, 0.04])[:, None] * np.array([1.0, 0.75, 0.5])
    return xr.Dataset(
        {
            "half_width": (("steps", "grid", "time"), np.arange(18.0).reshape(3, 3, 2)),
            "peak_pressure": (("steps", "grid", "time"), np.arange(18.0, 36).reshape(3, 3, 2)),
            "pressure_error_l1": (("steps", "grid"), by_steps / [[2], [4], [5]]),
            "step_error": (("steps", "grid"), by_steps),
            "grid_error": (("steps", "grid"), np.tile([0.01, 0.01, 0.03], (3, 1))),
            "convolutions": (("steps", "grid"), np.full((3, 3), 100.0)),
        },
        coords={"steps": STEPS, "grid": GRID, "time": time},
    )


def test_creep_says_what_a_digit_costs() -> None:
    text = said("creep", creep())
    assert "like N^{−2.00}, so a digit in time costs 3.2 times" in text
    assert "With 40 steps and 128 cells the pressure is known to 0.40 %" in text
    assert "in 100 transform pairs; with 64 cells the same steps leave 0.80 %" in text
    # of the two whose steps leave more than twice what the cells do
    assert "estimate is 2 to 4 times the error" in text
    assert not load_drawing("creep").findings(creep().isel(grid=[0]))


def friction() -> xr.Dataset:
    ratio, coefficient, fraction = [0.0, 0.3], [0.0, 0.2, 0.4], [0.0, 0.75]

    def each(*values: object) -> tuple[tuple[str, ...], np.ndarray]:
        return ("grid", "rough_grid", "poisson_ratio"), np.array([[values]])

    return xr.Dataset(
        {
            "von_mises": (
                ("grid", "rough_grid", "poisson_ratio", "coefficient"),
                np.array([[[[0.5, 0.6, 0.9], [0.558, 0.57, 0.8]]]]),
            ),
            "depth": (
                ("grid", "rough_grid", "poisson_ratio", "coefficient"),
                np.array([[[[0.7, 0.6, 0.0], [0.7, 0.015, 0.0]]]]),
            ),
            "stick": (
                ("grid", "rough_grid", "poisson_ratio", "fraction"),
                [[[[1, 0.4], [1, 0.53]]]],
            ),
            "stick_sphere": (
                ("grid", "rough_grid", "poisson_ratio", "fraction"),
                [[[[1, 0.6], [1, 0.7]]]],
            ),
            "superposition_error": each(0.001, 0.02),
            "shear_aside": each(0.0, 0.07),
        },
        coords={
            "grid": [65],
            "rough_grid": [24],
            "poisson_ratio": ratio,
            "coefficient": coefficient,
            "fraction": fraction,
        },
    )


def test_friction_says_where_stress_is_highest() -> None:
    text = said("friction", friction())
    assert "is 0.558 p_{H} without friction and 0.800 p_{H} at a coefficient of 0.4" in text
    # at 0.2 a little below it
    assert "it lies at the surface from 0.4 on" in text
    # Cattaneo's is 0.5
    assert "within 0.030 half-widths" in text
    assert "to 0.10 % in L1 at nu = 0, and miss 2.0 % of it" in text
    assert "of 7.0 % of the largest" in text
    assert not load_drawing("friction").findings(friction().isel(poisson_ratio=[1]))


def coating() -> xr.Dataset:
    """A coating four times as stiff, and one a quarter as stiff."""
    ratio, thickness = [0.25, 4.0], [0.1, 1.0, 10.0]
    axes = ("grid", "ratio", "thickness")
    return xr.Dataset(
        {
            "half_width": (axes, [[[1.01, 1.5, 2.1], [0.98, 0.7, 0.51]]]),
            "peak_pressure": (axes, [[[0.99, 0.7, 0.5], [1.02, 1.5, 2.0]]]),
            "interface_shear": (axes, [[[0.1, 0.2, 0.05], [0.31, 0.25, 0.06]]]),
            "interface_tension": (axes, [[[0.0, 0.0, 0.0], [0.4, 0.3, 0.0]]]),
            "image_error": (axes, [[[0.01, 0.2, 0.3], [0.02, 0.5, 0.1]]]),
            "reference_error": (axes, [[[np.nan, 2e-4, np.nan], [np.nan, 1e-4, np.nan]]]),
        },
        coords={"grid": [64], "ratio": ratio, "thickness": thickness},
    )


def test_a_coating_says_where_it_matters() -> None:
    text = said("coating", coating())
    assert "At a thickness of 0.1 a the half-width is within 2.0 % of that on the substrate" in text
    assert "at 10 a within 5.0 % of that on the coating" in text
    assert "met to 2.0e-04" in text
    assert "off by up to 50 % in L1 (E1/E2 = 4, thickness 1 a)" in text
    assert "largest, 0.31 of the peak pressure, at E1/E2 = 4 and a thickness of 0.1 a" in text
    assert not load_drawing("coating").findings(coating().isel(thickness=[0, 1]))
