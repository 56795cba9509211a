"""Figures of any study by its varied axes: curves for one axis, families for two; and errors against one value."""

from collections.abc import Sequence
from itertools import islice, product
from math import prod

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.model.axis import one_of
from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus, is_time, summary_messages
from studies.reference.paddings import padding_text
from studies.report.drawings import sensitivity
from studies.report.plots import DOUBTFUL, Law, Plot, doubtful, draw, is_sample, percent, value_text

# Measures that are drawn first where a study has more than there is room for.
DRAWN = (
    "central_film", "minimum_film", "friction_coefficient", "lambda_ratio", "contact_load_fraction", "pull_off",
    "traction_coefficient", "stick_fraction", "frictional_power", "energy_per_cycle", "friction_energy", "largest_slip",
    "rolling_resistance", "wear_volume", "largest_wear_depth", "dent_depth", "final_peak_pressure", "contact_fraction",
    "peak_pressure", "largest_von_mises", "mean_pressure", "approach", "stiffness", "mean_gap",
)  # fmt: skip
# What a case records of its solve, which is no measure.
RECORDED = (
    "accuracy_met", "solver_status", "iterations", "linear_iterations", "convolutions", "residual",
    "outer_iterations", "passes", "solves", "instants", "steps", "rejected", "restarts",
)  # fmt: skip
# Relative difference of values that are constant, within the residual of a solver.
CONSTANT = 1e-6
# Formulas that are drawn beside a measure.
LAWS = (Law("Moes", "central_film", "moes_film"), Law("Dowson & Higginson", "minimum_film", "dowson_higginson_film"))
MAX_PANELS, MAX_FIGURES = 6, 12
L1 = "pressure_error_l1"
NOT_NESTED = " No error of the pressure in L1: the grids differ in extent, or do not nest in the reference's."


def figures(dataset: xr.Dataset, plot: Sequence[str] = ()) -> Sequence[CaptionedFigure]:
    """Draw the measures of a stored study over its first two axes, a figure for each point on the others.

    They are curves over a varied load or else the longest numeric axis, with a line for each value of another.

    Parameters
    ----------
    dataset
        Stored study.
    plot
        Names of the measures to draw; those of a contact if empty.

    Raises
    ------
    InvalidInput
        For a name that the study does not have, or a study without numbers, such as one whose cases all failed.
    """
    good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    if not (dataset["case_status"] == CaseStatus.OK).any():
        why = "; ".join(summary_messages(dataset)) or "none of its cases was run"
        raise InvalidInput(f"The study has nothing to draw: {why}.")
    axes = _by_length(dataset)
    measures = _measures(dataset)
    names = chosen(dataset, plot)
    if not names:
        raise InvalidInput("The study has no measure to draw: let measures give a number that is not nan.")
    if "changes" in dataset.attrs:
        return sensitivity.figures(dataset, names)
    shown, further = axes[:2], axes[2:]
    drawn = []
    omitted = [name for name in measures if name not in names and not plot]
    points = product(*(dataset[axis].values for axis in further))
    count = prod(dataset.sizes[axis] for axis in further)
    for number, point in enumerate(islice(points, MAX_FIGURES), 1):
        selected = good.sel(dict(zip(further, point, strict=True)))
        is_hollow = any(bool(doubtful(selected, name).notnull().any()) for name in names)
        parts = [
            str(dataset.attrs.get("title", "Study")),
            ", ".join(value_text(dataset[axis], selected[axis].item()) for axis in further),
            f"hollow points: {DOUBTFUL['label']}" * is_hollow,
            f"--plot draws {len(omitted)} more, such as {omitted[0]}" if omitted else "",
            f"the first {MAX_FIGURES} of {count} points have a figure" * (count > MAX_FIGURES),
        ]
        caption = f"{'; '.join(part for part in parts if part)}."
        name = f"curves-{number}" if further else "curves"
        drawn.append(_curves(selected, names, shown, name, caption))
    return [*drawn, *errors_against_reference(dataset, names)]


def chosen(dataset: xr.Dataset, plot: Sequence[str]) -> Sequence[str]:
    """Return the measures `plot` of a stored study, or those of a contact if it is empty."""
    if plot:
        return [one_of("The variable to draw", name, _numbers(dataset)) for name in plot]
    measures = _measures(dataset)
    preferred = [name for name in DRAWN if name in measures] if len(measures) > MAX_PANELS else []
    return (preferred or measures)[:MAX_PANELS]


def _curves(
    dataset: xr.Dataset, names: Sequence[str], shown: Sequence[str], name: str, caption: str
) -> CaptionedFigure:
    """Draw measures over the first axis, with a line for each value of the second, or the median of its samples."""
    if not shown:
        dataset, shown = dataset.expand_dims("point"), ["point"]
    first, *families = shown
    samples = tuple(axis for axis in families if is_sample(axis) and dataset.sizes[axis] > 1)
    hue = next((axis for axis in families if axis not in samples), "")
    figure = draw(dataset, Plot(name, tuple(names), first, hue, over=samples, laws=LAWS, caption=caption))
    assert figure is not None
    return figure


