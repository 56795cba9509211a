"""The verdict on settings, by hand."""

from math import inf, nan
from pathlib import Path

import pytest

import contactstudy as cs
from studies.advice.comparison import Comparison, Measured, PaddingError, label_of, with_envelope
from studies.advice.stored import as_text, from_dataset, from_text, to_dataset
from studies.advice.subject import Setting

EXACT, COPIED, ZERO = cs.ExactPeriodicity(), cs.DuplicatedPadding(), cs.ZeroPadding()


def one(
    padding: cs.Padding, cells: int, error: float, times: tuple[float, ...], *, bounded: bool = True
) -> Measured:
    setting = Setting(padding, (cells, cells), 1e-4)
    return Measured(setting, label_of(padding), error, bounded, times[:1], times)


def of(*settings: Measured, floor: float = 0.0, error: float = 0.03) -> Comparison:
    return Comparison(
        name="hand", text="", extent=(1e-3, 1e-3), own=EXACT, error=error, floor=floor, reference=(96, 96),
        bounds={"pressure_l1": floor, "peak_pressure": inf}, paddings=(PaddingError(COPIED, 0.02, {"mean_gap": 0.1}),),
        paddings_on=(48, 48), tolerances={1e-2: 1e-3}, settings=settings, notes=("A note.",), spent=3.0,
    )  # fmt: skip


def test_a_tie_goes_to_the_boundary_of_the_scene_itself() -> None:
    # always 5 % quicker, which is clear and not worth it
    verdict = of(one(EXACT, 32, 0.02, (1.0,) * 15), one(COPIED, 32, 0.02, (0.95,) * 15)).verdict()
    assert verdict is not None
    assert verdict.best.label == "exact"
    (rival,) = verdict.rivals
    assert rival.is_tie
    assert rival.ratio == pytest.approx(0.95)


def test_another_padding_is_chosen_if_it_is_quicker_by_more_than_a_tenth_in_nearly_all_rounds() -> (
    None
):
    exact = one(EXACT, 32, 0.02, (1.0,) * 15)
    verdict = of(exact, one(COPIED, 32, 0.02, (0.8,) * 15)).verdict()
    assert verdict is not None
    assert verdict.best.label == "duplicated"
    # the same median ratio from three rounds decides nothing
    verdict = of(one(EXACT, 32, 0.02, (1.0,) * 3), one(COPIED, 32, 0.02, (0.8,) * 3)).verdict()
    assert verdict is not None
    assert verdict.best.label == "exact"


def test_the_bound_on_the_reference_is_added_to_every_error() -> None:
    fine, coarse = one(EXACT, 48, 0.015, (2.0,) * 9), one(EXACT, 32, 0.025, (1.0,) * 9)
    for floor, cells in ((0.004, 32), (0.006, 48)):
        verdict = of(coarse, fine, floor=floor).verdict()
        assert verdict is not None
        assert verdict.meets
        assert verdict.best.setting.cells == (cells, cells)
    assert verdict is not None
    assert verdict.coarser == coarse


def test_a_grid_that_nothing_bounds_is_never_recommended() -> None:
    hollow = one(EXACT, 16, 0.01, (0.5,) * 9, bounded=False)
    verdict = of(hollow, one(EXACT, 32, 0.02, (1.0,) * 9)).verdict()
    assert verdict is not None
    assert verdict.best.setting.cells == (32, 32)


def test_without_a_bound_on_the_reference_nothing_is_said_to_meet_a_request() -> None:
    verdict = of(one(EXACT, 32, 0.001, (1.0,) * 9), floor=inf).verdict()
    assert verdict is not None
    assert not verdict.meets


def test_the_error_of_a_grid_is_the_largest_of_it_and_of_all_finer_ones() -> None:
    assert with_envelope([0.08, 0.14, 0.06]) == [0.14, 0.14, 0.06]


def test_a_comparison_is_read_as_it_was_stored(tmp_path: Path) -> None:
    measured = of(one(EXACT, 32, 0.02, (1.0, 2.0)), one(COPIED, 48, 0.02, (1.5,)))
    dataset = to_dataset(measured)
    dataset.to_netcdf(tmp_path / "settings.nc")
    import xarray as xr

    with xr.open_dataset(tmp_path / "settings.nc") as read:
        assert from_dataset(read.load()) == measured


@pytest.mark.parametrize(
    "padding", [EXACT, (ZERO, ZERO), cs.CircularSuperposition(6), (EXACT, EXACT)]
)
def test_a_padding_survives_as_text(padding: cs.Padding | cs.Paddings) -> None:
    assert from_text(as_text(padding)) == padding


def test_times_outside_of_rounds_count_where_there_are_no_rounds() -> None:
    assert Measured(Setting(EXACT, (2, 2), 1e-4), "exact", 0.1, True, (1.0, 3.0, 2.0)).time == 2.0  # noqa: FBT003
    assert one(EXACT, 2, 0.1, (nan, 4.0, 6.0)).time == 5.0
