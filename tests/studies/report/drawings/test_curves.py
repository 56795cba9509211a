"""What the drawings of period, grid and kernels plot of numbers that are written here, and their laws by hand."""

import numpy as np
import xarray as xr

from studies.model.outcome import CaseStatus
from studies.registry import load_drawing
from studies.report.style import percent
from tests.studies.report.drawings.drawn import curves, findings, named, numbered, panels, same

PADDINGS = ["zero", "duplicated", "superposed", "circular", "exact"]
IMAGES, PERIODS, CELLS = np.array([1, 6, 7]), np.array([0.6, 1.2, 4.8]), np.array([16, 32, 64])
AXES = ("padding", "images", "period", "grid")


def swept(*variables: str) -> xr.Dataset:
    return numbered(dict(zip(AXES, (PADDINGS, IMAGES, PERIODS, CELLS), strict=True)), *variables)


def test_errors_stand_over_the_period_beside_the_law_of_windows_beyond_the_contact() -> None:
    dataset = swept("axis_pressure_error", "pressure_error_max")
    dataset["axis_pressure_error"] *= -1
    peak, largest = (curves(ax) for ax in panels("period", dataset))
    stored = dataset.isel(grid=-1, images=-1)
    # then the law of each of the three windows: a^2 / (8 D^2) where D = L, 7.5 L and 7.5 L, beyond the contact
    laws, peak = peak[5:], peak[:5]
    assert same(laws[0], [1.2, 4.8], [1 / (8 * 1.2**2), 1 / (8 * 4.8**2)])
    for law in laws[1:]:
        assert same(law, PERIODS, 1 / (8 * (7.5 * PERIODS) ** 2))
    for shown, variable in ((peak, "axis_pressure_error"), (largest, "pressure_error_max")):
        for name, curve in zip(PADDINGS, shown, strict=True):
            assert same(curve, PERIODS, abs(stored[variable].sel(padding=name)))


def test_errors_stand_over_the_grid_beside_their_laws() -> None:
    names = ("axis_pressure_error", "pressure_error_l1", "pressure_error_max", "half_width_error")
    dataset = swept(*names, "corrected_error_max")
    exact = dataset["pressure_error_l1"].sel(padding="exact", images=7, period=4.8)
    dataset["pressure_error_l1"].loc[exact.coords] = [0.08, 0.08 / 2**1.5, 0.01]
    stored = dataset.isel(images=-1, period=-1)
    shown = [curves(ax) for ax in panels("grid", dataset)]
    for variable, lines in zip(names, shown, strict=True):
        if variable == "pressure_error_max":
            assert same(lines.pop(5), CELLS, stored["corrected_error_max"].sel(padding="exact"))
        for name, curve in zip(PADDINGS, lines[:5], strict=True):
            assert same(curve, CELLS, stored[variable].sel(padding=name))
    peak, l1, largest, half_width = (lines[5:] for lines in shown)
    # windows that reach 4.8 a, 7.5 and 7.5 times as far
    reaches = (4.8, 7.5 * 4.8, 7.5 * 4.8)
    assert len(peak) == 3
    for law, reach in zip(peak, reaches, strict=True):
        assert same(law, CELLS, [1 / (8 * reach**2)] * 3)
    # through the three errors, which keep to it, in the mean of their logarithms
    assert same(l1[0], CELLS, 0.08 * (CELLS / 16) ** -1.5)
    middle = np.exp(np.log(stored["pressure_error_max"].sel(padding="exact")).mean())
    assert same(largest[0], CELLS, float(middle) * (CELLS / 32) ** -0.5)
    assert same(half_width[0], CELLS, (2.4 / CELLS) ** 3 / 50)


