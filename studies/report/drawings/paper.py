"""Drawing of the study `paper`: pressure across the contact with every padding, findings and a table."""

import numpy as np
import xarray as xr

from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.reference.line_contact import HAS_IMAGES, total_time
from studies.report.drawings.settings import ERROR, against, is_of_hertz, is_timed, shown_at
from studies.report.style import (
    LAW_STYLE,
    WIDTH,
    captioned,
    label_panels,
    padding_style,
    paddings,
    panels,
    percent,
    setting_label,
    variation_text,
)
from studies.report.wording import seconds_text

# Headings of the errors against Hertz that the table has; for other scenes it has all.
ERRORS = {
    "axis_pressure_error": "axis error",
    "peak_pressure_error": "peak error",
    "pressure_error_max": "largest error",
    "length_variation": "variation along length",
    "half_width_error": "half-width error",
}


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the pressure across the contact and its error, as the paper's Fig. 5."""
    finest = dataset.isel(period=-1, grid=-1)
    fig, (full, error) = panels(2, width=WIDTH / 2)
    x, size = dataset["x"].values, "half-width a" if is_of_hertz(dataset) else "mm"
    x = x if is_of_hertz(dataset) else 1e3 * x
    for name in paddings(dataset):
        part = finest.sel(padding=name).isel(images=-1)
        true = part["pressure_true"].values
        style = padding_style(name) | {"label": setting_label(part), "markevery": 8}
        full.plot(x, part["pressure"].values, **style)
        error.plot(x, 100 * (part["pressure"].values - true), **style)
        if name != "zero" and is_of_hertz(dataset):  # its ends would fill the picture
            low, high = (100 * (part[f"pressure_{end}"].values - true) for end in ("min", "max"))
            error.fill_between(x, low, high, color=style["color"], alpha=0.18, linewidth=0)
    full.plot(x, true, label="Hertz" if is_of_hertz(dataset) else "reference", **LAW_STYLE)
    label_panels(
        (full, error),
        (f"position across [{size}]", "pressure over the largest", ""),
        (f"position across [{size}]", "error [% of the largest]", ""),
    )
    full.set_ylim(0, 1.2)
    error.set_ylim(-100, 100)
    error.set_yscale("symlog", linthresh=0.1)
    text = "The pressure in the middle of the length, and its error on a scale that is linear within 0.1 %"
    if is_of_hertz(dataset):
        text = f"The paper's Fig. 5. {text}; bands show the range along the length (omitted for zero padding)"
    return (captioned("pressure", fig, f"{text}; {against(dataset)}, {shown_at(dataset, '')}."),)


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return what the paper's comparison of duplicated padding with six images comes to."""
    has_both = {"duplicated", "superposed"} <= set(paddings(dataset))
    if not (is_of_hertz(dataset) and has_both and 6 in dataset["images"].values):
        return ()
    finest = dataset.isel(period=-1, grid=-1)
    copied, six = (finest.sel(padding=name, images=6) for name in ("duplicated", "superposed"))
    ratio = abs(float(copied["axis_pressure_error"] / six["axis_pressure_error"]))
    return (
        Finding(
            "“n ≥ 6 gives very similar results to duplicated padding”: the computed errors differ.",
            f"At {shown_at(dataset, '').split(', ')[-1]} the error of the pressure on the axis is "
            f"{percent(copied['axis_pressure_error'])} with duplicated padding and "
            f"{percent(six['axis_pressure_error'])} with n = 6, a factor of {ratio:.0f}: one copy reaches one period to "
            "each side, as n = ½ would. Superposition errs along the length instead: with n = 6 the pressure of a "
            f"uniform cylinder varies by {variation_text(six)}, with duplicated padding by {variation_text(copied)}. "
            "In a plot such as the paper's Fig. 5 this is hardly visible.",
            "The paper's first claim",
        ),
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """Return the errors and the cost of every padding."""
    finest = dataset.isel(period=-1, grid=-1)
    names = {ERROR: "pressure in L1", **ERRORS}
    errors = [name for name in names if name in dataset] if is_of_hertz(dataset) else [
        str(name) for name in dataset.data_vars if name == ERROR or str(name).endswith("_error")
    ]  # fmt: skip
    headings = [
        names.get(name) or str(dataset[name].attrs["long_name"]).removeprefix("relative error of the ")
        for name in errors
    ]  # fmt: skip
    timed = is_timed(dataset)
    rows = [
        (
            "zero (not periodic)" if name == "zero" else setting_label(part),
            *(percent(part[error]) for error in errors),
            *([seconds_text(float(total_time(part)))] * timed),
        )
        for name in paddings(dataset)
        for images in dataset["images"].values[0 if name in HAS_IMAGES else -1 :]
        for part in [finest.sel(padding=name, images=images)]
        if np.isfinite(part[ERROR])
    ]
    text = (
        " Pressures over p_{H}: on the axis as the mean along the length next to it, the peak anywhere, the largest "
        "error of any cell. The largest is at the contact edge and depends on where the edge lies in its cell, so that "
        "on one grid a truncated window may have a smaller one by chance."
    )
    return (
        Table(
            f"Errors of every padding {against(dataset)}, {shown_at(dataset, '')}."
            + text * is_of_hertz(dataset)
            + " Times on one thread." * timed,
            ("padding", *headings, *["time"] * timed),
            tuple(rows),
        ),
    )
