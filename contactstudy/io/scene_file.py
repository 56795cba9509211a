"""A scene in a TOML file: numbers in SI units, or texts with a unit such as "10 mm"."""

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactstudy.domain.checks import InvalidInput, whole
from contactstudy.domain.device import Cpu, Device
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import (
    CircularSuperposition,
    DuplicatedPadding,
    ExactPeriodicity,
    Grid,
    Padding,
    Paddings,
    Superposition,
    ZeroPadding,
)
from contactstudy.domain.units import Metres, NewtonsPerMetre, Number, Pascals, Seconds
from contactstudy.io.materials import with_materials
from contactstudy.io.structuring import NO_KIND, structured
from contactstudy.planning.plan import FILM_ERROR, Plan, plan
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import Body, HalfSpace, contact_modulus
from contactstudy.scene.coated import CoatedHalfSpace
from contactstudy.scene.friction import Friction, PartialSlip, Sliding
from contactstudy.scene.inelastic import ElasticPlasticHalfSpace, ViscoelasticHalfSpace
from contactstudy.scene.load import (
    ChangingLoad,
    ConstantLoad,
    LineLoad,
    LoadHistory,
    SineLoad,
    TotalLoad,
)
from contactstudy.scene.lubrication import (
    Barus,
    ChangingSpeed,
    ConstantDensity,
    DensityLaw,
    DowsonHigginson,
    Eyring,
    LimitingShear,
    Lubrication,
    Newtonian,
    Roelands,
    ShearLaw,
    SpeedHistory,
    ViscosityLaw,
)
from contactstudy.scene.motion import Rolling, Wear
from contactstudy.scene.scene import Output, Scene
from contactstudy.scene.shapes.carried import Carried
from contactstudy.scene.shapes.roller import Crown, Cylinder, FiniteLength, LundbergProfile, Sphere
from contactstudy.scene.shapes.roughness import Roughness
from contactstudy.scene.shapes.shape import Detail, Shape
from contactstudy.scene.shapes.texture import (
    Cosine,
    FlatBottomed,
    Parabolic,
    Profile,
    Texture,
    Waviness,
)
from contactstudy.scene.stress import SubsurfaceStress
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.scene.surfaces.preparation import (
    AsMeasured,
    HarmonicFill,
    Mirrored,
    Missing,
    RefuseMissing,
    Seam,
    Tapered,
    Trend,
    Window,
)
from contactstudy.solvers.polonsky_keer import PolonskyKeer
from contactstudy.solvers.preconditioned_cg import PreconditionedCG
from contactstudy.solvers.solution import Solution
from contactstudy.solvers.solve import SolveOptions, Solver

if TYPE_CHECKING:
    from contactstudy.evolution.evolution import Evolution
    from contactstudy.evolution.rolling import SteadyRolling
    from contactstudy.lubrication.lubricated_contact import LubricatedContact


# Curvature [1/m] and contact modulus [Pa] of the scene to which a shape belongs.
Surroundings = tuple[float, float]


class Turn(Enum):
    """Orientation of a measured surface on the grid."""

    NONE = "as measured"
    QUARTER = "turned by a quarter: the length of the measurement runs across the contact"


@dataclass(frozen=True)
class MeasuredFile:
    """Measured surface given by its file; a relative path starts at the folder of the scene file."""

    file: str
    extent: tuple[Metres, Metres] | None = None
    unit: str | None = None
    missing: Missing = field(default_factory=RefuseMissing)
    trend: Trend = Trend.PLANE
    seam: Seam = field(default_factory=Tapered)
    turn: Turn = Turn.NONE
    window: Window | None = None

    def shape(self, folder: Path, _: Surroundings) -> MeasuredSurface:
        """Return the surface, read from the file."""
        path = folder / self.file
        if not path.is_file():
            raise InvalidInput(f"MeasuredSurface.file is {self.file!r}: give a file that is there.")
        surface = MeasuredSurface.read(
            path,
            extent=self.extent,
            unit=self.unit,
            missing=self.missing,
            trend=self.trend,
            seam=self.seam,
        )
        surface = surface if self.window is None else surface.cut(self.window)
        return surface.turned() if self.turn is Turn.QUARTER else surface


@dataclass(frozen=True)
class CrownFile:
    """Crown given by its radius, or by its drop at both ends of a length."""

    radius: Metres | None = None
    end_drop: Metres | None = None
    length: Metres | None = None

    def shape(self, _folder: Path, _: Surroundings) -> Crown:
        """Return the crown."""
        if self.radius is not None and self.end_drop is None and self.length is None:
            return Crown(self.radius)
        if self.radius is None and self.end_drop is not None and self.length is not None:
            return Crown.of_drop(self.end_drop, self.length)
        raise InvalidInput("Crown is not described: give its radius, or its end_drop and length.")


