from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.io.scene_files.scene_schema import KINDS, PlanSettings
from tests.conftest import STEEL
from tests.contactstudy.scene.shapes.test_shapes import Own

SURFACE = np.random.default_rng(1).normal(scale=1e-7, size=(12, 8))
SHAPES: tuple[cs.Shape, ...] = (
    cs.Cylinder(0.01), cs.Crown(0.5), cs.Crown(0.5, 8e-3), cs.Tilt(1e-3), cs.LundbergProfile(1e-7, 1e-6, 1e-3),
    cs.FiniteLength(8e-4), cs.Waviness(1e-7, along=1e-4, phase=0.25),
    cs.Texture(cs.Dimple(1e-7, 2e-5, "cosine"), (5e-5, 6e-5)),
    cs.Texture(cs.Groove(1e-7, 2e-5, "flat"), (5e-5, inf)),
    cs.Roughness(1e-7, 0.8, 1e-4, 3e-5, seed=3, peklenik=2.0, extent=(4e-4, 4e-4)),
    cs.Roughness(cs.RmsSlope(0.02), 0.7, 1e-4, 3e-5),
    cs.MeasuredSurface(SURFACE, (1e-4, 2e-4), cs.HarmonicFill(), "plane", cs.Mirrored()),
    cs.MeasuredSurface(SURFACE), cs.Sphere(0.02), cs.Ellipsoid(0.02, -0.05),
    cs.EndRelief(0.01, 0.008, end_radius=1.0, end_angle=0.01), cs.ProfilePoints((0.0, 0.005), (0.0, 1e-6)),
    cs.MovingShape(cs.Waviness(1e-7, along=5e-5), body=np.int64(1)),  # type: ignore[arg-type]
    cs.MovingShape(cs.MeasuredSurface(SURFACE, (1e-4, 2e-4), trend="plane")),
)  # fmt: skip
PADDINGS: tuple[cs.Padding | cs.Paddings, ...] = (
    cs.ExactPeriodicity(), cs.ZeroPadding(), cs.DuplicatedPadding(), cs.Superposition(3),
    (cs.ExactPeriodicity(), cs.CircularSuperposition(2)),
)  # fmt: skip


def scene(*shapes: cs.Shape) -> cs.Scene:
    rigid = cs.HalfSpace(inf, 0.0)
    return cs.Scene(cs.LineLoad(1e5), (STEEL, rigid), shapes, hardness=2.5e9)


def read_back(described: cs.Scene | cs.SceneFile, folder: Path) -> cs.SceneFile:
    cs.write_scene(described, folder / "scene.toml")
    return cs.read_scene(folder / "scene.toml")


def test_a_surface_read_from_a_file_is_named_by_it(tmp_path: Path) -> None:
    surface = cs.MeasuredSurface(SURFACE, (1e-4, 2e-4))
    surface.write(tmp_path / "ground.nc")
    read = cs.MeasuredSurface.read(tmp_path / "ground.nc", trend="none", seam=cs.AsMeasured())
    assert read.digest == surface.digest
    for laid in (read, read.turned(), read.cut(cs.Tile((2, 2), 3))):
        written = scene(cs.Cylinder(0.01), laid)
        assert read_back(written, tmp_path).scene == written
        assert "ground.nc" in (tmp_path / "scene.toml").read_text(encoding="utf-8")


def test_a_shape_of_ones_own_is_refused_by_name(tmp_path: Path) -> None:
    flat = Own(lambda grid: np.zeros(grid.cells))
    with pytest.raises(cs.InvalidInput, match=r"^Scene\.shapes\[1\] is a Own, which no scene file"):
        cs.write_scene(scene(cs.Cylinder(0.01), flat), tmp_path / "scene.toml")
    assert not (tmp_path / "scene.toml").exists()
    with pytest.raises(cs.InvalidInput, match="cannot be written"):
        cs.write_scene(scene(cs.Cylinder(0.01)), tmp_path / "nowhere" / "scene.toml")


