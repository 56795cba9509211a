"""Figures of any study by its varied axes: curves for one axis, families of curves for two."""

from collections.abc import Sequence
from itertools import islice, product
from math import prod

import xarray as xr

from contactstudy import InvalidInput
from studies.model.axis import one_of
from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus, is_time, summary_messages
from studies.report.drawings import against_reference, sensitivity
from studies.report.plots import DOUBTFUL, Law, Plot, doubtful, draw, is_sample, value_text

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
# Relative difference of values that are constant.
CONSTANT = 1e-6
# Formulas that are drawn beside a measure.
LAWS = (
    Law("Moes", "central_film", "moes_film"),
    Law("Dowson & Higginson", "minimum_film", "dowson_higginson_film"),
)
MAX_PANELS, MAX_FIGURES = 6, 12


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
    return [*drawn, *against_reference.figures(dataset, names)]


def chosen(dataset: xr.Dataset, plot: Sequence[str]) -> Sequence[str]:
    """Return the measures `plot` of a stored study, or those of a contact if it is empty."""
    return [one_of("plot", name, _numbers(dataset)) for name in plot] or _first(_measures(dataset))


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
        varies = _varies(dataset[name])
        is_load = name == "load_per_length" and varies
        return not is_load, not varies, is_sample(name), -dataset.sizes[name]

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
    return [name for name in measures if _changes(dataset[name])] or measures or times


def _first(measures: Sequence[str]) -> Sequence[str]:
    """Return the measures to draw: where there are more than there is room for, those of a contact."""
    preferred = [name for name in DRAWN if name in measures]
    return (preferred if len(measures) > MAX_PANELS and preferred else measures)[:MAX_PANELS]


def _changes(values: xr.DataArray) -> bool:
    """Return whether a measure is not the same at all points, within the residual of a solver."""
    largest, least = float(values.max()), float(values.min())
    return largest - least > CONSTANT * max(abs(largest), abs(least))


def _varies(values: xr.DataArray) -> bool:
    """Return whether an axis has several numbers."""
    return values.dtype.kind in "if" and values.size > 1
