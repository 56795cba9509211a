"""A scene in a TOML file: numbers in SI units, or texts with a unit such as "10 mm"."""

import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from enum import Enum
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from contactstudy.domain.checks import InvalidInput, whole
from contactstudy.domain.device import Cpu, Device
from contactstudy.domain.fields import Array
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
from contactstudy.domain.units import Metres, Number, Pascals, Seconds
from contactstudy.io.structuring import NO_KIND, structured
from contactstudy.planning.plan import Plan, plan
from contactstudy.problem.problem import Problem
from contactstudy.scene.bodies import Body, HalfSpace
from contactstudy.scene.coated import CoatedHalfSpace
from contactstudy.scene.friction import Friction, PartialSlip, Sliding
from contactstudy.scene.inelastic import ElasticPlasticHalfSpace, ViscoelasticHalfSpace
from contactstudy.scene.load import ChangingLoad, LineLoad, LoadHistory, SineLoad
from contactstudy.scene.motion import Rolling, Wear
from contactstudy.scene.scene import Output, Scene
from contactstudy.scene.shapes.roller import Crown, Cylinder, FiniteLength, LundbergProfile, Sphere
from contactstudy.scene.shapes.roughness import Roughness
from contactstudy.scene.shapes.shape import Shape
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


class Turn(Enum):
    """How a measured surface is laid on the grid."""

    NONE = "as measured"
    QUARTER = "what ran along the length runs across it"


@dataclass(frozen=True)
class MeasuredFile:
    """A measured surface by the file it is in; a path that is not absolute starts at the scene's folder."""

    file: str
    missing: Missing = field(default_factory=RefuseMissing)
    trend: Trend = Trend.PLANE
    seam: Seam = field(default_factory=Tapered)
    turn: Turn = Turn.NONE
    window: Window | None = None

    def read(self, folder: Path) -> MeasuredSurface:
        """The surface."""
        path = folder / self.file
        if not path.is_file():
            raise InvalidInput(f"MeasuredSurface.file is {self.file!r}: give a file that is there.")
        surface = MeasuredSurface.read(path, missing=self.missing, trend=self.trend, seam=self.seam)
        surface = surface if self.window is None else surface.cut(self.window)
        return surface.turned() if self.turn is Turn.QUARTER else surface


@dataclass(frozen=True)
class PlanSettings:
    """What a plan must meet, where the file names no grid."""

    error: Number | None = None
    period: Metres | None = None


@dataclass(frozen=True)
class TimeSteps:
    """The instants of a contact that changes in time: ``times``, or so many ``instants`` evenly up to ``end``.

    With an ``error``, steps between them are chosen for it.
    """

    times: tuple[Seconds, ...] = ()
    end: Seconds | None = None
    instants: int = 41
    error: Number | None = None

    def of(self, load: LineLoad | ChangingLoad) -> list[float] | None:
        """The times, up to the end of ``load`` where none is given; None where the error alone says."""
        if self.times:
            return list(self.times)
        end = self.end if self.end is not None else getattr(load, "end", None)
        if end is None:
            raise InvalidInput(
                "evolve has no end, nor has the load: give evolve.end or evolve.times [s]."
            )
        if self.end is None and self.error is not None:
            return None
        whole("evolve.instants", self.instants, 2, "give at least 2 instants")
        start = getattr(load, "start", 0.0)
        return [start + (end - start) * n / (self.instants - 1) for n in range(self.instants)]


@dataclass(frozen=True)
class Document:
    """The keys of a file."""

    load: ChangingLoad
    solids: tuple[Body, Body]
    shapes: tuple[Shape, ...] = ()
    hardness: Pascals = inf
    outputs: tuple[Output, ...] = ()
    friction: Friction | None = None
    wear: Wear | None = None
    rolling: Rolling | None = None
    evolve: TimeSteps = field(default_factory=TimeSteps)
    grid: Grid | None = None
    padding: Padding | None = None
    padding_across: Padding | None = None
    plan: PlanSettings = field(default_factory=PlanSettings)
    solve: SolveOptions = field(default_factory=SolveOptions)


# Types that stand for others in a file.
STANDING_IN: Mapping[type, type] = {MeasuredSurface: MeasuredFile}
# What may stand where a file says kind = "...", by the type that is wanted there.
KINDS: Mapping[Any, Mapping[str, type]] = {
    wanted: {kind.__name__: STANDING_IN.get(kind, kind) for kind in kinds}
    for wanted, kinds in (
        (
            Shape,
            (
                Cylinder,
                Crown,
                LundbergProfile,
                FiniteLength,
                Waviness,
                Texture,
                Roughness,
                MeasuredSurface,
                Sphere,
            ),
        ),
        (
            Padding,
            (
                ZeroPadding,
                DuplicatedPadding,
                Superposition,
                CircularSuperposition,
                ExactPeriodicity,
            ),
        ),
        (Friction, (Sliding, PartialSlip)),
        (Output, (SubsurfaceStress,)),
        (Profile, (Parabolic, Cosine, FlatBottomed)),
        (Missing, (RefuseMissing, HarmonicFill)),
        (Seam, (AsMeasured, Mirrored, Tapered)),
        (Solver, (PreconditionedCG, PolonskyKeer)),
    )
} | {
    Body: {
        "HalfSpace": HalfSpace,
        "CoatedHalfSpace": CoatedHalfSpace,
        "ViscoelasticHalfSpace": ViscoelasticHalfSpace,
        "ElasticPlasticHalfSpace": ElasticPlasticHalfSpace,
        NO_KIND: HalfSpace,
    },
    ChangingLoad: {
        "LineLoad": LineLoad,
        "LoadHistory": LoadHistory,
        "SineLoad": SineLoad,
        NO_KIND: LineLoad,
    },
}


