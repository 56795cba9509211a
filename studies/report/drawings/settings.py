"""Figures, claims and tables of the studies of settings, as data."""

from collections.abc import Iterable

import numpy as np
import xarray as xr

from studies.model.drawing import CaptionedFigure, Table
from studies.reference.line_contact import total_time
from studies.reference.paddings import HAS_IMAGES, padding_label
from studies.report.claims import Claim, drawing, number
from studies.report.plots import LAW_STYLE, WIDTH, Law, Plot, captioned, padding_style, panels, percent, seconds_text

# The measure that most figures show, its label, and where a figure is taken on axes that it does not show.
ERROR = "pressure_error_l1"
LABELS = {ERROR: "L1 error of the pressure"}
FINEST = {"grid": -1, "solver_tolerance": 0, "along": 0}
# Errors below this are of rounding, and written as zero.
ROUNDING = 1e-9
# Errors by the padding for which the least n is listed.
TARGETS = (1e-2, 1e-3, 1e-4)

REACH = Plot(
    "reach", (ERROR,), "reach", hue="padding", at=FINEST, line="none", log="xy", labels=LABELS,
    laws=(Law("law a²/(2πD²)", ERROR, lambda reach, _: 1 / (2 * np.pi * reach**2)),),
    caption="L1 error of the pressure over the reach D of the window: the distance to each side within which a point "
    "sees pressure (L/2 without neighbours, L with one copy, (n + ½)L with n periods). A mark is a padding at one n "
    "and one period L. Windows that move with the point follow one law, down to the error by the cells (dashed); one "
    "that is fixed to the domain lies above it.",
)  # fmt: skip
OVER_PERIOD = Plot(
    "over_period", (ERROR,), "period", hue="padding", dash="images", at=FINEST, line="none", log="xy", labels=LABELS,
    caption="L1 error of the pressure over the period.",
)  # fmt: skip
OVER_GRID = Plot(
    "over_grid", (ERROR,), "grid", hue="padding", dash="images",
    at={"period": -1, "solver_tolerance": 0, "along": 0}, log="xy", labels=LABELS,
    caption="L1 error of the pressure over the cells across, the largest over where the edge of the contact lies in "
    "its cell. A flat end is the error of the padding.",
)  # fmt: skip
SIDE_BY_SIDE = Plot(
    "paddings", (ERROR,), "padding", dash="images", at=FINEST | {"period": -1}, log="y", labels=LABELS,
    caption="L1 error of the pressure with every padding, at the longest period.",
)  # fmt: skip
FRONT = Plot(
    "front", (ERROR,), "total_time", hue="padding", at={"period": -1}, line="front", log="xy", labels=LABELS,
    caption="The price of accuracy at the longest period: the Pareto front of each padding, and as small marks its "
    "other settings.",
)  # fmt: skip


def from_then_on(meets: Iterable[bool], values: np.ndarray) -> str:
    """Return the least of some rising values from which on all meet a condition, or that none does."""
    enough = np.flatnonzero(np.minimum.accumulate(np.asarray(meets)[::-1])[::-1])
    return str(values[enough[0]]) if enough.size else f"> {values[-1]}"


def needed_images(dataset: xr.Dataset) -> Table | None:
    """Return the least n of a moving window from which on its own error stays below some errors, for each period."""
    names = dataset["padding"].values.tolist()
    if not {"circular", "exact"} <= {*names} or dataset.sizes["images"] < 3:
        return None
    single, errors, rows = [name for name in names if name not in HAS_IMAGES], dataset[ERROR].isel(grid=-1), []
    for period in errors["period"].values:
        part = errors.sel(period=period)
        added = part.sel(padding="circular").values - float(part.sel(padding="exact").min())
        least = [from_then_on(added <= target, errors["images"].values) for target in TARGETS]
        rows.append((f"{period:g} a", *map(percent, part.sel(padding=single).isel(images=0)), *least))
    return Table(
        "Error of the paddings without an n, and the least n of a circular window that adds no more than a target to "
        "the error by the cells.",
        ("period", *single, *(f"n for {percent(target)} more" for target in TARGETS)),
        tuple(rows),
    )


