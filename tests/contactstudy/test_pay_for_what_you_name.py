"""What a scene does not name is not transformed and not imported."""

import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np
import pytest
from scipy import fft

import contactstudy as cs
from contactstudy.elasticity.transforms import TRANSFORMS
from contactstudy.solvers.solve import SolveOptions
from tests.conftest import STEEL, LineContact

NOTHING: dict[str, cs.Shape] = {
    "waviness": cs.Waviness(0.0, across=3e-5, along=3e-5),
    "texture": cs.Texture(cs.Dimple(0.0, 1e-5), pitch=(3e-5, 3e-5)),
    "roughness": cs.Roughness(0.0, hurst=0.8, roll_off=1e-4, cut_off=1e-5),
    "roughness by slope": cs.Roughness(cs.RmsSlope(0.0), hurst=0.8, roll_off=1e-4, cut_off=1e-5),
    "crown": cs.Crown(inf),
    "tilt": cs.Tilt(0.0),
    "crown by its drop": cs.Crown.of_drop(0.0, length=1e-4),
    "Lundberg profile": cs.LundbergProfile(0.0, 0.0, length=1e-4),
}


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Calls of every transform there is, from here on."""
    calls: Counter[str] = Counter()

    def counting(name: str, transform: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: Any, **named: Any) -> Any:
            calls[name] += 1
            return transform(*arguments, **named)

        return call

    for name in ("fft", "ifft", "fft2", "ifft2", "rfft", "irfft", "dct", "dctn"):
        monkeypatch.setattr(fft, name, counting(name, getattr(fft, name)))

    for name in ("forward", "backward", "cosines"):
        monkeypatch.setattr(TRANSFORMS, name, counting(name, getattr(TRANSFORMS, name)))
    return calls


def solved(
    scene: cs.Scene, contact: LineContact, calls: Counter[str]
) -> tuple[cs.Solution, Counter[str]]:
    """A solution on a grid with a period of 9e-5 m, and the transforms it took."""
    calls.clear()
    grid = cs.Grid((128, 64), (2.4 * contact.hertz.half_width, 9e-5))
    return cs.solve(scene.problem(grid, cs.ExactPeriodicity())), Counter(calls)


@pytest.mark.parametrize("name", NOTHING)
def test_an_effect_of_no_size_is_the_scene_without_it(
    name: str, line_contact: LineContact, counted: Counter[str]
) -> None:
    plain = line_contact.scene
    without, transforms = solved(plain, line_contact, counted)
    with_it, more = solved(
        replace(plain, shapes=(*plain.shapes, NOTHING[name])), line_contact, counted
    )
    assert transforms["forward"] > 0
    assert more == transforms
    np.testing.assert_array_equal(with_it.pressure, without.pressure)
    np.testing.assert_array_equal(with_it.gap, without.gap)
    assert with_it.approach == without.approach


@pytest.mark.parametrize("hardness", [inf, 1e15], ids=["infinite", "never reached"])
def test_a_hardness_that_nothing_reaches_is_none(
    hardness: float, line_contact: LineContact, counted: Counter[str]
) -> None:
    without, transforms = solved(line_contact.scene, line_contact, counted)
    limited = replace(line_contact.scene, hardness=hardness)
    with_it, more = solved(limited, line_contact, counted)
    if hardness == inf:
        assert more == transforms
        np.testing.assert_array_equal(with_it.pressure, without.pressure)
        assert with_it.approach == without.approach
    else:  # the load is balanced in another order of sums, and the iteration may take another path
        difference = np.abs(with_it.pressure - without.pressure).max()
        # a residual times the operator's condition, up to 128 waves across
        assert difference < 128 * 1e-8 * 10 * without.problem.scales.pressure


def test_a_hardness_that_binds_sets_up_the_same_transforms(
    line_contact: LineContact, counted: Counter[str]
) -> None:
    """It costs iterations, each with its convolution and its preconditioning, and nothing besides."""
    limited = replace(line_contact.scene, hardness=0.8 * line_contact.hertz.peak_pressure)
    grid = cs.Grid((128, 64), (2.4 * line_contact.hertz.half_width, 9e-5))
    set_up = []
    for scene in (line_contact.scene, limited):
        counted.clear()
        problem = scene.problem(grid, cs.ExactPeriodicity())
        set_up.append(Counter(counted))
        solution = cs.solve(problem)
        assert solution.status is cs.Status.CONVERGED
        # one to begin with and one an iteration, also on coarser grids where there are some
        assert counted["forward"] == counted["backward"] >= 1 + solution.iterations
    assert set_up[0] == set_up[1]
    assert set_up[0]["cosines"] == 1


def test_all_errors_of_a_contact_share_one_coarser_solution(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene, grid = line_contact.scene, line_contact.grid((48, 24), 1.2)
    roller = cs.FiniteLength(0.7 * grid.extent[1])
    scene = replace(scene, shapes=(*scene.shapes, roller))
    solution = cs.solve(scene, grid, cs.ZeroPadding())
    solved, solve = [], SolveOptions.solved

    def counting(self: SolveOptions, problem: cs.Problem, *given: Any) -> cs.Solution:
        solved.append(problem.grid.cells)
        return solve(self, problem, *given)

    monkeypatch.setattr(SolveOptions, "solved", counting)
    assert solution.error.approach is not None
    assert solved == [(24, 12)]


def test_stress_that_is_not_asked_for_is_not_found(
    line_contact: LineContact, counted: Counter[str]
) -> None:
    plain = line_contact.scene
    asked = replace(plain, outputs=(cs.SubsurfaceStress(depths=(5e-5,)),))
    without, transforms = solved(plain, line_contact, counted)
    with_it, more = solved(asked, line_contact, counted)
    assert more == transforms
    assert without.problem.outputs == ()
    np.testing.assert_array_equal(with_it.pressure, without.pressure)


def test_one_cell_along_gives_the_pressure_of_many_where_nothing_varies(
    line_contact: LineContact,
) -> None:
    width = 2.4 * line_contact.hertz.half_width
    line, plane = (
        cs.solve(
            line_contact.scene.problem(cs.Grid((512, cells), (width, 9e-5)), cs.ExactPeriodicity()),
            tolerance=1e-12,
        ).pressure
        for cells in (1, 128)
    )
    np.testing.assert_allclose(plane, np.broadcast_to(line, plane.shape), atol=1e-9 * line.max())


HEAVY = (
    "SurfaceTopography",
    "cattrs",
    "contactstudy.elasticity.coating",
    "contactstudy.elasticity.eigenstrain",
    "contactstudy.elasticity.kernels.layer",
    "contactstudy.elasticity.viscoelastic",
    "contactstudy.elasticity.viscoelastic",
    "contactstudy.evolution",
    "contactstudy.io.dataset",
    "contactstudy.elasticity.kernels.traction",
    "contactstudy.elasticity.tangential",
    "contactstudy.evolution.adhesive_history",
    "contactstudy.scene.adhesion",
    "contactstudy.solvers.adhesion",
    "contactstudy.scene.coated",
    "contactstudy.scene.inelastic",
    "contactstudy.scene.friction",
    "contactstudy.solvers.friction",
    "contactstudy.solvers.plasticity",
    "contactstudy.solvers.friction",
    "contactstudy.scene.motion",
    "contactstudy.scene.stress",
    "matplotlib",
    "pandas",
    "scipy.interpolate",
    "scipy.ndimage",
    "xarray",
)


def test_a_plain_scene_imports_nothing_that_it_does_not_name() -> None:
    code = (
        f"import sys; from math import inf; import contactstudy as cs\nsteel = {STEEL!r}\n".replace(
            "HalfSpace", "cs.HalfSpace"
        )
        + "scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),))\n"
        "grid = cs.Grid((64, 32), (2.5e-4, 1e-4))\n"
        "assert cs.solve(scene.problem(grid, cs.ExactPeriodicity())).status is cs.Status.CONVERGED\n"
        f"print(sorted(set({HEAVY!r}) & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_march_of_bodies_that_do_not_yield_imports_no_plastic_strain() -> None:
    code = (
        f"import sys; from math import inf; import contactstudy as cs\nsteel = {STEEL!r}\n".replace(
            "HalfSpace", "cs.HalfSpace"
        )
        + "wear = cs.Wear(1e-15, 1.0)\n"
        "scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(0.01),), wear=wear)\n"
        "cs.solve(scene, cs.Grid((64, 1), (2.5e-4, 1e-4)), cs.ExactPeriodicity(), times=(0, 1))\n"
        "print([name for name in sys.modules if 'plastic' in name or 'eigenstrain' in name])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_body_that_yields_in_plane_strain_imports_no_waves_along_the_length() -> None:
    code = (
        "import sys; from math import inf; import contactstudy as cs\n"
        "body = cs.ElasticPlasticHalfSpace(210e9, 0.3, 1e9, 2e9)\n"
        "shapes = (cs.Cylinder(0.01),)\n"
        "scene = cs.Scene(cs.LineLoad(5e5), (body, cs.HalfSpace(float('inf'), 0.3)), shapes)\n"
        "grid = cs.Grid((16, 1), (8e-4, 1e-4))\n"
        "cs.solve(scene, grid, cs.ExactPeriodicity(), times=cs.TimeSteps((0,), step_error=cs.StepError.NONE))\n"
        "print([name for name in sys.modules if name.startswith('contactstudy.elasticity.eigenstrain.')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "plane_strain" in done.stdout
    assert "rows" not in done.stdout
    assert "wave" not in done.stdout
