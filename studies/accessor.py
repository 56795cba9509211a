"""Accessor ``dataset.study`` of a stored study (``import studies.accessor``): convergence, cost, tables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from scipy.stats import linregress

from contactstudy import InvalidInput
from contactstudy.domain.errors import InNotebook
from studies.advice.verdict import pareto_front
from studies.model.axis import one_of
from studies.model.outcome import CaseStatus
from studies.reference.line_contact import total_time

if TYPE_CHECKING:
    import pandas as pd


# Rows and columns of a table in a notebook.
ROWS, COLUMNS = 10, 8


@dataclass(frozen=True)
class ConvergenceOrder:
    """Order of convergence, ``|error| ~ axis ** -order``, with its standard error and the number of fitted points."""

    order: float
    uncertainty: float
    points: int


@xr.register_dataset_accessor("study")
class StudyAccessor(InNotebook):
    """Convergence, cost against error, and tables of a stored study.

    All methods raise :class:`~contactstudy.InvalidInput` for a name that the dataset does not have.
    """

    def __init__(self, dataset: xr.Dataset) -> None:
        self._dataset = _without_units(dataset)

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes of the study."""
        return tuple(str(name) for name in self._dataset["case_status"].dims)

    @property
    def cost(self) -> xr.DataArray:
        """Processor time of set-up and solve [s]."""
        return total_time(self._dataset).rename("cost")

    def order(self, error: str, axis: str, **at: object) -> ConvergenceOrder:
        """Return the order of convergence of `error` along a numeric `axis`, at one value of each other axis.

        Least squares through the logarithms; points where the error is zero or missing are left out.
        """
        one_of("axis", axis, [name for name in self.axes if self._dataset[name].dtype.kind in "iuf"])
        for name, value in at.items():
            one_of("order", name, [known_name for known_name in self.axes if known_name != axis])
            if value not in self._dataset[name].values:
                raise InvalidInput(f"order is at {name} {value!r}, which is not on that axis.")
        line = abs(self._variable(error).sel(at))
        line = line.squeeze([name for name in line.dims if name != axis and line.sizes[name] == 1])
        if line.dims != (axis,):
            other_axes = [str(name) for name in line.dims if name != axis]
            raise InvalidInput(f"order has more than one value along {other_axes}: give one of each.")
        x, y = line[axis].values, line.values
        is_there = np.isfinite(y) & (y > 0) & (x > 0)
        if is_there.sum() < 3:
            raise InvalidInput(f"order of {error!r} along {axis!r} has {is_there.sum()} points: give three or more.")
        fit = linregress(np.log(x[is_there].astype(float)), np.log(y[is_there]))
        return ConvergenceOrder(-float(fit.slope), float(fit.stderr), int(is_there.sum()))

    def pareto(self, error: str) -> "pd.DataFrame":
        """Return the Pareto front of the settings, cheapest first, with their cost and error."""
        table = self._priced(error)
        front = pareto_front(table["cost"].to_numpy(), table[error].to_numpy())
        return table.iloc[front].reset_index(drop=True)

    def cheapest(self, error: str, at_most: float) -> "pd.Series[object]":
        """Return the cheapest setting whose `error` is at most `at_most`.

        Raises :class:`~contactstudy.InvalidInput` with the least error if there is no such setting.
        """
        table = self._priced(error)
        good = table[table[error] <= at_most]
        if good.empty:
            least = f"the least is {table[error].min():.3g}; refine an axis"
            remedy = "no point has an error and a time; run the study with times"
            raise InvalidInput(f"{error} is nowhere below {at_most:g}: {remedy if table.empty else least}.")
        return good.loc[good["cost"].idxmin()]

    def table(self, variables: Sequence[str] = ()) -> "pd.DataFrame":
        """Return a row for every point, with the axes and `variables`; all that have no further dimension if empty."""
        names = [str(name) for name, variable in self._dataset.data_vars.items() if variable.dims == self.axes]
        chosen = [one_of("variable", name, names) for name in variables] or names
        flat = self._dataset[chosen].reset_coords(drop=True)
        return flat.to_dataframe(dim_order=list(self.axes)).reset_index()

    def _rows(self) -> str:
        """Return the title, and the table of the quantities that have bounds, or of all."""
        table = self.table()
        bounded = [name for name in table if f"{name}_bound" in table]
        if bounded:
            table = table[[*self.axes, *bounded]]
        style = {"max_rows": ROWS, "max_cols": COLUMNS, "float_format": "{:.4g}".format}
        return f"{self._dataset.attrs.get('title', 'study')}\n{table.to_string(index=False, **style)}"

    def _priced(self, error: str) -> "pd.DataFrame":
        """Return a table of all good points with their cost and the absolute error."""
        both = xr.Dataset({error: abs(self._variable(error)), "cost": self.cost})
        both = both.where(self._dataset["case_status"] == CaseStatus.OK)
        order = [*self.axes, *(dim for dim in both.dims if dim not in self.axes)]
        table = both.to_dataframe(dim_order=order).reset_index()
        # points of one case stand once
        return table.dropna(subset=[error, "cost"]).drop_duplicates([error, "cost"])

    def _variable(self, name: str) -> xr.DataArray:
        """Return a variable; raise InvalidInput if there is none with the name."""
        return self._dataset[one_of("variable", name, [str(n) for n in self._dataset.data_vars])]


def _without_units(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset with plain numbers, and units as text, if pint-xarray has quantified it."""
    quantities = getattr(dataset, "pint", None)  # there where pint_xarray is imported
    return dataset if quantities is None else quantities.dequantify(format="~D")
