from dataclasses import replace
from math import inf
from time import process_time
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.errors import ErrorParts
from contactstudy.planning.film_plan import finer_film_grid
from contactstudy.planning.plan import plan_grid
from tests.conftest import LineContact
from tests.contactstudy.lubrication import scenes as films


def rough(contact: LineContact, fraction: float, cut_off: float = 0.3) -> cs.Scene:
    a, gap = contact.hertz.half_width, contact.hertz.half_width**2 / contact.hertz.radius / 2
    shape = cs.Roughness(fraction * gap, hurst=0.8, roll_off=1.2 * a, cut_off=cut_off * a, seed=1)
    return contact.with_shapes(shape)


@pytest.mark.parametrize("error", [1e-2, 1e-4])
def test_a_planned_smooth_contact_meets_its_error(error: float, line_contact: LineContact) -> None:
    plan = cs.plan(line_contact.scene, error={"pressure": error})
    solution = cs.solve(line_contact.scene.problem(plan.grid, plan.padding), tolerance=1e-3 * error)
    assert solution.status is cs.Status.CONVERGED
    assert plan.error <= error
    exact = line_contact.hertz.pressure(solution.problem.grid.x)[:, None]
    # the place of the edge in its cell moves the error by a factor of two either way
    assert error / 8 < np.abs(solution.pressure - exact).sum() / exact.sum() < 2 * error


def test_images_that_a_padding_omits_are_in_the_error_of_its_plan(line_contact: LineContact) -> None:
    request = {"error": 1e-3, "period": 5 * line_contact.hertz.half_width}
    few = cs.plan(line_contact.scene, **request, padding=cs.Superposition(1))
    solved = cs.solve(line_contact.scene, **request, padding=cs.Superposition(1)).error.l1
    assert few.error == pytest.approx(solved.total, rel=0.05)
    assert few.error > 2 * solved.discretisation
    assert "plan.error: the images that the padding omits contribute" in few.warnings[-1]
    with pytest.raises(cs.NotDefined, match="the error of a window"):  # as its solve
        cs.plan(line_contact.scene, **request, padding=(cs.Superposition(2),) * 2)


