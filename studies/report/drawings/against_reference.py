"""Errors of a sweep against one value of a varied field, and these errors over the times, where times were taken."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from studies.model.drawing import CaptionedFigure
from studies.model.outcome import CaseStatus
from studies.reference.paddings import padding_text
from studies.report.plots import Plot, draw, percent

L1 = "pressure_error_l1"
NOT_NESTED = " No error of the pressure in L1: the grids differ in extent, or do not nest in the reference's."


def figures(dataset: xr.Dataset, names: Sequence[str]) -> Sequence[CaptionedFigure]:
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
    return tuple(one for one in made if one is not None)


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