RUBBER = cs.ViscoelasticHalfSpace(1e6, 0.4, ((1.5e6, 1.0), (5e5, 0.1)))


ADHESION = cs.Adhesion(0.05, 2e-8, "dugdale", "from full contact")
OIL = cs.Lubricant(0.04, 2e-8, viscosity_law=cs.Barus(), density=cs.ConstantDensity(), shear=cs.Eyring(5e6))
EFFECTS: tuple[dict[str, object], ...] = (
    {"solids": (cs.CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 2e-6, STEEL), STEEL)},
    {"solids": (cs.ElasticPlasticHalfSpace(210e9, 0.3, 1e9, 2e9, 1e9), STEEL)}, {"friction": cs.Sliding(0.12)},
    {"friction": cs.PartialSlip(0.3, -2e3)}, {"friction": cs.Fretting.cycle(0.3, 0.1)},
    {"shapes": (cs.Crown(1.0),), "friction": cs.TractiveRolling(0.3, longitudinal=1e-3, spin=0.5, speed=3.0)},
    {"adhesion": ADHESION, "load": cs.PullOff(1.0, 1e-2)}, {"adhesion": ADHESION, "load": cs.Approach(-1e-6, 2.0)},
    {"lubrication": cs.Lubrication(OIL, 1.0, 0.1, boundary=cs.Boundary(1e-9, 0.12))},
    {"lubrication": cs.Lubrication(OIL, cs.SpeedHistory((0.0, 1.0), (1.0, 2.0)))},
    {"lubrication": cs.Lubrication(OIL, 1.0, 0.1, thermal=cs.FilmHeat())},
    {"load": cs.LoadHistory((0.0, 0.0, 2.0), (0.0, 1e4, 1e4))},
    {"load": cs.SineLoad(1e3, 5e2, frequency=2.0, phase=0.1)}, {"solids": (RUBBER, STEEL)},
    {"solids": (cs.FreeFaces(STEEL, 0.01), STEEL)},
    {"wear": cs.Wear(1e-17, 0.1, body=1)}, {"solids": (RUBBER, STEEL), "rolling": cs.Rolling(2.0)},
)  # fmt: skip


LINE = scene(cs.Cylinder(0.01))
SWINGING = replace(LINE, hardness=inf, load=cs.SineLoad(1e3, 5e2, 2.0))
TOGETHER = {"load.per_length": "50:400:8 N/mm", "shapes.0.radius": ["10 mm", 0.02]}
FILES = (
    *(cs.SceneFile(scene(cs.Cylinder(0.02), shape)) for shape in SHAPES),
    *(cs.SceneFile(LINE, grid=cs.Grid((16, 8), (3e-4, 2e-4)), padding=one) for one in PADDINGS),
    *(cs.SceneFile(replace(LINE, **({"solids": (STEEL, STEEL), "hardness": inf} | of))) for of in EFFECTS),
    cs.SceneFile(replace(LINE, outputs=(cs.SubsurfaceStress((1e-5, 2e-5), 0),))),
    cs.SceneFile(LINE, options=cs.SolveOptions(tolerance=1e-6, solver=cs.PolonskyKeer(patience=7), precision="single")),
    cs.SceneFile(LINE, PlanSettings(error=2e-3)),
    cs.SceneFile(SWINGING, time_steps=cs.TimeSteps(end=2.0, instants=3, error=1e-2)),
    cs.SceneFile(SWINGING, time_steps=cs.TimeSteps(np.linspace(0.0, 2.0, 3))),  # type: ignore[arg-type]
    cs.SceneFile(LINE, vary=(TOGETHER, {"plan.error": [0.1, 0.3]})),
)  # fmt: skip


def test_what_a_file_says_reads_back(tmp_path: Path) -> None:
    for described in FILES:
        assert read_back(described, tmp_path) == described
    kinds = {type(shape).__name__ for one in FILES for shape in one.scene.shapes}
    assert set(KINDS[cs.Shape]) <= kinds