def test_the_finding_of_the_grid_is_of_exact_periodicity_over_the_longest_period() -> None:
    """L1 errors of 0.008, 0.008 / 2^1.5 and 0.001, the largest ones half a power of two apart."""
    dataset = swept("pressure_error_l1", "pressure_error_max", "setup_time", "solve_time")
    dataset["case_status"] = (AXES, np.full(dataset["setup_time"].shape, CaseStatus.OK))
    last = {"padding": "exact", "images": 7, "period": 4.8}
    dataset["pressure_error_l1"].loc[last] = [0.008, 0.008 / 2**1.5, 0.001]
    dataset["pressure_error_max"].loc[last] = 0.2 * (CELLS / 16) ** -0.5
    dataset["setup_time"].loc[last], dataset["solve_time"].loc[last] = [1, 2, 3], [2, 3, 25]
    [said] = findings("grid", dataset)
    assert said.startswith("64 cells across 2.4 a for 0.1 %")
    assert "like N^{−1.50}, from 0.80 % at 16 cells across in 3 s to 0.10 % at 64 in 28 s" in said
    assert "like N^{−0.50} and not monotonically: it is 10 % of p_{H} at 64" in said
    # in any order, and where no grid is fine enough
    dataset["pressure_error_l1"].loc[last] *= 1.5
    [said] = findings("grid", dataset.isel(grid=[2, 0, 1]))
    assert said.startswith("More than 64 cells across")
    assert not findings("grid", dataset.isel(grid=[0, 2]))


def test_errors_of_kernels_stand_over_n_and_a_half_beside_their_law() -> None:
    dataset = swept("kernel_error", "setup_time").sel(padding=PADDINGS[1:])
    dataset["kernel_error"].loc[{"padding": "exact"}] = 0.0
    half = IMAGES + 0.5
    for ax, period in zip(panels("kernels", dataset), PERIODS, strict=True):
        *errors, law = curves(ax)
        for name, curve in zip(("duplicated", "superposed", "circular"), errors, strict=True):
            stored = dataset["kernel_error"].sel(padding=name, period=period, grid=64)
            assert same(curve, half, stored)
        assert same(law, half, (1.44 + period**2 / 8) / (2 * (half * period) ** 2))
        assert ax.get_title() == f"period L = {period:g} a"
    [times] = panels("kernels", dataset, 1)
    *measured, law = curves(times)
    stored = dataset["setup_time"].sel(period=4.8, grid=64)
    for name, curve in zip(PADDINGS[1:], measured, strict=True):
        assert same(curve, half, stored.sel(padding=name))
    last, six = (float(stored.sel(padding="superposed", images=images)) for images in (7, 6))
    assert same(law, half, last * half / 7.5)
    caption = load_drawing("kernels").figure(dataset)[1].caption
    # a setting that is said to be so
    dataset["setup_time"].loc[{"padding": "superposed", "images": 6}] *= 3
    ratio = 3 * six / float(stored.sel(padding="exact", images=1))
    caption = load_drawing("kernels").figure(dataset)[1].caption
    assert f"Superposed, n = 6, takes {ratio:.2g} times as long as exact periodicity" in caption
    assert "for 64 x 64 cells and L = 4.8 a" in caption
    first, *others = (named(ax) for ax in panels("kernels", dataset))
    assert first[:2] == (
        "n + ½  (n periods on each side)",
        "error of the logarithm in the coefficients",
    )
    assert all(y == "" for _, y, _ in others)


def test_errors_of_images_stand_over_n_and_a_half_and_fall_with_its_square() -> None:
    dataset = swept("axis_pressure_error", "length_variation")
    dataset["axis_pressure_error"] *= -1
    half = IMAGES + 0.5
    for ax, period in zip(panels("images", dataset), PERIODS, strict=True):
        *errors, law = curves(ax)
        for name, curve in zip(PADDINGS, errors, strict=True):
            stored = dataset["axis_pressure_error"].sel(padding=name, period=period, grid=64)
            assert same(curve, half, -stored)
        assert same(law, half, 1 / (8 * (half * period) ** 2))
    said = [named(ax) for ax in panels("images", dataset)]
    assert [y for _, y, _ in said] == ["|axis-pressure error|", "", ""]
    assert [title for *_, title in said] == [f"period L = {period:g} a" for period in PERIODS]
    [variation] = panels("images", dataset, 1)
    for number, period in enumerate(PERIODS):
        measured, law = curves(variation)[2 * number : 2 * number + 2]
        stored = dataset["length_variation"].sel(padding="superposed", period=period, grid=64)
        assert same(measured, half, stored)
        # through the middle one of all n
        assert same(law, half, float(stored[1]) * (6.5 / half) ** 2)