def _exact(dataset: xr.Dataset) -> xr.DataArray:
    """Return the error of exact periodicity over the grids."""
    return dataset[ERROR].sel(padding="exact").isel(images=-1, period=-1).sortby("grid")


def _power(dataset: xr.Dataset) -> str | float:
    """Return the exponent with which the error of exact periodicity falls with the cells."""
    errors = _exact(dataset)
    if errors.size < 2:
        return np.nan
    return f"{np.polyfit(np.log(errors['grid']), np.log(errors), 1)[0]:.2f}".replace("-", "−")


WHICH_N = Claim(
    "Which n, for which period?",
    "Exact periodicity needs no n: its error is that of the cells, {exact} on {grid} of them across, at every period.",
    "A window of n periods leaves out an error of a²/(2π(n + ½)²L²), so that a short period needs many (the table): "
    "with n = {n} the largest error of a circular window is {worst}. One copy (duplicated) is as n = ½.",
    {
        "exact": lambda d: d[ERROR].isel(grid=-1).sel(padding="exact").max(),
        "grid": lambda d: int(d["grid"][-1]),
        "n": lambda d: int(d["images"][-1]),
        "worst": lambda d: d[ERROR].sel(padding="circular").isel(grid=-1, images=-1).max(),
    },
    {"padding": ("circular", "duplicated", "exact")},
)
WHICH_GRID = Claim(
    "Which grid?",
    "{enough} cells across 2.4 a for 1 %, if the padding leaves no error.",
    "With exact periodicity the L1 error falls with the power {power} of the cells, from {first} at {coarse} cells to "
    "{last} at {fine}. The largest error of a cell, at the edge of the contact, falls slowly: {largest} of Hertz's "
    "peak pressure at {fine} cells.",
    {
        "enough": lambda d: from_then_on(_exact(d).values <= 1e-2, _exact(d)["grid"].values),
        "power": _power,
        "first": number(ERROR, "grid", padding="exact"),
        "last": number(ERROR, padding="exact"),
        "coarse": lambda d: int(d["grid"].min()),
        "fine": lambda d: int(d["grid"].max()),
        "largest": number("pressure_error_max", padding="exact"),
    },
    {"padding": ("exact",)},
)


# Processor time with one cell along and with square cells, then the error with each.
QUICK, SLOW, ONE, SQUARE = (
    number(measure, "solver_tolerance", padding="exact", along=along)
    for measure in ("total_time", ERROR)
    for along in ("one", "square")
)
ONE_CELL_ALONG = Claim(
    "How many cells along?",
    "One, for a smooth cylinder: with exact periodicity it takes {less} of the time of square cells.",
    "On {grid} cells across the L1 error is {one} with one cell along and {square} "
    "with square ones, in {quick} and {slow} of processor time. The figures below"
    " have square cells, as the paper.",
    {
        "less": lambda d: QUICK(d) / SLOW(d),
        "grid": lambda d: int(d["grid"][-1]),
        "one": ONE,
        "square": SQUARE,
        "quick": lambda d: seconds_text(QUICK(d)),
        "slow": lambda d: seconds_text(SLOW(d)),
    },
    {"padding": ("exact",), "along": ("one", "square")},
)  # fmt: skip


LENGTH_CLAIM = Claim(
    "What does the paper say of the length?",
    "“Independent of the domain extent in the length direction”: true only for exact periodicity.",
    "Error of the pressure beside the axis at L = {short} a and at L = {long} a: duplicated {duplicated_short} and "
    "{duplicated_long}; superposed, n = 6, {superposed_short} and {superposed_long}; exact {exact_short} and "
    "{exact_long}.",
    {
        "short": lambda d: f"{float(d['period'].min()):g}",
        "long": lambda d: f"{float(d['period'].max()):g}",
        **{
            f"{name}_{word}": number("axis_pressure_error", *first, padding=name, images=6)
            for name in ("duplicated", "superposed", "exact")
            for word, first in (("short", ("period",)), ("long", ()))
        },
    },
    {"padding": ("duplicated", "superposed", "exact"), "images": (6,)},
)


# The paper's figure and table


