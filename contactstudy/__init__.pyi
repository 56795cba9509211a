# The public names, each with the module that defines it: what `import contactstudy` offers, imported on first use.
from . import analytic
from .answers.contact import Contact
from .answers.evolution import Evolution
from .answers.lubricated_contact import LubricatedContact
from .domain.checks import InvalidInput, NotDefined
from .domain.device import Cpu, Gpu
from .domain.errors import ErrorEstimate
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
from .elasticity.convolution import Convolution, convolution
from .evolution.time_steps import TimeSteps
from .forecast import plan
from .io.compare import compare
from .io.scene_files.materials import material
from .problem.bare_problem import BareProblem
from .problem.constraint import (
    Compressive,
    Constraint,
    HardnessLimited,
    PrescribedLoad,
)
from .problem.problem import Problem, Scales
from .progress import Progress
from .scene.adhesion import Adhesion
from .scene.friction.fretting import Fretting, PartialSlip
from .scene.friction.friction_law import Sliding
from .scene.friction.tractive_rolling import TractiveRolling
from .scene.loads.constant_load import Approach, LineLoad, PullOff, TotalLoad
from .scene.loads.load_history import LoadHistory, SineLoad
from .scene.lubrication.lubricant import (
    Barus,
    Carreau,
    ConstantDensity,
    DowsonHigginson,
    Eyring,
    FilmHeat,
    LimitingShear,
    Lubricant,
    Newtonian,
    Roelands,
    ThermalBody,
)
from .scene.lubrication.lubrication import (
    Boundary,
    ElrodAdams,
    Lubrication,
    ReynoldsCavitation,
    SpeedHistory,
)
from .scene.rolling import Rolling
from .scene.scene import (
    Scene,
)
from .scene.shapes.moving_shape import MovingShape
from .scene.shapes.roller import (
    Crown,
    Cylinder,
    Ellipsoid,
    EndRelief,
    FiniteLength,
    LundbergProfile,
    ProfilePoints,
    Sphere,
)
from .scene.shapes.roughness import RmsSlope, Roughness, Sa
from .scene.shapes.shape import LengthScales, Shape, Tilt
from .scene.shapes.texture import Dimple, Groove, Texture, Waviness
from .scene.solids.bodies import Body, HalfSpace
from .scene.solids.coated import CoatedHalfSpace
from .scene.solids.elastic_plastic import ElasticPlasticHalfSpace
from .scene.solids.free_faces import FreeFaces
from .scene.solids.hardness_profile import HardnessProfile
from .scene.solids.viscoelastic import ViscoelasticHalfSpace
from .scene.stress import SubsurfaceStress
from .scene.surfaces.measured_surface import MeasuredSurface
from .scene.surfaces.preparation import (
    AsMeasured,
    GaussianFilter,
    HarmonicFill,
    Mirrored,
    RefuseMissing,
    Tapered,
    Tile,
)
from .scene.wear import Wear
from .scene_file import SceneFile, read_scene, write_scene
from .solvers.conjugate_gradients import Iterate, PolonskyKeer, PreconditionedCG
from .solvers.solution import Solution, Status
from .solvers.solve import SolveOptions, Solver
from .solving import solve
from .stiffness import contact_stiffness, distant_approach

__version__: str

__all__ = [
    "Adhesion",
    "Approach",
    "AsMeasured",
    "BareProblem",
    "Barus",
    "Body",
    "Boundary",
    "Carreau",
    "CircularSuperposition",
    "CoatedHalfSpace",
    "Coefficients",
    "Compressive",
    "ConstantDensity",
    "Constraint",
    "Contact",
    "Convolution",
    "Cpu",
    "Crown",
    "Cylinder",
    "Dimple",
    "DowsonHigginson",
    "DuplicatedPadding",
    "ElasticPlasticHalfSpace",
    "Ellipsoid",
    "ElrodAdams",
    "EndRelief",
    "ErrorEstimate",
    "Evolution",
    "ExactPeriodicity",
    "Eyring",
    "FilmHeat",
    "FiniteLength",
    "FreeFaces",
    "Fretting",
    "GaussianFilter",
    "Gpu",
    "Grid",
    "Groove",
    "HalfSpace",
    "HardnessLimited",
    "HardnessProfile",
    "HarmonicFill",
    "InvalidInput",
    "Iterate",
    "LengthScales",
    "LimitingShear",
    "LineLoad",
    "LoadHistory",
    "Lubricant",
    "LubricatedContact",
    "Lubrication",
    "LundbergProfile",
    "MeasuredSurface",
    "Mirrored",
    "MovingShape",
    "Newtonian",
    "NotDefined",
    "Padding",
    "Paddings",
    "PartialSlip",
    "PolonskyKeer",
    "PreconditionedCG",
    "PrescribedLoad",
    "Problem",
    "ProfilePoints",
    "Progress",
    "PullOff",
    "RefuseMissing",
    "ReynoldsCavitation",
    "RmsSlope",
    "Roelands",
    "Rolling",
    "Roughness",
    "Sa",
    "Scales",
    "Scene",
    "SceneFile",
    "Shape",
    "SineLoad",
    "Sliding",
    "Solution",
    "SolveOptions",
    "Solver",
    "SpeedHistory",
    "Sphere",
    "Status",
    "SubsurfaceStress",
    "Superposition",
    "Tapered",
    "Texture",
    "ThermalBody",
    "Tile",
    "Tilt",
    "TimeSteps",
    "TotalLoad",
    "TractiveRolling",
    "ViscoelasticHalfSpace",
    "Waviness",
    "Wear",
    "ZeroPadding",
    "analytic",
    "compare",
    "contact_stiffness",
    "convolution",
    "distant_approach",
    "material",
    "plan",
    "read_scene",
    "solve",
    "write_scene",
]
