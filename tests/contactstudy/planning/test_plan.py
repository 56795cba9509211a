from dataclasses import replace
from math import inf
from time import process_time
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.imports import loaded
from contactstudy.forecast import _TimeLimitReached, _Watch
from contactstudy.planning.plan import plan_grid
from contactstudy.progress import Progress
from tests.conftest import STEEL, LineContact
from tests.contactstudy.lubrication import scenes as films


def l1(contact: LineContact, solution: cs.Solution) -> float:
    """Relative L1 error against Hertz."""
    exact = contact.hertz.pressure(solution.problem.grid.x)[:, None]
    return float(np.abs(solution.pressure - exact).sum() / (exact.sum() * solution.pressure.shape[1]))


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
    # the place of the edge in its cell moves the error by a factor of two either way
    assert error / 8 < l1(line_contact, solution) < 2 * error


def test_images_that_a_padding_omits_are_in_the_error_of_its_plan(
    line_contact: LineContact,
) -> None:
    request = {"error": 1e-3, "period": 5 * line_contact.hertz.half_width}
    few = cs.plan(line_contact.scene, **request, padding=cs.Superposition(1))
    solved = cs.solve(line_contact.scene, **request, padding=cs.Superposition(1)).error.l1
    assert few.error == pytest.approx(solved.total, rel=0.05)
    assert few.error > 2 * solved.discretisation
    assert "plan.error: the images that the padding omits contribute" in few.warnings[-1]
    with pytest.raises(cs.NotDefined, match="the error of a window"):  # as its solve
        cs.plan(line_contact.scene, **request, padding=(cs.Superposition(2),) * 2)


def test_where_nothing_varies_along_the_length_the_plan_is_one_dimensional(
    line_contact: LineContact,
) -> None:
    a = line_contact.hertz.half_width
    groove = cs.Texture(cs.Groove(1e-8, 0.1 * a), pitch=(0.4 * a, inf))
    for scene in (line_contact.scene, line_contact.with_shapes(groove)):
        plan = plan_grid(scene, error=1e-2)
        assert plan.dimension == plan.grid.cells[1] == 1


