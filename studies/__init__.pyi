# The public names, each with the module that defines it, imported on first use.
from contactstudy.io.pictures import panels

from .cli.solving import SolveProgress
from .engine.options import RunOptions
from .engine.run import run
from .model.axis import Axis
from .model.case import Case, error_estimates
from .model.drawing import CaptionedFigure, Drawing, Finding, Table
from .model.study import Study
from .registry import load
from .scene_study.sensitivity import sensitivity
from .scene_study.study_of import study_of

__all__ = [
    "Axis",
    "CaptionedFigure",
    "Case",
    "Drawing",
    "Finding",
    "RunOptions",
    "SolveProgress",
    "Study",
    "Table",
    "error_estimates",
    "load",
    "panels",
    "run",
    "sensitivity",
    "study_of",
]
