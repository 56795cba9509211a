"""What the drawings of roughness and of yield plot and say of numbers that are written here."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.definitions.plastic import REFERENCE
from studies.report.style import percent
from tests.studies.report.drawings.drawn import (
    bands,
    caption,
    curves,
    findings,
    labelled,
    named,
    numbered,
    panels,
    same,
    words,
)

RMS, SEEDS, PADDINGS = (
    [0.0, 0.1, 0.3],
    [1, 2],
    ["zero", "duplicated", "superposed", "circular", "exact"],
)
ANSWERS = (
    "contact_area", "half_width", "contact_extent", "peak_pressure", "load_spread", "smooth_difference",
)  # fmt: skip
ERRORS = (
    "pressure_error_l1", "half_width_error", "peak_pressure_error", "pressure_error_max",
    "curved_difference",
)  # fmt: skip
PLACES = np.arange(3)


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
    dataset = numbered(axes, *ANSWERS, *ERRORS)
    for name in ("grid", "period"):
        dataset *= xr.DataArray([100.0, 50.0, 1.0], coords={name: axes[name]})
    dataset = dataset.transpose(*axes)
    dataset["half_width_error"] *= -1
    shape = tuple(map(len, axes.values()))
    return dataset.assign(
        converged=(tuple(axes), np.ones(shape, dtype=int)),
        case_status=(tuple(axes)[:-1], np.ones(shape[:-1], dtype=int)),
    )


def finest(dataset: xr.Dataset) -> xr.Dataset:
    return dataset.sel(images=6, period=4.8, grid=160)


def middle_and_span(values: xr.DataArray) -> tuple[np.ndarray, np.ndarray]:
    """Of all surfaces at each rms."""
    flat = values.transpose("rms", ...).values.reshape(3, -1)
    return np.median(flat, axis=1), np.array([flat.min(axis=1), flat.max(axis=1)])


def test_what_roughness_does_stands_over_its_rms_by_lay_and_hurst_exponent() -> None:
    dataset = rough()
    stored = finest(dataset).sel(padding="exact")
    for ax, name in zip(panels("roughness", dataset), ANSWERS, strict=True):
        shown, spans = labelled(ax), bands(ax)
        assert len(shown) == len(spans) == 4
        for (label, line), span in zip(shown.items(), spans, strict=True):
            lay, hurst = (float(part.split(" ")[-1]) for part in label.split(", H ="))
            middle, both = middle_and_span(stored[name].sel(peklenik=lay, hurst=hurst))
            assert same(line, PLACES, middle)
            assert span == pytest.approx(both)
        assert [text.get_text() for text in ax.get_xticklabels()] == ["smooth", "0.1", "0.3"]
    text = caption("roughness", dataset)
    most = stored.sel(rms=0.3)
    for lay in (0.5, 2.0):
        area, peak = (
            float(most[name].sel(peklenik=lay).mean()) for name in ("contact_area", "peak_pressure")
        )
        assert f"lay {lay:g}: area {area:.2f}, peak pressure {peak:.1f} p_{{H}}" in text
    assert "At an rms of 0.3" in text


def test_errors_of_paddings_stand_over_the_rms_beside_what_roughness_does() -> None:
    dataset = rough()
    stored = finest(dataset)
    names = (
        "pressure_error_l1",
        "half_width_error",
        "peak_pressure_error",
        "pressure_error_max",
    )
    for ax, name in zip(panels("roughness", dataset, 1), names, strict=True):
        lines, spans = curves(ax), bands(ax)
        for number, padding in enumerate(PADDINGS[:4]):
            middle, both = middle_and_span(abs(stored[name].sel(padding=padding)))
            assert same(lines[number], PLACES, middle)
            assert spans[number] == pytest.approx(both)
        assert len(lines) == 4 + (name == "pressure_error_l1")
        if name == "pressure_error_l1":
            middle, _ = middle_and_span(stored["smooth_difference"].sel(padding="exact"))
            # the smooth contact differs from itself by nothing that could be drawn
            assert np.isnan(lines[4][1, 0])
            assert lines[4][1, 1:] == pytest.approx(middle[1:])


# a window of 4.8 a to each side, and two of 6.5 times that
LAWS = {
    name: 1 / (8 * (reach * 4.8) ** 2)
    for name, reach in (("duplicated", 1), ("superposed", 6.5), ("circular", 6.5))
}


def test_the_error_of_a_window_is_drawn_over_its_law() -> None:
    dataset = rough()
    stored = finest(dataset)
    ratio, after = panels("roughness", dataset, 2)
    for place, (name, law) in enumerate(LAWS.items()):
        one = stored.sel(padding=name)
        middle, both = middle_and_span(-one["half_width_error"] / law)
        assert same(curves(ratio)[place], PLACES, middle)
        assert bands(ratio)[place] == pytest.approx(both)
        left, _ = middle_and_span(one["curved_difference"] / one["pressure_error_l1"])
        assert same(curves(after)[place], PLACES, left)
    assert curves(ratio)[3][1].tolist() == [1, 1]
    assert (ratio.get_yscale(), after.get_yscale()) == ("linear", "log")


def test_the_finding_compares_the_smooth_contact_with_the_roughest() -> None:
    dataset = rough()
    axes = tuple(dataset["pressure_error_l1"].dims)
    middle = finest(dataset).median(("hurst", "peklenik", "seed"))
    for name, before, after in (
        ("pressure_error_l1", 0.01, 0.012),
        ("pressure_error_max", 0.002, 0.05),
        ("peak_pressure_error", 0.011, 0.004),
        ("curved_difference", 0.5, 0.003),
    ):
        assert set(middle[name].dims) == {"rms", "padding"}
        for padding, factor in (("duplicated", 1.0), ("circular", 0.1)):
            chosen = {"padding": padding, "images": 6, "period": 4.8, "grid": 160}
            dataset[name].loc[{"rms": 0.0} | chosen] = before * factor
            dataset[name].loc[{"rms": 0.3} | chosen] = after * factor
    laws = xr.DataArray(
        [LAWS["duplicated"], LAWS["circular"]], coords={"padding": ["duplicated", "circular"]}
    )
    for padding, low, high in (("duplicated", 0.9, 1.3), ("circular", 0.8, 1.1)):
        law = float(laws.sel(padding=padding))
        here = {"padding": padding, "images": 6, "period": 4.8, "grid": 160}
        dataset["half_width_error"].loc[here] = -low * law
        dataset["half_width_error"].loc[here | {"rms": 0.1, "seed": 2}] = -high * law
    dataset["smooth_difference"].loc[{"rms": 0.1, "padding": "exact"}] = 0.25
    assert len(axes) == 8
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
CAPS = {"peak_pressure": "cap_pressure", "half_width": "cap_half_width", "dent": "cap_dent"}


def plastic(steps: list[int] = STEPS, grid: list[int] = GRID) -> xr.Dataset:
    axes = {"pressure": PRESSURES, "hardening": [0.1, 0.5], "steps": steps, "grid": grid}
    errors = ("peak_pressure_error", "dent_error", "plastic_strain_error")
    dataset = numbered(
        axes, *SHOWN, *CAPS.values(), "cap_difference", *errors, "layers", "convolutions"
    )
    dataset["layers"] = (1e4 * dataset["layers"]).round()
    dataset["dent"] *= 100
    return dataset


def test_what_yields_stands_over_the_load_beside_a_hardness_and_the_known_contact() -> None:
    dataset = plastic()
    stored = dataset.isel(steps=-1, grid=-1)
    axes = panels("plastic", dataset)
    for ax, name in zip(axes, SHOWN, strict=False):
        lines = labelled(ax)
        for hardening in (0.1, 0.5):
            line = lines.pop(f"plastic, H = {hardening:g} E")
            assert same(line, PRESSURES, stored[name].sel(hardening=hardening))
        assert same(lines.pop("known"), [3.0], [REFERENCE[name]])
        if name in CAPS:
            assert same(
                lines.pop("hardness 2.8 Y"), PRESSURES, stored[CAPS[name]].sel(hardening=0.1)
            )
        assert not lines
    known = dataset.sel(pressure=3.0, hardening=0.1)
    steps, cost = axes[4:]
    wrong = known["peak_pressure_error"]
    # the layers follow 11 times 24 numbers; those of 8 steps at 3 Y are the 11th and 12th
    for number, cells in enumerate(GRID):
        label = f"{cells} cells, {11 * 24 + 11 + number} layers"
        assert same(labelled(steps)[label], STEPS, wrong.sel(grid=cells))
        work = known["convolutions"].sel(grid=cells) * cells
        assert same(labelled(cost)[label], work, wrong.sel(grid=cells))
    # of first order, through the fewest steps on the finest grid
    first = float(wrong.sel(grid=48, steps=2))
    assert same(curves(steps)[2], STEPS, [first, first / 4])
    without = panels("plastic", dataset.sel(pressure=[2.0, 4.0]))
    assert not without[4].lines
    assert not without[5].lines
    assert not panels("plastic", dataset.sel(hardening=[0.5]))[4].lines


def test_of_three_grids_and_three_numbers_of_steps_the_last_are_said_and_drawn() -> None:
    dataset = plastic([2, 4, 8], [24, 32, 48])
    finest = dataset.sel(steps=8, grid=48)
    axes = panels("plastic", dataset)
    for ax, name in zip(axes, SHOWN, strict=False):
        shown = labelled(ax)["plastic, H = 0.1 E"]
        assert same(shown, PRESSURES, finest[name].sel(hardening=0.1))
    known = dataset.sel(pressure=3.0, hardening=0.1)
    wrong, layers = known["peak_pressure_error"], known["layers"].sel(steps=8, grid=32)
    assert same(
        labelled(axes[4])[f"32 cells, {float(layers):g} layers"], [2, 4, 8], wrong.sel(grid=32)
    )
    first = float(wrong.sel(grid=48, steps=2))
    assert same(curves(axes[4])[3], [2, 4, 8], [first, first / 2, first / 4])
    over = "p_H / Y"
    assert [named(ax) for ax in axes] == [
        (over, "peak pressure / p_H", ""),
        (over, "half-width / a", ""),
        (over, "dent / (a Y / E)", ""),
        (over, "plastic depth / a", ""),
        ("steps in load", "error of the peak pressure", "dotted: first order"),
        ("transform pairs times cells", "error of the peak pressure", ""),
    ]
    cap, cost = findings("plastic", dataset)
    least, most = (finest["cap_difference"].sel(hardening=0.1, pressure=p) for p in (2.0, 4.0))
    assert words(f"differs by {percent(most)} in L1") in cap
    assert words(f"At 2 Y it differs by {percent(least)}") in cap
    dent = percent(known["dent_error"].sel(steps=8, grid=48))
    assert "With 8 steps and 48 cells" in cost
    assert words(f"the dent within {dent} and") in cost
    fall = float(wrong.sel(grid=48, steps=2) / wrong.sel(grid=48, steps=8))
    assert f"falls by a factor of {fall:.1f}" in cost


def test_the_findings_of_yield_are_of_the_most_steps_and_the_finest_grid() -> None:
    dataset = plastic()
    cap, cost = findings("plastic", dataset)
    # the 20th of 24 numbers at 4 Y: 0.0020 of p_H
    assert "At p_H = 4 Y, where the peak pressure is 0.01 Y" in cap
    # the 20th after 168, and the 4th
    assert "differs by 1.9 % in L1" in cap
    assert "At 2 Y it differs by 1.7 %" in cap
    # the 20th after 144, and a hundred times the 20th after 48
    assert "a depth of yielding of 0.016 a Y / E in the place of a dent of 0.68." in cap
    # the 12th after 192, 216 and 240, and after 264
    assert "With 8 load steps the peak pressure on a yielding body is accurate to 2.0 %" in cost
    assert "With 8 steps and 48 cells (276 layers)" in cost
    assert "the dent within 2.3 % and the largest plastic strain within 2.5 %" in cost
    fallen = dataset.copy(deep=True)
    fallen["peak_pressure_error"].loc[{"pressure": 3.0, "hardening": 0.1, "grid": 48}] = [
        0.1,
        0.04,
    ]
    assert (
        "From 2 steps to 8 the error of the pressure falls by a factor of 2.5"
        in findings("plastic", fallen)[1]
    )
    assert len(findings("plastic", dataset.sel(pressure=[2.0, 4.0]))) == 1
    assert not findings("plastic", dataset.isel(steps=[0]))
    assert not findings("plastic", dataset.isel(pressure=[0]))
