"""Recommendations against the error they promise, and against what else is stored."""

from dataclasses import replace
from math import exp

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.accuracy.expected_error import Edges, Metric
from contactstudy.domain.grid import Paddings
from contactstudy.planning.cost import (
    SMOOTH_CONVOLUTIONS,
    CostModel,
    Timing,
    convolutions_to,
    log_work,
    padded_points,
)
from contactstudy.solvers.solve import SolveOptions
from studies.advice.recommendation import (
    Limits,
    Recommendation,
    RoughContact,
    SmoothContact,
    contact_of,
    mode_of,
    recommend,
)
from studies.advice.settings_table import STORED_ERRORS, stored_timings
from studies.advice.verification import WHAT, verify
from studies.definitions import pareto
from studies.engine.run import run
from studies.model.case import Case
from studies.model.outcome import CaseStatus
from studies.reference.line_contact import HERTZ, LINE, PADDINGS, SCENE, padding_at
from studies.registry import load
from studies.store.netcdf import read
from tests.studies.conftest import quiet

MODES = (LINE, *PADDINGS)


def samples(grid: cs.Grid, padding: cs.Padding | Paddings) -> tuple[Timing, ...]:
    """A microsecond for a hundred cells and images, and as much for transforms, whatever the clock says."""
    cells = 128, min(grid.cells[1], 128)
    return tuple(
        Timing(
            cs.Grid(cells, (1.0, 1.0)),
            one,
            35.0,
            1e-8 * cells[0] * cells[1] * images,
            1e-6 * cells[0] * cells[1],
        )
        for one, images in (
            [(replace(padding, images=n), 2 * n + 1) for n in (1, 6)]
            if isinstance(padding, cs.Superposition | cs.CircularSuperposition)
            else [(padding, 1)]
        )
    )


MODEL = CostModel(sample=samples)


def smooth(period: float, *modes: str) -> SmoothContact:
    a = HERTZ.half_width
    return SmoothContact(a, period * a, modes or MODES, images=(1, 2, 4, 8, 20))


def true_error(metric: Metric, found: Recommendation) -> float:
    best = found.best
    case = Case(SCENE, best.grid, best.padding, cs.SolveOptions(best.tolerance))
    measured = pareto.measures(case, case.run(case.prepare()))
    names = STORED_ERRORS[WHAT[metric]]
    name = names[-1] if best.edges is Edges.CORRECTED else names[0]
    return abs(float(measured[name]))


def test_a_recommended_setting_of_any_mode_meets_its_error_on_periods_not_stored() -> None:
    met = []
    for period in (0.9, 3.7):
        for metric in Metric:
            for target in (6e-2, 7e-3, 9e-4, 1e-4):
                for mode in (name for name in MODES if name != "zero"):
                    found = recommend(smooth(period, mode), Limits(target, metric), MODEL)
                    if found.meets and found.best.grid.cells[1] <= 128:
                        met.append(true_error(metric, found) <= target)
    assert len(met) >= 30
    assert np.mean(met) >= 0.95


@pytest.mark.whole
def test_a_recommended_setting_of_a_rough_contact_meets_its_error() -> None:
    a, gap = HERTZ.half_width, HERTZ.half_width**2 / HERTZ.radius / 2
    for seed, error in ((1, 0.2), (2, 0.1)):
        shape = cs.Roughness(0.6 * gap, hurst=0.8, roll_off=1.2 * a, cut_off=0.4 * a, seed=seed)
        scene = replace(SCENE, shapes=(*SCENE.shapes, shape))
        contact = contact_of(scene, 2.4 * a, Limits(error))
        assert isinstance(contact, RoughContact)
        best = recommend(contact, Limits(error), MODEL).best
        # the same question to a plan has the same answer
        assert best.grid == cs.plan(scene, error=error, period=2.4 * a).grid
        nx, ny = best.grid.cells
        finer = cs.Grid((4 * nx, 4 * ny), best.grid.extent)
        coarse = cs.solve(scene.problem(best.grid, best.padding), tolerance=best.tolerance)
        fine = cs.solve(scene.problem(finer, cs.ExactPeriodicity()), tolerance=1e-5)
        means = fine.pressure.reshape(nx, 4, ny, 4).mean(axis=(1, 3))
        assert np.abs(coarse.pressure - means).sum() / means.sum() <= error


def test_a_surface_narrower_than_its_contact_has_no_recommendation() -> None:
    a = HERTZ.half_width
    heights = 1e-8 * np.random.default_rng(0).standard_normal((24, 16))
    surface = cs.MeasuredSurface(heights, extent=(1.5 * a, a))
    scene = replace(SCENE, shapes=(*SCENE.shapes, surface))
    with pytest.raises(cs.NotDefined, match="outgrows the measured surface"):
        contact_of(scene, None, Limits(0.1))


