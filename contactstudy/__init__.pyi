# The public names, each with the module that defines it: what `import contactstudy` offers, imported on first use.
from . import analytic, kernels
from .accuracy.estimate import ErrorEstimate, error_estimate
from .accuracy.expected_error import ErrorParts
from .domain.checks import InvalidInput, NotDefined
from .domain.device import Cpu, Gpu, Precision
from .domain.grid import (
    CircularSuperposition,
    DuplicatedPadding,
    ExactPeriodicity,
    Grid,
    Padding,
    Paddings,
    Superposition,
    ZeroPadding,
)
from .elasticity.coefficients import Coefficients
from .elasticity.convolution import Convolution, convolution, superposed
from .evolution.evolution import Evolution
from .evolution.evolve import StepError, evolve
from .evolution.repeated_rolling import RepeatedRolling, RollingPass, roll_repeatedly
from .evolution.rolling import SteadyRolling, solve_rolling
from .evolution.steps import Scheme
from .evolution.track import RollingPressure
from .io.compare import Comparison, compare
from .io.dataset import to_dataset
from .io.materials import material
from .io.scene_file import SceneFile, read_scene
from .io.scene_writer import write_scene
from .lubrication.evolve_lubricated import FilmEvolution, evolve_lubricated
from .lubrication.lubricated_contact import (
    FilmError,
    FilmErrorParts,
    FilmScales,
    FilmStatus,
    LubricatedContact,
)
from .lubrication.solve_lubricated import film_error, film_grid, solve_lubricated
from .planning.plan import Plan, plan
from .problem.bare_problem import BareProblem
from .problem.constraint import (
    Compressive,
    Constraint,
    Gap,
    HardnessLimited,
    PrescribedLoad,
    Resultant,
)
from .problem.operator import Operator
from .problem.problem import Problem, Scales
from .scene.bodies import Body, HalfSpace
from .scene.coated import CoatedHalfSpace
from .scene.friction import PartialSlip, Sliding
from .scene.inelastic import ElasticPlasticHalfSpace, ViscoelasticHalfSpace
from .scene.load import LineLoad, LoadHistory, SineLoad, TotalLoad
from .scene.lubrication import (
    Barus,
    ChangingSpeed,
    ConstantDensity,
    DowsonHigginson,
    ElrodAdams,
    Eyring,
    LimitingShear,
    Lubricant,
    Lubrication,
    Newtonian,
    ReynoldsCavitation,
    Roelands,
    SpeedHistory,
)
from .scene.motion import Rolling, Wear
from .scene.scene import Output, Scene
from .scene.shapes.carried import Carried
from .scene.shapes.roller import Crown, Cylinder, FiniteLength, LundbergProfile, Sphere
from .scene.shapes.roughness import Ra, RmsSlope, Roughness
from .scene.shapes.shape import Detail, Shape
from .scene.shapes.texture import Cosine, Dimple, FlatBottomed, Groove, Parabolic, Texture, Waviness
from .scene.stress import SubsurfaceStress
from .scene.surfaces.measured_surface import MeasuredSurface
from .scene.surfaces.preparation import (
    AsMeasured,
    HarmonicFill,
    Mirrored,
    RefuseMissing,
    Tapered,
    Trend,
    Window,
)
from .solvers.iterate import Iterate
from .solvers.polonsky_keer import PolonskyKeer
from .solvers.preconditioned_cg import PreconditionedCG
from .solvers.solution import Solution, Status
from .solvers.solve import SolveOptions, Solver
from .solving import solve

__version__: str

__all__ = [
    "AsMeasured",
    "BareProblem",
    "Barus",
    "Body",
    "Carried",
    "ChangingSpeed",
    "CircularSuperposition",
    "CoatedHalfSpace",
    "Coefficients",
    "Comparison",
    "Compressive",
    "ConstantDensity",
    "Constraint",
    "Convolution",
    "Cosine",
    "Cpu",
    "Crown",
    "Cylinder",
    "Detail",
    "Dimple",
    "DowsonHigginson",
    "DuplicatedPadding",
    "ElasticPlasticHalfSpace",
    "ElrodAdams",
    "ErrorEstimate",
    "ErrorParts",
    "Evolution",
    "ExactPeriodicity",
    "Eyring",
    "FilmError",
    "FilmErrorParts",
    "FilmEvolution",
    "FilmScales",
    "FilmStatus",
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
    "LimitingShear",
    "LineLoad",
    "LoadHistory",
    "Lubricant",
    "LubricatedContact",
    "Lubrication",
    "LundbergProfile",
    "MeasuredSurface",
    "Mirrored",
    "Newtonian",
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
    "Ra",
    "RefuseMissing",
    "RepeatedRolling",
    "Resultant",
    "ReynoldsCavitation",
    "RmsSlope",
    "Roelands",
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
    "SolveOptions",
    "Solver",
    "SpeedHistory",
    "Sphere",
    "Status",
    "SteadyRolling",
    "StepError",
    "SubsurfaceStress",
    "Superposition",
    "Tapered",
    "Texture",
    "TotalLoad",
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
    "evolve_lubricated",
    "film_error",
    "film_grid",
    "kernels",
    "material",
    "plan",
    "read_scene",
    "roll_repeatedly",
    "solve",
    "solve_lubricated",
    "solve_rolling",
    "superposed",
    "to_dataset",
    "write_scene",
]
