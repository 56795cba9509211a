"""Seconds of a setting by hand: sums of terms, samples between which images are a straight line, fits."""

from math import log2

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from contactstudy.planning.cost import SMOOTH_ITERATIONS, Timed
from studies.advice import cost_model as module
from studies.advice.cost_model import CostModel, Fit, cost_model, mode_of
from studies.model.outcome import CaseStatus

GRID = cs.Grid((64, 32), (1.0, 1.0))
CIRCULAR = cs.CircularSuperposition(3)
FIT = Fit(np.array([0.1, 1e-3, 1e-5]), np.array([0.2, 1e-2, 1e-6]))
# twice as wide, for a free width
POINTS = 128 * 32


def test_a_fit_is_a_sum_of_cells_images_digits_and_transforms() -> None:
    set_up = 0.1 + 1e-3 * 64 * 32 + 1e-5 * 64 * 32 * 7
    solve = 0.2 + 1e-2 * 6 + 1e-6 * 6 * POINTS * log2(POINTS)
    assert FIT.seconds(GRID, CIRCULAR, 1e-6, 1.0) == pytest.approx(set_up + solve)
    assert FIT.seconds(GRID, CIRCULAR, 1e-6, 3.0) == pytest.approx(set_up + 3 * solve)
    # all images in closed form count as one
    one = 0.1 + 1e-3 * 64 * 32 + 1e-5 * 64 * 32
    assert FIT.seconds(GRID, cs.ExactPeriodicity(), 1e-6, 1.0) == pytest.approx(one + solve)
    model = CostModel({"circular": FIT})
    assert model.seconds(GRID, CIRCULAR, 1e-6, 3 * SMOOTH_ITERATIONS) == pytest.approx(
        set_up + 3 * solve
    )


def test_a_mode_has_the_name_of_its_padding_and_one_cell_along_is_a_line() -> None:
    line = cs.Grid((64, 1), (1.0, 1.0))
    assert mode_of(line, cs.ExactPeriodicity()) == "line"
    assert mode_of(GRID, cs.ExactPeriodicity()) == "exact"
    assert mode_of(line, CIRCULAR) == "circular"
    assert mode_of(GRID, cs.Superposition(2)) == "superposed"
    assert mode_of(GRID, (cs.ZeroPadding(), cs.ZeroPadding())) == "free"


def test_without_a_fit_one_and_six_images_are_timed_and_others_lie_on_their_line(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    timed = []

    def time(grid: cs.Grid, padding: cs.CircularSuperposition) -> Timed:
        timed.append(padding)
        return Timed(2048, 4096, 1.0 + 0.5 * getattr(padding, "images", 0), 0.01)

    monkeypatch.setattr(module, "timed", time)
    seen = []
    monkeypatch.setattr(
        Timed, "seconds", lambda self, *words: seen.append((self.setup, words)) or 7.0
    )
    model = CostModel({})
    assert model.seconds(GRID, cs.CircularSuperposition(11), 1e-6, 40.0) == 7.0
    assert timed == [cs.CircularSuperposition(1), cs.CircularSuperposition(6)]
    # 1.5 s for one, 4 s for six; iterations are counted to eight digits
    [(set_up, words)] = seen
    assert set_up == pytest.approx(1.5 + 0.5 * 10)
    assert words == (GRID, cs.CircularSuperposition(11), pytest.approx(30.0))
    model.seconds(GRID, cs.CircularSuperposition(0), 1e-8, 40.0)
    assert seen[-1][0] == pytest.approx(1.0)
    assert len(timed) == 2
    model.seconds(GRID, cs.ExactPeriodicity(), 1e-8, 40.0)
    # on one cell along another sample
    model.seconds(cs.Grid((64, 1), (1.0, 1.0)), cs.ExactPeriodicity(), 1e-8, 40.0)
    assert len(timed) == 4
    # and more cells along are more of the same
    for along in (2, 64):
        model.seconds(cs.Grid((64, along), (1.0, 1.0)), cs.ExactPeriodicity(), 1e-8, 40.0)
    assert len(timed) == 4


@pytest.mark.parametrize(
    ("few", "many", "images", "wanted"),
    [
        # more images are never quicker
        (3.0, 1.0, 11, 3.0),
        # and no set-up takes less than no time
        (0.5, 5.5, 0, 0.0),
    ],
)
def test_a_line_through_two_samples_neither_falls_nor_goes_below_nothing(
    few: float, many: float, images: int, wanted: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def time(_: cs.Grid, padding: cs.CircularSuperposition) -> Timed:
        return Timed(2048, 4096, few if padding.images == 1 else many, 0.01)

    monkeypatch.setattr(module, "timed", time)
    timed = CostModel({})._timed("circular", GRID, cs.CircularSuperposition(images))
    assert timed.setup == wanted


def stored(tolerances: list[float]) -> xr.Dataset:
    """Times of a made-up fit, on three grids at one n, with failed and untimed cases among them."""
    axes = ("padding", "images", "period", "grid", "solver_tolerance", "solver")
    grids = [16, 32, 64, 128]
    shape = (2, 1, 1, 4, len(tolerances), 2)
    dataset = xr.Dataset(
        {name: (axes, np.zeros(shape)) for name in ("setup_time", "solve_time")}
        | {"case_status": (axes, np.full(shape, CaseStatus.OK))},
        coords={
            "padding": ["circular", "line"],
            "images": [3],
            "period": [2.0],
            "grid": grids,
            "solver_tolerance": tolerances,
            "solver": ["preconditioned_cg", "polonsky_keer"],
        },
        attrs={"cpu": "here"},
    )
    for n, cells in enumerate(grids):
        for k, tolerance in enumerate(tolerances):
            for m, along in enumerate((cells, 1)):
                points, images, digits = 2 * cells * along, (7, 1)[m], -np.log10(tolerance)
                dataset["setup_time"][m, 0, 0, n, k] = (
                    0.1 + 1e-3 * cells * along + 1e-5 * cells * along * images
                )
                dataset["solve_time"][m, 0, 0, n, k] = (
                    0.2 + 1e-2 * digits + 1e-6 * digits * points * log2(points)
                )
    # the other solver is not asked
    dataset["solve_time"][..., 1] *= 50
    return dataset


def test_a_fit_finds_the_terms_that_made_its_times_and_leaves_out_failed_cases() -> None:
    dataset = stored([1e-4, 1e-8])
    dataset["case_status"][0, 0, 0, 1, 0, 0] = CaseStatus.FAILED
    dataset["setup_time"][0, 0, 0, 1, 0, 0] = 1e3
    dataset["solve_time"][0, 0, 0, 2, 1, 0] = 0.0
    fits = cost_model(dataset, "here").fits
    # at one n the cells and the cells times images are one term
    for mode, padding, along in (("circular", CIRCULAR, 256), ("line", cs.ExactPeriodicity(), 1)):
        grid = cs.Grid((256, along), (1.0, 2.0))
        found = fits[mode].seconds(grid, padding, 1e-6, 1.0)
        assert found == pytest.approx(FIT.seconds(grid, padding, 1e-6, 1.0), rel=1e-6)
    assert not cost_model(dataset, "there").fits
    assert not cost_model(None, "here").fits


def test_three_times_are_too_few_for_a_fit() -> None:
    assert set(cost_model(stored([1e-6]), "here").fits) == {"circular", "line"}
    assert not cost_model(stored([1e-6]).isel(grid=[0, 1, 2]), "here").fits
