"""The verdict on a scene's settings in words, for the page and for the command."""

from collections.abc import Sequence
from math import inf, isfinite

from studies.advice.compared_scene import REPORTED, Setting
from studies.advice.comparison import LINE, Alternative, Comparison, MeasuredSetting, Verdict
from studies.model.plain_text import two_digits
from studies.report.style import percent

NAMES = {"exact": "exact periodicity", LINE: "exact periodicity", "free": "free ends"}
# Paddings that a figure's title names as equally fast.
MAX_TIES = 3
# Requested errors of the table of costs.
DECADES = (0.3, 0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4)


def padding_name(label: str) -> str:
    """Return the name of a padding in a sentence."""
    return NAMES.get(label, f"{label} padding" if label in ("zero", "duplicated") else label)


def cells_text(cells: tuple[int, int]) -> str:
    """Return numbers of cells, such as "128 x 96 cells"."""
    return f"{cells[0]} x {cells[1]} cells"


def tolerance_text(tolerance: float) -> str:
    """Return a tolerance, such as "1e-2"."""
    return f"{tolerance:.0e}".replace("e-0", "e-")


def enumerated(words: Sequence[str]) -> str:
    """Return words as a list in a sentence."""
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))


def setting_text(measured: MeasuredSetting) -> str:
    """Return a setting in words."""
    tolerance = tolerance_text(measured.setting.tolerance)
    return f"{padding_name(measured.label)}, {cells_text(measured.setting.cells)}, tolerance {tolerance}"


def seconds_text(seconds: float) -> str:
    """Return a time with two digits, in ms below a second."""
    if seconds >= 0.9995:
        return f"{two_digits(seconds)} s"
    return f"{two_digits(1000 * seconds)} ms"


def error_text(error: float, floor: float) -> str:
    """Return an error with the reference's bound, where there is one."""
    if floor == 0:
        return percent(error)
    return f"{percent(error)} ± {percent(floor)}" if isfinite(floor) else f"{percent(error)} ± ?"


def ratio_text(alternative: Alternative) -> str:
    """Return how long an alternative takes beside the chosen setting, as a ratio and as a difference."""
    extra_time = alternative.measured.time * (1 - 1 / alternative.ratio)
    difference = f"{seconds_text(abs(extra_time))} {'more' if extra_time > 0 else 'less'}"
    padding = padding_name(alternative.measured.label)
    return f"{padding} ({alternative.ratio:.2g} times, {difference})"


def verdict_text(comparison: Comparison, verdict: Verdict) -> str:
    """Return the verdict in a sentence."""
    best = verdict.best
    cost = f"in {seconds_text(best.time)} on one thread"
    error = error_text(best.error, comparison.reference_bound)
    if verdict.meets:
        return (
            f"Use {setting_text(best)}: the L1 error of the pressure is {error}, {cost}; "
            f"{percent(verdict.error)} was requested."
        )
    if comparison.reference_bound == inf:
        return (
            f"No setting can be shown to meet {percent(verdict.error)}: the finest solution has no bound on its own "
            f"error. The nearest is {setting_text(best)}, {percent(best.error)} from it, {cost}."
        )
    return f"No setting is shown to meet {percent(verdict.error)}. The nearest is {setting_text(best)}: {error}, {cost}."