def model_times(case: Case) -> tuple[float, float]:
    assert not isinstance(case.padding, tuple)
    images = 1 if case.padding.window is None else len(case.padding.window)
    points = padded_points(case.grid, case.padding)
    convolutions = convolutions_to(case.options.tolerance, SMOOTH_CONVOLUTIONS)
    return 1e-8 * images * exp(log_work(np.prod(case.grid.cells))), 1e-8 * convolutions * exp(
        log_work(points)
    )


@pytest.fixture(scope="module")
def small_pareto(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    """A small ``pareto`` whose times are exactly those of the model."""
    axes = {"grid": "32,48,64", "solver": "preconditioned_cg", "solver_tolerance": "1e-6,1e-8"}
    study, out = load("pareto").override(axes), tmp_path_factory.mktemp("pareto")
    run(study, out, workers=0, repeats=1, log=quiet)
    dataset = read(out / "pareto.nc").assign_attrs(cpu="here")
    times = np.array([model_times(case) for case in study.cases() if isinstance(case, Case)])
    names = tuple(axis.name for axis in study.points)
    shape = tuple(dataset.sizes[name] for name in names)
    dataset["setup_time"], dataset["solve_time"] = ((names, one.reshape(shape)) for one in times.T)
    return dataset


@pytest.mark.whole
def test_no_stored_setting_foreseen_to_meet_the_error_is_much_faster(
    small_pareto: xr.Dataset,
) -> None:
    found = verify(small_pareto)
    assert len(found.error) >= 30
    assert np.mean(found.error <= 1) >= 0.95
    assert np.max(found.slower) <= 1.3
    assert np.nanmedian(found.slower_than_luck) <= 1.3


def test_times_that_follow_the_model_are_foreseen_to_rounding(small_pareto: xr.Dataset) -> None:
    a = HERTZ.half_width
    model = CostModel(stored_timings(small_pareto, "here"))
    for mode in MODES:
        padding = padding_at("exact" if mode == LINE else mode, 12)
        grid = cs.Grid((256, 1 if mode == LINE else 256), (2.4 * a, 3.3 * a))
        case = Case(SCENE, grid, padding, SolveOptions(tolerance=1e-7))
        found = model.seconds(grid, padding, convolutions_to(1e-7, SMOOTH_CONVOLUTIONS))
        assert found == pytest.approx(sum(model_times(case)), rel=1e-3)


def test_times_of_another_machine_or_of_failed_cases_are_not_used(small_pareto: xr.Dataset) -> None:
    assert stored_timings(small_pareto, "there") == ()
    assert stored_timings(None, "here") == ()
    every = len(stored_timings(small_pareto, "here"))
    failed = small_pareto.copy(deep=True)
    failed["case_status"][{"padding": 0, "grid": 0}] = CaseStatus.FAILED
    failed["solve_time"][{"padding": 1, "grid": 0}] = 0.0
    lost = small_pareto.sizes["images"] * small_pareto.sizes["period"] * 2
    assert len(stored_timings(failed, "here")) == every - 2 * lost


def test_a_mode_has_the_name_of_its_padding_and_one_cell_along_is_a_line() -> None:
    line, square = (cs.Grid((64, along), (1.0, 1.0)) for along in (1, 64))
    assert mode_of(line, cs.ExactPeriodicity()) == "line"
    assert mode_of(square, cs.ExactPeriodicity()) == "exact"
    assert mode_of(line, cs.CircularSuperposition(3)) == "circular"
    assert mode_of(square, cs.Superposition(2)) == "superposed"
    assert mode_of(square, (cs.ZeroPadding(), cs.ZeroPadding())) == "free"


def test_the_cheapest_comes_first_and_the_runner_up_is_of_another_mode() -> None:
    found = recommend(smooth(2.4), Limits(1e-4), MODEL)
    assert found.meets
    assert found.best.mode == LINE
    assert found.best.edges is Edges.CORRECTED
    assert found.runner_up is not None
    assert found.runner_up.mode == "exact"
    assert found.runner_up.seconds > found.best.seconds
    assert max(found.best.error.total, found.runner_up.error.total) <= 1e-4


def test_where_none_can_the_best_is_the_most_accurate_within_the_limits() -> None:
    limits = Limits(1e-7, Metric.PEAK_PRESSURE, memory=1e6)
    found = recommend(smooth(2.4, "exact", "circular"), limits, MODEL)
    assert not found.meets
    assert found.affordable
    assert found.best.mode == "exact"
    assert found.best.bytes <= 1e6
    more = replace(limits, memory=1e7)
    better = recommend(smooth(2.4, "exact", "circular"), more, MODEL)
    assert better.best.error.total < found.best.error.total
    nothing = recommend(smooth(2.4), replace(limits, seconds=1e-9), MODEL)
    assert not nothing.affordable


@pytest.mark.parametrize("limits", [{"error": -1.0}, {"error": 1e-3, "seconds": 0.0}])
def test_limits_that_nothing_meets_are_refused(limits: dict[str, float]) -> None:
    with pytest.raises(cs.InvalidInput, match="above 0"):
        Limits(**limits)  # type: ignore[arg-type]
