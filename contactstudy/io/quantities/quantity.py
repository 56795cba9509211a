"""Number of an answer with unit and bound, and how numbers are written."""

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
# Relative bound above which a number is zero beside its bound, which is then said as it is.
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
        What is said of this value alone, behind its label.
    is_fraction
        Whether it is a part of one, whose error is said as it is and not relative to the value.
    rivals
        Of a largest value, those that it may have as well at other places or between the cells, each with its depth [m]:
        its bound includes them, and that of its depth the depths of those within its bound.
    least_change
        Relative change that counts at least between grids: of a largest stress that may lie between depths.
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
        said = _error_text(self) or self.reason.rstrip(".")
        return f"{readable(self.value, self.unit)} ({said})"


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
    """Return a quantity of this value with the bound of its relative error, as :func:`with_bound` gives it."""
    return with_bound(Quantity(value, unit, label, **more), parts, fallback_reasons)


def roller_length(posed: PosedScene | None) -> float | None:
    """Return the length [m] of the roller of a scene; None for an endless one, whose load is that of a period."""
    if posed is None:
        return None
    scene, length = posed.scene, posed.scene.roller_length
    if length is None or (scene.repeats(posed.padding) and length != posed.grid.length):
        return None
    return scene.loaded_length(posed.grid, posed.padding)


def per_length(value: float, unit: str, label: str, length: float | None, period: float) -> Quantity:
    """Return a total over the grid: as it is for a roller of a `length` [m], else divided by the `period` [m]."""
    if length is not None:
        return Quantity(value, unit, label)
    return Quantity(value / period, f"{unit} m-1", f"{label} per length")


def as_text(quantities: Quantities) -> str:
    """Return quantities as a table: label, value with unit, error, place; those by formulas in one line.

    A number without a bound has no text in the column of errors, and its reason below.
    """
    rows = [
        (
            quantity.label + quantity.detail,
            readable(quantity.value, quantity.unit),
            _error_text(quantity),
            ", ".join(_position_text(axis, at) for axis, at in (quantity.position or {}).items()),
        )
        for quantity in quantities.values()
        if not quantity.is_formula
    ]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    lines = []
    for label, value, error, position_text in rows:
        line = f"  {label:<{widths[0]}}  {value:>{widths[1]}}  {error:<{widths[2]}}"
        lines.append(f"{line}  at {position_text}" if position_text else line.rstrip())
    formulas = [
        f"{quantity.label}{quantity.detail} {readable(quantity.value, quantity.unit)}"
        for quantity in quantities.values()
        if quantity.is_formula
    ]
    lines += [f"  by formulas: {'; '.join(formulas)}"] * bool(formulas)
    unbounded: dict[str, list[str]] = {}
    for quantity in quantities.values():
        if not isfinite(quantity.bound) and not quantity.is_formula:
            unbounded.setdefault(quantity.reason, []).append(quantity.label)
    return "\n".join([*lines, *(f"  {', '.join(labels)}: {reason}" for reason, labels in unbounded.items())])


def _position_text(axis: str, at: float) -> str:
    """Return the coordinate of a value as text."""
    return f"{at:.3g} s" if axis == "time" else f"{axis} = {readable(at, 'm', 3)}"


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
    """Return a ratio in per cent with two digits, or whole from 100 % on."""
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
