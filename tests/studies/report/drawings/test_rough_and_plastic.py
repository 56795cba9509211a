"""What the drawings of roughness and of yield plot and say of numbers that are written here."""

from typing import Any

import numpy as np
import xarray as xr

from tests.studies.report.drawings.drawn import findings, numbered

RMS, SEEDS, PADDINGS = (
    [0.0, 0.1, 0.3],
    [1, 2],
    ["zero", "duplicated", "superposed", "circular", "exact"],
)
QUANTITIES = (
    "contact_area", "half_width", "contact_extent", "peak_pressure", "load_spread", "smooth_difference",
)  # fmt: skip
ERRORS = (
    "pressure_error_l1", "half_width_error", "peak_pressure_error", "pressure_error_max",
    "curved_difference",
)  # fmt: skip


def rough() -> xr.Dataset:
    """On the coarser grids and shorter periods all is larger by far, and nothing is said of it."""
    axes: dict[str, Any] = {
        "rms": RMS,
        "hurst": [0.3, 0.8],
        "peklenik": [0.5, 2.0],
        "seed": SEEDS,
        "images": [6],
        "period": [1.2, 2.4, 4.8],
        "grid": [40, 80, 160],
        "padding": PADDINGS,
    }
    dataset = numbered(axes, *QUANTITIES, *ERRORS)
    for name in ("grid", "period"):
        dataset *= xr.DataArray([100.0, 50.0, 1.0], coords={name: axes[name]})
    dataset = dataset.transpose(*axes)
    dataset["half_width_error"] *= -1
    shape = tuple(map(len, axes.values()))
    return dataset.assign(
        converged=(tuple(axes), np.ones(shape, dtype=int)),
        case_status=(tuple(axes)[:-1], np.ones(shape[:-1], dtype=int)),
    )


def test_the_finding_compares_the_smooth_contact_with_the_roughest() -> None:
    dataset = rough()
    finest = {"images": 6, "period": 4.8, "grid": 160}
    for name, before, after in (
        ("pressure_error_l1", 0.01, 0.012),
        ("pressure_error_max", 0.002, 0.05),
        ("peak_pressure_error", 0.011, 0.004),
        ("curved_difference", 0.5, 0.003),
    ):
        for padding, factor in (("duplicated", 1.0), ("circular", 0.1)):
            for rms, value in ((0.0, before), (0.3, after)):
                dataset[name].loc[finest | {"padding": padding, "rms": rms}] = value * factor
    # a window of 4.8 a to each side, and one of 6.5 times that
    for padding, reach, low, high in (("duplicated", 1, 0.9, 1.3), ("circular", 6.5, 0.8, 1.1)):
        law, here = 1 / (8 * (reach * 4.8) ** 2), finest | {"padding": padding}
        dataset["half_width_error"].loc[here] = -low * law
        dataset["half_width_error"].loc[here | {"rms": 0.1, "seed": 2}] = -high * law
    dataset["smooth_difference"].loc[{"rms": 0.1, "padding": "exact"}] = 0.25
    [said] = findings("roughness", dataset)
    assert "At L = 4.8 a the L1 error" in said
    assert (
        "is 1.0 % smooth and 1.2 % rough with duplicated and 0.10 % smooth and 0.12 % rough" in said
    )
    assert "at an rms height of 0.3 a²/(2R)" in said
    assert "too small by 0.80 to 1.30 times a²/(8D²)" in said
    # 0.003 over 0.012
    assert "25 % and 25 % of those L1 errors remain" in said
    assert "grows from 0.20 % to 5.0 % of p_{H} and from 0.020 % to 0.50 %" in said
    assert "falls from 1.1 % to 0.40 % and from 0.11 % to 0.040 %" in said
    assert "changes the pressure by 25 % (L1) at an rms of 0.1; unlike that" in said
    wrong = dataset.copy(deep=True)
    wrong["converged"][0, 0, 0, 0, 0, 0, 0, 0] = 0
    assert not findings("roughness", wrong)
    assert not findings("roughness", dataset.isel(rms=[0]))


PRESSURES, STEPS, GRID = [2.0, 3.0, 4.0], [2, 8], [24, 48]
SHOWN = ("peak_pressure", "half_width", "dent", "plastic_depth")
CAPS = {
    "peak_pressure": "hardness_limited_pressure",
    "half_width": "hardness_limited_half_width",
    "dent": "hardness_limited_dent",
}


def plastic(steps: list[int] = STEPS, grid: list[int] = GRID) -> xr.Dataset:
    axes = {"pressure": PRESSURES, "hardening": [0.1, 0.5], "steps": steps, "grid": grid}
    errors = ("peak_pressure_error", "dent_error", "plastic_strain_error")
    dataset = numbered(
        axes,
        *SHOWN,
        *CAPS.values(),
        "hardness_limited_difference",
        *errors,
        "layers",
        "convolutions",
    )
    dataset["layers"] = (1e4 * dataset["layers"]).round()
    dataset["dent"] *= 100
    return dataset


def test_the_findings_of_yield_are_of_the_most_steps_and_the_finest_grid() -> None:
    dataset = plastic()
    cap, cost = findings("plastic", dataset)
    # the 20th of 24 numbers at 4 Y: 0.0020 of p_H
    assert "At p_{H} = 4 Y, where the peak pressure is 0.01 Y" in cap
    # the 20th after 168, and the 4th
    assert "differs by 1.9 % in L1" in cap
    assert "At 2 Y it differs by 1.7 %" in cap
    # the 20th after 144, and a hundred times the 20th after 48
    assert "a largest negative gap of 0.016 a Y / E in the place of a dent of 0.68." in cap
    # the 12th after 192, 216 and 240, and after 264
    assert "With 8 load steps the peak pressure on a yielding body is accurate to 2.0 %" in cost
    assert "With 8 steps and 48 cells (276 layers)" in cost
    assert "the dent within 2.3 % and the largest plastic strain within 2.5 %" in cost
    fallen = dataset.copy(deep=True)
    fallen["peak_pressure_error"].loc[{"pressure": 3.0, "hardening": 0.1, "grid": 48}] = [0.1, 0.04]
    assert (
        "From 2 steps to 8 the error of the pressure falls by a factor of 2.5"
        in findings("plastic", fallen)[1]
    )
    assert len(findings("plastic", dataset.sel(pressure=[2.0, 4.0]))) == 1
    assert not findings("plastic", dataset.isel(steps=[0]))
    assert not findings("plastic", dataset.isel(pressure=[0]))
