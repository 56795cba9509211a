"""What the drawings of the paper's figures and of the paddings' price plot of numbers that are written here."""

import numpy as np
import pytest
import xarray as xr

import contactstudy as cs
from studies.definitions.line_contact import POINT_CELLS as CELLS
from studies.model.outcome import CaseStatus
from studies.report.style import percent
from tests.studies.report.drawings.drawn import (
    bands,
    caption,
    curves,
    findings,
    labelled,
    named,
    numbered,
    panels,
    rows,
    same,
    words,
)

PADDINGS = ["zero", "duplicated", "superposed", "circular", "exact"]
ERRORS = (
    "axis_pressure_error", "peak_pressure_error", "pressure_error_max", "length_variation",
    "half_width_error",
)  # fmt: skip
X = np.array([-1.2, -0.6, 0.0, 0.6, 1.2])


def paper(*images: int) -> xr.Dataset:
    axes = {"padding": PADDINGS, "images": images or (1, 6)}
    dataset = numbered(axes, *ERRORS, "iterations", "setup_time", "solve_time")
    dataset["iterations"] = (1e4 * dataset["iterations"]).round()
    offset = (np.arange(CELLS) + 0.5) * 3 / CELLS - 1.5
    along = numbered(axes | {"offset": offset}, "displacement_x", "displacement_y")
    across = numbered(axes | {"x": X}, "pressure", "pressure_min", "pressure_max")
    return dataset.merge(along).merge(across)


def test_the_displacement_stands_over_the_offset_beside_that_of_one_contact() -> None:
    dataset = paper()
    stored = dataset.isel(images=-1)
    hertz = cs.analytic.HertzPoint(load=1.0, radius=1.0, contact_modulus=1.0)
    offset = dataset["offset"].values
    inside, outside = np.abs(offset) < 1, np.abs(offset) > 1
    for ax, name in zip(panels("paper", dataset), ("x", "y"), strict=True):
        lines = labelled(ax)
        for padding in ("zero", "duplicated"):
            values = stored[f"displacement_{name}"].sel(padding=padding)
            assert same(lines.pop(f"{padding} padding"), offset, values)
        x, law = lines.pop("Hertz, one contact alone")
        assert x == pytest.approx(offset)
        # Johnson (1985), 3.42: 1 - r²/2 inside, from there the arcsine
        assert law[inside] == pytest.approx(1 - offset[inside] ** 2 / 2)
        r = np.abs(offset[outside])
        closed = ((2 - r**2) * np.arcsin(1 / r) + np.sqrt(r**2 - 1)) / np.pi
        assert law[outside] == pytest.approx(closed)
        assert not lines
    assert hertz.contact_radius == pytest.approx(0.75 ** (1 / 3))
    away = "distance from centre / contact radius"
    assert [named(ax) for ax in panels("paper", dataset)] == [
        (away, "displacement / Hertz's at the centre", "across the contact"),
        (away, "", "along the length"),
    ]
    text = caption("paper", dataset)
    # of n = 6, the second row of 120 numbers: 60 in the middle, the first at the edge
    assert "zero padding it is 0.0181 at the centre, 0.0121 at the edge across" in text
    assert "and 0.1321 at the edge along" in text
    # two rows later
    assert "duplicated padding it is 0.0421 at the centre, 0.0361 at the edge across" in text


def test_the_pressure_stands_over_the_width_and_its_error_in_per_cent_of_the_peak() -> None:
    dataset = paper()
    whole, error = panels("paper", dataset, 1)
    stored = dataset.isel(images=-1)
    hertz = np.array([0, 0.8, 1, 0.8, 0])
    lines = curves(whole)
    for name, line, wrong in zip(PADDINGS, lines, curves(error), strict=False):
        one = stored.sel(padding=name)
        assert same(line, X, one["pressure"])
        assert same(wrong, X, 100 * (one["pressure"] - hertz))
    assert same(lines[5], X, hertz)
    assert len(lines) == 6
    shown = bands(error)
    for name, band in zip(PADDINGS[1:], shown, strict=True):
        one = stored.sel(padding=name)
        wanted = [100 * (one[f"pressure_{end}"] - hertz) for end in ("min", "max")]
        assert band == pytest.approx(np.array(wanted))
    # all of the pressure, and errors of either sign up to the whole of it
    assert (whole.get_yscale(), error.get_yscale()) == ("linear", "symlog")
    assert (whole.get_ylim(), error.get_ylim()) == ((0, 1.2), (-100, 100))
    assert error.yaxis.get_transform().linthresh == 0.1  # type: ignore[attr-defined]
    text = caption("paper", dataset, 1)
    # the largest errors follow 20 others; of n = 6
    assert "zero: 0.22 %; duplicated: 0.24 %; superposed, n = 6: 0.26 %" in text


