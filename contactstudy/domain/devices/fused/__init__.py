"""Passes over fields compiled by numba (extra ``fast``): each reads and writes its fields once.

They do what array operations do elsewhere in several passes. Fields (x, y) are C-contiguous: others would be compiled
for anew. ``found`` (x, results) takes what a pass finds in each row, so that sums do not depend on who works on which
rows. Results differ by rounding from those of array operations.
"""

from contactstudy.domain.devices.fused.extension import filled, gathered, means, spilled, weights
from contactstudy.domain.devices.fused.iteration import (
    advance,
    beyond,
    chosen,
    contact,
    curvature,
    joined,
    level,
    lower,
    lowered,
    measured,
    product,
    products,
    slope,
    totals,
    trial,
)
from contactstudy.domain.devices.fused.waves import scale

__all__ = [
    "advance",
    "beyond",
    "chosen",
    "contact",
    "curvature",
    "filled",
    "gathered",
    "joined",
    "level",
    "lower",
    "lowered",
    "means",
    "measured",
    "product",
    "products",
    "scale",
    "slope",
    "spilled",
    "totals",
    "trial",
    "weights",
]
