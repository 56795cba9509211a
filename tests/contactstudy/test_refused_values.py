"""Values that are refused where they are given, and how the sentence begins that says so; ``*`` is any words."""

import re
from collections.abc import Callable
from dataclasses import replace
from math import inf, nan
from typing import Any

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from tests.conftest import STEEL

RIGID = cs.HalfSpace(inf, 0.3)
EXACT, FREE = cs.ExactPeriodicity(), cs.ZeroPadding()
SMOOTH = cs.Scene(cs.LineLoad(1e5), (STEEL, STEEL), (cs.Cylinder(0.01),))
GRID = cs.Grid((16, 8), (2e-4, 1e-4))
HEIGHTS = np.random.default_rng(0).standard_normal(GRID.cells) * 1e-7
YIELDING = cs.ElasticPlasticHalfSpace(2e11, 0.3, 1e9)
COATED = cs.CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 2e-6, STEEL)
CASE = cs.HardnessProfile(surface=7e9, core=3e9, case_depth=1e-3)
ROUGH = cs.Roughness(rms=2e-7, hurst=0.8, roll_off=5e-5, cut_off=1e-5)
DIMPLE = cs.Dimple(5e-6, 1e-4)
OIL = cs.Lubricant(0.04, 2e-8)
BELOW = cs.SubsurfaceStress((1e-4,))


def refused(make: Callable[[], object], said: str) -> None:
    with pytest.raises(cs.InvalidInput, match="^" + ".*".join(map(re.escape, said.split("*")))):
        make()


def smooth(**changed: Any) -> cs.Scene:
    """The smooth line contact with other fields."""
    return replace(SMOOTH, **changed)


def measured(heights: Any = HEIGHTS, **named: Any) -> np.ndarray:
    return cs.MeasuredSurface(heights, **named).gap(GRID)


def labelled(**coordinates: Any) -> xr.DataArray:
    return xr.DataArray(np.zeros((6, 4)), dims=("width", "length"), coords=coordinates)


def film(**named: Any) -> cs.Lubrication:
    return cs.Lubrication(**{"lubricant": OIL, "mean_speed": 1.0} | named)


def solved(**named: Any) -> cs.Contact:
    return cs.solve(SMOOTH, GRID, EXACT, **named)