def test_the_table_of_the_paper_has_a_row_for_each_n_that_counts() -> None:
    exact, duplicated, one, six, *_, zero = rows("paper", paper())
    assert exact == (
        "exact", "0.10 %", "0.20 %", "0.30 %", "0.40 %", "0.50 %", "60", "0.007", "0.008"
    )  # fmt: skip
    assert duplicated[:3] == ("duplicated", "0.040 %", "0.14 %")
    assert (one[0], six[0]) == ("circular, n = 1", "circular, n = 6")
    assert one[1:3] == ("0.070 %", "0.17 %")
    assert six[1:3] == ("0.080 %", "0.18 %")
    assert zero[0] == "zero (not periodic)"


PERIODS = [0.6, 2.4, 4.8]


def padding(images: tuple[int, ...] = (1, 6), grid: tuple[int, ...] = (16, 64)) -> xr.Dataset:
    """Circular with six images is best of those that are cheap; exact is best of all.

    Times are 1 s, 2 s, ... in the order of the paddings, twice that for n = 6 and four times on the finer grid.
    """
    axes = {"padding": PADDINGS, "images": images, "period": PERIODS, "grid": grid}
    dataset = numbered(axes, "axis_pressure_error", "length_variation")
    dataset["axis_pressure_error"] *= -1
    order = xr.DataArray(np.arange(1.0, 6), coords={"padding": PADDINGS})
    dearer = xr.DataArray(
        [{1: 1.0, 3: 1.5, 6: 2.0}[n] for n in images], coords={"images": [*images]}
    )
    finer = xr.DataArray([n / 16 for n in grid], coords={"grid": [*grid]})
    alike = xr.DataArray([1.0, 1.0, 1.0], coords={"period": PERIODS})
    time = (order * dearer * alike * finer).transpose(*axes)
    dataset["setup_time"], dataset["solve_time"] = 0.25 * time, 0.75 * time
    window = xr.DataArray([0.5, 0.05, 0.04, 0.02, 0.0], coords={"padding": PADDINGS})
    own = xr.DataArray([{16: 8e-3, 32: 3e-3, 64: 1e-3}[n] for n in grid], coords={"grid": [*grid]})
    dataset["pressure_error_l1"] = (window / dearer**2 * alike + own).transpose(*axes)
    return dataset.assign(
        case_status=(tuple(axes), np.full(tuple(map(len, axes.values())), CaseStatus.OK))
    )


def test_the_price_is_wall_time_in_all_against_the_error_in_l1() -> None:
    dataset = padding()
    axes = panels("padding", dataset)
    assert [ax.get_title() for ax in axes] == ["period L = 0.6 a", "period L = 4.8 a"]
    for ax in axes:
        shown = labelled(ax)
        # zero with one image is the cheapest; then duplicated, superposed and circular in turn, and six images
        # of these, of which duplicated is best; exact takes 5 s, 10 s, 20 s and 40 s
        cost, error = shown["Pareto front"]
        assert cost[:4] == pytest.approx([1, 2, 3, 4])
        assert error[:4] == pytest.approx([0.508, 0.058, 0.048, 0.0205])
        assert (cost[-1], error[-1]) == pytest.approx((20, 1e-3))
        assert same(shown["exact"], [5, 20], [8e-3, 1e-3])
        assert same(shown["circular"], [4, 8, 32], [0.028, 0.013, 0.006])
        faint = [line for line in ax.lines if line.get_linestyle() == "None"]
        assert sorted(faint[3].get_xdata()) == pytest.approx([4, 8, 16, 32])
        assert sorted(faint[3].get_ydata()) == pytest.approx([0.006, 0.013, 0.021, 0.028])
    text = caption("padding", dataset)
    assert "L = 4.8 a: exact at 64 cells, L1 error 0.10 % in 20 s" in text


def test_the_error_of_the_peak_stands_over_the_reach_beside_its_law() -> None:
    dataset = padding()
    [ax] = panels("padding", dataset, 1)
    shown = labelled(ax)
    periods = np.array(PERIODS)
    stored = -dataset["axis_pressure_error"].sel(grid=64)
    for name, reach in (("zero", periods / 2), ("duplicated", periods)):
        assert same(shown[name], reach, stored.sel(padding=name, images=1))
    for name in ("superposed", "circular"):
        both = np.concatenate([1.5 * periods, 6.5 * periods])
        assert same(shown[name], both, stored.sel(padding=name).values.ravel())
    # the largest of exact periodicity, with the first n
    floor = shown["exact (grid error alone)"][1]
    assert floor == pytest.approx([float(stored.sel(padding="exact", images=1).max())] * 2)
    reach, law = shown["law a²/(8D²)"]
    assert (reach[0], reach[-1]) == pytest.approx((0.3, 6.5 * 4.8))
    assert law == pytest.approx(1 / (8 * reach**2))


