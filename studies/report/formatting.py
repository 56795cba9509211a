"""Numbers, settings and axes in the words of captions, legends and tables."""

from collections.abc import Iterable
from typing import SupportsFloat

import numpy as np
import xarray as xr

from studies.reference.line_contact import padding_label


def setting_label(dataset: xr.Dataset) -> str:
    """:func:`padding_label` of a Dataset reduced to one padding and one n."""
    return padding_label(str(dataset["padding"].values), int(dataset["images"]))


def select_evenly(values: Iterable[float], most: int = 3) -> list[float]:
    """At most ``most`` of ``values``, first and last among them: what fits on a figure."""
    chosen = list(values)
    if len(chosen) <= most:
        return chosen
    return [chosen[round(k * (len(chosen) - 1) / (most - 1))] for k in range(most)]


def percent(value: SupportsFloat) -> str:
    """A share as a person writes it: two digits, in per cent."""
    share = 100 * abs(float(value))
    if not np.isfinite(share) or share == 0:
        return "0 %" if share == 0 else "not known"
    if share >= 10:
        return f"{share:.0f} %"
    digits = max(0, 1 - int(np.floor(np.log10(share))))
    return f"{share:.{digits}f} %" if digits < 7 else f"{share:.1e} %"


def paddings(dataset: xr.Dataset) -> list[str]:
    """The paddings a Dataset holds, in its order."""
    return [str(name) for name in dataset["padding"].values]


def variation_text(dataset: xr.Dataset) -> str:
    """How much the pressure of one setting varies along the length."""
    variation = float(dataset["length_variation"])
    return f"{percent(variation)} of p_H" if variation > 1e-12 else "nothing but rounding"
