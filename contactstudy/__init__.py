"""Rough line contacts, periodic along their length: how accurate the answer is, and what that cost."""

from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from contactstudy import analytic
from contactstudy.accuracy.estimate import ErrorEstimate, ErrorParts, error_estimate
from contactstudy.domain.checks import InvalidInput, NotDefined
from contactstudy.domain.device import Cpu
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
from contactstudy.domain.version import VERSION as __version__
from contactstudy.elasticity.coefficients import Coefficients
from contactstudy.elasticity.convolution import Convolution, convolution, superposed
from contactstudy.planning.plan import Plan, plan
from contactstudy.problem.bare_problem import BareProblem
from contactstudy.problem.compressive import Compressive
from contactstudy.problem.constraint import Constraint
from contactstudy.problem.gap import Gap
from contactstudy.problem.hardness_limited import HardnessLimited
from contactstudy.problem.operator import Operator
from contactstudy.problem.problem import Problem, Scales
from contactstudy.problem.resultant import PrescribedLoad, Resultant
from contactstudy.scene.load import LineLoad
from contactstudy.scene.outputs import Output
from contactstudy.scene.scene import Scene
from contactstudy.scene.shapes.crown import Crown, LundbergProfile
from contactstudy.scene.shapes.detail import Detail
from contactstudy.scene.shapes.finite_length import FiniteLength
from contactstudy.scene.shapes.roughness import RmsSlope, Roughness
from contactstudy.scene.shapes.round import Cylinder, Sphere
from contactstudy.scene.shapes.shape import Shape
from contactstudy.scene.shapes.texture import (
    Cosine,
    Dimple,
    FlatBottomed,
    Groove,
    Parabolic,
    Texture,
)
from contactstudy.scene.shapes.waviness import Waviness
from contactstudy.scene.solids import Body, HalfSpace
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.scene.surfaces.missing_points import HarmonicFill, RefuseMissing
from contactstudy.scene.surfaces.seam import AsMeasured, Mirrored, Tapered
from contactstudy.scene.surfaces.trend import Trend
from contactstudy.scene.surfaces.window import Window
from contactstudy.solvers.iterate import Iterate
from contactstudy.solvers.polonsky_keer import PolonskyKeer
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution, Status
from contactstudy.solvers.solve import Solver, solve

if _TYPE_CHECKING:
    from contactstudy import kernels
    from contactstudy.evolution.evolution import Evolution
    from contactstudy.evolution.evolve import StepError, evolve
    from contactstudy.evolution.rolling import SteadyRolling, solve_rolling
    from contactstudy.evolution.scheme import Scheme
    from contactstudy.io.compare import Comparison, compare
    from contactstudy.io.dataset import to_dataset
    from contactstudy.io.scene_file import SceneFile, read_scene
    from contactstudy.io.scene_writer import write_scene
    from contactstudy.scene.coated import CoatedHalfSpace
    from contactstudy.scene.friction import PartialSlip, Sliding
    from contactstudy.scene.load_history import LoadHistory, SineLoad
    from contactstudy.scene.rolling import Rolling
    from contactstudy.scene.stress import SubsurfaceStress
    from contactstudy.scene.viscoelastic import ViscoelasticHalfSpace
    from contactstudy.scene.wear import Wear

__all__ = [
    "AsMeasured",
    "BareProblem",
    "Body",
    "CircularSuperposition",
    "CoatedHalfSpace",
    "Coefficients",
    "Comparison",
    "Compressive",
    "Constraint",
    "Convolution",
    "Cosine",
    "Cpu",
    "Crown",
    "Cylinder",
    "Detail",
    "Dimple",
    "DuplicatedPadding",
    "ErrorEstimate",
    "ErrorParts",
    "Evolution",
    "ExactPeriodicity",
    "FiniteLength",
    "FlatBottomed",
    "Gap",
    "Grid",
    "Groove",
    "HalfSpace",
    "HardnessLimited",
    "HarmonicFill",
    "InvalidInput",
    "Iterate",
    "LineLoad",
    "LoadHistory",
    "LundbergProfile",
    "MeasuredSurface",
    "Mirrored",
    "NotDefined",
    "Operator",
    "Output",
    "Padding",
    "Paddings",
    "Parabolic",
    "PartialSlip",
    "Plan",
    "PolonskyKeer",
    "Precision",
    "PreconditionedCG",
    "PrescribedLoad",
    "Problem",
    "RefuseMissing",
    "Resultant",
    "RmsSlope",
    "Rolling",
    "Roughness",
    "Scales",
    "Scene",
    "SceneFile",
    "Scheme",
    "Shape",
    "SineLoad",
    "Sliding",
    "Solution",
    "Solver",
    "Sphere",
    "Status",
    "SteadyRolling",
    "StepError",
    "SubsurfaceStress",
    "Superposition",
    "Tapered",
    "Texture",
    "Trend",
    "ViscoelasticHalfSpace",
    "Waviness",
    "Wear",
    "Window",
    "ZeroPadding",
    "__version__",
    "analytic",
    "compare",
    "convolution",
    "error_estimate",
    "evolve",
    "kernels",
    "plan",
    "read_scene",
    "solve",
    "solve_rolling",
    "superposed",
    "to_dataset",
    "write_scene",
]

# Names whose modules a solve does not need: imported when they are first asked for.
_LATER = {
    "Comparison": "contactstudy.io.compare",
    "compare": "contactstudy.io.compare",
    "CoatedHalfSpace": "contactstudy.scene.coated",
    "PartialSlip": "contactstudy.scene.friction",
    "Sliding": "contactstudy.scene.friction",
    "Evolution": "contactstudy.evolution.evolution",
    "LoadHistory": "contactstudy.scene.load_history",
    "Rolling": "contactstudy.scene.rolling",
    "SceneFile": "contactstudy.io.scene_file",
    "Scheme": "contactstudy.evolution.scheme",
    "SineLoad": "contactstudy.scene.load_history",
    "SteadyRolling": "contactstudy.evolution.rolling",
    "StepError": "contactstudy.evolution.evolve",
    "SubsurfaceStress": "contactstudy.scene.stress",
    "ViscoelasticHalfSpace": "contactstudy.scene.viscoelastic",
    "Wear": "contactstudy.scene.wear",
    "evolve": "contactstudy.evolution.evolve",
    "kernels": "contactstudy.kernels",
    "read_scene": "contactstudy.io.scene_file",
    "solve_rolling": "contactstudy.evolution.rolling",
    "to_dataset": "contactstudy.io.dataset",
    "write_scene": "contactstudy.io.scene_writer",
}


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = _import_module(_LATER[name])
    return module if _LATER[name] == f"{__name__}.{name}" else getattr(module, name)


def __dir__() -> list[str]:
    return [*__all__, "__doc__", "__version__"]
