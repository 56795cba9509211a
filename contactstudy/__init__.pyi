# The public names, each with the module that defines it: what `import contactstudy` offers, imported on first use.
from . import analytic, kernels
from .accuracy.estimate import ErrorEstimate, ErrorParts, error_estimate
from .domain.checks import InvalidInput, NotDefined
from .domain.device import Cpu, Gpu, Precision
from .domain.grid import Grid
from .domain.padding import (
    CircularSuperposition,
    DuplicatedPadding,
    ExactPeriodicity,
    Padding,
    Paddings,
    Superposition,
    ZeroPadding,
)
from .elasticity.coefficients import Coefficients
from .elasticity.convolution import Convolution, convolution, superposed
from .evolution.evolution import Evolution
from .evolution.evolve import StepError, evolve
from .evolution.passes.contacts import RollingPressure
from .evolution.passes.repeated_rolling import RepeatedRolling, RollingPass
from .evolution.passes.roll_repeatedly import roll_repeatedly
from .evolution.rolling import SteadyRolling, solve_rolling
from .evolution.scheme import Scheme
from .io.compare import Comparison, compare
from .io.dataset import to_dataset
from .io.scene_file import SceneFile, read_scene
from .io.scene_writer import write_scene
from .planning.plan import Plan, plan
from .problem.bare_problem import BareProblem, PrescribedLoad, Resultant
from .problem.constraint import Compressive, Constraint, Gap, HardnessLimited
from .problem.operator import Operator
from .problem.problem import Problem, Scales
from .scene.bodies.coated import CoatedHalfSpace
from .scene.bodies.elastic_plastic import ElasticPlasticHalfSpace
from .scene.bodies.solids import Body, HalfSpace
from .scene.bodies.viscoelastic import ViscoelasticHalfSpace
from .scene.friction import PartialSlip, Sliding
from .scene.loads.load import LineLoad
from .scene.loads.load_history import LoadHistory, SineLoad
from .scene.outputs import Output
from .scene.rolling import Rolling
from .scene.scene import Scene
from .scene.shapes.crown import Crown, LundbergProfile
from .scene.shapes.detail import Detail
from .scene.shapes.finite_length import FiniteLength
from .scene.shapes.roughness import RmsSlope, Roughness
from .scene.shapes.round import Cylinder, Sphere
from .scene.shapes.shape import Shape
from .scene.shapes.texture import Cosine, Dimple, FlatBottomed, Groove, Parabolic, Texture
from .scene.shapes.waviness import Waviness
from .scene.stress import SubsurfaceStress
from .scene.surfaces.measured_surface import MeasuredSurface
from .scene.surfaces.missing_points import HarmonicFill, RefuseMissing
from .scene.surfaces.seam import AsMeasured, Mirrored, Tapered
from .scene.surfaces.trend import Trend
from .scene.surfaces.window import Window
from .scene.wear import Wear
from .solvers.iterate import Iterate
from .solvers.polonsky_keer import PolonskyKeer
from .solvers.preconditioned_cg import PreconditionedCG
from .solvers.solution import Solution, Status
from .solvers.solve import Solver, solve

__version__: str

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
    "ElasticPlasticHalfSpace",
    "ErrorEstimate",
    "ErrorParts",
    "Evolution",
    "ExactPeriodicity",
    "FiniteLength",
    "FlatBottomed",
    "Gap",
    "Gpu",
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
    "RepeatedRolling",
    "Resultant",
    "RmsSlope",
    "Rolling",
    "RollingPass",
    "RollingPressure",
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
    "analytic",
    "compare",
    "convolution",
    "error_estimate",
    "evolve",
    "kernels",
    "plan",
    "read_scene",
    "roll_repeatedly",
    "solve",
    "solve_rolling",
    "superposed",
    "to_dataset",
    "write_scene",
]