@dataclass(frozen=True)
class ProfileFile:
    """Logarithmic profile given by amplitude and drop, by the load it is made for, or by ISO/TS 16281."""

    length: Metres
    amplitude: Metres | None = None
    end_drop: Metres | None = None
    straight: Metres = 0.0
    for_load: NewtonsPerMetre | None = None
    iso_16281_diameter: Metres | None = None

    def shape(self, _folder: Path, surroundings: Surroundings) -> LundbergProfile:
        """Return the profile; one for a load needs the curvature and the modulus of the scene."""
        drops = self.amplitude, self.end_drop
        ways = [
            drops != (None, None),
            self.for_load is not None,
            self.iso_16281_diameter is not None,
        ]
        if sum(ways) != 1 or (ways[0] and None in drops):
            raise InvalidInput(
                "LundbergProfile is not described by one way: give amplitude and end_drop, for_load (the load per "
                "length that it spreads evenly), or iso_16281_diameter."
            )
        if self.iso_16281_diameter is not None:
            return LundbergProfile.iso_16281(self.iso_16281_diameter, self.length)
        if self.for_load is not None:
            curvature, modulus = surroundings
            if curvature <= 0:
                raise InvalidInput(
                    "LundbergProfile.for_load is for a round roller: give a Cylinder."
                )
            return LundbergProfile.for_load(
                self.for_load, contact_modulus=modulus, radius=1 / curvature, length=self.length
            )
        assert self.amplitude is not None
        assert self.end_drop is not None
        return LundbergProfile(self.amplitude, self.end_drop, self.length, self.straight)


@dataclass(frozen=True)
class CarriedFile:
    """Shape that a body carries, which may be given by a file."""

    shape: Shape
    body: int = 0


@dataclass(frozen=True)
class PlanSettings:
    """Accuracy and period that a plan must meet, for a scene whose file names no grid."""

    error: Number | None = None
    period: Metres | None = None


@dataclass(frozen=True)
class TimeSteps:
    """Instants of a contact that changes in time.

    Parameters
    ----------
    times
        The instants [s]; none for evenly spaced ones.
    end
        Last instant [s], that of the load if None.
    instants
        Number of evenly spaced instants.
    error
        Largest L1 error by which steps between instants are chosen, or None for one step each.
    """

    times: tuple[Seconds, ...] = ()
    end: Seconds | None = None
    instants: int = 41
    error: Number | None = None

    def instants_of(self, *values: object) -> list[float] | None:
        """Return the instants [s], up to the last end of the histories in `values`; None if the error alone decides."""
        if self.times:
            return list(self.times)
        histories = [value for value in values if isinstance(value, ChangingLoad | ChangingSpeed)]
        if self.end is None and not histories:
            raise InvalidInput(
                "evolve has no end, nor has the load: give evolve.end or evolve.times [s]."
            )
        end = max(history.end for history in histories) if self.end is None else self.end
        if self.end is None and self.error is not None:
            return None
        whole("evolve.instants", self.instants, 2, "give at least 2 instants")
        start = histories[0].start if histories else 0.0
        return [start + (end - start) * n / (self.instants - 1) for n in range(self.instants)]


@dataclass(frozen=True)
class Document:
    """Keys of a scene file."""

    load: ChangingLoad
    solids: tuple[Body, Body]
    shapes: tuple[Shape, ...] = ()
    hardness: Pascals = inf
    outputs: tuple[Output, ...] = ()
    friction: Friction | None = None
    wear: Wear | None = None
    rolling: Rolling | None = None
    lubrication: Lubrication | None = None
    evolve: TimeSteps = field(default_factory=TimeSteps)
    grid: Grid | None = None
    padding: Padding | None = None
    padding_across: Padding | None = None
    plan: PlanSettings = field(default_factory=PlanSettings)
    solve: SolveOptions = field(default_factory=SolveOptions)


# Classes that describe a shape in a file, where these differ from the shape itself.
DESCRIPTIONS: Mapping[type, type] = {
    Carried: CarriedFile,
    Crown: CrownFile,
    LundbergProfile: ProfileFile,
    MeasuredSurface: MeasuredFile,
}


