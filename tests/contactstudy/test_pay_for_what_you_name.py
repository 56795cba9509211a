import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from math import inf
from typing import Any

import numpy as np
import pytest
from scipy import fft

import contactstudy as cs
from contactstudy.domain.device import caching
from contactstudy.elasticity.transforms import TRANSFORMS
from contactstudy.io.scene_files.scene_schema import KINDS
from tests.conftest import LineContact

NOTHING: dict[str, cs.Shape] = {
    "waviness": cs.Waviness(0.0, across=3e-5, along=3e-5),
    "dimples": cs.Texture(cs.Dimple(0.0, 1e-5), pitch=(3e-5, 3e-5)),
    "measured surface": cs.MeasuredSurface(np.zeros((24, 8)), (1e-2, 9e-5)),
    "roughness": cs.Roughness(0.0, hurst=0.8, roll_off=1e-4, cut_off=1e-5),
    "crown": cs.Crown(inf),
    "tilt": cs.Tilt(0.0),
    "Lundberg profile": cs.LundbergProfile(0.0, 1e-6, length=1e-4),
    "flat cylinder": cs.Cylinder(inf),
    "profile": cs.ProfilePoints((0.0, 0.005), (0.0, 0.0)),
    "relief": cs.EndRelief(0.01, 0.008),
    "moving": cs.MovingShape(cs.Waviness(0.0, across=3e-5)),
}


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Iterator[Counter[str]]:
    """Calls of every transform there is, from here on; nothing of one solve is kept for the next."""
    calls: Counter[str] = Counter()

    def call(name: str, transform: Any, *arguments: Any, **named: Any) -> Any:
        calls[name] += 1
        return transform(*arguments, **named)

    names = {fft: ("fft", "ifft", "fft2", "ifft2", "rfft", "irfft", "dct", "dctn")}
    for of, each in (names | {TRANSFORMS: ("forward", "backward")}).items():
        for name in each:
            monkeypatch.setattr(of, name, partial(call, name, getattr(of, name)))
    with caching(None):
        yield calls


def solved(scene: cs.Scene, contact: LineContact, calls: Counter[str]) -> tuple[cs.Solution, Counter[str]]:
    """A solution on a grid with a period of 9e-5 m, and the transforms it took."""
    calls.clear()
    grid = cs.Grid((128, 64), (2.4 * contact.hertz.half_width, 9e-5))
    return cs.solve(scene.problem(grid, cs.ExactPeriodicity())), Counter(calls)


@pytest.mark.cases(len(NOTHING))
@pytest.mark.parametrize("name", NOTHING)
def test_an_effect_of_no_size_is_the_scene_without_it(
    name: str, line_contact: LineContact, counted: Counter[str]
) -> None:
    plain = line_contact.scene
    without, transforms = solved(plain, line_contact, counted)
    with_it, more = solved(replace(plain, shapes=(*plain.shapes, NOTHING[name])), line_contact, counted)
    assert NOTHING[name].gap(with_it.problem.grid).shape in {(128, 1), (1, 64)}
    assert more == transforms
    assert transforms["forward"] > 0
    np.testing.assert_array_equal(with_it.pressure, without.pressure)
    assert with_it.approach == without.approach


def test_every_shape_is_a_kind_of_scene_files_and_is_tried_without_height_or_always_has_one() -> None:
    always_high = {"Sphere", "Ellipsoid", "FiniteLength"}
    shapes = {name for name in dir(cs) if {"gap", "length_scales"} <= set(dir(getattr(cs, name)))}
    assert {type(shape).__name__ for shape in NOTHING.values()} | always_high == shapes == KINDS[cs.Shape].keys()


def test_stress_is_computed_where_it_is_read(line_contact: LineContact, counted: Counter[str]) -> None:
    asked = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(depths=(5e-5,)),))
    _, transforms = solved(line_contact.scene, line_contact, counted)
    assert solved(asked, line_contact, counted)[1] == transforms


# One after the other in one process: what is run, and modules that nothing up to then has named.
RUN = (
    ("import sys, contactstudy as cs, studies", "numpy xarray dask matplotlib"),
    (
        """
steel, exact = cs.HalfSpace(210e9, 0.3), cs.ExactPeriodicity()
scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),))
grid = cs.Grid((16, 4), (2.5e-4, 1e-4))
cs.MeasuredSurface([[0.0] * 4] * 16).gap(grid)
assert cs.solve(scene.problem(grid, exact)).status is cs.Status.CONVERGED
""",
        """SurfaceTopography cattrs dask matplotlib pandas scipy.interpolate scipy.ndimage xarray studies.engine
        contactstudy.elasticity.coating contactstudy.elasticity.eigenstrain contactstudy.elasticity.tangential
        contactstudy.elasticity.kernels.layer_waves contactstudy.elasticity.kernels.stress contactstudy.evolution
        contactstudy.elasticity.viscoelastic contactstudy.io.dataset contactstudy.lubrication
        contactstudy.scene.adhesion contactstudy.scene.solids.coated contactstudy.scene.friction
        contactstudy.scene.solids.inelastic
        contactstudy.scene.stress
        contactstudy.solvers.adhesion contactstudy.solvers.coulomb contactstudy.solvers.plasticity""",
    ),
    (
        """
wearing = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),), wear=cs.Wear(1e-15, 1.0))
cs.solve(wearing, cs.Grid((64, 1), (2.5e-4, 1e-4)), exact, times=(0, 1))
""",
        "contactstudy.elasticity.eigenstrain contactstudy.evolution.states.plastic contactstudy.lubrication",
    ),
    (
        """
body, rigid = cs.ElasticPlasticHalfSpace(210e9, 0.3, 1e9, 2e9), cs.HalfSpace(float("inf"), 0.3)
yields = cs.Scene(cs.LineLoad(5e5), (body, rigid), (cs.Cylinder(0.01),))
once = cs.TimeSteps((0,), error_estimator="none")
cs.solve(yields, cs.Grid((16, 1), (8e-4, 1e-4)), exact, times=once)
assert "contactstudy.elasticity.eigenstrain.plane_strain_operator" in sys.modules
""",
        "contactstudy.elasticity.eigenstrain.periodic_operator",
    ),
    ("cs.solve(scene.problem(grid, exact)).to_dataset()", "matplotlib contactstudy.scene.stress"),
)


def test_no_module_is_imported_before_a_scene_names_it() -> None:
    ours = [name for _, names in RUN for name in names.split() if name.startswith("contactstudy")]
    assert all(find_spec(name) for name in ours)
    code = "\n".join(f"{step}\nprint(set({names.split()!r}) & sys.modules.keys())" for step, names in RUN)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.split() == ["set()"] * len(RUN), done.stderr