@pytest.mark.cases(3)
def test_a_plan_runs_as_it_stands_for_every_kind_of_shape(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    heights = 1e-8 * np.random.default_rng(0).standard_normal((32, 24))
    strong = cs.Crown.of_drop(200 * a**2 / line_contact.hertz.radius, 12 * a)
    for shape, free in (
        (cs.Waviness(2e-8, along=0.5 * a), False),
        (strong, True),  # a contact of over 4 a
        (cs.Texture(cs.Dimple(5e-8, 0.2 * a), pitch=(0.5 * a, 0.5 * a)), False),
        (cs.MeasuredSurface(heights, extent=(8 * a, 6 * a)), False),
        (cs.FiniteLength(8 * a), True),
        (cs.LundbergProfile(1e-7, 1e-6, 8 * a), True),
    ):
        scene = line_contact.with_shapes(shape)
        plan = cs.plan(scene, error=0.1)
        solution = cs.solve(scene.problem(plan.grid, plan.padding))
        assert solution.status is cs.Status.CONVERGED, shape
        assert isinstance(plan.padding, tuple) == free
        assert plan.seconds > 0
        assert plan.bytes > 8 * 12 * solution.pressure.size


def test_shapes_that_repeat_share_a_period(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    waves = (cs.Waviness(1e-8, along=0.5 * a), cs.Waviness(1e-8, along=0.75 * a))
    assert cs.plan(line_contact.with_shapes(*waves), error=0.1).grid.length == pytest.approx(1.5 * a)
    stranger = cs.Waviness(1e-8, along=0.5 * np.pi * a)
    with pytest.raises(cs.InvalidInput, match="share no period"):
        cs.plan(line_contact.with_shapes(*waves, stranger))


def test_what_is_wrong_with_a_grid_is_said_before_anything_runs(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    scene = rough(line_contact, 0.6)
    good = cs.plan(scene, error=0.1)
    assert good.warnings == ()
    assert cs.plan(scene, grid=good.grid).warnings == ()
    narrow = replace(good.grid, extent=(2 * a, good.grid.length))
    planned = cs.plan(scene, grid=narrow)
    (said,) = [text for text in planned.warnings if "the contact is wider" in text]
    # the width to try holds it, or comes nearer
    wide = 1e-6 * float(said.partition("give a width of ")[2].split()[0])
    assert narrow.extent[0] < wide < 4 * good.grid.extent[0]
    assert planned.error == inf
    short = replace(good.grid, extent=(good.grid.extent[0], 2 * a))
    assert "longest wavelengths" in " ".join(cs.plan(scene, grid=short).warnings)
    coarse = replace(good.grid, cells=(16, 16))
    said = cs.plan(scene, grid=coarse).warnings
    assert [f"Grid.cells[{axis}] is 16" in text for axis, text in enumerate(said[:2])] == [True] * 2
    wave = line_contact.with_shapes(cs.Waviness(1e-8, along=0.3 * a))
    odd = cs.Grid((64, 64), (2.4 * a, a))
    assert "not a multiple" in cs.plan(wave, grid=odd).period_check


def test_the_error_of_a_film_beyond_its_most_cells_is_not_promised() -> None:
    """The grid is no coarser, and no narrower, than that of an error which they reach."""
    scene = films.by_moes(20, 2)
    planned, within = plan_grid(scene, error=1e-6), plan_grid(scene, error=1e-3)
    assert planned.error == inf
    assert planned.warnings[0].startswith("plan.error is 1e-06: ")
    assert within.warnings == ()
    assert planned.grid.cell_size[0] < within.grid.cell_size[0]
    assert planned.grid.extent[0] > within.grid.extent[0]


def test_a_film_is_planned_on_the_padding_that_is_given() -> None:
    wavy = films.by_moes(20, 2, cs.Waviness(1e-8, across=1e-4, along=1e-4))
    cut = cs.plan(wavy, padding=cs.CircularSuperposition(2))
    assert (cut.padding, cut.error) == (cs.CircularSuperposition(2), inf)
    assert "by the images that it leaves out is not predicted" in cut.warnings[0]
    short = cs.solve(wavy, cs.Grid((48, 8), (6e-4, 1e-4)), cs.CircularSuperposition(2))
    assert "images that it leaves out" in short.quantities["central_film"].reason
    # of one cell along the length its length would act on the film
    for refused in (
        (cs.ExactPeriodicity(), cs.ExactPeriodicity()),
        cs.ZeroPadding(),
        cs.CircularSuperposition(2),
    ):
        with pytest.raises(cs.InvalidInput, match="a film flows in at one side"):
            cs.plan(films.by_moes(20, 2), padding=refused)


def test_a_plan_of_a_film_counts_the_steps_that_are_given() -> None:
    loaded = replace(films.by_moes(20, 2), load=cs.LoadHistory((0.0, 1.0), (1.0, 2.0)))
    planned = cs.plan(loaded, times=cs.TimeSteps(step=1e-3))
    assert planned.solves == pytest.approx(1000, rel=0.2)  # from the first of them


def test_a_plan_says_which_texture_has_a_sharp_edge(line_contact: LineContact) -> None:
    a, gap = line_contact.hertz.half_width, line_contact.hertz.half_width**2 / 0.01 / 2
    for profile, is_sharp in (
        ("parabolic", True),
        ("flat", True),
        ("cosine", False),
    ):
        groove = cs.Groove(0.1 * gap, 0.2 * a, profile)
        scene = line_contact.with_shapes(cs.Texture(groove, (0.4 * a, inf)))
        assert any("sharp edge" in said for said in cs.plan(scene, error=0.03).warnings) == is_sharp


def test_a_plan_stays_on_the_measured_surface_and_in_the_memory(
    line_contact: LineContact, monkeypatch: pytest.MonkeyPatch
) -> None:
    a = line_contact.hertz.half_width
    heights = 3e-7 * np.random.default_rng(0).standard_normal((40, 24))
    scene = line_contact.with_shapes(cs.MeasuredSurface(heights, extent=(2.4 * a, 1.4 * a)))
    plan = cs.plan(scene, error=0.1)
    assert plan.grid.extent[0] <= 2.4 * a * (1 + 1e-12)
    narrow = line_contact.with_shapes(cs.MeasuredSurface(heights, extent=(1.5 * a, 1.4 * a)))
    said = cs.plan(narrow, error=0.1)
    assert said.error == inf
    assert "known over" in " ".join(said.warnings)
    worn = replace(narrow, wear=cs.Wear(1e-13, 1.0))
    in_time = cs.plan(worn, grid=None, error=0.3, times=(0.0, 1.0))
    assert in_time.grid.extent[0] <= 1.5 * a * (1 + 1e-12)
    assert "as it grows or rolls, or its plastic zone may need" in " ".join(in_time.warnings)
    monkeypatch.setattr("contactstudy.planning.plan.available_bytes", lambda: 4e6)
    wide = line_contact.with_shapes(cs.MeasuredSurface(heights / 10, extent=(6 * a, 3 * a)))
    small = cs.plan(wide, error={"pressure": 1e-4})
    # of the 80 % that a plan may take, a hundredth of the cells along each axis is left for rounding, and a step
    assert 0.9 * 0.8 * 4e6 < small.bytes <= 0.8 * 4e6
    assert small.error > 1e-4
    assert "GB that are free" in " ".join(small.warnings)


def test_a_measured_surface_is_solved_on_its_own_points_unless_an_error_is_asked_for(
    line_contact: LineContact,
) -> None:
    a = line_contact.hertz.half_width
    heights = 1e-8 * np.random.default_rng(0).standard_normal((60, 40))
    scene = line_contact.with_shapes(cs.MeasuredSurface(heights, extent=(6 * a, 4 * a)))
    found = cs.plan(scene)
    assert found.grid.cell_size == pytest.approx((0.1 * a, 0.1 * a))
    assert found.grid.cells[1] == 40
    assert any("its own points" in reason for reason in found.reasons)
    assert cs.solve(scene.problem(found.grid, found.padding)).status is cs.Status.CONVERGED


def test_a_plan_that_meets_its_error_does_not_warn_of_its_own_cells(line_contact: LineContact) -> None:
    """Of a long wave in many points, of which a few cells are enough."""
    a = line_contact.hertz.half_width
    wave = np.cos(2 * np.pi * np.arange(256) / 256)
    surface = cs.MeasuredSurface(1e-8 * np.outer(wave, wave), extent=(6 * a, 6 * a))
    planned = plan_grid(line_contact.with_shapes(surface), error=0.1)
    assert planned.grid.cell_size[0] > 6 * a / 256
    assert planned.warnings == ()


def test_a_solve_that_the_width_of_its_surface_cuts_off_is_not_refined(line_contact: LineContact) -> None:
    a = line_contact.hertz.half_width
    heights = 1e-8 * np.random.default_rng(0).standard_normal((24, 24))
    surface = cs.MeasuredSurface(heights, extent=(1.5 * a, 1.5 * a))
    found = cs.solve(line_contact.with_shapes(surface), error=1e-3)
    assert found.status is cs.Status.CONTACT_AT_EDGE
    assert np.prod(found.grid.cells) < 4 * heights.size


def test_a_plan_of_adhesion_resolves_the_waves_of_the_surfaces(line_contact: LineContact) -> None:
    shapes = (*line_contact.scene.shapes, cs.Waviness(1e-8, across=4e-6))
    adhesion = cs.Adhesion(0.05, range=1e-7)
    planned = cs.plan(replace(line_contact.scene, shapes=shapes, adhesion=adhesion), error=1e-2)
    assert 8 < 4e-6 / planned.grid.cell_size[0] < 50


@pytest.mark.parametrize(
    ("attraction_range", "padding", "cause"),
    [(2e-6, cs.CircularSuperposition(0), "images"), (None, cs.ExactPeriodicity(), "range")],
)
def test_a_plan_of_adhesion_expects_the_error_by_images_and_by_a_range_chosen_for_the_grid(
    attraction_range: float | None, padding: cs.Padding, cause: str
) -> None:
    bodies = cs.HalfSpace(5e6, 0.49), cs.HalfSpace(inf, 0.3)
    adhesion = cs.Adhesion(0.05, attraction_range)
    scene = cs.Scene(cs.LineLoad(0.5), bodies, (cs.Cylinder(1e-3),), adhesion=adhesion)
    planned = cs.plan(scene, error=0.04, padding=padding)
    answer = cs.solve(scene, planned.grid, padding)
    assert planned.error == pytest.approx(answer.error.l1.total, rel=0.5)
    assert any(cause in said and "contribute" in said for said in planned.warnings)


def test_a_plan_of_adhesion_resolves_the_zone_and_the_width_of_what_has_crept() -> None:
    """The zone ``pi E* w / (4 sigma0^2)`` has six cells; the relaxed contact is four times as wide as Hertz's."""
    soft = cs.ViscoelasticHalfSpace(1e5, 0.0, ((1.5e6, 1.0),))
    bodies, adhesion = (soft, cs.HalfSpace(inf, 0.0)), cs.Adhesion(0.05, range=1e-5)
    scene = cs.Scene(cs.LineLoad(100.0), bodies, (cs.Cylinder(0.01),), adhesion=adhesion)
    planned = cs.plan(scene, error=0.1, times=(0.0, 1.0, 1e3))
    assert planned.grid.cell_size[0] <= np.pi * 1e5 * 0.05 / (4 * (0.05 / 1e-5) ** 2) / 6
    assert planned.grid.extent[0] > 2 * 4 * scene.hertz.half_width
    assert planned.seconds < inf


@pytest.mark.parametrize("attraction_range", [1e-6, None])
def test_a_plan_of_adhesion_has_the_zone_of_the_answer(attraction_range: float | None) -> None:
    coated = cs.CoatedHalfSpace(cs.HalfSpace(5e6, 0.5), 1e-5, cs.HalfSpace(1e6, 0.5))
    bodies = coated, cs.ViscoelasticHalfSpace(1e6, 0.5, ((1e6, 1.0),))
    adhesion = cs.Adhesion(0.05, attraction_range)
    scene = cs.Scene(cs.LineLoad(1.0), bodies, (cs.Cylinder(1e-3),), adhesion=adhesion)
    grid = cs.Grid((256, 1), (4e-4, 1e-3))
    first = cs.solve(scene, grid, times=[0.0, 100.0]).frames[0].quantities
    zone, tabor = (first[name].value for name in ("cells_in_zone", "tabor_parameter"))
    said = f"adhesion: {zone:.3g} cells in the cohesive zone at a Tabor parameter of {tabor:.3g},"
    reasons = cs.plan(scene, times=(0.0, 100.0), grid=grid).reasons
    assert any(reason.startswith(said) for reason in reasons)


def test_a_measured_flat_is_solved_on_its_own_points_with_both_axes_periodic(
    line_contact: LineContact,
) -> None:
    heights = 1e-8 * np.random.default_rng(0).standard_normal((16, 12))
    flat = replace(
        line_contact.scene,
        load=cs.LineLoad(100.0),
        shapes=(cs.MeasuredSurface(heights, extent=(32e-6, 24e-6)),),
    )
    exact = cs.ExactPeriodicity()
    planned = cs.plan(flat)
    assert cs.plan(flat, error=1e-3).warnings[0].startswith("plan.error is 0.001: ")
    assert "not a multiple" in cs.plan(flat, period=36e-6).warnings[0]
    with pytest.raises(cs.InvalidInput, match=r"^plan\.period is -1"):
        cs.plan(flat, period=-1)
    assert planned.grid == cs.Grid((16, 12), (32e-6, 24e-6))
    assert planned.padding == (exact, exact)
    answer = cs.solve(flat)
    assert answer.pressure.shape == (16, 12)
    assert answer.status is cs.Status.CONVERGED
    worn = replace(flat, wear=cs.Wear(1e-18, 1.0))
    assert cs.plan(worn, times=(0.0, 1.0)).grid == planned.grid
    soft = replace(flat, solids=(cs.ViscoelasticHalfSpace(1e11, 0.3, ((1e11, 1.0),)), STEEL))
    # two fields of its Maxwell element, and eight of the steps
    assert cs.plan(soft, times=(0.0, 1.0)).bytes - planned.bytes == 8 * 16 * 12 * (2 + 8)
    loaded = replace(flat, load=cs.LoadHistory((0.0, 1.0), (50.0, 100.0)))
    adhesive = replace(loaded, adhesion=cs.Adhesion(0.05, range=1e-7))
    followed = cs.plan(adhesive, times=(0.0, 0.5, 1.0))
    assert followed.solves >= 3
    assert 0 < followed.seconds < inf
    finer = cs.Grid((32, 24), (32e-6, 24e-6))
    assert cs.plan(flat, grid=finer).grid == cs.solve(flat, finer).grid == finer
    without = replace(flat, shapes=(cs.MeasuredSurface(heights),))
    with pytest.raises(cs.NotDefined, match="MeasuredSurface with its extent"):
        cs.solve(without)


def test_a_plan_for_two_threads_has_the_grid_of_one_for_one(line_contact: LineContact) -> None:
    one, two = (cs.plan(line_contact.scene, error=1e-2, device=cs.Cpu(count)) for count in (1, 2))
    assert (two.grid, two.device) == (one.grid, cs.Cpu(2))
    assert two.seconds > 0


def test_the_seconds_of_a_plan_grow_with_the_depths_at_which_stress_is_asked_for(
    line_contact: LineContact,
) -> None:
    """Three hundred depths take longer than any solve of a smooth contact on few cells."""
    depths = tuple(np.linspace(1e-6, 1e-3, 300))
    for scene in (
        line_contact.scene,
        replace(line_contact.scene, rolling=cs.Rolling(1.0)),
    ):
        stressed = replace(scene, outputs=(cs.SubsurfaceStress(depths),))
        plain, planned = (cs.plan(one, error={"pressure": 1e-2}) for one in (scene, stressed))
        assert planned.grid == plain.grid
        assert planned.seconds > 2 * plain.seconds


@pytest.mark.cases(3)
@pytest.mark.parametrize("kind", ["rough", "creeping", "rolling", "rolling elastically"])
def test_a_plan_is_the_grid_of_the_solve_and_wider_than_the_contact(kind: str, line_contact: LineContact) -> None:
    creeping = cs.ViscoelasticHalfSpace(1e6, 0.49, ((1e6, 1.0),)), cs.HalfSpace(inf, 0.3)
    soft = cs.Scene(cs.LineLoad(300.0), creeping, (cs.Cylinder(0.01),))
    scene, named = {
        "rough": (rough(line_contact, 0.3), {}),
        "creeping": (soft, {"times": (0.0, 1.0)}),
        "rolling": (replace(soft, rolling=cs.Rolling(0.1)), {}),
        "rolling elastically": (replace(line_contact.scene, rolling=cs.Rolling(0.1)), {}),
    }[kind]
    named |= {"error": 0.05}  # of every number
    planned, answer = cs.plan(scene, **named), cs.solve(scene, **named)
    assert planned.grid.cells == answer.grid.cells
    assert planned.grid.extent[0] == pytest.approx(answer.grid.extent[0])
    touching = np.abs(answer.grid.x[(answer.pressure.reshape(-1, *answer.grid.cells).any(axis=(0, 2)))])
    assert 2 * touching.max() < planned.grid.extent[0]


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


def test_the_table_of_a_material_is_made_once_and_not_counted() -> None:
    body = cs.HalfSpace(210e9, 0.2345, free_faces=1e-3)
    before = loaded()
    cs.Scene(cs.LineLoad(1e5), (body, body), (cs.Cylinder(0.01),)).problem(
        cs.Grid((16, 12), (4e-4, 1e-3)), cs.ZeroPadding()
    )
    assert loaded() > before


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


def test_a_solve_that_is_ended_on_a_later_grid_is_extrapolated_from_what_is_done_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now = 0.0
    monkeypatch.setattr("contactstudy.forecast.process_time", lambda: now)
    watch = _Watch()
    for now, fraction in ((0.1, 0.5), (0.2, 1.0), (1.5, 0.0)):  # noqa: B007 (the clock reads it)
        watch(Progress(fraction, ""))
    now = 1.7
    with pytest.raises(_TimeLimitReached):
        watch(Progress(0.5, ""))
    seconds, _ = watch.whole
    assert 1.7 < seconds < 10
