"""Keys of a scene file and their types, which :func:`~contactstudy.read_scene` reads, and the table of materials.

Most tables of a file have the fields of the class that they describe as keys. Where a file says more, or otherwise, a
class here has its keys, and its method ``described(folder, context)`` returns what they describe. Paths of files start
at the `folder` of the scene file. The `context` is the sum of the curvatures across [1/m] of the scene's shapes, and
both bodies.
"""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cache
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from contactstudy.domain import grid as grids
from contactstudy.domain import validation
from contactstudy.domain.validation import (
    AT_LEAST_ZERO,
    OR_INFINITE,
    InvalidInput,
    Metres,
    Number,
    in_si,
    suggestion,
    validated,
)
from contactstudy.evolution.march import TimeSteps
from contactstudy.io.scene_files.structuring import NO_KIND
from contactstudy.scene import friction as frictions
from contactstudy.scene import loads
from contactstudy.scene.adhesion import Adhesion
from contactstudy.scene.friction import Wear
from contactstudy.scene.lubrication import Lubrication
from contactstudy.scene.scene import Friction, Output
from contactstudy.scene.shapes import roller
from contactstudy.scene.shapes import roughness as texture
from contactstudy.scene.shapes.roughness import Roughness
from contactstudy.scene.shapes.shape import MovingShape, Shape, Tilt, curvatures_of
from contactstudy.scene.solids.bodies import Body, HalfSpace, hertz_line
from contactstudy.scene.solids.coated import CoatedHalfSpace
from contactstudy.scene.solids.inelastic import ElasticPlasticHalfSpace, ViscoelasticHalfSpace
from contactstudy.scene.stress import SubsurfaceStress
from contactstudy.scene.surfaces import preparation
from contactstudy.scene.surfaces.measured_surface import MeasuredSurface
from contactstudy.scene.surfaces.text_file import decoded, table
from contactstudy.scene.surfaces.text_surface import Reading, column_unit
from contactstudy.solvers.conjugate_gradients import PolonskyKeer, PreconditionedCG
from contactstudy.solvers.solve import SolveOptions, Solver


@validated
class Material:
    """Elastic constants and strength of a material.

    Parameters
    ----------
    name
        Name in scene files.
    youngs_modulus
        Young's modulus [Pa].
    poisson_ratio
        Poisson's ratio.
    source
        Publications that give the constants and the strength.
    synonyms
        Further names that scene files may use.
    yield_stress
        Tensile stress at which it yields [Pa], infinite for brittle materials.
    hardness
        Indentation hardness [Pa].
    """

    name: str
    youngs_modulus: validation.Pascals
    poisson_ratio: float
    source: str
    synonyms: tuple[str, ...] = ()
    yield_stress: Annotated[validation.Pascals, validation.OR_INFINITE] = inf
    hardness: Annotated[validation.Hardness, validation.OR_INFINITE] = inf

    def body_fields(self, kind: object = None) -> dict[str, Any]:
        """Return the fields of a body of this material, by name; `kind` is that of the body in a file."""
        elastic = {"youngs_modulus": self.youngs_modulus, "poisson_ratio": self.poisson_ratio}
        if kind == ElasticPlasticHalfSpace.__name__:
            return elastic | ({"yield_stress": self.yield_stress} if self.yield_stress < inf else {})
        return elastic | {"yield_stress": self.yield_stress, "hardness": self.hardness}


@cache
def materials() -> Mapping[str, Material]:
    """Return all materials by their names."""
    text = (files("contactstudy.io.scene_files") / "materials.toml").read_text(encoding="utf-8")
    return {name: Material(name, **entry) for name, entry in tomllib.loads(text).items()}


def material(name: str) -> HalfSpace:
    """Return the half-space of a material, such as ``material("steel")``.

    Raises :class:`~contactstudy.InvalidInput` for a name that is not in the table.
    """
    return HalfSpace(**_material_named("material", name).body_fields())


def _material_named(field: str, name: object) -> Material:
    """Return the material of this name or synonym, in upper or lower case; errors speak of `field`."""
    names = {alias: m for m in materials().values() for alias in (m.name, *m.synonyms)}
    lower_case = {alias.lower(): m for alias, m in names.items()}
    if not isinstance(name, str) or name.lower() not in lower_case:
        hint = suggestion(str(name), names)
        raise InvalidInput(f"{field} is {name!r}: {hint}, or give youngs_modulus and poisson_ratio.")
    return lower_case[name.lower()]


