"""Tornado and table of a sensitivity: what quantities change by as each number of a scene is lowered and raised."""

from collections.abc import Sequence
from math import inf
from textwrap import fill

import numpy as np
import xarray as xr

from contactstudy.domain.validation import display_unit_of, readable
from studies.model.drawing import CaptionedFigure, Table
from studies.report.plots import COLORS, captioned, panels, percent
from studies.scene_study.sensitivity import LOWERED, RAISED, changes_in

MAX_BARS = 15  # numbers of a scene that a figure shows


def figures(sweep: xr.Dataset, names: Sequence[str]) -> Sequence[CaptionedFigure]:
    """Draw the changes of some quantities of a stored sensitivity, the largest above."""
    changes = changes_in(sweep)
    names = _present(changes, names)
    shown = min(changes.sizes["number"], MAX_BARS)
    figure, axes = panels(len(names), columns=2, width=4.8, height=1.2 + 0.38 * shown)
    for name, ax in zip(names, axes, strict=True):
        size, unit, order = _scale(changes, name)
        rows, order = np.arange(shown), order[:shown][::-1]
        bound = changes[f"{name}_change_bound"].max("side").values[order] / size
        bound = np.where(np.isfinite(bound), bound, 0.0)
        ax.barh(rows, 2 * bound, 1.0, -bound, color="0.85", label="within the bound of the error")
        sides = changes[f"{name}_change"].values[order].T / size
        for side, values, color in zip((LOWERED, RAISED), sides, COLORS, strict=False):
            ax.barh(rows, values, 0.6, color=color, label=f"number {side}")
        reach = 1.15 * max(np.nanmax(np.abs(sides)), 1e-9)
        texts = changes[["number", "change"]].isel(number=order)
        pairs = zip(texts["number"].values, texts["change"].values, strict=True)
        ax.set_yticks(rows, ["\n".join(pair) for pair in pairs], fontsize="small")
        ax.set(title=_headline(changes, name), xlabel=f"change [{unit}]", xlim=(-reach, reach))
        ax.axvline(0, color="black", lw=0.8)
        ax.grid(axis="y", visible=False)
    caption = (
        "Change of each quantity as one number of the scene is lowered and raised, by the tolerance beside it or "
        "by 1 %. In the grey band a change is within the bound of the error."
    )
    return [captioned("tornado", figure, caption)]


def table(sweep: xr.Dataset, names: Sequence[str]) -> Table:
    """Return the changes of some quantities of a stored sensitivity, the largest of each first, with their bounds."""
    changes, rows = changes_in(sweep), []
    for name in _present(changes, names):
        size, unit, order = _scale(changes, name)
        for varied_name in order:
            at = changes.isel(number=int(varied_name))
            change_values, bound = at[f"{name}_change"].values, float(at[f"{name}_change_bound"].max())
            note = "within the bound" if np.nanmax(np.abs(change_values)) <= bound else ""
            note = "no bound" if bound == inf else note
            texts = [f"{value / size:.3g}" for value in (*change_values, bound)]
            rows.append((name, *(str(at[key].values) for key in ("number", "change")), *texts, unit, note))
    head = ("quantity", "number", "as given", LOWERED, RAISED, "bound", "unit", "note")
    return Table("Changes as each number is lowered and raised alone.", head, tuple(rows))


def _present(changes: xr.Dataset, names: Sequence[str]) -> list[str]:
    """Return those of some names that have a change, all that have one if none of them does."""
    every = [str(name).removesuffix("_change") for name in changes if str(name).endswith("_change")]
    return [name for name in names if name in every] or every


def _scale(changes: xr.Dataset, name: str) -> tuple[float, str, np.ndarray]:
    """Return size and name of the unit of a change, per cent of a quantity but zero, and the order of the numbers."""
    change, original = changes[f"{name}_change"], abs(float(changes[name]))
    order = abs(change).max("side").fillna(0).values.argsort(kind="stable")[::-1]
    return (original / 100, "%", order) if original else (*display_unit_of(change, change.attrs["units"]), order)


def _headline(changes: xr.Dataset, name: str) -> str:
    """Return label, value and bound of a quantity of the scene as given."""
    original, bound, about = float(changes[name]), float(changes[f"{name}_bound"]), changes[name].attrs
    certainty = "no bound" if bound == inf else f"± {percent(bound / original)}" if original else ""
    return f"{fill(about.get('long_name', name), 44)}\n{readable(original, about['units'])}, {certainty}".rstrip(", ")
