"""The sections of a page about a scene's settings, from what a folder has stored of it or from a measurement."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from studies.advice.compared_scene import SceneText
from studies.advice.comparison import Comparison
from studies.advice.measuring import compare_settings
from studies.advice.nested_answers import Budget
from studies.advice.stored import path_in, store, stored
from studies.model.plain_text import Log
from studies.report.chapters import SETTINGS
from studies.report.drawings.comparison import parts
from studies.report.section import FORMATS, Section, embedded
from studies.store.netcdf import open_folder


def comparison_of(
    described: SceneText, error: float, budget: Budget, out: Path, log: Log
) -> Comparison:
    """Return the comparison of a scene that a folder has, if it answers the request; else measure and store it.

    One that does not meet the request answers it unless there are more seconds now.

    Parameters
    ----------
    described
        The scene.
    error
        Requested relative L1 error of the pressure.
    budget
        Seconds for a measurement.
    out
        Folder of the file.
    log
        Takes a sentence on each step.
    """
    comparison = stored(described.key, out)
    if comparison is not None:
        verdict = comparison.verdict(error)
        had_time = comparison.error == error and budget.seconds <= comparison.budget
        if had_time or (verdict is not None and verdict.meets and verdict.best.rounds):
            log(f"read the rounds stored in {path_in(out)}")
            return replace(comparison, error=error)
    comparison = compare_settings(described.subject(error), error, budget, log)
    store(comparison, described.key, open_folder(out))
    return comparison


def scene_sections(
    comparison: Comparison,
    out: Path,
    formats: Sequence[str] = FORMATS,
    max_parts: int | None = None,
) -> Sequence[Section]:
    """Draw a comparison into a folder, and return it, or the first `max_parts` of it, as sections of a page."""
    return [
        Section(
            name=part.name,
            title=part.title,
            axes_text="",
            findings=part.findings,
            figures=[embedded(figure, SETTINGS, out, formats) for figure in part.figures],
            tables=part.tables,
            file=SETTINGS,
        )
        for part in parts(comparison)[:max_parts]
    ]


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
