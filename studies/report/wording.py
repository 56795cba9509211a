"""The verdict on a scene's settings in words, for the page and for the command."""

from collections.abc import Iterator
from math import isfinite

from contactstudy.domain.grid import cells_text
from studies.advice.verdict import PRESSURE, TIE, Measured, Verdict
from studies.model.plain_text import two_digits
from studies.report.style import percent

# Errors for which a page lists the fastest setting, beside the requested one.
DECADES = (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4)


def padding_name(label: str) -> str:
    """Return the name of a padding in a sentence."""
    if label == "exact":
        return "exact periodicity"
    return f"{label} padding" if label in ("zero", "duplicated") else label


def tolerance_text(tolerance: float) -> str:
    """Return a tolerance, such as "1e-2"."""
    return f"{tolerance:.0e}".replace("e-0", "e-")


def seconds_text(seconds: float) -> str:
    """Return a time with two digits, in ms below a second."""
    if seconds >= 0.9995:
        return f"{two_digits(seconds)} s"
    return f"{two_digits(1000 * seconds)} ms"


def setting_text(one: Measured) -> str:
    """Return a setting in words."""
    setting = one.setting
    tolerance = tolerance_text(setting.tolerance)
    return f"{padding_name(setting.label)}, {cells_text(setting.cells)}, tolerance {tolerance}"


def bound_text(verdict: Verdict, one: Measured) -> str:
    """Return the bound of a setting with what it is of, and the measured difference."""
    bound = verdict.bound(one)
    where = "in L1" if verdict.measure == PRESSURE else one.worst
    reached = f"error at most {percent(bound)} {where}" if isfinite(bound) else "an error without a bound"
    return f"{reached}, measured difference {percent(one.difference)}"


def claim(verdict: Verdict) -> str:
    """Return the verdict in a sentence."""
    best = verdict.best()
    if best is None:
        nearest = verdict.nearest
        return (
            f"No setting that was tried is shown to keep {percent(verdict.error)} by {verdict.measure}. The nearest is "
            f"{setting_text(nearest)}: {bound_text(verdict, nearest)}, in {seconds_text(nearest.seconds)}."
        )
    return (
        f"Use {setting_text(best)}: {bound_text(verdict, best)}, in {seconds_text(best.seconds)} on one thread; "
        f"{percent(verdict.error)} was requested, and is kept by {verdict.measure}."
    )


def explanation(verdict: Verdict) -> Iterator[str]:
    """Yield sentences on other paddings, and on what the verdict stands on."""
    best, meeting = verdict.best(), verdict.meeting()
    if verdict.measure == PRESSURE:
        error = (best or verdict.nearest).error
        here = f", here up to {percent(error)}" if isfinite(error) else ""
        yield f"Other numbers of the answer may have larger errors{here}."
    along = {one.setting.label: one.setting.cells[1] for one in verdict.settings}
    if min(along.values()) == 1:
        yield "Nothing varies along the length, so that one cell along it is enough."
        if (copied := along.get("duplicated", 1)) > 1:
            yield f"Duplicated padding has {copied}, since its window is off centre on fewer."
            yield "The period is free too: over 100 half-widths every padding has the cells' error alone."
    if best is not None:
        fastest = {one.setting.label: one for one in reversed(meeting)}
        others = sorted(
            (one for one in fastest.values() if one.setting.label != best.setting.label), key=lambda one: one.seconds
        )  # fmt: skip
        ratios = [(padding_name(one.setting.label), one.seconds / best.seconds) for one in others]
        if ties := [name for name, ratio in ratios if ratio <= TIE]:
            whose = ", which goes to the scene's own padding" * (best.setting.label == verdict.own)
            yield f"As fast within {percent(TIE - 1)}, or but for the set-up, a tie{whose}: {', '.join(ties)}."
        if slower := [f"{name} ({ratio:.2g} times)" for name, ratio in ratios if ratio > TIE]:
            yield f"Slower: {', '.join(slower)}."
    least: dict[str, Measured] = {}
    for one in verdict.settings:
        known = least.setdefault(one.setting.label, one)
        least[one.setting.label] = min(known, one, key=verdict.bound)
    kept = {one.setting.label for one in meeting}
    if missed := [
        f"{padding_name(label)} ({percent(verdict.bound(one))})" for label, one in least.items() if label not in kept
    ]:  # fmt: skip
        yield f"Not kept on any grid that was tried, with the least bound: {', '.join(missed)}."
    if verdict.own in ("free ends", "repeating across and along"):
        yield f"The scene has {verdict.own}: no other padding is that contact, and none was tried."
    yield f"Differences are against {verdict.reference}."
    yield from verdict.notes


def lines(verdict: Verdict) -> Iterator[str]:
    """Yield the verdict as lines of a terminal, with the tables of a scene file."""
    yield f"{verdict.name}: {claim(verdict)}"
    yield from (f"  {sentence}" for sentence in explanation(verdict))
    yield "  in the scene file, instead of its tables grid, padding, solve and plan:"
    chosen = verdict.best() or verdict.nearest
    yield from (f"    {line}".rstrip() for line in verdict.toml(chosen).strip().splitlines())