def _by_length(dataset: xr.Dataset) -> list[str]:
    """Return the axes: a varied load first, then other numbers, samples and names, and of these the longest first."""

    def rank(name: str) -> tuple[bool, bool, bool, int]:
        varies = dataset[name].dtype.kind in "if" and dataset.sizes[name] > 1
        return not (varies and name == "load_per_length"), not varies, is_sample(name), -dataset.sizes[name]

    return sorted(map(str, dataset["case_status"].dims), key=rank)


def _numbers(dataset: xr.Dataset) -> list[str]:
    """Return the names of the variables over all axes that have numbers, flags left out."""
    dims = dataset["case_status"].dims
    return [
        str(name)
        for name, variable in dataset.data_vars.items()
        if variable.dims == dims and variable.dtype.kind in "iuf" and variable.notnull().any()
        if name != "case_status" and "flag_meanings" not in variable.attrs
    ]


def _measures(dataset: xr.Dataset) -> list[str]:
    """Return the names of the measures that change, or all where none does; times only where there is nothing else."""
    present = [
        name for name in _numbers(dataset) if "_bound" not in name and "_estimate" not in name and name not in RECORDED
    ]
    times = [name for name in present if is_time(name)]
    measures = [name for name in present if name not in times]
    ranges = {name: (float(dataset[name].min()), float(dataset[name].max())) for name in measures}
    changing = [name for name, (low, high) in ranges.items() if high - low > CONSTANT * max(abs(low), abs(high))]
    return changing or measures or times


def errors_against_reference(dataset: xr.Dataset, names: Sequence[str]) -> Sequence[CaptionedFigure]:
    """Draw the relative errors of some measures against the sweep's reference, and over the times of its cases.

    The attribute ``reference`` of the dataset names an axis and the value on it, such as ``load_per_length=10000.0``;
    without it, or where the axis lacks that value, nothing is drawn. Of the other axes the largest error counts, and
    the median time.
    """
    axis, _, value = str(dataset.attrs.get("reference", "")).partition("=")
    if axis not in dataset["case_status"].dims or dataset.sizes[axis] < 2:
        return ()
    good = dataset.where(dataset["case_status"] == CaseStatus.OK)
    coordinate = dataset[axis].values
    # a stored number may differ from the one that was named by rounding
    is_number = coordinate.dtype.kind in "iuf"
    if not is_number and value not in coordinate:
        return ()
    place = int(abs(coordinate - float(value)).argmin() if is_number else (coordinate == value).argmax())
    true = good.isel({axis: place})
    compared = good.isel({axis: [k for k in range(coordinate.size) if k != place]})
    other_axes = [name for name in dataset["case_status"].dims if name != axis]
    # a quantity without a bound may not be comparable: the datum of an approach differs between paddings
    bounded = [name for name in names if np.isfinite(true.get(f"{name}_bound", np.inf)).all()]
    errors = {
        name.replace("_", " "): abs(compared[name] / true[name] - 1).max(other_axes)
        for name in bounded or names
        if bool((true[name] != 0).all())
    }
    has_l1 = L1 in compared and bool(compared[L1].notnull().any())
    if has_l1:
        errors = {"pressure in L1": compared[L1].max(other_axes), **errors}
    if not errors:
        return ()
    text = f"{true[axis].item():.4g}" if is_number else padding_text(true[axis].item())
    reference = f"{axis.replace('_', ' ')} {text}"
    of_all = xr.concat(list(errors.values()), "quantity").assign_coords(quantity=list(errors))
    label = {"long_name": "relative error"}
    first = next(iter(errors))
    # an error of 0 has no place on a logarithmic axis
    drawn = xr.Dataset({"relative_error": of_all.where(of_all > 0).assign_attrs(label)})
    drawn["error"] = errors[first].assign_attrs(long_name=f"relative error of the {first}")
    times = ("setup_time_cpu", "solve_time_cpu")
    drawn.update({name: compared[name].median(other_axes) for name in times if name in compared})
    drawn[axis].attrs |= dataset[axis].attrs
    about = _bounds_of_reference(true, list(errors)) + ("" if has_l1 else NOT_NESTED)
    plots = (
        Plot(
            "errors", ("relative_error",), axis, hue="quantity", line="none", log="y",
            caption=f"Relative errors against {reference}; a quantity without a mark agrees exactly, or has no number."
            f"{about}",
        ),
        Plot(
            "front", ("error",), "total_time", hue=axis, line="none", log="xy",
            caption=f"Relative error of the {first} against {reference}, over the time of a case; of several cases at "
            "one value the largest error and the median time.",
        ),
    )  # fmt: skip
    made = (draw(drawn, plot) for plot in plots)
    return tuple(figure for figure in made if figure is not None)


def _bounds_of_reference(true: xr.Dataset, names: Sequence[str]) -> str:
    """Return a sentence with the error bounds of the reference itself, below which errors are not resolved."""
    keys = {name: name.replace(" ", "_") for name in names}
    bounds = {
        name: float((true[f"{key}_bound"] / abs(true[key])).max(skipna=False))
        for name, key in keys.items()
        if f"{key}_bound" in true
    }
    if "pressure_l1_estimate" in true:
        bounds = {"pressure in L1": float(true["pressure_l1_estimate"].max(skipna=False)), **bounds}
    finite = [f"{name} {percent(bound)}" for name, bound in bounds.items() if 0 < bound < np.inf]
    return f" Bounds of the reference itself: {', '.join(finite)}." if finite else ""
