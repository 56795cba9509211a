"""Outcomes of computations: sentences on them, their times, and checks that netCDF returns what is stored."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.model.plain_text import counted, is_storable, name_problem, shortened
from studies.model.study import Measures

# Attributes by which netCDF, CF or xarray change values, hide them or move them elsewhere.
RESERVED = frozenset(
    {"scale_factor", "add_offset", "missing_value", "valid_min", "valid_max", "valid_range"}
    | {"calendar", "coordinates", "dtype", "grid_mapping", "cell_measures"}
    | {"ancillary_variables", "formula_terms", "climatology", "compress", "sample_dimension"}
    | {"instance_dimension", "node_coordinates", "node_count", "part_node_count", "geometry"}
    | {"CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST", "DIMENSION_LABELS"}
)
# Units that xarray reads as a time difference; "since" makes a date.
TIME_UNITS = frozenset({"days", "hours", "minutes", "seconds", "milliseconds", "microseconds", "nanoseconds"})
# Attributes that are text.
TEXTS = frozenset({"units", "long_name", "standard_name"})
MAX_CASE_BYTES = 2**25  # bytes of all variables of a case: a table of a thousand such cases takes 34 GB
MAX_WHOLE_NUMBER = 2**53  # beyond it a whole number is changed where another case has no value


class CaseStatus(IntEnum):
    """Status of a computation."""

    NOT_RUN = 0
    OK = 1
    FAILED = 2
    TIMEOUT = 3
    KILLED = 4


# Variables that the store adds to every case, and keywords of xarray's ``sel``: no axis may have these names.
RESERVED_NAMES = frozenset((
    "case_status", "case_key", "error", "repeat", "wall_time",
    "tolerance", "method", "drop",
    *(f"{part}_time{end}" for part in ("setup", "solve") for end in ("", "_cpu", "_all")),
))  # fmt: skip


@dataclass(frozen=True, eq=False)
class Outcome:
    """Variables of one computation, or its failure.

    Attributes
    ----------
    case_status
        Status of the computation.
    variables
        Measured variables, by name.
    error
        Why there are no variables, in a sentence; empty where there are some.
    seconds
        Wall time of the whole computation [s].
    fields
        Fields of the contact, where they are stored.
    sample
        Times of a timed run.
    """

    case_status: CaseStatus
    variables: Mapping[str, xr.Variable] = field(default_factory=dict)
    error: str = ""
    seconds: float = 0.0
    fields: Mapping[str, xr.Variable] = field(default_factory=dict)
    sample: "TimedRun | None" = None


def summary_messages(dataset: xr.Dataset) -> Iterator[str]:
    """Yield sentences on how many cases failed, did not converge, miss their accuracy or lack a bound."""
    keys, statuses = dataset["case_key"].values.astype(str).ravel(), dataset["case_status"].values
    _, places = np.unique(keys, return_index=True)
    places = places[statuses.ravel()[places] != CaseStatus.NOT_RUN]
    failed = places[statuses.ravel()[places] != CaseStatus.OK]
    if failed.size:
        first = dataset["error"].values.ravel()[failed.min()]
        yield f"{failed.size} of {counted(places.size, 'case')} failed, the first with {first}"
    status = dataset.get("solver_status")
    if status is not None and "flag_meanings" in status.attrs and status.shape == statuses.shape:
        ended = status.values.ravel()[places]
        solves = np.isfinite(ended).sum()
        for number, meaning in enumerate(str(status.attrs["flag_meanings"]).upper().split()):
            if meaning != "CONVERGED" and (count := np.count_nonzero(ended == number)):
                yield f"{count} of {counted(solves, 'solve')} ended with {meaning}; see 'solver_status'"
    if "accuracy_met" in dataset and dataset["accuracy_met"].shape == statuses.shape:
        met = dataset["accuracy_met"].values.ravel()[places]
        if missed := np.count_nonzero(met == 0):
            why = dataset.get("accuracy_missed", dataset["accuracy_met"]).values.ravel()
            first = f", the first with {why[places][met == 0][0]}" if why.dtype.kind in "OU" else ""
            verb = "misses" if missed == 1 else "miss"
            yield f"{missed} of {counted(places.size, 'case')} {verb} the requested accuracy{first}"
    if "warnings" in dataset and dataset["warnings"].shape == statuses.shape:
        warnings = [text for text in dataset["warnings"].values.ravel()[places] if isinstance(text, str) and text]
        if warnings:
            verb = "warns" if len(warnings) == 1 else "warn"
            cases = counted(places.size, "case")
            yield f"{len(warnings)} of {cases} {verb}, the first: {warnings[0]} See 'warnings'."
    unbounded = {}
    for name, bound in dataset.data_vars.items():
        value = dataset.get(str(name).removesuffix("_bound"))
        if value is None or value.name == name or bound.shape != statuses.shape:
            continue
        if not {value.dtype.kind, bound.dtype.kind} <= set("iuf"):
            continue
        has_value, has_bound = (np.isfinite(of.values.ravel()[places]) for of in (value, bound))
        # where no case has a bound, the answer gives the reason
        if 0 < (count := np.count_nonzero(has_value & ~has_bound)) < np.count_nonzero(has_value):
            unbounded[str(value.name)] = count
    if unbounded:
        counts = ", ".join(f"{name} in {count}" for name, count in unbounded.items())
        yield f"no bound of {counts} of {counted(places.size, 'case')}"


@dataclass(frozen=True, eq=False)
class RunSettings:
    """Settings of a run that every case needs.

    `measures` returns the measured variables of a case and its result, which have no name of the `axes`.
    """

    measures: Measures
    keeps_fields: bool = False
    axes: frozenset[str] = frozenset()


@dataclass(frozen=True)
class TimedRun:
    """Wall and processor times [s] of set-up and solve in one timed run of a case."""

    setup: float
    solve: float
    setup_cpu: float
    solve_cpu: float


def is_time(name: str) -> bool:
    """Return whether a variable has times of a case, which depend on the machine."""
    return name.startswith(("setup_time", "solve_time", "wall_time"))


# Parts of a timed run, in the order of `TimedRun`, with what each does.
PARTS = {"setup": "to set up coefficients and transforms, where a solve does not do it itself", "solve": "to solve"}


def timing_variables(
    names: tuple[str, ...], index: np.ndarray, samples: Sequence[Sequence[TimedRun]]
) -> Mapping[str, xr.Variable]:
    """Return the least wall and processor times of each case, and every wall time.

    The variables are over the axes `names`; `index` has the number of the case at each point. There are none where no
    case was timed.
    """
    repeats = max((len(runs) for runs in samples), default=0)
    if not repeats:
        return {}
    times = np.full((len(samples), repeats, 4), np.nan)
    for case, runs in enumerate(samples):
        times[case, : len(runs)] = [astuple(run) for run in runs] or np.nan
    least, data = np.fmin.reduce(times, axis=1), {}

    def variable(values: np.ndarray, what: str, *further_dims: str) -> xr.Variable:
        return xr.Variable(names + further_dims, values[index], {"units": "s", "long_name": what})

    for place, (part, what) in enumerate(PARTS.items()):
        about = f"wall time {what}, one case at a time, least of the repeats"
        data[f"{part}_time"] = variable(least[:, place], about)
        data[f"{part}_time_cpu"] = variable(least[:, place + 2], f"processor time {what}, least of the repeats")
        data[f"{part}_time_all"] = variable(times[:, :, place], f"wall time {what}, every repeat", "repeat")
    return data


# Checks of measured values


class MeasuredNaNError(ArithmeticError):
    """Raised for a measured value that is nan."""


def measured_variables(measured: object, reserved: Iterable[str], source: str = "measures") -> dict[str, xr.Variable]:
    """Return the mapping that a function of a study returned as variables that netCDF stores unchanged.

    No variable and no dimension may have a `reserved` name; messages call the function `source`. Raises
    :class:`~contactstudy.InvalidInput` for a value that netCDF cannot store, and MeasuredNaNError for one that is nan,
    other than a ``<name>_bound`` or an ``<name>_estimate`` of an error, which may be unknown.
    """
    if not isinstance(measured, Mapping):
        raise InvalidInput(f"{source} returns {shortened(measured)}: return named values, such as {{'peak': 1.0}}.")
    reserved = frozenset(reserved)
    variables = {name: _variable(name, value, source, reserved) for name, value in measured.items()}
    sizes: dict[str, int] = {}
    for name, variable in variables.items():
        for dim, size in variable.sizes.items():
            if sizes.setdefault(str(dim), size) != size:
                raise InvalidInput(
                    f"{source} gives {name!r} with {size} values along {dim!r} and another variable with "
                    f"{sizes[str(dim)]}: give dimensions of different sizes different names."
                )
    for name, variable in variables.items():
        if name in sizes and variable.dims != (name,):
            raise InvalidInput(
                f"{source} gives {name!r} as a variable and as a dimension: only a coordinate, with that "
                "one dimension, has the name of a dimension."
            )
    return variables


def check_size(variables: Mapping[str, xr.Variable]) -> None:
    """Raise InvalidInput, with the size, for more bytes of one case than a table of many cases can hold."""
    size = sum(variable.nbytes for variable in variables.values())
    if size > MAX_CASE_BYTES:
        raise InvalidInput(
            f"measures gives {size / 1e6:.3g} MB, more than the {MAX_CASE_BYTES / 1e6:.3g} MB of a case: give fewer "
            "numbers, or give them as 'fields' of the case, which have a file of their own."
        )


def _variable(name: object, value: object, source: str, reserved: frozenset[str]) -> xr.Variable:
    """Return one value as a variable; raise InvalidInput where netCDF cannot store it."""
    taken = "this name is taken, choose another"
    if problem := name_problem(name) or taken * (name in reserved):
        raise InvalidInput(f"{source} gives a variable {shortened(name)}: {problem}.")
    assert isinstance(name, str)

    def invalid(refused: object, remedy: str) -> InvalidInput:
        return InvalidInput(f"{source} gives {name!r} as {shortened(refused)}: {remedy}.")

    # numpy drops the NUL at the end of a text
    text = value if isinstance(value, str) else ""
    if isinstance(value, xr.DataArray):
        value = value.variable
    if not isinstance(value, xr.Variable):
        if np.ndim(value) != 0 or not (isinstance(value, str) or np.isscalar(value)):  # type: ignore[arg-type]
            raise invalid(value, "give a number, text, or xarray.Variable(dims, values)")
        value = xr.Variable((), value, {"long_name": name.replace("_", " ")})
    for dim in value.dims:
        if problem := name_problem(dim) or taken * (dim in reserved):
            raise InvalidInput(f"{source} gives {name!r} along {shortened(dim)}: {problem}.")
    if len(set(value.dims)) < len(value.dims):
        raise invalid(value.dims, "give each dimension another name")
    values = np.asarray(value.values)
    if values.dtype.kind == "O" and all(isinstance(entry, str) for entry in values.flat):
        values = np.asarray(values.tolist(), dtype=str)
    if values.dtype.kind == "U":
        if not all(is_storable(str(entry)) for entry in (text, *values.flat)):
            raise invalid(value.values, "give text without control characters and lone surrogates")
    elif values.dtype.kind not in "biuf" or values.dtype.itemsize > 8:
        raise invalid(value.values, "give numbers of at most 64 bits, or text")
    is_error = name.endswith("_bound") or "_estimate" in name
    if values.dtype.kind == "f" and np.isnan(values).any() and not is_error:
        raise MeasuredNaNError(f"{name} is nan")
    if values.dtype.kind in "iu" and values.size and max(-int(values.min()), int(values.max())) > MAX_WHOLE_NUMBER:
        raise invalid(values.max(), "give whole numbers up to 2^53, or text")
    plain = values.astype(np.float32) if values.dtype == np.float16 else values
    attributes = {key: _attribute(name, key, entry, source) for key, entry in value.attrs.items()}
    return xr.Variable(value.dims, plain.astype(plain.dtype.newbyteorder("="), copy=False), attributes)


def _attribute(variable: str, name: object, value: object, source: str) -> Any:
    """Return the value of an attribute in a type that netCDF stores unchanged."""
    where = f"{source} gives {variable!r} the attribute {shortened(name)}"
    if problem := name_problem(name):
        raise InvalidInput(f"{where}: {problem}.")
    if str(name).startswith("_") or name in RESERVED:
        raise InvalidInput(
            f"{where}: programs that read netCDF change, hide or move values by it; choose another name."
        )
    if name == "units" and (value in TIME_UNITS or " since " in f" {value} ".lower()):
        raise InvalidInput(
            f"{where} as {shortened(value)}: xarray would read a date or a time difference; give a number of "
            "'s', 'min', 'h' or 'd'."
        )
    if isinstance(value, str) and is_storable(value):
        return value
    is_row = isinstance(value, np.ndarray | np.generic | list | tuple | int | float)
    row = np.array(value, dtype=object) if is_row and name not in TEXTS else np.array([])
    if row.size and row.ndim <= 1:
        if all(isinstance(entry, str) and is_storable(entry) for entry in row.flat):
            return [str(entry) for entry in row]
        array = np.asarray(value)
        is_number = array.dtype.kind in "iuf" and array.dtype.itemsize <= 8
        if is_number and array.dtype != np.float16:
            return array.astype(array.dtype.newbyteorder("="))[()]
    raise InvalidInput(f"{where} as {shortened(value)}: give a number, text or a row of numbers.")
