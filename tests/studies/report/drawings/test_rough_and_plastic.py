from typing import Any

import xarray as xr

from tests.studies.report.drawings.drawn import findings, numbered


def rough() -> xr.Dataset:
    """On the coarser grids and shorter periods all is larger by far, and nothing is said of it."""
    axes: dict[str, Any] = {
        "rms": [0.0, 0.1, 0.3], "hurst": [0.3, 0.8], "peklenik": [0.5, 2.0], "seed": [1, 2], "images": [6],
        "period": [1.2, 2.4, 4.8], "grid": [40, 80, 160], "padding": ["zero", "duplicated", "circular", "exact"],
    }  # fmt: skip
    dataset = numbered(
        axes, *["load_spread", "smooth_difference", "pressure_error_l1", "half_width_error"],
        *["peak_pressure_error", "pressure_error_max", "curved_difference"],
    )  # fmt: skip
    for name in ("grid", "period"):
        dataset *= xr.DataArray([100.0, 50.0, 1.0], coords={name: axes[name]})
    dataset["half_width_error"] *= -1
    converged = xr.ones_like(dataset["load_spread"], dtype=int)
    status = converged.isel(padding=0, drop=True)
    return dataset.assign(converged=converged, case_status=status)


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
    for number in (
        "L = 4.8 a", "1.0 % smooth and 1.2 % rough with duplicated and 0.10 % smooth and 0.12 % rough",
        "rms height of 0.3 a²/(2R)", "0.80 to 1.30 times a²/(8D²)",
        "25 % and 25 % of those L1 errors",  # 0.003 over 0.012
        "from 0.20 % to 5.0 % of p_{H} and from 0.020 % to 0.50 %",
        "from 1.1 % to 0.40 % and from 0.11 % to 0.040 %", "by 25 % (L1) at an rms of 0.1",
    ):  # fmt: skip
        assert number in said
    assert not findings("roughness", dataset.isel(rms=[0]))
    dataset["converged"][0, 0, 0, 0, 0, 0, 0, 0] = 0
    assert not findings("roughness", dataset)


def plastic() -> xr.Dataset:
    axes = {"pressure": [2.0, 3.0, 4.0], "hardening": [0.1, 0.5], "steps": [2, 8], "grid": [24, 48]}
    dataset = numbered(
        axes,
        *["peak_pressure", "half_width", "dent", "plastic_depth", "hardness_limited_pressure"],
        *["hardness_limited_half_width", "hardness_limited_dent", "hardness_limited_difference"],
        *["peak_pressure_error", "dent_error", "plastic_strain_error", "layers", "convolutions"],
    )
    dataset["layers"] = (1e4 * dataset["layers"]).round()
    dataset["dent"] *= 100
    return dataset


def test_the_findings_of_yield_are_of_the_most_steps_and_the_finest_grid() -> None:
    dataset = plastic()
    cap, cost = findings("plastic", dataset)
    # the 20th of 24 numbers at 4 Y: 0.0020 of p_H
    assert "p_{H} = 4 Y, where the peak pressure is 0.01 Y" in cap
    # the 20th after 168, and the 4th
    assert "by 1.9 % in L1" in cap
    assert "At 2 Y it differs by 1.7 %" in cap
    # the 20th after 144, and a hundred times the 20th after 48
    assert "depth of 0.016 a Y / E in the place of a dent of 0.68." in cap
    # the 12th after 192, 216 and 240, and after 264
    assert "accurate to 2.0 %" in cost
    assert "8 steps and 48 cells (276 layers)" in cost
    assert "the dent within 2.3 % and the largest plastic strain within 2.5 %" in cost
    fallen = dataset.copy(deep=True)
    fallen["peak_pressure_error"].loc[{"pressure": 3.0, "hardening": 0.1, "grid": 48}] = [0.1, 0.04]
    assert "falls by a factor of 2.5" in findings("plastic", fallen)[1]
    assert len(findings("plastic", dataset.sel(pressure=[2.0, 4.0]))) == 1
    assert not findings("plastic", dataset.isel(steps=[0]))
    assert not findings("plastic", dataset.isel(pressure=[0]))
