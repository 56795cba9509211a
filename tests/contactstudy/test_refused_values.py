"""Each value that is refused where it is given, and how the sentence begins that says so; ``*`` stands for any words."""

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
CASE = cs.HardnessProfile(surface=7e9, core=3e9, case_depth=1e-3)
COATED = cs.CoatedHalfSpace(cs.HalfSpace(250e9, 0.22), 2e-6, STEEL)
ROUGH = cs.Roughness(rms=2e-7, hurst=0.8, roll_off=5e-5, cut_off=1e-5)
DIMPLE, GROOVE = cs.Dimple(5e-6, 1e-4), cs.Groove(2e-6, 4e-5)
DIMPLES = cs.Texture(DIMPLE, (2e-4, 2.5e-4))
HELD = cs.LoadHistory((1.0, 3.0), (1.0, 2.0))
OIL = cs.Lubricant(0.04, 2e-8)
STRESS = cs.SubsurfaceStress((1e-4,))


def refused(make: Callable[[], object], said: str) -> None:
    with pytest.raises(cs.InvalidInput, match="^" + ".*".join(map(re.escape, said.split("*")))):
        make()


def field(of: Any, name: str) -> Callable[[Any], object]:
    """A value with another field."""
    return lambda one: replace(of, **{name: one})


def labelled(**coordinates: Any) -> xr.DataArray:
    return xr.DataArray(np.zeros((6, 4)), dims=("width", "length"), coords=coordinates)


def relaxing(pairs: Any) -> cs.Body:
    return cs.ViscoelasticHalfSpace(1e9, 0.3, pairs)


def measured(extent: Any) -> np.ndarray:
    return cs.MeasuredSurface(HEIGHTS, extent).gap(GRID)


def film(**named: Any) -> cs.Lubrication:
    return cs.Lubrication(**{"lubricant": OIL, "mean_speed": 1.0} | named)


def solved(**named: Any) -> cs.Contact:
    return cs.solve(SMOOTH, GRID, EXACT, **named)


