"""Recommendations against the error they promise, and against what else is stored."""

from dataclasses import replace
from math import log2

import numpy as np
import pytest
import xarray as xr
from studies.advice.cost_model import CostModel, Fit, cost_model

import contactstudy as cs
from contactstudy.accuracy.expected_error import Edges, Metric
from contactstudy.planning.cost import padded
from studies.advice.recommendation import (
    Limits,
    Recommendation,
    RoughContact,
    SmoothContact,
    contact_of,
    recommend,
)
from studies.advice.settings_table import STORED_ERRORS
from studies.advice.verification import WHAT, verify
from studies.definitions import pareto
from studies.engine.run import run
from studies.model.case import Case
from studies.reference.line_contact import HERTZ, LINE, PADDINGS, SCENE, padding_at
from studies.registry import load
from studies.store.netcdf import read
from tests.studies.conftest import quiet

MODES = (LINE, *PADDINGS)
# a millisecond for the set-up, then in proportion to cells, images and transforms
MODEL = CostModel(
    {mode: Fit(np.array([1e-3, 1e-7, 2e-8]), np.array([1e-4, 1e-4, 2e-8])) for mode in MODES}
)


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
    cells, points = np.prod(case.grid.cells), padded(case.grid, case.padding)
    images = 1 if case.padding.window is None else len(case.padding.window)
    digits = -np.log10(case.options.tolerance)
    setup = 1e-3 + 1e-7 * cells + 2e-8 * cells * images
    return float(setup), float(1e-4 + 1e-4 * digits + 2e-8 * digits * points * log2(points))


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
    model = cost_model(small_pareto, "here")
    for mode in MODES:
        padding = padding_at("exact" if mode == LINE else mode, 12)
        grid = cs.Grid((256, 1 if mode == LINE else 256), (2.4 * a, 3.3 * a))
        expected = sum(model_times(Case(SCENE, grid, padding, cs.SolveOptions(1e-7))))
        assert model.seconds(grid, padding, 1e-7, 10) == pytest.approx(expected, rel=1e-3)


def test_times_of_another_machine_or_none_are_not_used(small_pareto: xr.Dataset) -> None:
    assert cost_model(small_pareto, "there").fits == {}
    model = cost_model(None, "here")
    grid = cs.Grid((64, 64), (1.0, 1.0))
    few, many = (
        model.seconds(grid, cs.CircularSuperposition(images), 1e-8, 10) for images in (2, 200)
    )
    assert 0 < few <= many
    # two samples serve every n
    assert len(model.samples) == 2


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