def _kinds(*classes: type) -> dict[str, type]:
    """Return the classes that describe `classes` in a file, by the names of the latter."""
    return {kind.__name__: DESCRIPTIONS.get(kind, kind) for kind in classes}


# Classes that ``kind = "..."`` may name in a file, by the type of the field.
KINDS: Mapping[Any, Mapping[str, type]] = {
    Shape: _kinds(
        Cylinder,
        Crown,
        LundbergProfile,
        FiniteLength,
        Waviness,
        Texture,
        Roughness,
        MeasuredSurface,
        Sphere,
        Carried,
    ),
    Padding: _kinds(
        ZeroPadding, DuplicatedPadding, Superposition, CircularSuperposition, ExactPeriodicity
    ),
    Body: _kinds(HalfSpace, CoatedHalfSpace, ViscoelasticHalfSpace, ElasticPlasticHalfSpace)
    | {NO_KIND: HalfSpace},
    ChangingLoad: _kinds(LineLoad, TotalLoad, LoadHistory, SineLoad) | {NO_KIND: LineLoad},
    Friction: _kinds(Sliding, PartialSlip),
    Output: _kinds(SubsurfaceStress),
    Profile: _kinds(Parabolic, Cosine, FlatBottomed),
    Missing: _kinds(RefuseMissing, HarmonicFill),
    Seam: _kinds(AsMeasured, Mirrored, Tapered),
    Solver: _kinds(PreconditionedCG, PolonskyKeer),
    ViscosityLaw: _kinds(Roelands, Barus),
    DensityLaw: _kinds(DowsonHigginson, ConstantDensity),
    ShearLaw: _kinds(Newtonian, Eyring, LimitingShear),
    ChangingSpeed: _kinds(SpeedHistory),
}


@dataclass(frozen=True)
class SceneFile:
    """Contents of a scene file: the scene, and grid, padding and options if given; a missing grid is planned.

    Parameters
    ----------
    scene
        The scene.
    plan_settings
        Accuracy and period of the plan.
    settings
        Options of a solve.
    grid, padding
        Grid and padding of the file, or None.
    time_steps
        Instants of a scene that changes in time.
    vary
        Fields that the file varies, by their paths, in groups: fields of one group change together.
    """

    scene: Scene
    plan_settings: PlanSettings = field(default_factory=PlanSettings)
    settings: SolveOptions = field(default_factory=SolveOptions)
    grid: Grid | None = None
    padding: Padding | Paddings | None = None
    time_steps: TimeSteps = field(default_factory=TimeSteps)
    vary: tuple[Mapping[str, object], ...] = ()

    def plan(self, *, on: Device = Cpu()) -> Plan:  # noqa: B008 (frozen)
        """Return the plan for this scene, on the file's grid if it has one; seconds are for the device `on`."""
        period, error = None if self.grid else self.plan_settings.period, self.plan_settings.error
        times = self.time_steps.times
        end = max(times) if times else self.time_steps.end
        return plan(self.scene, error=error, period=period, grid=self.grid, end=end, on=on)

    def problem(self, planned: Plan | None = None) -> Problem:
        """Return the problem on the grid and with the padding of the file, or of the plan, made if not given."""
        return self.scene.problem(*self._where(planned))

    def solve(
        self,
        planned: Plan | None = None,
        *,
        start: Array | None = None,
        on: Device = Cpu(),  # noqa: B008 (frozen)
    ) -> Solution:
        """Solve :meth:`problem` with the options of the file.

        The solve begins with the pressure `start` (x, y) [Pa] if given, on the device `on`.
        """
        return self.settings.solved(self.problem(planned), start, on)

    def evolve(
        self,
        planned: Plan | None = None,
        *,
        folder: str | PathLike[str] | None = None,
        progress: Callable[[float, float], None] | None = None,
    ) -> "Evolution | Any":
        """March through a scene that changes in time, at the instants of the file; see :func:`~contactstudy.evolve`."""
        from contactstudy.evolution.evolve import evolve  # only scenes that change in time need it

        return evolve(
            self.scene,
            *self._where(planned),
            times=self.time_steps.instants_of(
                self.scene.load, getattr(self.scene.lubrication, "mean_speed", None)
            ),
            error=self.time_steps.error,
            folder=folder,
            progress=progress,
            options=self.settings,
        )

    def roll(self, planned: Plan | None = None) -> "SteadyRolling":
        """Solve a scene that rolls steadily; see :func:`~contactstudy.solve_rolling`."""
        from contactstudy.evolution.rolling import solve_rolling

        return solve_rolling(self.scene, *self._where(planned), options=self.settings)

    def lubricate(self, planned: Plan | None = None) -> "LubricatedContact":
        """Solve a lubricated scene, with an estimate of its errors in plane strain; see `solve_lubricated`."""
        from contactstudy.lubrication.solve_lubricated import solve_lubricated

        grid, padding = self._where(planned)
        error = (self.plan_settings.error or FILM_ERROR) if grid.cells[1] == 1 else None
        return solve_lubricated(
            self.scene, grid, padding, error=error, tolerance=self.settings.tolerance
        )

    def _where(self, planned: Plan | None) -> tuple[Grid, Padding | Paddings]:
        grid, padding = self.grid, self.padding
        if grid is None or padding is None:
            planned = planned or self.plan()
            grid, padding = planned.grid, padding or planned.padding
        return grid, padding