def test_n_is_enough_where_it_and_all_larger_ones_meet_a_thousandth() -> None:
    images, periods = [0, 1, 2, 6], [0.6, 2.4]
    error = np.zeros((4, 4, 2, 1))
    # circular: the second n meets it by chance at the first period, none at the other
    error[0, :, :, 0] = np.transpose([[5e-3, 1e-4, 2e-3, 1e-3], [9e-3, 8e-3, 7e-3, 6e-3]])
    error[1] = -2e-5  # exact
    error[2] = 0.02  # duplicated
    error[3, :, 1, 0] = [0.05, 0.02, 0.01, -5e-4]  # superposed
    error[3, :, 0, 0] = 0.03
    axes = {"padding": ["circular", "exact", "duplicated", "superposed"], "images": images}
    dataset = xr.Dataset(
        {
            "axis_pressure_error": (AXES, error),
            "peak_pressure_error": (AXES, np.full(error.shape, 0.016)),
            "length_variation": (AXES, np.full(error.shape, 0.017)),
            "case_status": (AXES, np.full(error.shape, CaseStatus.OK)),
        },
        coords={**axes, "period": periods, "grid": [64]},
    )
    dataset["length_variation"].loc[{"padding": "duplicated"}] = 1e-16
    which, six = (
        one.measured.replace("\u00a0", " ") for one in load_drawing("images").findings(dataset)
    )
    assert "needs n = 6 at L = 0.6 a, a larger n than stored at L = 2.4 a" in which
    assert "exact periodicity is at most 0.0020 %" in which
    assert "2.0 % with duplicated padding and 0.050 % with n = 6, a factor of 40" in six
    assert "varies by 1.7 % of p_{H} and exceeds p_{H} nowhere by more than 1.6 %" in six
    assert "with duplicated padding it varies by rounding only" in six
    caption = load_drawing("images").figure(dataset)[0].caption.replace("\u00a0", " ")
    # from the n on at which superposition stays below duplicated padding
    assert "more accurate than duplicated padding at L = 2.4 a from n = 2 on (2.0 %)" in caption
    assert "L = 0.6 a from" not in caption


def test_the_findings_of_the_period_are_of_the_finest_grid_and_the_largest_n() -> None:
    dataset = swept("axis_pressure_error")
    dataset["case_status"] = (AXES, np.full(dataset["axis_pressure_error"].shape, CaseStatus.OK))
    stored = dataset["axis_pressure_error"].isel(grid=-1, images=-1)
    assert len(load_drawing("period").findings(dataset.isel(period=[0, 2]))) == 2
    ends = [percent(stored.sel(padding="zero", period=period)) for period in (0.6, 4.8)]
    text = load_drawing("period").figure(dataset.assign(pressure_error_max=stored))[0].caption
    assert f"zero: {ends[0]} at L = 0.6 a, {ends[1]} at 4.8 a" in text
    first, second = (finding.measured for finding in load_drawing("period").findings(dataset))
    shown = {name: [percent(one) for one in stored.sel(padding=name)] for name in PADDINGS}
    assert (
        f"a period of 0.6 a, or a single row of cells, with an error of {shown['exact'][-1]}"
        in first
    )
    assert f"duplicated padding is {shown['duplicated'][-1]} at L = 4.8 a" in first
    (short, _, long), (near, _, far) = shown["duplicated"], shown["superposed"]
    assert "Between L = 0.6 a and L = 4.8 a" in second
    assert (
        f"from {short} to {long} with duplicated and from {near} to {far} with superposed" in second
    )
    # two steps along the axis, of which each is three of the numbers
    assert f"with exact periodicity it changes by {percent(6e-4)}" in second