@pytest.mark.cases(3)
def test_a_plan_runs_as_it_stands_for_every_kind_of_shape(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    heights = 1e-8 * np.random.default_rng(0).standard_normal((32, 24))
    strong = cs.Crown.of_drop(200 * a**2 / line_contact.hertz.radius, 12 * a)
    for shape, free in (
        (strong, True),  # a contact of over 4 a
        (cs.Texture(cs.Dimple(5e-8, 0.2 * a), pitch=(0.5 * a, 0.5 * a)), False),
        (cs.MeasuredSurface(heights, extent=(8 * a, 6 * a)), False),
    ):
        scene = line_contact.with_shapes(shape)
        plan = cs.plan(scene, error=0.1)
        solution = cs.solve(scene.problem(plan.grid, plan.padding))
        assert solution.status is cs.Status.CONVERGED, shape
        assert isinstance(plan.padding, tuple) == free
        assert plan.seconds > 0
        assert plan.bytes > 8 * 12 * solution.pressure.size


def test_the_error_of_a_film_beyond_its_most_cells_is_not_promised() -> None:
    """The grid is no coarser, and no narrower, than that of an error which they reach."""
    scene = films.by_moes(20, 2)
    planned, within = plan_grid(scene, error=1e-6), plan_grid(scene, error=1e-3)
    assert planned.error == inf
    assert planned.warnings[0].startswith("plan.error is 1e-06: ")
    assert within.warnings == ()
    assert planned.grid.cell_size[0] < within.grid.cell_size[0]
    assert planned.grid.extent[0] > within.grid.extent[0]


@pytest.mark.parametrize("inlet", [0.3e-2, 0.9e-2, 1.1e-2])
def test_a_film_on_its_extent_is_refined_while_finer_cells_meet_its_error(inlet: float) -> None:
    grid = films.grid(64, 3.0)
    errors = dict.fromkeys(("central_film", "minimum_film"), ErrorParts(discretisation=1.2e-2 - inlet, inlet=inlet))
    finer = finer_film_grid(grid, grid, errors, 1e-2, 1000, grid)
    assert (finer is not None) is (inlet < 1e-2)


def test_a_scene_in_time_with_adhesion_is_expected_to_be_refined_as_it_is() -> None:
    solids = cs.ViscoelasticHalfSpace(1e6, 0.49, ((1e6, 1.0),)), cs.HalfSpace(inf, 0.3)
    adhesion = cs.Adhesion(0.05, range=4e-6)
    scene = cs.Scene(cs.LineLoad(2.0), solids, (cs.Cylinder(0.01),), adhesion=adhesion)
    error, times = {"pressure": 0.02}, (0.0, 1.0)
    first, planned = plan_grid(scene, error=0.02, times=times), cs.plan(scene, error=error, times=times)
    solved = cs.solve(scene, error=error, times=times)
    assert first.grid.cells < planned.grid.cells == solved.grid.cells


def test_a_solve_that_the_width_of_its_surface_cuts_off_is_not_refined(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    heights = 1e-8 * np.random.default_rng(0).standard_normal((24, 24))
    surface = cs.MeasuredSurface(heights, extent=(1.5 * a, 1.5 * a))
    found = cs.solve(line_contact.with_shapes(surface), error=1e-3)
    assert found.status is cs.Status.CONTACT_AT_EDGE
    assert np.prod(found.grid.cells) < 4 * heights.size


def test_a_plan_of_adhesion_resolves_the_zone_and_the_width_of_what_has_crept() -> None:
    """The zone ``pi E* w / (4 sigma0^2)`` has six cells; the relaxed contact is four times as wide as Hertz's."""
    soft = cs.ViscoelasticHalfSpace(1e5, 0.0, ((1.5e6, 1.0),))
    bodies, adhesion = (soft, cs.HalfSpace(inf, 0.0)), cs.Adhesion(0.05, range=1e-5)
    scene = cs.Scene(cs.LineLoad(100.0), bodies, (cs.Cylinder(0.01),), adhesion=adhesion)
    planned = cs.plan(scene, error=0.1, times=(0.0, 1.0, 1e3))
    assert planned.grid.cell_size[0] <= np.pi * 1e5 * 0.05 / (4 * (0.05 / 1e-5) ** 2) / 6
    assert planned.grid.extent[0] > 2 * 4 * scene.hertz.half_width
    assert planned.seconds < inf


def test_a_plan_for_two_threads_has_the_grid_of_one_for_one(line_contact: LineContact) -> None:
    one, two = (cs.plan(line_contact.scene, error=1e-2, device=cs.Cpu(count)) for count in (1, 2))
    assert (two.grid, two.device) == (one.grid, cs.Cpu(2))
    assert two.seconds > 0


def test_a_plan_speaks_of_the_grid_on_which_its_solve_ends() -> None:
    steel = cs.ElasticPlasticHalfSpace(2.1e11, 0.3, yield_stress=8e8, hardening_modulus=5e9)
    scene = cs.Scene(cs.LoadHistory((0.0, 1.0, 2.0), (0.0, 6e5, 0.0)), (steel, steel), (cs.Cylinder(0.01),))
    plan = cs.plan(scene, error=0.1)
    [begins] = [reason for reason in plan.reasons if "begins on" in reason]
    assert f"{plan.grid.cells[0]} x 1 cells" not in begins
    again = plan_grid(scene, error=0.1, grid=plan.grid)
    assert plan.bytes == again.bytes
    assert any(reason.startswith(f"{plan.grid.cells[0]} x 1 cells:") for reason in plan.reasons)


def test_a_number_that_no_answer_has_is_refused(line_contact: LineContact) -> None:
    rolling = replace(line_contact.scene, rolling=cs.Rolling(0.1))
    for scene in (line_contact.scene, rolling, films.by_moes(5, 0)):
        with pytest.raises(cs.InvalidInput, match="peak_presure"):
            cs.plan(scene, error={"peak_presure": 0.1})


def test_seconds_count_nothing_that_is_compiled(monkeypatch: pytest.MonkeyPatch, line_contact: LineContact) -> None:
    exact = pytest.importorskip("contactstudy.domain.loops.compiled").exact
    scene, grid = line_contact.scene, line_contact.grid((64, 64), 1.4)
    spent = []

    def solve(*arguments: Any, **options: Any) -> cs.Contact:
        if not spent:  # as a solve that calls a loop for the first time
            exact(lambda x: x + 1.0)(1.0)
            begin = process_time()
            while process_time() < begin + 0.5:
                pass
        spent.append(0)
        return cs.solve(*arguments, **options)

    monkeypatch.setattr("contactstudy.forecast.solve", solve)
    assert cs.plan(scene, grid=grid).seconds < 0.5
    assert len(spent) > 1


@pytest.mark.parametrize("power", [0.5, 2.0])
def test_seconds_grow_with_the_power_of_the_cells_that_coarse_solves_show(
    power: float, monkeypatch: pytest.MonkeyPatch, line_contact: LineContact
) -> None:
    clock = [0.0]

    def solve(scene: cs.Scene, grid: cs.Grid, *arguments: Any, **options: Any) -> cs.Contact:
        clock[0] += 2.0 * (np.prod(grid.cells) / 128**2) ** power
        return cs.solve(scene, grid, *arguments, **options)

    monkeypatch.setattr("contactstudy.forecast.solve", solve)
    monkeypatch.setattr("contactstudy.forecast.process_time", lambda: clock[0])
    assert cs.plan(line_contact.scene, grid=line_contact.grid((128, 128), 1.4)).seconds == pytest.approx(2.0, rel=0.1)


def test_a_plan_whose_solves_do_not_end_in_time_says_that_its_error_is_not_predicted(
    monkeypatch: pytest.MonkeyPatch, line_contact: LineContact
) -> None:
    monkeypatch.setattr("contactstudy.forecast.SOLVE_SECONDS", 0.0)
    planned = cs.plan(replace(line_contact.scene, wear=cs.Wear(1e-13, 1.0)), error=0.1, times=(0.0, 1.0))
    assert planned.error == inf
    assert "error is not predicted" in " ".join(planned.warnings)


def test_what_is_wrong_with_a_grid_is_said_before_anything_runs(line_contact: LineContact) -> None:
    a, scene = line_contact.hertz.half_width, rough(line_contact, 0.6)
    good = cs.plan(scene, error=0.1)
    assert good.warnings == cs.plan(scene, grid=good.grid).warnings == ()
    planned = cs.plan(scene, grid=replace(good.grid, extent=(2 * a, good.grid.length)))
    (said,) = [text for text in planned.warnings if "the contact is wider" in text]
    # the width to try holds it, or comes nearer
    assert 2 * a < 1e-6 * float(said.partition("give a width of ")[2].split()[0]) < 4 * good.grid.extent[0]
    assert planned.error == inf
    short = replace(good.grid, extent=(good.grid.extent[0], 2 * a))
    assert "longest wavelengths" in " ".join(cs.plan(scene, grid=short).warnings)
    said = cs.plan(scene, grid=replace(good.grid, cells=(16, 16))).warnings
    assert [f"Grid.cells[{axis}] is 16" in text for axis, text in enumerate(said[:2])] == [True] * 2
    wave = line_contact.with_shapes(cs.Waviness(1e-8, along=0.3 * a))
    assert "not a multiple" in " ".join(cs.plan(wave, grid=cs.Grid((64, 64), (2.4 * a, a))).warnings)


def test_a_film_is_planned_on_the_padding_that_is_given() -> None:
    wavy = films.by_moes(20, 2, cs.Waviness(1e-8, across=1e-4, along=1e-4))
    cut = cs.plan(wavy, padding=cs.CircularSuperposition(2))
    assert (cut.padding, cut.error) == (cs.CircularSuperposition(2), inf)
    assert "by the images that it leaves out is not predicted" in cut.warnings[0]
    # of one cell along the length its length would act on the film
    for refused in ((cs.ExactPeriodicity(), cs.ExactPeriodicity()), cs.ZeroPadding()):
        with pytest.raises(cs.InvalidInput, match="a film flows in at one side"):
            cs.plan(films.by_moes(20, 2), padding=refused)


def test_a_measured_surface_is_solved_on_its_own_points_unless_an_error_is_asked_for(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    surface = cs.MeasuredSurface(1e-8 * np.random.default_rng(0).standard_normal((60, 40)), extent=(6 * a, 4 * a))
    found = cs.plan(line_contact.with_shapes(surface))
    assert found.grid.cell_size == pytest.approx((0.1 * a, 0.1 * a))
    assert found.grid.cells[1] == 40
    flat = replace(line_contact.scene, load=cs.LineLoad(100.0), shapes=(surface,))
    planned = cs.plan(flat)
    assert (planned.grid.cells, planned.padding) == ((60, 40), (cs.ExactPeriodicity(),) * 2)
    assert cs.solve(flat).pressure.shape == (60, 40)
    assert cs.plan(flat, error=1e-3).warnings[0].startswith("plan.error is 0.001: ")
    assert "not a multiple" in cs.plan(flat, period=6.2 * a).warnings[0]
    worn = replace(flat, wear=cs.Wear(1e-18, 1.0))
    assert cs.plan(worn, times=(0.0, 1.0)).grid == planned.grid
    with pytest.raises(cs.NotDefined, match="MeasuredSurface with its extent"):
        cs.solve(replace(flat, shapes=(cs.MeasuredSurface(surface.heights),)))


def test_a_plan_stays_on_the_measured_surface_and_says_what_memory_it_takes(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    a = line_contact.hertz.half_width
    heights = 3e-7 * np.random.default_rng(0).standard_normal((40, 24))
    narrow = line_contact.with_shapes(cs.MeasuredSurface(heights, extent=(1.5 * a, 1.4 * a)))
    said = cs.plan(narrow, error=0.1)
    assert said.grid.extent[0] <= 1.5 * a * (1 + 1e-12)
    assert said.error == inf
    assert "known over" in " ".join(said.warnings)
    in_time = cs.plan(replace(narrow, wear=cs.Wear(1e-13, 1.0)), error=0.3, times=(0.0, 1.0))
    assert "as it grows or rolls, or its plastic zone may need" in " ".join(in_time.warnings)
    monkeypatch.setattr("contactstudy.planning.plan.available_bytes", lambda: 4e6)
    wide = line_contact.with_shapes(cs.MeasuredSurface(heights / 10, extent=(6 * a, 3 * a)))
    small = cs.plan(wide, error={"pressure": 1e-4})
    assert small.bytes > 0.8 * 4e6
    assert "GB that are free" in " ".join(small.warnings)


def test_a_plan_of_adhesion_expects_the_error_by_a_range_chosen_for_the_grid() -> None:
    bodies = cs.HalfSpace(5e6, 0.49), cs.HalfSpace(inf, 0.3)
    scene = cs.Scene(cs.LineLoad(0.5), bodies, (cs.Cylinder(1e-3),), adhesion=cs.Adhesion(0.05))
    planned = cs.plan(scene, error=0.04)
    answer = cs.solve(scene, planned.grid, planned.padding)
    assert planned.error == pytest.approx(answer.error.l1.total, rel=0.5)
    assert any("range" in said and "contribute" in said for said in planned.warnings)


def test_the_seconds_of_a_plan_grow_with_the_depths_at_which_stress_is_asked_for(line_contact: LineContact) -> None:
    """Three hundred depths take longer than any solve of a smooth contact on few cells."""
    stressed = replace(line_contact.scene, outputs=(cs.SubsurfaceStress(tuple(np.linspace(1e-6, 1e-3, 300))),))
    plain, planned = (cs.plan(one, error={"pressure": 1e-2}) for one in (line_contact.scene, stressed))
    assert planned.grid == plain.grid
    assert planned.seconds > 2 * plain.seconds


@pytest.mark.parametrize("kind", ["rough", "rolling"])
def test_a_plan_is_the_grid_of_the_solve_and_wider_than_the_contact(kind: str, line_contact: LineContact) -> None:
    creeping = cs.ViscoelasticHalfSpace(1e6, 0.49, ((1e6, 1.0),)), cs.HalfSpace(inf, 0.3)
    soft = cs.Scene(cs.LineLoad(300.0), creeping, (cs.Cylinder(0.01),), rolling=cs.Rolling(0.1))
    scene = {"rough": rough(line_contact, 0.3), "rolling": soft}[kind]
    planned, answer = cs.plan(scene, error=0.05), cs.solve(scene, error=0.05)
    assert planned.grid.cells == answer.grid.cells
    assert planned.grid.extent[0] == pytest.approx(answer.grid.extent[0])
    assert 2 * np.abs(answer.grid.x[answer.pressure.any(axis=1)]).max() < planned.grid.extent[0]