def read_scene(path: str | PathLike[str]) -> SceneFile:
    """Read a scene from a TOML file.

    Tables ``load``, ``solids`` (two), ``shapes`` and ``outputs`` (each with its ``kind``), ``friction``,
    ``wear``, ``rolling``, ``lubrication``, ``grid``, ``padding``, ``plan``, ``solve``, ``evolve`` and ``vary``,
    and the key ``hardness``, have the fields of the corresponding classes as keys. A solid may name its ``material``.

    Raises
    ------
    InvalidInput
        With a line for every key that cannot be used.
    """
    path = Path(path)
    try:
        raw = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(
            f"{path} cannot be read ({error}): give a TOML file in UTF-8."
        ) from error
    except (ValueError, RecursionError) as error:  # also a number of thousands of digits
        raise InvalidInput(f"{path} is not valid TOML: {error}.") from error
    try:
        groups = _groups(raw.pop("vary", {}))
        raw = with_materials(raw)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error
    document = structured(raw, Document, KINDS, str(path))
    try:
        return replace(scene_file_from(document, path.parent), vary=groups)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error


def scene_file_from(document: Document, folder: Path = Path()) -> SceneFile:
    """Return the scene of `document`; files of surfaces start at `folder`."""
    modulus = contact_modulus(document.solids)
    curvature = sum(getattr(shape, "curvature", 0.0) for shape in document.shapes)

    def read(shape: Any) -> Shape:
        if isinstance(shape, CarriedFile):
            return Carried(read(shape.shape), shape.body)
        if isinstance(shape, MeasuredFile | CrownFile | ProfileFile):
            return shape.shape(folder, (curvature, modulus))
        described: Shape = shape
        return described

    shapes = tuple(read(shape) for shape in document.shapes)
    scene = Scene(
        _with_length(document, shapes),
        document.solids,
        shapes,
        document.hardness,
        document.outputs,
        friction=document.friction,
        wear=document.wear,
        rolling=document.rolling,
        lubrication=document.lubrication,
    )
    padding: Padding | Paddings | None = document.padding
    if document.padding_across is not None:
        if document.padding is None:
            raise InvalidInput(
                "padding_across is given without padding: give the one along the length too."
            )
        padding = document.padding_across, document.padding
    return SceneFile(scene, document.plan, document.solve, document.grid, padding, document.evolve)


def _groups(vary: object) -> tuple[Mapping[str, object], ...]:
    """Return the varied fields in groups: one group for each field of a table, or for each table of a list."""
    if isinstance(vary, Mapping):
        return tuple({field: values} for field, values in _paths(vary).items())
    if isinstance(vary, list) and all(isinstance(group, Mapping) and group for group in vary):
        return tuple(_paths(group) for group in vary)
    raise InvalidInput(
        f"vary is {vary!r}: give a table of fields and their values, such as load.per_length = '50:400:8 N/mm'."
    )


def _paths(table: Mapping[str, object], before: str = "") -> dict[str, object]:
    """Return the values of nested tables by their paths."""
    paths: dict[str, object] = {}
    for key, value in table.items():
        paths |= (
            _paths(value, f"{before}{key}.")
            if isinstance(value, Mapping)
            else {before + key: value}
        )
    return paths


def _with_length(document: Document, shapes: Iterable[Shape]) -> ConstantLoad | ChangingLoad:
    """Return the load; a total load on shapes without a length is spread over the length of the grid, if known."""
    load = document.load
    has_length = any(0 < getattr(shape, "detail", Detail()).roller < inf for shape in shapes)
    period = document.grid.period if document.grid else document.plan.period
    if isinstance(load, TotalLoad) and load.length is None and not has_length and period:
        return replace(load, length=period)
    return load
