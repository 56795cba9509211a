"""Rough contacts by padding: a window of images has the same law as on a smooth surface, which is Hertz's."""

from math import pi

import pytest
import xarray as xr

from studies.definitions.roughness import case_at, measures
from studies.registry import load

POINT = {
    "rms": 0.1, "hurst": 0.8, "peklenik": 1.0, "seed": 1, "images": 6, "period": 2.4, "grid": 80,
}  # fmt: skip


def sweeps_with_estimates(**changed: float) -> xr.Dataset:
    """What one surface gives, by padding; on a grid half as fine as the study's."""
    comparison = case_at(POINT | changed)
    return xr.Dataset(measures(comparison, comparison.run(comparison.prepare())))


@pytest.fixture(scope="module")
def by_images() -> dict[tuple[float, int], xr.Dataset]:
    return {
        (rms, images): sweeps_with_estimates(rms=rms, images=images)
        for rms in (0.0, 0.3)
        for images in (2, 6)
    }


@pytest.mark.parametrize("rms", [0.0, 0.3])
def test_the_error_falls_with_the_square_of_the_reach_on_any_surface(
    rms: float, by_images: dict[tuple[float, int], xr.Dataset]
) -> None:
    two, six = (by_images[rms, images].sel(padding="circular") for images in (2, 6))
    ratio = (6.5 / 2.5) ** 2
    for error in ("pressure_error_l1", "half_width_error"):
        # the law's next term is (a/D)² of it, 3 % at n = 2
        assert float(two[error] / six[error]) == pytest.approx(ratio, rel=0.06)


def test_a_window_is_a_more_curved_cylinder_on_any_surface(
    by_images: dict[tuple[float, int], xr.Dataset],
) -> None:
    smooth, rough = (by_images[rms, 6].sel(padding="circular") for rms in (0.0, 0.3))
    left = [float(one["curved_difference"] / one["pressure_error_l1"]) for one in (smooth, rough)]
    assert left[0] < 2 * (1 / 15.6) ** 2  # the law's next term
    # an uneven load moves with the window: beyond it lacks a fraction of the spread, times (L / 2 pi a)²
    assert left[1] < float(rough["load_spread"]) * (2.4 / (2 * pi)) ** 2 * 2


def test_zero_padding_ends_the_length_and_exact_errs_nowhere() -> None:
    found = sweeps_with_estimates()
    exact, zero = found.sel(padding="exact"), found.sel(padding="zero")
    errors = "pressure_error_l1", "half_width_error", "pressure_error_max", "curved_difference"
    assert all(float(exact[error]) == 0 for error in errors)
    assert float(zero["peak_pressure_error"]) > 0.1  # the pressure of a free end
    assert (found["converged"] == 1).all()


def test_roughness_takes_area_and_spreads_the_load() -> None:
    smooth, rough, across = (
        sweeps_with_estimates(rms=rms, peklenik=lay).sel(padding="exact")
        for rms, lay in ((0.0, 1.0), (0.1, 0.5), (0.1, 2.0))
    )
    assert float(rough["contact_area"]) < float(smooth["contact_area"])
    assert float(rough["half_width"]) > float(smooth["half_width"])
    # ridges across the length take the load from what lies between them, ridges along it less so
    assert float(across["load_spread"]) > 1.5 * float(rough["load_spread"])


def test_answers_of_a_smooth_contact_are_hertz_s() -> None:
    exact = sweeps_with_estimates(rms=0.0).sel(padding="exact")
    cell = 3.2 / 80  # in half-widths
    assert float(exact["contact_area"]) == pytest.approx(1, abs=2 * cell)
    assert float(exact["contact_extent"]) == pytest.approx(1, abs=cell)
    # the second moment of cells of constant pressure, a twelfth of a cell squared off, and its edge
    assert float(exact["half_width"]) == pytest.approx(1, abs=cell**1.5)
    assert float(exact["peak_pressure"]) == pytest.approx(1, abs=cell**2)
    assert float(exact["load_spread"]) == pytest.approx(0, abs=1e-7)
    assert float(exact["smooth_difference"]) == pytest.approx(0, abs=1e-6)


def test_without_roughness_all_choices_are_one_case() -> None:
    study = load("roughness").override({"rms": "0,0.1", "seed": "1,2"})
    smooth = len(study.cases()) // 2
    assert len(set(study.cases())) == 1 + smooth