def pressures(dataset: xr.Dataset) -> CaptionedFigure:
    """Draw the pressure across the contact with every padding, and its error, as the paper's Fig. 5."""
    part = dataset.isel(period=-1, grid=-1, images=-1)
    x, across = dataset["x"].values, "position across [half-width a]"
    fig, (full, error) = panels(2, width=WIDTH / 2)
    for name in part["padding"].values.tolist():
        line = part.sel(padding=name)
        style = padding_style(name) | {"label": padding_label(name, int(part["images"])), "markevery": 8}
        off = {key: 100 * (line[key] - line["pressure_true"]) for key in ("pressure", "pressure_min", "pressure_max")}
        full.plot(x, line["pressure"], **style)
        error.plot(x, off["pressure"], **style)
        if name != "zero":  # its ends would fill the picture
            error.fill_between(x, off["pressure_min"], off["pressure_max"], color=style["color"], alpha=0.18, lw=0)
    full.plot(x, line["pressure_true"], label="Hertz", **LAW_STYLE)
    full.set(xlabel=across, ylabel="pressure over Hertz's peak pressure", ylim=(0, 1.2))
    error.set(xlabel=across, ylabel="error [% of Hertz's peak pressure]", ylim=(-100, 100))
    error.set_yscale("symlog", linthresh=0.1)
    return captioned(
        "pressure",
        fig,
        "The pressure in the middle of the length, as in the paper's Fig. 5, and its error on a scale that is linear "
        "within 0.1 %; bands show its range along the length (omitted for zero padding).",
    )


# Heads of the columns of a table, by the measures that these have.
ERRORS = {
    "axis_pressure_error": "beside the axis", "peak_pressure_error": "highest cell", "pressure_error_max": "largest",
    ERROR: "pressure in L1", "half_width_error": "half-width", "length_variation": "along the length",
}  # fmt: skip


def errors_of_paddings(dataset: xr.Dataset) -> Table:
    """Return the errors of every padding, and its time where it was taken."""
    part = dataset.isel(period=-1, grid=-1)
    timed = "solve_time_cpu" in part and bool(part["solve_time_cpu"].notnull().any())
    rows = [
        (
            padding_label(name, images),
            *(percent(line[of] if abs(line[of]) > ROUNDING else 0) for of in ERRORS),
            *([seconds_text(float(total_time(line)))] if timed else []),
        )
        for name in dataset["padding"].values.tolist()
        for images in dataset["images"].values[0 if name in HAS_IMAGES else -1 :]
        for line in [part.sel(padding=name, images=images)]
        if np.isfinite(line[ERROR])
    ]
    return Table(
        f"Errors of every padding on {int(part['grid'])} cells across, against Hertz's contact.",
        ("padding", *ERRORS.values(), *["time"] * timed),
        tuple(rows),
    )


# Errors with duplicated padding and with superposition.
COPIED, COUNTED = (number("axis_pressure_error", padding=name, images=6) for name in ("duplicated", "superposed"))
SIMILAR_CLAIM = Claim(
    "What does the paper say of n?",
    "“n ≥ 6 gives very similar results to duplicated padding”: the errors differ by a factor of {factor}.",
    "The error of the pressure beside the axis is {duplicated} with duplicated padding and {superposed} with n = 6: "
    "one copy reaches one period to each side, as n = ½ would. Superposition errs along the length instead: there the "
    "pressure of a uniform cylinder varies by {variation} of the peak. In a plot such as the paper's Fig. 5 neither is "
    "visible.",
    {
        "factor": lambda d: f"{abs(COPIED(d) / COUNTED(d)):.0f}",
        "duplicated": COPIED,
        "superposed": COUNTED,
        "variation": number("length_variation", padding="superposed", images=6),
    },
    {"padding": ("duplicated", "superposed"), "images": (6,)},
)

# The drawings of the studies, by their names

padding = drawing(SIDE_BY_SIDE, FRONT)
period = drawing(REACH, OVER_PERIOD, FRONT)
images = drawing(REACH, FRONT, claims=[WHICH_N, LENGTH_CLAIM], tables=[needed_images])
grid = drawing(OVER_GRID, FRONT, claims=[WHICH_GRID])
pareto = drawing(OVER_GRID, FRONT, claims=[ONE_CELL_ALONG])
paper = drawing(pressures, claims=[SIMILAR_CLAIM], tables=[errors_of_paddings])
