"""Whether the bounds of an answer keep a requested error, and which of its numbers keep it least."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import ceil, inf, isfinite
from re import sub

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.errors import PRESSURE, Request
from contactstudy.domain.grid import Grid
from contactstudy.io.quantities.quantity import RELATIVE_TO_ZERO, Quantities, Quantity, per_cent

# Ends of the names of numbers for which finer cells are no remedy: the depth of a largest stress is known only to the
# distance between the depths at which stress is computed.
NOT_BY_CELLS = "safety_factor_depth", "von_mises_depth", "shear_stress_depth", "orthogonal_shear_depth"
# Ends of the names of numbers at an edge, whose bounds fall only like the square root of the cell size.
OF_HALF_ORDER = "surface_tension", "largest_shear"
# What is in the names of numbers for which no grid is refined unless they are named.
NOT_REFINED = "shear_stress", "orthogonal_shear", "_safety_factor", *OF_HALF_ORDER
# Names of components, with the whole quantity: the error of a component is relative to the whole, if that is larger.
WHOLE = {"lateral_traction_coefficient": "traction_coefficient"}


@dataclass(frozen=True)
class Judged:
    """One number of an answer, as a request sees it.

    Attributes
    ----------
    label
        Name for display.
    bound
        Bound of its relative error, or of the error itself where the number is a fraction. Infinite where it has none.
    requested
        Error not to exceed; infinite without a request.
    reason
        Why it has no bound; empty where it has one.
    order
        Power of the cell size with which the bound falls; 0 if finer cells do not lessen it.
    refines
        Whether a grid is refined for it.
    """

    label: str
    bound: float
    requested: float
    reason: str = ""
    order: float = 1.0
    refines: bool = True

    @property
    def ratio(self) -> float:
        """Bound over the requested error, or the bound itself without a request."""
        return self.bound / self.requested if isfinite(self.requested) else self.bound

    @property
    def finer(self) -> float:
        """Factor on the cells along an axis with which the bound meets the request.

        It is infinite for a number that finer cells do not help.
        """
        return self.ratio ** (1 / self.order) if self.order else inf

    def __str__(self) -> str:
        """Return the bound and the name, such as ``0.7 % in the half-width``."""
        bound = per_cent(self.bound) if isfinite(self.bound) else "no bound"
        return f"{bound} in the {self.label}"


def judged_numbers(quantities: Quantities, request: Request | None) -> dict[str, Judged]:
    """Return the numbers that a request speaks of, by name: all that have an error if it names none.

    A name of the request stands for the number of that name and for all that end with it, so that ``von_mises`` is the
    largest stress of the body, of its coating and of its substrate.

    Raises
    ------
    InvalidInput
        For a name that no number has.
    """
    uncertain = {name: quantity for name, quantity in quantities.items() if _is_uncertain(quantity)}
    if not isinstance(request, Mapping):
        requested = inf if request is None else request
        every = {name: _judged(name, quantities, requested) for name in uncertain}
        return {
            name: replace(one, refines=not any(part in name for part in NOT_REFINED)) for name, one in every.items()
        }
    found: dict[str, Judged] = {}
    for key, requested in request.items():
        if key == PRESSURE:
            continue
        names = [name for name in quantities if _is_named(name, key)]
        if not names:
            known = ", ".join((PRESSURE, *uncertain))
            raise InvalidInput(f"error names {key!r}, which this answer does not have: give some of {known}.")
        # the closest name is the one that is meant
        if key in names:
            names = [key]
        found |= {name: _judged(name, quantities, requested) for name in names if name in uncertain}
    return found


def _is_named(name: str, key: str) -> bool:
    """Return whether `key` is the `name` of a number or its last words, before the index of a body where it has one."""
    return sub(r"_\d$", "", name).endswith(f"_{key}") or name == key


def _is_uncertain(quantity: Quantity) -> bool:
    """Return whether a number has a relative error: it is neither exact, nor a formula, nor zero."""
    is_zero = quantity.reason == RELATIVE_TO_ZERO or (isfinite(quantity.bound) and not quantity.value)
    return not (quantity.is_formula or not quantity.bound or is_zero)


def _judged(name: str, quantities: Quantities, requested: float) -> Judged:
    """Return the number `name` of the `quantities`, with a `requested` relative error."""
    quantity = quantities[name]
    whole = quantities.get(WHOLE.get(name, name), quantity)
    scale = 1.0 if quantity.is_fraction else max(abs(quantity.value), abs(whole.value))
    bound = quantity.bound / scale if scale else inf
    label = quantity.label.split(" (")[0] + (" (absolute)" if quantity.is_fraction else "")
    order = 0.5 if name.endswith(OF_HALF_ORDER) else float(not name.endswith(NOT_BY_CELLS))
    return Judged(label, bound, requested, quantity.reason, order)


def without_bound(numbers: Iterable[Judged]) -> str:
    """Return which numbers have no bound, with the reason of the first; empty if all have one."""
    unknown = [number for number in numbers if not isfinite(number.bound)]
    if not unknown:
        return ""
    first, others = unknown[0], len(unknown) - 1
    beside = f" and {others} other{'s' if others > 1 else ''}" if others else ""
    why = sub(r"^No bound[^:]*: ", "", first.reason).rstrip(".")
    return f"no bound for the {first.label}{beside}: {why}"


def finer_grid(grid: Grid, factor: float) -> Grid:
    """Return a grid of the same extent with `factor` times the cells along each axis that has several."""
    across, along = (count if count == 1 else ceil(count * factor) for count in grid.cells)
    return Grid((across, along), grid.extent)