@dataclass(frozen=True)
class SceneFile:
    """A scene with what its file says of grid, padding and solver; what it leaves open is planned."""

    scene: Scene
    plan_settings: PlanSettings = field(default_factory=PlanSettings)
    settings: SolveOptions = field(default_factory=SolveOptions)
    grid: Grid | None = None
    padding: Padding | Paddings | None = None
    time_steps: TimeSteps = field(default_factory=TimeSteps)

    def plan(self, *, on: Device = Cpu()) -> Plan:  # noqa: B008 (frozen)
        """The plan for this scene, on the file's grid if it has one; ``on`` is the device its seconds are for."""
        period, error = None if self.grid else self.plan_settings.period, self.plan_settings.error
        times = self.time_steps.times
        end = max(times) if times else self.time_steps.end
        return plan(self.scene, error=error, period=period, grid=self.grid, end=end, on=on)

    def problem(self, planned: Plan | None = None) -> Problem:
        """The problem on the grid and with the padding of the file, or those of the plan, made if not given."""
        return self.scene.problem(*self._where(planned))

    def solve(
        self,
        planned: Plan | None = None,
        *,
        start: Array | None = None,
        on: Device = Cpu(),  # noqa: B008 (frozen)
    ) -> Solution:
        """Solve :meth:`problem` with the options of the file, from the pressure ``start`` (x, y) [Pa] if given.

        ``on`` is the device, as for :func:`~contactstudy.solve`.
        """
        return self.settings.solved(self.problem(planned), start, on)

    def evolve(
        self,
        planned: Plan | None = None,
        *,
        folder: str | PathLike[str] | None = None,
        progress: Callable[[float, float], None] | None = None,
    ) -> "Evolution":
        """The same for a scene that changes in time, at the instants of the file."""
        from contactstudy.evolution.evolve import evolve  # only scenes that change in time need it

        return evolve(
            self.scene,
            *self._where(planned),
            times=self.time_steps.of(self.scene.load),
            error=self.time_steps.error,
            folder=folder,
            progress=progress,
            **self._options,
        )

    def roll(self, planned: Plan | None = None) -> "SteadyRolling":
        """The same for a scene that rolls steadily."""
        from contactstudy.evolution.rolling import solve_rolling

        return solve_rolling(self.scene, *self._where(planned), **self._options)

    def _where(self, planned: Plan | None) -> tuple[Grid, Padding | Paddings]:
        grid, padding = self.grid, self.padding
        if grid is None or padding is None:
            planned = planned or self.plan()
            grid, padding = planned.grid, padding or planned.padding
        return grid, padding

    @property
    def _options(self) -> dict[str, Any]:
        """The options of a solve by their names."""
        return {one.name: getattr(self.settings, one.name) for one in fields(self.settings)}


def read_scene(path: str | PathLike[str]) -> SceneFile:
    """The scene in a TOML file.

    Tables ``load``, ``solids`` (two), ``shapes`` and ``outputs`` (each with its ``kind``), ``friction``,
    ``wear``, ``rolling``, ``grid``, ``padding``, ``plan``, ``solve`` and ``evolve``, and the key ``hardness``,
    take the fields of the values of these names. Raises :class:`~contactstudy.InvalidInput`, which names the
    key, for anything else.
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
    document = structured(raw, Document, KINDS, str(path))
    try:
        return scene_file_of(document, path.parent)
    except InvalidInput as error:
        raise InvalidInput(f"{path}: {error}") from error


def scene_file_of(document: Document, folder: Path = Path()) -> SceneFile:
    """``document`` with its measured surfaces read, from paths that start at ``folder``."""
    shapes = tuple(
        shape.read(folder) if isinstance(shape, MeasuredFile) else shape
        for shape in document.shapes
    )
    scene = Scene(
        document.load,
        document.solids,
        shapes,
        document.hardness,
        document.outputs,
        friction=document.friction,
        wear=document.wear,
        rolling=document.rolling,
    )
    padding: Padding | Paddings | None = document.padding
    if document.padding_across is not None:
        if document.padding is None:
            raise InvalidInput(
                "padding_across is given without padding: give the one along the length too."
            )
        padding = document.padding_across, document.padding
    return SceneFile(scene, document.plan, document.solve, document.grid, padding, document.evolve)
