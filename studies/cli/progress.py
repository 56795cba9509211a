"""How far a solve is: a bar in a terminal, and the pressure so far where it is stopped."""

from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite, log
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contactstudy import InvalidInput
from contactstudy.domain.fields import Array

if TYPE_CHECKING:
    import xarray as xr
    from tqdm import tqdm


class Progress:
    """The residual on its way to ``tolerance``, and the last pressure, dimensionless."""

    def __init__(self, tolerance: float, bar: "tqdm[None]") -> None:
        self.tolerance, self._bar = tolerance, bar
        self.residual = float("inf")
        self.pressure: Array | None = None
        self.iterations = 0
        self._first: float | None = None

    def see(self, residual: float, pressure: Array) -> None:
        """Take the next residual."""
        self.pressure = pressure
        self.residual, self.iterations = residual, self.iterations + 1
        if not isfinite(residual) or residual <= 0:
            return
        if self._first is None:
            self._first = max(residual, 10 * self.tolerance)
        done = log(self._first / residual) / log(self._first / self.tolerance)
        self._bar.n = round(100 * min(max(done, 0.0), 1.0))
        self._bar.set_postfix_str(f"residual {residual:.1e} of {self.tolerance:.1e}", refresh=False)
        self._bar.update(0)


@contextmanager
def progress(name: str, tolerance: float) -> Iterator[Progress]:
    """A bar on a terminal, none elsewhere."""
    from tqdm import tqdm

    layout = "{desc} {percentage:3.0f} %|{bar}| {postfix} [{elapsed}]"
    with tqdm(total=100, desc=name, bar_format=layout, disable=None, leave=False, delay=1) as bar:
        yield Progress(tolerance, bar)


def stopped(seen: Progress, unit: float, like: "xr.Dataset") -> "xr.Dataset":
    """The pressure so far [Pa], with the coordinates and attributes of ``like``."""
    assert seen.pressure is not None
    labels = {"units": "Pa", "long_name": "contact pressure, not converged"}
    values = np.asarray(seen.pressure, dtype=np.float64) * unit
    found = like[["x", "y"]].assign(pressure=(("x", "y"), values, labels))
    residual = {"units": "1", "long_name": "residual of the solver"}
    return found.assign(residual=((), seen.residual, residual)).assign_attrs(
        title="line contact, stopped before it converged"
    )


def pressure_in(path: Path) -> Array:
    """The pressure (x, y) [Pa] in a file that ``contactstudy solve`` wrote."""
    from studies.store.netcdf import read_any

    dataset = read_any(path)
    if "pressure" not in dataset or dataset["pressure"].dims != ("x", "y"):
        raise InvalidInput(
            f"--start is {str(path)!r}, which has no pressure over (x, y): give a file that contactstudy solve wrote."
        )
    return np.asarray(dataset["pressure"].values, dtype=np.float64)