def test_the_findings_of_padding_are_of_the_longest_period_and_the_finest_grid() -> None:
    which, costs = findings("padding", padding())
    # the 60th number in per cent, and 60 numbers later; 40 s with six images
    assert "At 64 x 64 cells and L = 4.8 a its axis-pressure error is 0.60 %" in which
    assert "varies along the length by 1.2 % of p_{H}; the time is 40 s" in which
    assert "duplicated: 0.24 % in 16 s; superposed, n = 6: 0.36 % in 24 s" in which
    # exact periodicity with n = 6: 10 s and 40 s
    assert "an L1 error of 0.10 % costs 40 s on one thread" in costs
    # 4 times the time for an eighth of the error: 10^(log 4 / log 8)
    assert f"one tenth of the error takes {10 ** (np.log(4) / np.log(8)):.0f} times" in costs
    assert "0.80 % at 16 cells across in 10 s; 0.10 % at 64 cells across in 40 s" in costs
    rising = padding()
    rising["pressure_error_l1"] = 0 * rising["pressure_error_l1"] + 1e-3
    assert (
        "one tenth of the error takes"
        not in findings("padding", rising)[1].partition("Measured")[0]
    )


def test_of_three_grids_and_three_n_the_last_are_said_and_drawn() -> None:
    dataset = padding((1, 3, 6), (16, 32, 64))
    which, costs = findings("padding", dataset)
    last = -dataset["axis_pressure_error"].sel(images=6, period=4.8, grid=64)
    exact, six = (percent(last.sel(padding=name)) for name in ("exact", "superposed"))
    assert words(f"At 64 x 64 cells and L = 4.8 a its axis-pressure error is {exact}") in which
    assert words(f"superposed, n = 6: {six} in 24 s") in which
    assert "costs 40 s on one thread" in costs
    assert f"one tenth of the error takes {10 ** (np.log(4) / np.log(8)):.0f} times" in costs
    [ax] = panels("padding", dataset, 1)
    stored = -dataset["axis_pressure_error"].sel(padding="zero", images=1, grid=64)
    assert same(labelled(ax)["zero"], np.array(PERIODS) / 2, stored)
    assert [named(one)[:2] for one in (ax, *panels("padding", dataset))] == [
        ("reach of the window D / half-width a", "|axis-pressure error|"),
        ("wall time, set-up and solve [s]", "L1 error of pressure"),
        ("wall time, set-up and solve [s]", ""),
    ]


def test_the_table_of_prices_has_the_cheapest_setting_for_each_target() -> None:
    table = rows("padding", padding())
    assert len(table) == 12
    assert table[4:8] == [
        ("2.4 a", "10 %", "duplicated", "16", "5.8 %", "2"),
        ("2.4 a", "1.0 %", "exact", "16", "0.80 %", "5"),
        ("2.4 a", "0.10 %", "exact", "64", "0.10 %", "20"),
        ("2.4 a", "0.020 %", "none stored; the most accurate is exact", "64", "0.10 %", "20"),
    ]


def test_one_grid_does_not_tell_what_a_digit_costs() -> None:
    costs = findings("padding", padding().isel(grid=[1]))[1]
    assert "an L1 error of 0.10 % costs 40 s on one thread. Measured: 0.10 % at 64" in costs


def test_the_largest_n_is_shown_of_any_number_of_them() -> None:
    dataset = paper(1, 3, 6)
    stored = dataset.sel(padding="superposed", images=6)
    whole, error = panels("paper", dataset, 1)
    assert same(labelled(whole)["superposed, n = 6"], X, stored["pressure"])
    assert "superposed, n = 6" in labelled(error)
    largest = 100 * float(stored["pressure_error_max"])
    assert f"superposed, n = 6: {largest:.2g} %" in caption("paper", dataset, 1)
    across, along = panels("paper", dataset)
    for ax, name in ((across, "x"), (along, "y")):
        shown = dataset[f"displacement_{name}"].sel(padding="zero", images=6)
        assert same(labelled(ax)["zero padding"], dataset["offset"], shown)
