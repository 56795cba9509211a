"""Quantity: a number of an answer with its unit and the bound of its error, and how quantities are written as text."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Any

from contactstudy.domain.errors import ErrorParts
from contactstudy.domain.validation import readable
from contactstudy.scene.scene import PosedScene

NO_ESTIMATE = "No bound: no estimate of its error is known."
RELATIVE_TO_ZERO = "No bound: the value is 0, and its error is known relative to it alone."
FORMULA = "No bound: the value is that of a formula."
# Relative bound above which a number counts as zero beside its bound, which is then written in the unit of the number:
# "error <= 1000 %" tells no more.
MAX_RELATIVE = 10.0


@dataclass(frozen=True)
class Quantity:
    """Number of an answer.

    Parameters
    ----------
    value
        Value in the SI unit.
    unit
        SI unit, such as ``"Pa"`` or ``"m2 m-1"``.
    label
        Name for display.
    bound
        Upper estimate of the absolute error, in the same unit; infinite where it is not known.
    reason
        Sentence on why the bound is infinite; empty where it is finite.
    position
        Coordinates at which the value is found, by the names of the axes, [m], or [s] for ``time``; None where it has
        none.
    detail
        Text on this value alone, written behind its label, such as from where an approach counts.
    is_fraction
        True for a part of a whole, from 0 to 1, whose error is written as it is and not relative to the value.
    rivals
        Pairs of a value and its depth [m], 0 at the surface, which a largest value may have at other places or between
        the cells. The bound of the value includes these values; the bound of its depth includes the depths of those
        within that bound.
    least_change
        Least relative change between grids that the bound assumes: of a largest stress, which may lie between depths.
    """

    value: float
    unit: str
    label: str
    bound: float = inf
    reason: str = NO_ESTIMATE
    position: Mapping[str, float] | None = None
    detail: str = ""
    is_fraction: bool = False
    rivals: Sequence[tuple[float, float]] = ()
    least_change: float = 0.0

    @property
    def is_formula(self) -> bool:
        """True for the value of a formula, which has no error estimate."""
        return self.reason == FORMULA

    @property
    def relative_bound(self) -> float:
        """Bound over the size of the value; infinite where the value is 0 and the bound is not."""
        if not self.bound:
            return 0.0
        return self.bound / abs(self.value) if self.value else inf

    def __str__(self) -> str:
        """Return value and bound, such as ``0.427 GPa (error <= 0.1 %)``, or the reason why there is none."""
        return f"{readable(self.value, self.unit)} ({_error_text(self) or self.reason.rstrip('.')})"


# Quantities of an answer, by their names such as "peak_pressure".
Quantities = Mapping[str, Quantity]


def with_bound(quantity: Quantity, parts: ErrorParts | None, fallback_reasons: Sequence[str] = ()) -> Quantity:
    """Return a quantity with the bound of its relative error, and the reason where that is infinite.

    Parameters
    ----------
    quantity
        The quantity.
    parts
        Its relative error; None where no estimate is known.
    fallback_reasons
        Reasons where `parts` has none; the first is taken.
    """
    if parts is None:
        return quantity
    if not quantity.value and 0 < parts.total < inf:
        return replace(quantity, reason=RELATIVE_TO_ZERO)
    if isfinite(parts.total):
        return replace(quantity, bound=parts.total * abs(quantity.value), reason="")
    reason = parts.reason or next(iter(fallback_reasons), NO_ESTIMATE)
    return replace(quantity, bound=inf, reason=reason)


def bounded(
    value: float, unit: str, label: str, parts: ErrorParts | None, fallback_reasons: Sequence[str] = (), **more: Any
) -> Quantity:
    """Return a quantity with `value`, `unit`, `label`, other fields `more`, and the bound of its relative error.

    The error `parts` and `fallback_reasons` are those of :func:`with_bound`.
    """
    return with_bound(Quantity(value, unit, label, **more), parts, fallback_reasons)


def roller_length(posed: object) -> float | None:
    """Return the length [m] of the roller of a posed scene; None without one or a scene, and of an endless one.

    The load of an endless contact is that of a period. A body that is cut off at the ends of the grid, whose contact
    repeats by the padding, is endless.
    """
    if not isinstance(posed, PosedScene):
        return None
    scene, length = posed.scene, posed.scene.roller_length
    if length is None or (scene.repeats(posed.padding) and length != posed.grid.length):
        return None
    return scene.loaded_length(posed.grid, posed.padding)


def per_length(value: float, unit: str, label: str, length: float | None, period: float) -> Quantity:
    """Return a total `value` over the grid: as it is for a roller of a `length` [m], if None divided by `period` [m].

    The `unit` and the `label` are those of the total; if it is divided, both say so.
    """
    if length is not None:
        return Quantity(value, unit, label)
    return Quantity(value / period, f"{unit} m-1", f"{label} per length")


def as_text(quantities: Quantities) -> str:
    """Return quantities as a table: label, value with unit, error, place; those by formulas in one line.

    A number without a bound has no text in the column of errors, and its reason below.
    """
    rows, formulas, unbounded = list[tuple[str, str, str, str]](), list[str](), dict[str, list[str]]()
    for quantity in quantities.values():
        label, value = quantity.label + quantity.detail, readable(quantity.value, quantity.unit)
        if quantity.is_formula:
            formulas.append(f"{label} {value}")
            continue
        places = (
            f"{at:.3g} s" if axis == "time" else f"{axis} = {readable(at, 'm', 3)}"
            for axis, at in (quantity.position or {}).items()
        )
        rows.append((label, value, _error_text(quantity), ", ".join(places)))
        if not isfinite(quantity.bound):
            unbounded.setdefault(quantity.reason, []).append(quantity.label)
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    lines = []
    for label, value, error, place in rows:
        line = f"  {label:<{widths[0]}}  {value:>{widths[1]}}  {error:<{widths[2]}}"
        lines.append(f"{line}  at {place}" if place else line.rstrip())
    if formulas:
        lines.append(f"  by formulas: {'; '.join(formulas)}")
    return "\n".join([*lines, *(f"  {', '.join(labels)}: {reason}" for reason, labels in unbounded.items())])


def _error_text(quantity: Quantity) -> str:
    """Return the bound of a number relative to it, or as it is of a fraction or nearly zero; empty without a bound."""
    if not quantity.bound:
        return "exact"
    if not isfinite(quantity.bound):
        return ""
    if quantity.is_fraction:
        return f"error <= {per_cent(quantity.bound)} (absolute)"
    if quantity.relative_bound > MAX_RELATIVE:
        return f"error <= {readable(quantity.bound, quantity.unit, 2)}"
    return f"error <= {per_cent(quantity.relative_bound)}"


def per_cent(ratio: float) -> str:
    """Return a ratio as text in per cent, with two digits below 100 % and whole from there on."""
    percent = 100 * ratio
    return f"{percent:.2g} %" if percent < 99.5 else f"{percent:.0f} %"


def as_json(quantities: Quantities) -> dict[str, dict[str, object]]:
    """Return quantities in SI units by their names; a bound that is not known is None, with its reason."""
    return {
        name: {
            "value": quantity.value,
            "unit": quantity.unit,
            "bound": quantity.bound if isfinite(quantity.bound) else None,
            **({"reason": quantity.reason} if quantity.reason else {}),
            "label": quantity.label + quantity.detail,
            **({"at": dict(quantity.position)} if quantity.position else {}),
        }
        for name, quantity in quantities.items()
    }
