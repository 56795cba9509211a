"""What other programs are given, and what is taken from them: programs that are written here."""

import sys
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions import peers
from studies.definitions.peers import MODULUS, P_H, A, ProgramRun
from studies.reference.line_contact import HERTZ, SCENE
from studies.registry import load

LOAD = SCENE.load.largest
SIDE = 2.4 * A
CELL = (SIDE / 6) ** 2


def install(monkeypatch: pytest.MonkeyPatch, name: str, **members: Any) -> None:
    module = ModuleType(name)
    vars(module).update(members)
    monkeypatch.setitem(sys.modules, name, module)


def parabola(cells: int, radius: float, along: float) -> np.ndarray:
    """The gap under a cylinder, or with ``along`` = 1 under a sphere."""
    x = (np.arange(cells) + 0.5) * SIDE / cells - SIDE / 2
    return (x[:, None] ** 2 + along * x[None, :] ** 2) / (2 * radius)


@pytest.mark.parametrize(
    ("boundary", "half_space"),
    [("semi-periodic", "Semi"), ("free", "Free"), ("periodic", "Periodic")],
)
def test_contact_mechanics_is_given_heights_and_forces_and_gives_forces_of_cells(
    boundary: str, half_space: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: dict[str, Any] = {}

    def substrate(name: str) -> Any:
        return lambda *given, **named: made.update(substrate=(name, given, named))

    def minimise(_: object, surface: object, **named: Any) -> SimpleNamespace:
        made.update(surface=surface, named=named)
        # of twice as many cells where the program pads
        return SimpleNamespace(jac=np.arange(12.0)[:, None] * 100 + np.arange(12.0))

    names = {
        "Semi": "SemiPeriodicFFTElasticHalfSpace",
        "Free": "FreeFFTElasticHalfSpace",
        "Periodic": "PeriodicFFTElasticHalfSpace",
    }
    install(
        monkeypatch, "ContactMechanics", **{full: substrate(name) for name, full in names.items()}
    )
    install(monkeypatch, "ContactMechanics.Optimization", constrained_conjugate_gradients=minimise)
    install(monkeypatch, "SurfaceTopography", Topography=lambda *given: given)
    case = ProgramRun("ContactMechanics", boundary, 6)
    found = case.run(case.prepare())
    wanted = np.arange(6.0)[:, None] * 100 + np.arange(6.0)
    np.testing.assert_allclose(found, wanted / CELL)
    name, (cells, modulus, extent), named = made["substrate"]
    assert (name, cells, modulus) == (half_space, (6, 6), HERTZ.contact_modulus)
    assert extent == pytest.approx((SIDE, SIDE))
    # periodic along the length alone, by ten images on each side
    assert named == ({"periodicity": (False, True), "n_images": 10} if name == "Semi" else {})
    heights, extent = made["surface"]
    assert extent == pytest.approx((SIDE, SIDE))
    if boundary != "periodic":
        radius, along = (0.01, 0) if boundary == "semi-periodic" else (0.02, 1)
        np.testing.assert_allclose(heights, -parabola(6, radius, along), rtol=1e-9, atol=1e-20)
    assert made["named"]["external_force"] == pytest.approx(LOAD * SIDE)
    # a hundred-millionth of what Hertz's contact flattens, and of the force on a cell at its peak
    assert made["named"]["pentol"] == pytest.approx(1e-8 * P_H * A / MODULUS, abs=0)
    assert made["named"]["forcetol"] == pytest.approx(1e-8 * P_H * CELL, abs=0)


@pytest.mark.parametrize("boundary", ["free", "periodic"])
def test_tamaas_is_given_heights_and_a_mean_pressure(
    boundary: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: dict[str, Any] = {"operators": []}

    class Solver:
        pressure = "pressures"

        def __init__(self, *given: Any) -> None:
            made["solver"] = given

        def setIntegralOperator(self, name: str) -> None:
            made["operators"].append(name)

        def solve(self, mean: float) -> None:
            made["mean"] = mean

    model = SimpleNamespace(traction=[[1.0, 2.0], [3.0, 4.0]])
    factory = SimpleNamespace(
        createModel=lambda *given: made.update(model=given) or model,
        registerNonPeriodic=lambda _, name: made["operators"].append(name),
    )
    install(
        monkeypatch, "tamaas", initialize=lambda count: made.update(threads=count),
        ModelFactory=factory, PolonskyKeerRey=Solver, model_type=SimpleNamespace(basic_2d="plane"),
    )  # fmt: skip
    case = ProgramRun("tamaas", boundary, 6, threads=3)
    assert case.run(case.prepare()).tolist() == [[1, 2], [3, 4]]
    assert made["threads"] == 3
    kind, extent, cells = made["model"]
    assert (kind, cells) == ("plane", [6, 6])
    assert extent == pytest.approx([SIDE, SIDE])
    assert (model.E, model.nu) == (MODULUS, 0)
    given, heights, tolerance, *kinds = made["solver"]
    assert (given, tolerance, kinds) == (model, 1e-8, ["pressures", "pressures"])
    assert made["operators"] == (["dcfft", "dcfft"] if boundary == "free" else [])
    if boundary == "free":
        np.testing.assert_allclose(heights, -parabola(6, 0.02, 1), rtol=1e-9)
    assert made["mean"] == pytest.approx(LOAD / SIDE)


@pytest.mark.parametrize(
    ("cells", "coarsest"), [(64, 64), (66, 33), (130, 65), (256, 64), (200, 50)]
)
def test_aspher_is_given_gaps_in_half_widths_and_begins_on_the_coarsest_grid(
    cells: int, coarsest: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: dict[str, Any] = {}

    def nested(*given: Any, **named: Any) -> SimpleNamespace:
        made.update(given=given, named=named)
        return SimpleNamespace(pressure=np.arange(cells**2))

    install(monkeypatch, "aspher", solve_nested=nested)
    case = ProgramRun("aspher", "free", cells)
    found = case.run(case.prepare())
    np.testing.assert_allclose(found, MODULUS * np.arange(cells**2).reshape(cells, cells))
    size, gap, mean = made["given"]
    assert size == cells
    np.testing.assert_allclose(gap, parabola(cells, 0.02, 1) / A, rtol=1e-9)
    assert mean == pytest.approx(LOAD / SIDE / MODULUS)
    named = made["named"]
    assert named.pop("domain_size") == pytest.approx(2.4)
    assert named == {"coarsest": coarsest, "tol": 1e-9, "backend": "fft"}
    around = ProgramRun("aspher", "periodic", cells)
    around.run(around.prepare())
    assert made["named"]["backend"] == "periodic"


@pytest.mark.parametrize(
    ("program", "boundary", "threads"),
    [
        ("ContactMechanics", "free", 2),
        ("tamaas", "semi-periodic", 1),
        ("aspher", "semi-periodic", 1),
    ],
)
def test_what_a_program_has_not_is_said(
    program: str, boundary: str, threads: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(monkeypatch, program)
    with pytest.raises(NotImplementedError, match=f"^{program} has no"):
        ProgramRun(program, boundary, 6, threads).prepare()


def test_this_program_goes_to_a_residual_of_1e_10_on_its_threads(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen = []

    def solve(problem: cs.Problem, **named: Any) -> SimpleNamespace:
        seen.append((problem.grid.cells, named))
        return SimpleNamespace(pressure=np.array([[1.0, 2.0], [5.0, 3.0]]))

    monkeypatch.setattr(cs, "solve", solve)
    study = load("peers")
    point = {"program": "contactstudy", "boundary": "periodic", "threads": 3, "grid": 2}
    case: Any = study.scene_at(point)
    pressure = case.run(case.prepare())
    assert seen == [((2, 2), {"tolerance": 1e-10, "on": cs.Cpu(threads=3)})]
    # a half too much in a corner, a quarter too little in another, of the highest of 5
    wrong = pressure + np.array([[0.5, 0.0], [0.0, -0.25]])
    assert float(study.measures(case, wrong)["difference"]) == pytest.approx(0.1)
    assert float(study.measures(case, 2 * pressure - wrong)["difference"]) == pytest.approx(0.1)
    # three times the mean pressure of the load
    carried = case.record(np.full((2, 2), 3 * LOAD / SIDE))
    assert float(carried["load_carried"]) == pytest.approx(3)
    with pytest.raises(cs.InvalidInput, match="at least 2 cells"):
        study.scene_at(point | {"grid": 1})


def test_a_program_has_one_thread_unless_told_otherwise() -> None:
    assert ProgramRun("tamaas", "free", 6).threads == 1
    assert [*peers.PROGRAMS] == ["contactstudy", "ContactMechanics", "tamaas", "aspher"]
