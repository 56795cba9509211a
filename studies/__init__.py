"""Studies: many contacts, swept, stored, timed and drawn."""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from contactstudy.domain.imports import import_for as _import_for

if _TYPE_CHECKING:
    from contactstudy.io.pictures.figure import panels
    from studies.engine.options import RunOptions
    from studies.engine.run import run
    from studies.model.axis import Axis
    from studies.model.case import Case, OperatorCase, error_estimates
    from studies.model.drawing import CaptionedFigure, Drawing, Finding, Table
    from studies.model.study import Study
    from studies.registry import load
    from studies.scene_study.study_of import study_of

# Each name where it stands; nothing is imported before it is asked for.
_PUBLIC = {
    "Axis": "studies.model.axis",
    "CaptionedFigure": "studies.model.drawing",
    "Case": "studies.model.case",
    "Drawing": "studies.model.drawing",
    "Finding": "studies.model.drawing",
    "OperatorCase": "studies.model.case",
    "RunOptions": "studies.engine.options",
    "Study": "studies.model.study",
    "Table": "studies.model.drawing",
    "error_estimates": "studies.model.case",
    "load": "studies.registry",
    "panels": "contactstudy.io.pictures.figure",
    "run": "studies.engine.run",
    "study_of": "studies.scene_study.study_of",
}

__all__ = [
    "Axis",
    "CaptionedFigure",
    "Case",
    "Drawing",
    "Finding",
    "OperatorCase",
    "RunOptions",
    "Study",
    "Table",
    "error_estimates",
    "load",
    "panels",
    "run",
    "study_of",
]


def __getattr__(name: str) -> object:
    if name not in _PUBLIC:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(_import_for(f"{__name__}.{name}", _PUBLIC[name]), name)


def __dir__() -> list[str]:
    return [*__all__, "__doc__"]