VALUES: list[tuple[str, Callable[[Any], object], list[Any]]] = [
    ("ViscoelasticHalfSpace.relaxation[1][0] is *: give a pressure above 0", relaxing, [((1e9, 1.0), (0.0, 1.0))]),
    ("FreeFaces.length", lambda length: cs.FreeFaces(STEEL, length), [0.0, -1.0, inf, "10 mN"]),
    ("FreeFaces.solid", lambda solid: cs.FreeFaces(solid, 0.01), [COATED, YIELDING, 2e11]),
    ("CoatedHalfSpace.coating", field(COATED, "coating"), [RIGID, 2e11, cs.FreeFaces(STEEL, 0.01)]),
    ("HardnessProfile.depths", lambda depths: cs.HardnessProfile(depths, (7e9, 3e9)), [(0, 0), (1e-4, 1e-3), (0,)]),
    ("HardnessProfile", lambda case: cs.HardnessProfile(**case), [{}, {"surface": 7e9}, {"hardness": (7e9,)}]),
    (
        "HardnessProfile.surface",
        lambda surface: cs.HardnessProfile(surface=surface, core=3e9, case_depth=1e-3),
        [5e9],
    ),
    ("CoatedHalfSpace.coating", field(COATED, "coating"), [replace(STEEL, hardness_profile=CASE)]),
    (
        "CoatedHalfSpace.interlayers",
        lambda layer: replace(COATED, interlayers=(layer,) if layer is not RIGID else layer),
        [STEEL, RIGID, replace(RIGID, thickness=1e-6), cs.HalfSpace(1e17, 0.3, thickness=1e-6)],
    ),
    ("CoatedHalfSpace.coating", field(COATED, "substrate"), [replace(STEEL, youngs_modulus=1e3)]),
    ("HalfSpace.poisson_ratio is *above -1 and up to 0.5", field(STEEL, "poisson_ratio"), [-1.0, 0.5000001]),
    ("ViscoelasticHalfSpace.equilibrium_modulus is 0 and there", lambda one: cs.ViscoelasticHalfSpace(one, 0.3), [0.0]),
    # loads
    (
        "LineLoad.per_length is *: give a load",
        lambda one: replace(SMOOTH, load=cs.LineLoad(one)), [0.0, -0.0, -1.0, nan, inf, 10**400, None],
    ),
    ("Scene.load is a TotalLoad* give TotalLoad.length", field(SMOOTH, "load"), [cs.TotalLoad(100.0)]),
    ("LoadHistory.per_length has 1 loads", lambda one: cs.LoadHistory((0.0, 1.0), one), [(1.0,)]),
    ("LoadHistory.per_length is 0 throughout", lambda one: cs.LoadHistory((0.0, 1.0), one), [(0.0, 0.0)]),
    ("LoadHistory.times[1]", lambda one: cs.LoadHistory(one, (1.0, 1.0)), [(1.0, 0.0)]),
    ("LoadHistory.times[2]", lambda one: cs.LoadHistory(one, (1.0, 1.0, 1.0)), [(0.0, 0.0, 0.0)]),
    ("LoadHistory.per_length", lambda one: cs.LoadHistory(one, ()), [()]),
    # what a scene holds
    ("Scene.solids", field(SMOOTH, "solids"), [(STEEL,), STEEL, (STEEL, 210e9), ()]),
    ("Scene.solids*all rigid", field(SMOOTH, "solids"), [(RIGID, RIGID)]),
    ("Scene.shapes[0] is *: give a Shape, such", field(SMOOTH, "shapes"), [(0.01,), (cs.Cylinder,), (None,)]),
    ("Scene.outputs[1] is *: give one", field(SMOOTH, "outputs"), [(cs.SubsurfaceStress(), STRESS)]),
    (
        "*body is 1, a rigid body: give 0",
        field(replace(SMOOTH, solids=(STEEL, RIGID)), "outputs"), [(replace(STRESS, body=1),)],
    ),
    ("SubsurfaceStress.depths", cs.SubsurfaceStress, [(), 1e-4, None, (-1e-5,), (1e-4, nan), ("1 mN",)]),
    # shapes
    ("Crown end_drop is *: give ", lambda one: cs.Crown.of_drop(one, 0.01), [-1e-6]),
    ("Crown length is *: give ", lambda one: cs.Crown.of_drop(1e-6, one), [0.0]),
    (
        "LundbergProfile.length is *: give ",
        lambda one: cs.LundbergProfile.for_load(1e5, contact_modulus=1e11, radius=0.01, length=one), [1e-5],
    ),
    ("LundbergProfile.straight is 0.01", lambda one: cs.LundbergProfile(1e-6, 1e-6, 0.01, straight=one), [0.01]),
    ("Tilt.angle is *between -0.1 and 0.1 rad", cs.Tilt, [0.2, -inf]),
    (
        "MovingShape.shape is *: give",
        cs.MovingShape, [cs.Cylinder(1.0), cs.Sphere(1.0), cs.FiniteLength(1.0), None],
    ),
    ("Waviness.along", lambda one: cs.Waviness(0.01, along=one).gap(GRID), [3e-5]),
    *((f"Roughness.{name} is ", field(ROUGH, name), bad) for name, bad in {
        "rms": [-1e-9], "hurst": [0.0, 1.0], "roll_off": [1e-6], "peklenik": [0.0, inf], "extent": [1e-3],
    }.items()),
    ("Roughness.extent[1] is 7e-05: give a length", lambda one: replace(ROUGH, extent=one).gap(GRID), [(2e-4, 7e-5)]),
    ("Roughness.cut_off is 1e-40: give * waves", lambda one: replace(ROUGH, cut_off=one).gap(GRID), [1e-40]),
    ("Texture.pitch is *: give ", field(DIMPLES, "pitch"), [1e-4, (1e-4, inf), (0.9e-4, 2e-4)]),
    ("Texture.pitch[1] is *: give ", lambda one: replace(DIMPLES, pitch=one).gap(GRID), [(2e-4, 1.5e-4)]),
    ("Texture.pitch is *: give ", lambda one: cs.Texture(GROOVE, one), [(1e-4, 1e-4)]),
    ("Texture area_density is *: give ", lambda one: cs.Texture.of_density(DIMPLE, one, 2e-4), [1.0]),
    ("Texture along is *: give ", lambda one: cs.Texture.of_density(DIMPLE, 0.1, one), [None]),
    ("Texture along is *: give ", lambda one: cs.Texture.of_density(GROOVE, 0.1, one), [2e-4]),
    # measured surfaces
    ("MeasuredSurface.extent is *: give ", measured, [1.0, (1e-4, 1e-4)]),
    ("MeasuredSurface period is *: give ", measured, [(1.0, 3e-5)]),
    ("MeasuredSurface.trend is *: did you mean 'plane'", lambda one: cs.MeasuredSurface(HEIGHTS, trend=one), ["plain"]),
    (
        "MeasuredSurface.extent is None*16 x 4 points",
        lambda one: cs.MeasuredSurface(one).gap(GRID), [HEIGHTS[:, :4], np.zeros((16, 4))],
    ),
    ("MeasuredSurface.heights has *: give an array", cs.MeasuredSurface, [
        1.0, [1.0, 2.0], np.zeros((2, 2, 2)), np.zeros((0, 3)), [["a"]], [[1, 2], [3]], None,
        np.ones((2, 2), dtype=bool), np.ones((2, 2), dtype=complex), xr.DataArray([1.0]),
    ]),
    ("*coordinates for 1 of its dimensions", cs.MeasuredSurface, [labelled(width=np.arange(6))]),
    ("*width has coordinates that are not", cs.MeasuredSurface, [
        labelled(width=np.arange(6) ** 2, length=np.arange(4)), labelled(width=np.zeros(6), length=np.arange(4)),
    ]),
    ("*heights has the units 'nm': convert to m", cs.MeasuredSurface, [labelled().assign_attrs(units="nm")]),
    ("*heights.length has the units 'um': convert to m", cs.MeasuredSurface, [
        labelled(width=np.arange(6), length=("length", np.arange(4), {"units": "um"})),
    ]),
    # adhesion, friction, wear and rolling
    *((f"TractiveRolling{said}", lambda one: cs.TractiveRolling(**{"coefficient": 0.3} | one), bad) for said, bad in (
        ("*has none of", [{}]), ("*has longitudinal and tangential of", [{"longitudinal": 1e-3, "tangential": 1e3}]),
        (".speed", [{"longitudinal": 1e-3, "speed": 0.0}]),
    )),
    *((f"Fretting{said}", lambda one: cs.Fretting(**{"coefficient": 0.3} | one), bad) for said, bad in (
        ("*give one of them", [{"forces": (0.1,), "displacements": (1.0,)}, {}]),
        ("*give times", [{"displacements": (1.0,)}]), (".forces", [{"forces": ()}, {"forces": (0.1, nan)}]),
        ("*2 stresses and", [{"forces": (0.1,), "bulk_stresses": (1e7, 2e7)}]),
        ("*together with times", [{"forces": (0.1,), "times": (1.0,), "bulk_stresses": (1e7,)}]),
        ("*give one time for each", [{"forces": (0.0, 0.1), "times": (0.0,)}]),
        (".times[1] is 0.0", [{"forces": (0.0, 0.1), "times": (1.0, 0.0)}]),
    )),
    ("Fretting*steps", lambda one: cs.Fretting.cycle(0.3, 0.1, steps=one), [0]),
    *((f"Rolling.{said}", lambda one: cs.Rolling(**one), [bad]) for said, bad in (
        ("speed is 1.0 with passes", {"speed": 1.0, "passes": 2}),
        ("distance is 0.1 without passes", {"speed": 1.0, "distance": 0.1}),
        ("steady is 0.001 without passes", {"speed": 1.0, "steady": 1e-3}),
        ("pressure is * without passes", {"speed": 1.0, "pressure": "elastic"}),
    )),
    ("TimeSteps.times is empty: give one instant", lambda one: cs.TimeSteps(times=one), [(), []]),
    ("*give time_steps.end or time_steps.times", lambda end: cs.TimeSteps(end=end).instants_of(), [None]),
    ("TimeSteps*: leave one of them out.", lambda one: cs.TimeSteps(**one), [
        {"times": (0.0, 5.0), "end": 5.0}, {"times": (0.0,), "instants": 7}, {"step": 1.0, "error": 0.1},
    ]),
    # lubricants and films
    ("SpeedHistory.mean_speed[0] is 0", lambda one: cs.SpeedHistory((0, 1), one), [(0, 1)]),
    ("SpeedHistory", lambda one: cs.SpeedHistory(*one), [((0,), (1,)), ((0, 1), (1,)), ((1, 0), (1, 1))]),
    ("Lubricant.pressure_viscosity is 7e-08 * exponent is", lambda one: cs.Lubricant(0.04, one), [7e-8]),
    (
        "Roelands.exponent is 0.4, and heat and pressure * 0.608 alone",
        lambda one: film(lubricant=cs.Lubricant(0.04, 2e-8, cs.Roelands(one)), thermal=cs.FilmHeat()), [0.4],
    ),
    (
        "Lubrication.mean_speed is *give a speed above 0, *or a SpeedHistory",
        lambda one: film(mean_speed=one), [cs.LoadHistory((0, 1), (1e3, 1e4))],
    ),
    (
        "Lubrication.slide_roll_ratio is 2, where a surface stands still",
        lambda one: film(thermal=cs.FilmHeat(), slide_roll_ratio=one), [2],
    ),
    (
        "Lubricant.viscosity is 6e-05",
        lambda one: film(lubricant=cs.Lubricant(one, 0.0), thermal=cs.FilmHeat()), [6e-5],
    ),
    (
        "Lubrication.boundary is supported with ElrodAdams",
        lambda one: film(boundary=cs.Boundary(5e-9), cavitation=one), [cs.ReynoldsCavitation()],
    ),
    # where and how it is solved
    *((f"Grid.{said}: give ", lambda one: cs.Grid(**{"cells": (8, 8), "extent": (1.0, 1.0)} | one), [bad])
      for said, bad in (
          ("cells[0] is 1", {"cells": (1, 8)}), ("cells[1] is 0", {"cells": (8, 0)}), ("cells is 8", {"cells": 8}),
          ("extent[1] is 0.0", {"extent": (1.0, 0.0)}), ("extent[0] is inf", {"extent": (inf, 1.0)}),
      )),
    (
        "padding is *(across, along).",
        lambda one: cs.convolution(1.0, GRID, one, 1.0), [None, "exact", (FREE,), (FREE, 6)],
    ),
    ("grid is (8, 8): give a Grid.", lambda one: SMOOTH.problem(one, EXACT), [(8, 8)]),
    (
        "Grid.cells is * GB and this machine has ",
        lambda one: SMOOTH.problem(cs.Grid(one, (1e-3, 1e-3)), EXACT), [(2**22, 2**22)],
    ),
    ("pressure has the shape (8, 16): give it (16, 8).", SMOOTH.problem(GRID, EXACT).operator, [np.ones((8, 16))]),
    ("solve.scene is *: give a Scene, or scene.problem", cs.solve, [3, None, "rough.toml"]),
    ("solve.tolerance is ", lambda one: solved(tolerance=one), [0.0, -1e-8, nan]),
    ("solve.solver is ", lambda one: solved(solver=one), [5, cs.PolonskyKeer]),
    ("solve.device is 2: give Cpu(threads=2) or Gpu()", lambda one: solved(device=one), [2]),
    ("solve.folder is given, and a static contact has", lambda one: solved(folder=one), ["frames"]),
    *((f"solve.start {said}", lambda one: solved(start=one), [bad]) for said, bad in (
        ("has the shape (8, 16): give it (16, 8).", np.ones((8, 16))),
        ("is not finite in 128 cells: it must be at least 0 Pa", np.full((16, 8), nan)),
        ("is below 0 Pa in 128 cells: it must be at least 0 Pa", np.full((16, 8), -1.0)),
        ("is at most 0 Pa: give a pressure that carries some load", np.zeros((16, 8))),
        ("is at most 4.941e-324 Pa: give a pressure", np.full((16, 8), 5e-324)),
        ("is no array of numbers: give a pressure in Pa", "so"),
    )),
    ("plan.device is 2: give Cpu(threads=2) or Gpu()", lambda one: cs.plan(SMOOTH, device=one), [2]),
]  # fmt: skip


@pytest.mark.cases(len(VALUES))
@pytest.mark.parametrize(("said", "make", "values"), VALUES)
def test_a_value_is_refused_in_a_sentence(said: str, make: Callable[[Any], object], values: list[Any]) -> None:
    for value in values:
        refused(lambda value=value: make(value), said)
