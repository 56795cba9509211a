"""Checks of measured values, so that netCDF and xarray return what was stored."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from contactstudy import InvalidInput
from studies.model.plain_text import is_storable, name_problem, shortened

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
    if problem := name_problem(name):
        raise InvalidInput(f"{source} gives a variable {shortened(name)}: {problem}.")
    assert isinstance(name, str)
    if name in reserved:
        raise InvalidInput(f"{source} gives {name!r}: this name is taken, choose another.")

    def invalid(refused: object, remedy: str) -> InvalidInput:
        return InvalidInput(f"{source} gives {name!r} as {shortened(refused)}: {remedy}.")

    if isinstance(value, xr.DataArray):
        value = value.variable
    if not isinstance(value, xr.Variable):
        if np.ndim(value) != 0 or not (isinstance(value, str) or np.isscalar(value)):  # type: ignore[arg-type]
            raise invalid(value, "give a number, text, or xarray.Variable(dims, values)")
        value = xr.Variable((), value, {"long_name": name.replace("_", " ")})
    for dim in value.dims:
        problem = name_problem(dim) or "this name is taken, choose another" * (dim in reserved)
        if problem:
            raise InvalidInput(f"{source} gives {name!r} along {shortened(dim)}: {problem}.")
    if len(set(value.dims)) < len(value.dims):
        raise invalid(value.dims, "give each dimension another name")
    values = np.asarray(value.values)
    if values.dtype.kind == "O" and all(isinstance(entry, str) for entry in values.flat):
        values = np.asarray(values.tolist(), dtype=str)
    if values.dtype.kind == "U":
        # numpy drops the NUL at the end of a text, but keeps the length of a lone one
        has_nul = values.ndim == 0 and values.dtype.itemsize != 4 * max(len(str(values)), 1)
        if has_nul or not all(is_storable(str(entry)) for entry in values.flat):
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