VALUES: list[tuple[str, Callable[[], object]]] = [
    # bodies
    ("HalfSpace.poisson_ratio is *above -1 and up to 0.5", lambda: cs.HalfSpace(1e9, -1.0)),
    ("ViscoelasticHalfSpace.equilibrium_modulus is 0 and there", lambda: cs.ViscoelasticHalfSpace(0.0, 0.3)),
    ("ViscoelasticHalfSpace.relaxation[1][0] is *: give a pressure above 0",
     lambda: cs.ViscoelasticHalfSpace(1e9, 0.3, ((1e9, 1.0), (0.0, 1.0)))),
    ("FreeFaces.length", lambda: cs.FreeFaces(STEEL, "10 mN")),
    ("FreeFaces.solid", lambda: cs.FreeFaces(COATED, 0.01)),
    ("CoatedHalfSpace.coating is rigid", lambda: replace(COATED, coating=RIGID)),
    ("CoatedHalfSpace.coating is *stiff", lambda: replace(COATED, substrate=replace(STEEL, youngs_modulus=1e3))),
    ("CoatedHalfSpace.interlayers[0] is *without a thickness", lambda: replace(COATED, interlayers=(STEEL,))),
    ("HardnessProfile has surface: give", lambda: cs.HardnessProfile(surface=7e9)),
    ("HardnessProfile.surface", lambda: replace(CASE, surface=5e9)),
    # loads
    ("LineLoad.per_length is -0.0: give a load", lambda: smooth(load=cs.LineLoad(-0.0))),
    ("Scene.load is a TotalLoad* give TotalLoad.length", lambda: smooth(load=cs.TotalLoad(100.0))),
    ("LoadHistory.per_length has length 1 beside 2 times: give one", lambda: cs.LoadHistory((0.0, 1.0), (1.0,))),
    ("LoadHistory.per_length is (0.0, 0.0): give a load above 0", lambda: cs.LoadHistory((0.0, 1.0), (0.0, 0.0))),
    ("LoadHistory.times[1]", lambda: cs.LoadHistory((1.0, 0.0), (1.0, 1.0))),
    # what a scene holds
    ("Scene.solids", lambda: smooth(solids=(STEEL,))),
    ("Scene.solids*all rigid", lambda: smooth(solids=(RIGID, RIGID))),
    ("Scene.shapes[0] is *: give a Shape, such", lambda: smooth(shapes=(cs.Cylinder,))),
    ("Scene.outputs[1] is *: give one", lambda: smooth(outputs=(cs.SubsurfaceStress(), BELOW))),
    ("*body is 1, a rigid", lambda: smooth(solids=(STEEL, RIGID), outputs=(replace(BELOW, body=1),))),
    ("SubsurfaceStress.depths is ()", lambda: cs.SubsurfaceStress(())),
    # shapes
    ("LundbergProfile.straight is 0.01", lambda: cs.LundbergProfile(1e-6, 1e-6, 0.01, straight=0.01)),
    ("Tilt.angle is *between -0.1 and 0.1 rad", lambda: cs.Tilt(0.2)),
    ("MovingShape.shape is *: give", lambda: cs.MovingShape(cs.Sphere(1.0))),
    ("Waviness.along", lambda: cs.Waviness(0.01, along=3e-5).gap(GRID)),
    ("Roughness.roll_off is ", lambda: replace(ROUGH, roll_off=1e-6)),
    ("Roughness.extent[1] is 70 µm, and the grid", lambda: replace(ROUGH, extent=(2e-4, 7e-5)).gap(GRID)),
    ("Roughness.cut_off is 1e-40: give * waves", lambda: replace(ROUGH, cut_off=1e-40).gap(GRID)),
    ("Texture.pitch is *: give ", lambda: cs.Texture(DIMPLE, (0.9e-4, 2e-4))),
    ("The grid is 200 µm wide, and MeasuredSurface.extent 100 µm: give ", lambda: measured(extent=(1e-4, 1e-4))),
    ("MeasuredSurface.trend is *: did you mean 'plane'", lambda: measured(trend="plain")),
    ("MeasuredSurface.heights has *: give an array", lambda: measured([[1, 2], [3]])),
    ("*coordinates for 1 of its dimensions", lambda: measured(labelled(width=np.arange(6)))),
    ("*heights has the units 'nm': convert to m", lambda: measured(labelled().assign_attrs(units="nm"))),
    # motion and friction
    ("TractiveRolling has none of", lambda: cs.TractiveRolling(0.3)),
    ("TractiveRolling.speed", lambda: cs.TractiveRolling(0.3, longitudinal=1e-3, speed=0.0)),
    ("Fretting*give one of them", lambda: cs.Fretting(0.3)),
    ("Fretting*give times", lambda: cs.Fretting(0.3, displacements=(1.0,))),
    ("Fretting*together with times", lambda: cs.Fretting(0.3, (0.1,), (1.0,), bulk_stresses=(1e7,))),
    ("Rolling.speed is 1.0 and its passes 2: give", lambda: cs.Rolling(1.0, passes=2)),
    ("TimeSteps.times is empty: give one instant", lambda: cs.TimeSteps(times=())),
    ("*give time_steps.end or time_steps.times", lambda: cs.TimeSteps().instants_of()),
    # lubricants and films
    ("SpeedHistory.mean_speed[0] is 0", lambda: cs.SpeedHistory((0, 1), (0, 1))),
    ("Lubricant.pressure_viscosity is 7e-08 * exponent is", lambda: cs.Lubricant(0.04, 7e-8)),
    ("Roelands.exponent is 0.4, and heat and pressure * 0.608 alone",
     lambda: film(lubricant=cs.Lubricant(0.04, 2e-8, cs.Roelands(0.4)), thermal=cs.FilmHeat())),
    ("Lubrication.mean_speed is *give a speed above 0, *or a SpeedHistory", lambda: film(mean_speed=0.0)),
    ("Lubrication.slide_roll_ratio is 2", lambda: film(thermal=cs.FilmHeat(), slide_roll_ratio=2)),
    ("Lubricant.viscosity is 6e-05", lambda: film(lubricant=cs.Lubricant(6e-5, 0.0), thermal=cs.FilmHeat())),
    ("Lubrication.boundary is supported with ElrodAdams",
     lambda: film(boundary=cs.Boundary(5e-9), cavitation=cs.ReynoldsCavitation())),
    # where and how it is solved
    ("Grid.cells[0] is 1: give ", lambda: cs.Grid((1, 8), (1.0, 1.0))),
    ("Grid.extent[0] is inf: give ", lambda: cs.Grid((8, 8), (inf, 1.0))),
    ("padding is *(across, along).", lambda: cs.convolution(1.0, GRID, (FREE, 6), 1.0)),
    ("grid is (8, 8): give a Grid.", lambda: SMOOTH.problem((8, 8), EXACT)),
    ("Grid.cells is * GB and this machine has ",
     lambda: SMOOTH.problem(cs.Grid((2**22, 2**22), (1e-3, 1e-3)), EXACT)),
    ("pressure has the shape (8, 16): give it (16, 8).",
     lambda: SMOOTH.problem(GRID, EXACT).operator(np.ones((8, 16)))),
    ("solve.scene is *: give a Scene, or scene.problem", lambda: cs.solve("rough.toml")),
    ("grid is (24, 1): give a Grid, or None.", lambda: cs.solve(SMOOTH, (24, 1))),
    ("solve.progress is 5: give a function", lambda: solved(progress=5)),
    ("solve.tolerance is ", lambda: solved(tolerance=nan)),
    ("solve.solver is ", lambda: solved(solver=cs.PolonskyKeer)),
    ("solve.device is 2: give Cpu(threads=2) or Gpu()", lambda: solved(device=2)),
    ("solve.folder is given, and a static contact has", lambda: solved(folder="frames")),
    ("solve.start has the shape (8, 16): give it (16, 8).", lambda: solved(start=np.ones((8, 16)))),
    ("solve.start is not finite in 128 cells: it must be at least", lambda: solved(start=np.full((16, 8), nan))),
    ("solve.start is at most 0 Pa: give a pressure that carries", lambda: solved(start=np.zeros((16, 8)))),
]  # fmt: skip


@pytest.mark.cases(len(VALUES))
@pytest.mark.parametrize(("said", "make"), VALUES)
def test_a_value_is_refused_in_a_sentence(said: str, make: Callable[[], object]) -> None:
    refused(make, said)
