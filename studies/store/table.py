"""Outcomes as one labelled Dataset."""

from collections import defaultdict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from contactstudy.io.dataset import flags
from studies.model.axis import Axis
from studies.model.outcome import CaseStatus, Outcome, TimedRun, timing_variables

# a table of all points may take this many times the bytes stored of a variable, and this many bytes more
MAX_FILL_FACTOR, FREE_BYTES = 4, 2**28
# attributes in which variables of one quantity agree
MEANING_ATTRIBUTES = ("units", "standard_name", "flag_values", "flag_meanings", "positive")
Variables = Mapping[int, xr.Variable]  # by the number of the case


def assemble(
    axes: Sequence[Axis],
    keys: Sequence[str],
    outcome_of: Callable[[str], Outcome | None],
    samples_of: Callable[[str], Sequence[TimedRun]],
    attributes: Mapping[str, Any],
) -> xr.Dataset:
    """Return every point of some axes with the outcome of the case of its key; points of one case share its numbers.

    The keys are in the order of the axes, the last one fastest; a variable's own dimensions follow. Where a case has no
    numbers (NaN, or no text), ``case_status`` says so, ``error`` why. Where cases give one name to values of different
    dimensions, types or units, those of most cases are stored; the attribute ``left_out`` names the others.
    `outcome_of` and `samples_of` return the outcome, if any, and the timed runs of a case.
    """
    shape = tuple(len(axis.values) for axis in axes)
    names = tuple(axis.name for axis in axes)
    rows: dict[str, int] = {}
    numbers = [rows.setdefault(case, len(rows)) for case in keys]
    index = np.array(numbers, dtype=int).reshape(shape)
    outcomes = [outcome_of(case) for case in rows]
    coords = {axis.name: axis.coordinate for axis in axes}
    data: dict[str, xr.Variable] = {}
    left_out: list[str] = []
    for name, variables in _chosen(outcomes, index.size, left_out):
        kind = _kind(variables)
        if kind.dims != (name,):
            values = _filled(variables, len(rows))[index]
            data[name] = xr.Variable(names + kind.dims, values, dict(kind.attrs))
        elif all(np.array_equal(kind.values, variable.values) for variable in variables.values()):
            coords[name] = kind
        else:
            left_out.append(f"{name}, a coordinate that is not the same at every point")
    times = timing_variables(names, index, [samples_of(case) for case in rows])
    about_cases = _about_cases(names, index, dict(zip(rows, outcomes, strict=True)))
    notes = {"left_out": "; ".join(left_out)} if left_out else {}
    return xr.Dataset({**times, **data, **about_cases}, coords, dict(attributes) | notes)


def _chosen(outcomes: Sequence[Outcome | None], points: int, left_out: list[str]) -> Iterator[tuple[str, Variables]]:
    """Yield for each name the variables that most cases have, unless their dimensions contradict those of others."""
    columns: dict[str, dict[int, xr.Variable]] = defaultdict(dict)
    for row, outcome in enumerate(outcomes):
        for name, variable in outcome.variables.items() if outcome is not None else ():
            columns[name][row] = variable
    kinds = {name: {variable.dims for variable in every.values()} for name, every in columns.items()}
    no_coordinates = {name for name, dims in kinds.items() if dims != {(name,)}}
    sizes: dict[Hashable, int] = {}
    for name, every in columns.items():
        alike: dict[Hashable, dict[int, xr.Variable]] = defaultdict(dict)
        for row, variable in every.items():
            alike[_signature(variable)][row] = variable
        chosen = max(alike.values(), key=len)
        kind = _kind(chosen)
        filled, stored = points * kind.nbytes, len(chosen) * kind.nbytes
        if filled > FREE_BYTES + MAX_FILL_FACTOR * stored:
            left_out.append(
                f"{name} of {len(chosen)} cases, since a table of all points would take {filled / 1e9:.3g} GB; "
                "the journal has it"
            )
            continue
        if len(chosen) < len(every):
            left_out.append(
                f"{name} of {len(every) - len(chosen)} of {len(every)} cases, which differs from the others' in "
                "dimensions, type or units"
            )
        clashes = [
            dim
            for dim, size in kind.sizes.items()
            if sizes.get(dim, size) != size or (dim in no_coordinates and dim != name)
        ]
        if clashes:
            left_out.append(f"{name}, since another variable has another {clashes[0]}")
            continue
        sizes.update(kind.sizes)
        yield name, chosen


def _kind(variables: Variables) -> xr.Variable:
    """Return the first of several variables."""
    return next(iter(variables.values()))


def _signature(variable: xr.Variable) -> Hashable:
    """Return what two variables of one quantity share: dimensions, shape, type and meaning."""
    attrs = variable.attrs
    meaning = tuple(str(attrs[name]) if name in attrs else None for name in MEANING_ATTRIBUTES)
    return variable.dims, variable.shape, variable.dtype.kind == "U", meaning


def _filled(variables: Variables, count: int) -> np.ndarray:
    """Return the values of `count` cases; nan or empty text where a case has none."""
    stored = np.stack([variable.values for variable in variables.values()])
    is_text = stored.dtype.kind == "U"
    stored = stored.astype(object) if is_text else stored
    if len(variables) == count:
        return stored
    # integers and booleans have no nan
    dtype = stored.dtype if stored.dtype.kind in "fO" else np.dtype(float)
    filled = np.full((count, *stored.shape[1:]), "" if is_text else np.nan, dtype)
    filled[list(variables)] = stored
    return filled


def _about_cases(
    names: tuple[str, ...], index: np.ndarray, outcomes: Mapping[str, Outcome | None]
) -> dict[str, xr.Variable]:
    """Return the variables on the status and the failure of each case."""
    statuses = [outcome.case_status if outcome else CaseStatus.NOT_RUN for outcome in outcomes.values()]
    meanings = [status.name.lower() for status in CaseStatus]
    numbers = np.array(statuses, dtype=np.int8)[index]
    data = {"case_status": flags(names, numbers, meanings, "status of the case")}
    errors = [outcome.error if outcome else "" for outcome in outcomes.values()]
    what = "key of the case, also in the journal and of the group of its fields"
    texts: list[tuple[str, Sequence[str], str]] = [("case_key", list(outcomes), what)]
    if any(errors):
        texts.append(("error", errors, "why the case has no numbers"))
    for name, values, long_name in texts:
        column = np.array(values, dtype=object)[index]
        data[name] = xr.Variable(names, column, {"long_name": long_name})
    seconds = np.array([outcome.seconds if outcome else np.nan for outcome in outcomes.values()])
    label = {"units": "s", "long_name": "wall time of the case, beside other cases"}
    return data | {"wall_time": xr.Variable(names, seconds[index], label)}
