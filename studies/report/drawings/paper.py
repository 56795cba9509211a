"""Drawing of the study `paper`: figures, findings and tables from its stored data."""

import numpy as np
import xarray as xr

import contactstudy as cs
from studies.definitions.line_contact import POINT_CELLS
from studies.model.drawing import CaptionedFigure, Finding, Table
from studies.reference.line_contact import COUNTS_IMAGES
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

TITLES = {"x": "across the contact", "y": "along the length"}

KNOWN_AXES = ("padding", "images")


def figure(dataset: xr.Dataset) -> tuple[CaptionedFigure, ...]:
    """Draw the paper's Figs. 4 and 5."""
    return _displacement(dataset), _pressure(dataset)


def _displacement(dataset: xr.Dataset) -> CaptionedFigure:
    shown = [name for name in ("zero", "duplicated") if name in paddings(dataset)]
    hertz = cs.analytic.HertzPoint(load=1.0, radius=1.0, contact_modulus=1.0)
    fig, axes = panels(2, width=WIDTH / 2)
    for ax, direction in zip(axes, TITLES, strict=True):
        offset = dataset["offset"]
        for name in shown:
            displacement = dataset[f"displacement_{direction}"].sel(padding=name).isel(images=-1)
            ax.plot(
                offset, displacement, label=f"{name} padding", markevery=8, **padding_style(name)
            )
        analytic = hertz.displacement(offset * hertz.contact_radius) / hertz.approach
        ax.plot(offset, analytic, label="Hertz, one contact alone", **LAW_STYLE)
        ax.set(xlabel="distance from centre / contact radius", title=TITLES[direction])
    axes[0].set_ylabel("displacement / Hertz's at the centre")
    remarks = {
        "zero": "it agrees with Hertz's solution of a single contact, since it has no neighbours.",
        "duplicated": "the neighbours raise the curve, and along the length they also bend it.",
    }
    words = []
    for name in shown:
        part = dataset.sel(padding=name).isel(images=-1)
        across, along = part["displacement_x"], part["displacement_y"]
        words.append(
            f"With {name} padding it is {float(across[POINT_CELLS // 2]):.4f} at the centre, "
            f"{float(across[0]):.4f} at the edge across and {float(along[0]):.4f} at the edge along: "
            + remarks[name]
        )
    return captioned(
        "displacement",
        fig,
        "The paper's Fig. 4. Displacement under a semi-elliptic pressure of radius a that repeats every "
        f"3a along the length ({POINT_CELLS} x {POINT_CELLS} cells). " + " ".join(words),
    )


def _pressure(dataset: xr.Dataset) -> CaptionedFigure:
    fig, (full, error) = panels(2, width=WIDTH / 2)
    x = dataset["x"]
    hertz = np.sqrt(np.clip(1 - x**2, 0, None))
    parts = {name: dataset.sel(padding=name).isel(images=-1) for name in paddings(dataset)}
    for name, part in parts.items():
        style = padding_style(name) | {"label": setting_label(part), "markevery": 8}
        full.plot(x, part["pressure"], **style)
        error.plot(x, 100 * (part["pressure"] - hertz), **style)
        if name != "zero":  # its ends would fill the picture
            low, high = (100 * (part[f"pressure_{end}"] - hertz) for end in ("min", "max"))
            error.fill_between(x, low, high, color=style["color"], alpha=0.18, linewidth=0)
    full.plot(x, hertz, label="Hertz", **LAW_STYLE)
    label_panels(
        (full, error),
        ("position across / half-width a", "pressure / $p_H$", ""),
        ("position across / half-width a", "error against Hertz [% of $p_H$]", ""),
    )
    full.set_ylim(0, 1.2)
    error.set_ylim(-100, 100)
    error.set_yscale("symlog", linthresh=0.1)
    facts = "; ".join(
        f"{setting_label(part)}: {percent(part['pressure_error_max'])}" for part in parts.values()
    )
    return captioned(
        "pressure",
        fig,
        "The paper's Fig. 5. Left: pressure across the line contact in the middle of the length. Right: its error; "
        "bands show the range along the length (omitted for zero padding, whose ends would fill the "
        "panel), on a scale that is linear within 0.1 % and logarithmic beyond. "
        f"Largest error of any cell, over p_{{H}}: {facts}.",
    )


def findings(dataset: xr.Dataset) -> tuple[Finding, ...]:
    """Return what the paper's comparison of duplicated padding with six images comes to."""
    names = {"duplicated", "superposed"}
    if not names <= set(paddings(dataset)) or 6 not in dataset["images"].values:
        return ()
    copied, six = (dataset.sel(padding=name, images=6) for name in ("duplicated", "superposed"))
    ratio = abs(float(copied["axis_pressure_error"] / six["axis_pressure_error"]))
    return (
        Finding(
            "“n ≥ 6 gives very similar results to duplicated padding”: the computed errors differ.",
            f"At L = 2.4 a the error of the pressure on the axis is {percent(copied['axis_pressure_error'])} with "
            f"duplicated "
            f"padding and {percent(six['axis_pressure_error'])} with n = 6, a factor of {ratio:.0f}: one copy "
            f"reaches one "
            "period to each side, as n = ½ would. Superposition errs along the length instead: with n = 6 the "
            f"pressure of a uniform cylinder varies by {variation_text(six)}, with duplicated padding by "
            f"{variation_text(copied)}. In a plot such as the paper's Fig. 5 this is hardly visible.",
            "The paper's first claim",
        ),
    )


def tables(dataset: xr.Dataset) -> tuple[Table, ...]:
    """Return the table of errors and cost."""
    return (accuracy_table(dataset),)


def accuracy_table(dataset: xr.Dataset) -> Table:
    """Return the errors and the cost of every padding at the paper's setting."""
    errors = (
        "axis_pressure_error", "peak_pressure_error", "pressure_error_max", "length_variation",
        "half_width_error",
    )  # fmt: skip
    rows = []
    order = ("exact", "duplicated", "circular", "superposed", "zero")
    for name in (name for name in order if name in paddings(dataset)):
        for images in dataset["images"].values[0 if name in COUNTS_IMAGES else -1 :]:
            part = dataset.sel(padding=name, images=images)
            rows.append(
                (
                    "zero (not periodic)" if name == "zero" else setting_label(part),
                    *(percent(part[error]) for error in errors),
                    str(int(part["iterations"])),
                    f"{float(part['setup_time']):.3f}",
                    f"{float(part['solve_time']):.3f}",
                )
            )
    return Table(
        "A smooth line contact on the paper's grid, 128 x 128 cells over 2.4 a x 2.4 a, compared with Hertz. "
        "Pressures over p_{H}: on the axis as the mean along the length next to it, the peak anywhere, "
        "the largest error of any cell. The largest error is located at the contact edge and depends on the "
        "position of the edge within its cell, so on a single grid a truncated window may have a smaller error by "
        "chance. Times on one thread.",
        (
            "padding", "axis error",
            "peak error", "largest error", "variation along length", "half-width error",
            "iterations", "set-up [s]", "solve [s]",
        ),
        tuple(rows),
    )  # fmt: skip