def alternatives_text(comparison: Comparison, verdict: Verdict) -> str:
    """Return sentences on the other paddings and on the next coarser grid."""
    best = verdict.best
    rounds = max((len(setting.rounds) for setting in comparison.settings), default=0)
    sentences = []
    timed = [alternative for alternative in verdict.alternatives if alternative.measured.rounds]
    shown = [alternative for alternative in timed if alternative.is_significant]
    undecided = [r for r in timed if not r.is_as_fast and not r.is_significant]
    untimed = [r for r in verdict.alternatives if not r.measured.rounds]
    if ties := [padding_name(r.measured.label) for r in timed if r.is_as_fast]:
        sentences.append(f"As fast within 10 %: {', '.join(ties)}.")
    for words, alternatives in (
        (f"Slower by {rounds} rounds of timing", [r for r in shown if r.ratio > 1]),
        (f"Quicker by {rounds} rounds of timing", [r for r in shown if r.ratio < 1]),
        (f"Not decided by {rounds} rounds of timing", undecided),
        ("Meets the request too, but is not among the quickest", untimed),
    ):
        if alternatives:
            sentences.append(f"{words}: {', '.join(map(ratio_text, alternatives))}.")
    meeting = {best.label, *(r.measured.label for r in verdict.alternatives)}
    lines = [comparison.settings_of(label) for label in comparison.labels if label not in meeting]
    finest = sorted((line[-1] for line in lines if line), key=lambda measured: measured.error)
    judged = [
        item
        for item in finest
        if item.is_bounded and item.setting.cells[0] >= best.setting.cells[0]
    ]
    for words, items in (
        ("No grid is accurate enough with", judged),
        ("Not timed on grids as fine, or without a bound", [r for r in finest if r not in judged]),
    ):
        if items and verdict.meets:
            misses = [f"{padding_name(item.label)} ({percent(item.error)})" for item in items]
            if len(items) > 3:
                misses = [f"{len(items)} paddings, from {misses[0]} to {misses[-1]}"]
            sentences.append(f"{words}: {', '.join(misses)}.")
    if coarser := verdict.coarser:
        saved = coarser.time / verdict.best.time
        took = f"{saved:.2g} times the time" if saved < 1 else "no less time"
        sentences.append(
            f"The next coarser grid, {cells_text(coarser.setting.cells)}, has an error of "
            f"{percent(coarser.error)} in {took}{_why(comparison, verdict, coarser)}."
        )
    return " ".join(sentences)


def _why(comparison: Comparison, verdict: Verdict, coarser: MeasuredSetting) -> str:
    """Return why the next coarser grid was not chosen."""
    if not verdict.meets:
        return ""
    if not coarser.is_bounded:
        return ", but its own error has no bound"
    if coarser.error + comparison.reference_bound > verdict.error >= coarser.error:
        return ", which meets the request only without the bound of the reference"
    if coarser.error > verdict.error:
        return " and misses the request"
    return ", which saves no time"


def title_text(comparison: Comparison, verdict: Verdict) -> str:
    """Return the verdict in two short lines, for a figure."""
    best: Setting = verdict.best.setting
    first = f"{comparison.name}: {verdict.best.label}, {cells_text(best.cells)}, tol. {tolerance_text(best.tolerance)}"
    second = f"{error_text(verdict.best.error, comparison.reference_bound)} in {seconds_text(verdict.best.time)}"
    if not verdict.meets:
        return f"{first}\n{second}: {percent(verdict.error)} is not met"
    ties = [
        alternative.measured.label
        for alternative in verdict.alternatives
        if alternative.is_as_fast and alternative.measured.rounds
    ]
    named = "; ".join(ties[:MAX_TIES]) + "; ..." * (len(ties) > MAX_TIES)
    return f"{first}\n{second}" + f"; as fast: {named}" * bool(ties)


def reported_quantities(comparison: Comparison) -> Sequence[tuple[str, str]]:
    """Return the numbers whose change by a padding is known, each with its name for people."""
    names = {name for padding in comparison.paddings for name in padding.changes}
    return [(name, long_name) for name, long_name in REPORTED.items() if name in names]


def introduction(comparison: Comparison) -> str:
    """Return an introduction: the scene, the paddings and the measure of error."""
    width, length = (1e3 * side for side in comparison.extent)
    return (
        f"The scene {comparison.name} on {width:.4g} mm x {length:.4g} mm, solved with every padding on finer and finer "
        "grids. Neighbouring periods can be ignored (zero), copied once (duplicated), summed over n periods on each "
        "side in a window fixed to the domain (superposed) or moving with the point (circular), or summed to infinity "
        f"in closed form (exact){'; free ends have none' * (comparison.boundary_label == 'free')}. The L1 error is the "
        f"mean absolute error of the pressure over the mean pressure. Measured in "
        f"{comparison.seconds:.0f} s, times on one thread."
    )