def with_materials(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return tables of a scene file with the constants of each ``material`` beside the keys given there.

    A hardness in HV or HRC also gives the yield stress, where neither that nor a material is named. A material of a body
    without elastic constants of its own is refused here, where the file is known, with what to give instead.
    """

    def solid(value: Any, path: str) -> Any:
        if isinstance(value, list):
            return [solid(entry, f"{path}[{n}]") for n, entry in enumerate(value)]
        if not isinstance(value, Mapping):
            return value
        inner = {key: solid(entry, f"{path}.{key}") for key, entry in value.items()}
        hardness = str(inner.get("hardness", ""))
        if hardness.endswith(("HV", "HRC")) and not {"material", "yield_stress"} & set(inner):
            # a third of the hardness is about the yield stress of a metal (Tabor 1951)
            inner["yield_stress"] = in_si(f"{path}.hardness", hardness, validation.HARDNESS) / 3
        if "material" not in inner:
            return inner
        constants = _material_named(f"{path}.material", inner.pop("material"))
        if (kind := inner.get("kind")) in ("CoatedHalfSpace", "ViscoelasticHalfSpace"):
            raise InvalidInput(
                f"{path}.material is {constants.name!r}, and a {kind} has no constants of its own there: give it to a "
                "HalfSpace, an ElasticPlasticHalfSpace, or the coating and the substrate."
            )
        return constants.body_fields(inner.get("kind")) | inner

    solids = table.get("solids")
    if not isinstance(solids, list):
        return dict(table)
    return dict(table) | {"solids": [solid(entry, f"solids[{n}]") for n, entry in enumerate(solids)]}


# Sum of the curvatures across [1/m] of the shapes, and the bodies, of the scene to which a shape belongs.
ProfileContext = tuple[float, tuple[Body, Body]]


@dataclass(frozen=True, kw_only=True)
class MeasuredSurfaceTable(Reading):
    """Measured surface given by its file; a relative path starts at the folder of the scene file.

    In Python a surface without rules of its own may stand in place of the file.

    In a scene without a curved shape its width is made periodic as its length is, unless `seam_across` says otherwise.

    Parameters
    ----------
    file
        Path of the file, from the folder of the scene file.
    turn
        "quarter" rotates by 90 degrees: the length of the measurement then runs across the contact.
    """

    file: Annotated[str, validation.Example("'surface.csv'")] | MeasuredSurface
    missing: preparation.Missing = field(default_factory=preparation.RefuseMissing)
    trend: preparation.Trend = "plane"
    filter: preparation.GaussianFilter | None = None
    seam: preparation.PeriodicExtension = field(default_factory=preparation.Tapered)
    seam_across: preparation.PeriodicExtension | None = None
    turn: Literal["none", "quarter"] = "none"
    tile: preparation.Tile | None = None

    def described(self, folder: Path, context: ProfileContext) -> MeasuredSurface:
        """Return the surface, read from the file."""
        curvature, _ = context
        across = self.seam_across or (preparation.AsMeasured() if curvature else self.seam)
        rules = {name: getattr(self, name) for name in ("missing", "trend", "filter", "seam")} | {"seam_across": across}
        reading = {member.name: getattr(self, member.name) for member in fields(Reading)}
        if isinstance(self.file, MeasuredSurface):
            surface = replace(self.file, extent=self.file.extent or self.extent, **rules)
        elif (path := folder / self.file).is_file():
            surface = MeasuredSurface.read(path, **reading, **rules)
        else:
            raise InvalidInput(f"MeasuredSurface.file is {self.file!r}: give the path of an existing file.")
        if self.tile is not None:
            surface = surface.cut(self.tile)
        return surface.turned() if self.turn == "quarter" else surface


@dataclass(frozen=True)
class CrownTable:
    """Crown given by its radius, with or without a length, or by its drop at both ends of a length.

    Parameters
    ----------
    end_drop
        Drop at both ends of the `length` [m], at least zero, in place of the radius.
    """

    radius: Annotated[Metres, OR_INFINITE] | None = None
    end_drop: Annotated[Metres, AT_LEAST_ZERO] | None = None
    length: Annotated[Metres, OR_INFINITE] | None = None

    def described(self, _folder: Path, _: ProfileContext) -> roller.Crown:
        """Return the crown."""
        if self.radius is not None and self.end_drop is None:
            return roller.Crown(self.radius, inf if self.length is None else self.length)
        if self.radius is None and self.end_drop is not None and self.length is not None:
            return roller.Crown.of_drop(self.end_drop, self.length)
        raise InvalidInput("Crown is not described: give its radius, or its end_drop and length.")


@dataclass(frozen=True)
class ProfilePointsTable:
    """Profile given by its points, or by a file of two columns, position and drop, with units in its header.

    A second column named height or z counts outwards from the body, as instruments measure it.

    Parameters
    ----------
    file
        Text file of two columns, position and drop, with their units in the header, in place of positions and drops. A
        relative path starts at the folder of the scene file.
    """

    positions: tuple[Annotated[Metres, validation.FINITE], ...] = ()
    drops: tuple[Annotated[Metres, validation.FINITE], ...] = ()
    file: str | None = None
    axis: roller.Axis = "along"

    def described(self, folder: Path, _: ProfileContext) -> roller.ProfilePoints:
        """Return the profile, read from the file if there is one."""
        if self.file is None:
            return roller.ProfilePoints(self.positions, self.drops, self.axis)
        remedy = "give a file of two columns with their units in the header, such as position [mm], drop [um]"
        try:
            columns = table(self.file, decoded((folder / self.file).read_bytes()) or "", None)
        except (OSError, InvalidInput) as error:
            raise InvalidInput(f"ProfilePoints.file is {self.file!r}, which is no table: {remedy}.") from error
        units = [column_unit(name) for name in columns.names]
        if len(units) != 2 or None in units or not np.isfinite(columns.values).all():
            raise InvalidInput(f"ProfilePoints.file is {self.file!r}, with the columns {columns.names}: {remedy}.")
        points = columns.values[np.argsort(columns.values[:, 0])] * np.array(units, dtype=float)
        positions, drops = points.T
        if re.match(r"\W*(height|z\b)", columns.names[1].lower()):  # outwards, as instruments have it
            drops = drops.max() - drops
        return roller.ProfilePoints(tuple(positions.tolist()), tuple(drops.tolist()), self.axis)


@dataclass(frozen=True)
class LundbergProfileTable:
    """Logarithmic profile given by amplitude and drop, by the load it is made for, or by ISO/TS 16281.

    Source of the modified profile: Fujiwara & Kawase (2007), NTN Technical Review 75, 140.

    Parameters
    ----------
    for_load
        Load per length [N/m] that the profile spreads evenly on these bodies, in place of `amplitude` and `end_drop`.
    iso_16281_diameter
        Diameter [m] of a roller with the profile of ISO/TS 16281, in place of `amplitude` and `end_drop`.
    k1
        Factor K1 on the amplitude of the profile for a load.
    k2
        Fraction K2 of the length that is profiled, above 0 and up to 1; the rest is straight.
    z_m
        Drop z_m [m] at the ends of the profile for a load; None for the drop that spreads the load evenly.
    """

    length: Metres
    amplitude: Annotated[Metres, AT_LEAST_ZERO] | None = None
    end_drop: Annotated[Metres, AT_LEAST_ZERO] | None = None
    straight: Annotated[Metres, AT_LEAST_ZERO] = 0.0
    for_load: validation.NewtonsPerMetre | None = None
    iso_16281_diameter: Metres | None = None
    k1: Number = 1.0
    k2: Annotated[Number, validation.UP_TO_ONE] = 1.0
    z_m: Annotated[Metres, AT_LEAST_ZERO] | None = None

    def described(self, _folder: Path, context: ProfileContext) -> roller.LundbergProfile:
        """Return the profile; one for a load needs the curvature and the bodies of the scene."""
        ways = [name for name in ("amplitude", "for_load", "iso_16281_diameter") if getattr(self, name) is not None]
        if len(ways) != 1 or (self.amplitude is None) != (self.end_drop is None):
            raise InvalidInput(
                "LundbergProfile must be described in exactly one way: give amplitude and end_drop, for_load (the load "
                "per length that it spreads evenly), or iso_16281_diameter."
            )
        if self.for_load is None and (self.k1, self.k2, self.z_m) != (1.0, 1.0, None):
            raise InvalidInput("LundbergProfile.k1, k2 and z_m modify a profile for a load: give for_load.")
        if self.straight and self.amplitude is None:
            remedy = "leave it out, the straight part follows from for_load or iso_16281_diameter"
            raise InvalidInput(f"LundbergProfile.straight is {self.straight!r}: {remedy}.")
        if self.amplitude is not None and self.end_drop is not None:
            return roller.LundbergProfile(self.amplitude, self.end_drop, self.length, self.straight)
        if self.for_load is None:
            assert self.iso_16281_diameter is not None
            return roller.LundbergProfile.iso_16281(self.iso_16281_diameter, self.length)
        curvature, solids = context
        if curvature <= 0:
            raise InvalidInput("LundbergProfile.for_load is for a round roller: give a Cylinder.")
        modulus = hertz_line(self.for_load, 1 / curvature, solids).contact_modulus  # at the half-width
        even = roller.LundbergProfile.for_load(
            self.for_load, contact_modulus=modulus, radius=1 / curvature, length=self.length
        )
        drop = even.end_drop if self.z_m is None else self.z_m
        return roller.LundbergProfile(self.k1 * even.amplitude, drop, self.length, (1 - self.k2) * self.length)


@dataclass(frozen=True)
class MeanPressure:
    """Load of nominally flat bodies as the mean pressure over the whole surface.

    Parameters
    ----------
    pressure
        Mean pressure [Pa] over the grid; without one over a measured surface, or over one period of waves and textures.
        Both axes are then periodic, where no padding is given.
    """

    pressure: validation.Pascals

    def load(self, width: float | None, shapes: tuple[Shape, ...]) -> loads.LineLoad:
        """Return the load per length over the `width` [m] of the grid or the surface."""
        if any(map(any, map(curvatures_of, shapes))):
            raise InvalidInput(
                "load.pressure is the mean pressure of nominally flat bodies, and a shape is curved: give per_length, "
                "or total."
            )
        if width is None:
            raise InvalidInput(
                "load.pressure acts on a surface of a size that is not known: give a [grid], of whole waves or pitches, "
                "or a MeasuredSurface."
            )
        return loads.LineLoad(self.pressure * width)


@dataclass(frozen=True)
class MovingShapeTable:
    """Shape that moves with a `body`, itself described as any shape in a file."""

    shape: Shape
    body: validation.BodyIndex = 0

    def described(self, folder: Path, context: ProfileContext) -> MovingShape:
        """Return the shape that moves."""
        return MovingShape(shape_of(self.shape, folder, context), self.body)


@dataclass(frozen=True)
class PlanSettings:
    """Error to plan or solve for, one or several, and the period of a grid that is chosen.

    Parameters
    ----------
    error
        Relative error of every number of the answer, or a table of errors by the names of these numbers.
    period
        Length [m] of a grid that is chosen.
    """

    error: validation.RelativeError | Mapping[str, validation.RelativeError] | None = field(default=None, hash=False)
    period: Metres | None = None


# Load of a scene, or in a file the mean pressure that makes one.
LoadInFile = loads.ConstantLoad | MeanPressure | loads.ChangingLoad | loads.Approach | loads.PullOff


@dataclass(frozen=True)
class SceneDocument:
    """Keys of a scene file.

    Parameters
    ----------
    time_steps
        Instants to record of a scene that changes in time, and how steps are taken.
    grid
        Cells and their size; without it they are planned.
    padding
        Boundary conditions along the length; without them they are planned.
    padding_across
        Boundary conditions across the contact, beside `padding`; free if left out.
    plan
        Error to plan and solve for.
    solve
        Options of the solver.
    """

    load: LoadInFile
    solids: tuple[Body, Body]
    shapes: tuple[Shape, ...] = ()
    hardness: Annotated[validation.Hardness, OR_INFINITE] = inf
    outputs: tuple[Output, ...] = ()
    friction: Friction | None = None
    wear: Wear | None = None
    rolling: frictions.Rolling | None = None
    lubrication: Lubrication | None = None
    adhesion: Adhesion | None = None
    time_steps: TimeSteps = field(default_factory=TimeSteps)
    grid: grids.Grid | None = None
    padding: grids.Padding | None = None
    padding_across: grids.Padding | None = None
    plan: PlanSettings = field(default_factory=PlanSettings)
    solve: SolveOptions = field(default_factory=SolveOptions)


def shape_of(shape: Any, folder: Path, context: ProfileContext) -> Shape:
    """Return the shape that a table describes; paths of files in it start at `folder`."""
    described: Shape = shape.described(folder, context) if type(shape).__name__.endswith(TABLE) else shape
    return described


# End of the name of a class that has the keys of a shape in a file where these are not the fields of the shape.
TABLE = "Table"


def _kinds(*classes: type) -> dict[str, type]:
    """Return classes by the names that a file has for them."""
    return {kind.__name__.removesuffix(TABLE): kind for kind in classes}


# Classes that ``kind = "..."`` may name in a file, by the type of the field; of a union they are its members.
KINDS: Mapping[Any, Mapping[str, type]] = {
    Shape: _kinds(
        roller.Cylinder, CrownTable, LundbergProfileTable, roller.FiniteLength, Tilt, texture.Waviness,
        texture.Texture, Roughness, MeasuredSurfaceTable, roller.Sphere, roller.Ellipsoid, ProfilePointsTable,
        roller.EndRelief, MovingShapeTable,
    ),
    grids.Padding: _kinds(
        grids.ZeroPadding, grids.DuplicatedPadding, grids.Superposition, grids.CircularSuperposition,
        grids.ExactPeriodicity,
    ),
    Body: _kinds(HalfSpace, CoatedHalfSpace, ViscoelasticHalfSpace, ElasticPlasticHalfSpace) | {NO_KIND: HalfSpace},
    LoadInFile: _kinds(
        loads.LineLoad, loads.TotalLoad, MeanPressure, loads.LoadHistory, loads.SineLoad, loads.Approach, loads.PullOff,
    ) | {NO_KIND: loads.LineLoad},
    Friction: _kinds(frictions.Sliding, frictions.PartialSlip, frictions.Fretting, frictions.TractiveRolling),
    Output: _kinds(SubsurfaceStress),
    Solver: _kinds(PreconditionedCG, PolonskyKeer),
}  # fmt: skip
