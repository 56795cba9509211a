"""Rough line contacts, periodic along their length: how accurate the answer is, and what that cost."""

from importlib import import_module
from typing import TYPE_CHECKING

from contactstudy import analytic
from contactstudy.accuracy.estimate import ErrorEstimate, ErrorParts, error_estimate
from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import (
    CircularSuperposition,
    DuplicatedPadding,
    ExactPeriodicity,
    Padding,
    Paddings,
    Superposition,
    ZeroPadding,
)
from contactstudy.domain.precision import Precision
from contactstudy.elasticity.convolution import Convolution, convolution
from contactstudy.elasticity.kernels import cell as influence
from contactstudy.planning.plan import Plan, plan
from contactstudy.problem.problem import Problem
from contactstudy.scene.load import LineLoad
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.basic import Cylinder, Shape, Sphere, Waviness
from contactstudy.scene.shapes.crown import Crown, LundbergProfile
from contactstudy.scene.shapes.detail import Detail
from contactstudy.scene.shapes.finite_length import FiniteLength
from contactstudy.scene.shapes.roughness import RmsSlope, Roughness
from contactstudy.scene.shapes.texture import (
    Cosine,
    Dimple,
    FlatBottomed,
    Groove,
    Parabolic,
    Texture,
)
from contactstudy.scene.solids import HalfSpace
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.scene.surfaces.missing_points import HarmonicFill, RefuseMissing
from contactstudy.scene.surfaces.seam import AsMeasured, Mirrored, Tapered
from contactstudy.scene.surfaces.trend import Trend
from contactstudy.solvers.polonsky_keer import PolonskyKeer
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import Solver, solve

if TYPE_CHECKING:
    from contactstudy.io.dataset import to_dataset
    from contactstudy.io.scene_file import SceneFile, read_scene
    from contactstudy.scene.stress import SubsurfaceStress

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
    "SceneFile": "contactstudy.io.scene_file",
    "SubsurfaceStress": "contactstudy.scene.stress",
    "read_scene": "contactstudy.io.scene_file",
    "to_dataset": "contactstudy.io.dataset",
}


def __getattr__(name: str) -> object:
    if name in LATER:
        return getattr(import_module(LATER[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
