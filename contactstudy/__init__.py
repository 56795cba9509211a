"""Rough line contacts, periodic along their length: how accurate the answer is, and what that cost."""

from importlib import import_module
from typing import TYPE_CHECKING

from contactstudy import analytic, influence
from contactstudy.checks import InvalidInput
from contactstudy.convolution import Convolution, convolution
from contactstudy.crown import Crown, LundbergProfile
from contactstudy.detail import Detail
from contactstudy.error_estimate import ErrorEstimate, ErrorParts, error_estimate
from contactstudy.finite_length import FiniteLength
from contactstudy.grid import Grid
from contactstudy.load import LineLoad
from contactstudy.measured import MeasuredSurface
from contactstudy.missing import HarmonicFill, RefuseMissing
from contactstudy.padding import (
    CircularSuperposition,
    DuplicatedPadding,
    ExactPeriodicity,
    Padding,
    Paddings,
    Superposition,
    ZeroPadding,
)
from contactstudy.plan import Plan, plan
from contactstudy.polonsky_keer import PolonskyKeer
from contactstudy.precision import Precision
from contactstudy.preconditioned_cg import PreconditionedCG
from contactstudy.problem import Problem
from contactstudy.roughness import RmsSlope, Roughness
from contactstudy.scene import Scene
from contactstudy.seam import AsMeasured, Mirrored, Tapered
from contactstudy.shapes import Cylinder, Shape, Sphere, Waviness
from contactstudy.solids import HalfSpace
from contactstudy.solution import Solution, Status
from contactstudy.solver import Solver, solve
from contactstudy.texture import Cosine, Dimple, FlatBottomed, Groove, Parabolic, Texture
from contactstudy.trend import Trend

if TYPE_CHECKING:
    from contactstudy.dataset import to_dataset
    from contactstudy.scene_file import SceneFile, read_scene
    from contactstudy.stress import SubsurfaceStress

__version__ = "0.1.0"

__all__ = [
    "AsMeasured",
    "CircularSuperposition",
    "Convolution",
    "Cosine",
    "Crown",
    "Cylinder",
    "Detail",
    "Dimple",
    "DuplicatedPadding",
    "ErrorEstimate",
    "ErrorParts",
    "ExactPeriodicity",
    "FiniteLength",
    "FlatBottomed",
    "Grid",
    "Groove",
    "HalfSpace",
    "HarmonicFill",
    "InvalidInput",
    "LineLoad",
    "LundbergProfile",
    "MeasuredSurface",
    "Mirrored",
    "Padding",
    "Paddings",
    "Parabolic",
    "Plan",
    "PolonskyKeer",
    "Precision",
    "PreconditionedCG",
    "Problem",
    "RefuseMissing",
    "RmsSlope",
    "Roughness",
    "Scene",
    "SceneFile",
    "Shape",
    "Solution",
    "Solver",
    "Sphere",
    "Status",
    "SubsurfaceStress",
    "Superposition",
    "Tapered",
    "Texture",
    "Trend",
    "Waviness",
    "ZeroPadding",
    "analytic",
    "convolution",
    "error_estimate",
    "influence",
    "plan",
    "read_scene",
    "solve",
    "to_dataset",
]


# What needs libraries that a solve does not, imported by whoever asks for it.
LATER = {
    "SceneFile": "contactstudy.scene_file",
    "SubsurfaceStress": "contactstudy.stress",
    "read_scene": "contactstudy.scene_file",
    "to_dataset": "contactstudy.dataset",
}


def __getattr__(name: str) -> object:
    if name in LATER:
        return getattr(import_module(LATER[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
