"""What the drawings of time, memory and accuracy plot and say of numbers that are written here."""

import numpy as np
import pytest
import xarray as xr

from studies.definitions.effect_cost import YIELD
from studies.model.outcome import CaseStatus
from studies.report.drawings.pareto import DECADES, decades, dominated_modes, savings
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

CELLS = np.array([16, 32, 128])


def solved(dataset: xr.Dataset, *axes: str) -> xr.Dataset:
    """All cases came to an end."""
    shape = [dataset.sizes[axis] for axis in axes]
    return dataset.assign(case_status=(axes, np.full(shape, CaseStatus.OK)))


def solvers() -> xr.Dataset:
    """Times grow like N^1 to N^3 with one solver and like N^2 to N^3 with the other, from 1 s and 4 s."""
    axes = {
        "solver": ["preconditioned_cg", "polonsky_keer"],
        "surface": ["smooth", "wavy", "rough"],
        "grid": CELLS,
    }
    dataset = numbered(axes, "iterations", "convolutions", "memory")
    dataset["iterations"] = (1e4 * dataset["iterations"]).round()
    power = np.array([[1, 2, 3], [2, 2.5, 3]])[..., None]
    start = np.array([1, 4])[:, None, None]
    dataset["solve_time"] = tuple(axes), start * (CELLS / 16.0) ** power
    dataset["memory"] = 1e4 * dataset["memory"]
    return solved(dataset, *axes)


def test_what_a_solver_takes_stands_over_the_grid_beside_the_square() -> None:
    dataset = solvers()
    for ax, variable in zip(
        panels("solvers", dataset), ("solve_time", "iterations", "convolutions"), strict=True
    ):
        lines = curves(ax)
        stored = dataset[variable].stack(line=("solver", "surface")).transpose("line", "grid")
        for line, values in zip(lines, stored, strict=False):
            assert same(line, CELLS, values)
        assert len(lines) == 6 + (variable == "solve_time")
        if variable == "solve_time":
            assert same(lines[6], CELLS, [1, 4, 64])
    text = caption("solvers", dataset)
    assert "At 128 x 128 cells" in text
    # at the finest grid: every third of the numbers
    assert (
        "preconditioned CG: 3 to 9 iterations, 8 to 5.1e+02 s, growing like N^{1.0} to N^{3.0}"
        in text
    )
    # the numbers of both solvers follow 36 others
    assert "at most 45 fields of memory" in text
    assert "at most 54 fields of memory" in text
    assert "Polonsky & Keer: 12 to 18 iterations, 2.6e+02 to 2e+03 s, growing like N^{2.0}" in text
    [said] = findings("solvers", dataset)
    # 4 * 8^1, 4 * 8^0.5 and 4 times as long
    assert "4.0 to 32.0 times faster" in said
    assert "wavy: 6 iterations in 64 s against 15 iterations in 7.2e+02 s" in said
    assert not findings("solvers", dataset.isel(solver=[0]))
    # two grids tell a growth, and one does not
    assert "growing like N^{1.0}" in caption("solvers", dataset.isel(grid=[0, 1]))
    assert "growing" not in caption("solvers", dataset.isel(grid=[2]))


def speed(device: str = "cpu") -> xr.Dataset:
    axes = {
        "surface": ["rough", "self-affine"],
        "hurst": [0.2, 0.8],
        "cut_off": [2.0],
        "share": [0.2],
        "precision": ["double"],
        "device": [device],
        "threads": [1, 2],
        "grid": CELLS,
    }
    names = ("solve_time", "iterations", "transform_ratio", "contact_share", "memory")
    dataset = numbered(axes, *names)
    dataset["iterations"] = (1e4 * dataset["iterations"]).round()
    dataset["transform_ratio"] *= 1e3
    dataset["memory"] *= 1e4
    return solved(dataset, *axes)


def test_the_speed_of_each_surface_stands_over_the_grid_by_threads() -> None:
    dataset = speed()
    axes = panels("speed", dataset)
    shown = [labelled(ax) for ax in axes]
    rough = {"surface": "rough", "hurst": 0.2}
    where = {"rough": rough} | {
        f"self-affine, H = {hurst:g}": {"surface": "self-affine", "hurst": hurst}
        for hurst in (0.2, 0.8)
    }
    for ax, lines, variable in zip(
        axes, shown, ("solve_time", "iterations", "transform_ratio"), strict=True
    ):
        stored = dataset[variable].squeeze(("cut_off", "share", "precision", "device"), drop=True)
        counts = {", 1 thread": 1, ", 2 threads": 2}
        if variable == "iterations":
            del counts[", 2 threads"]
        for name, chosen in where.items():
            for words_of, threads in counts.items():
                line = lines.pop(f"{name}{words_of}")
                assert same(line, CELLS, stored.sel(chosen | {"threads": threads}))
        law = lines.pop("N²", None)
        assert (ax.get_yscale() == "log") == (variable == "solve_time")
        assert not lines
        if variable == "solve_time":
            assert law is not None
            # the numbers rise by 1e-4: the first of all is the least on the coarsest grid
            assert same(law, CELLS, [1e-4, 4e-4, 64e-4])
    text = caption("speed", dataset)
    # of one thread on the finest grid: the 3rd, 15th and 21st number of 24 of each variable
    assert "rough: 27 iterations in 0.0003 s, 0.75 % in contact, 99 fields of memory" in text
    assert "H = 0.8: 45 iterations in 0.0021 s, 0.93 % in contact" in text
    assert "waves down to 2 cells of every grid. At 128 x 128 cells, on 1 thread" in text
    assert "on a graphics processor" in caption("speed", speed("gpu"))


def test_precisions_and_devices_are_named_where_there_are_several() -> None:
    dataset = speed().squeeze(("precision", "device"), drop=True)
    single = dataset.expand_dims(precision=["double", "single"])
    both = single.expand_dims(device=["cpu", "gpu"]).isel(hurst=[0])
    shown = labelled(panels("speed", both)[0])
    ways = ("cpu, 1 thread", "cpu, 2 threads", "gpu")
    wanted = {f"rough, {size}, {on}" for size in ("double", "single") for on in ways}
    assert {name for name in shown if name.startswith("rough")} == wanted
    assert findings("speed", speed().isel(grid=[0, 2]))


def test_of_three_numbers_of_threads_the_first_and_the_last_are_compared() -> None:
    four = speed().isel(threads=[0]).assign_coords(threads=[4])
    four["solve_time"] = four["solve_time"] / 2.5
    [said] = findings("speed", xr.concat([speed(), four], "threads"))
    assert "is 2.5 to 2.5 times as fast on 4 threads as on 1 thread" in said


def test_the_speed_is_said_from_the_coarsest_grid_to_the_finest() -> None:
    [said] = findings("speed", speed())
    # 27 over 25 of the first surface is the largest growth
    assert (
        "From 16 to 128 cells across, the number of iterations grows by a factor of at most 1.1."
        in said
    )
    assert "rough: 25 to 27" in said
    assert "H = 0.8: 43 to 45" in said
    # 5.1 of the first to 6.9 of the last on one thread
    assert "a solve takes 5.1 to 6.9 times the time of its bare transforms" in said
    # 3 / 6 to 21 / 24 of the time, over all surfaces
    assert "is 0.5 to 0.9 times as fast on 2 threads as on 1 thread" in said
    assert "times as fast" not in findings("speed", speed("gpu"))[0]
    assert "times as fast" not in findings("speed", speed().isel(threads=[0]))[0]
    assert not findings("speed", speed().isel(grid=[0]))


def test_programs_are_drawn_by_the_time_of_set_up_and_solve() -> None:
    axes = {
        "program": ["contactstudy", "tamaas"],
        "boundary": ["semi-periodic", "free"],
        "threads": [1, 4],
        "grid": CELLS,
    }
    dataset = numbered(axes, "setup_time", "solve_time", "difference")
    dataset["solve_time"].loc[{"program": "tamaas", "boundary": "semi-periodic"}] = np.nan
    # larger on the coarser grids
    dataset["difference"] *= xr.DataArray([100.0, 10.0, 1.0], coords={"grid": CELLS})
    said = [named(ax) for ax in panels("peers", dataset)]
    assert said == [
        ("cells across and along", "wall time, set-up and solve [s]", "semi-periodic"),
        ("cells across and along", "", "free"),
    ]
    first, second = (labelled(ax) for ax in panels("peers", dataset))
    assert list(first) == ["contactstudy, 1 thread", "contactstudy, 4 threads"]
    assert list(second) == [*first, "tamaas, 1 thread", "tamaas, 4 threads"]
    total = dataset["setup_time"] + dataset["solve_time"]
    for boundary, lines in (("semi-periodic", first), ("free", second)):
        for label, line in lines.items():
            program, _, count = label.partition(", ")
            chosen = {"program": program, "boundary": boundary, "threads": int(count[0])}
            assert same(line, CELLS, total.sel(chosen))
    text = caption("peers", dataset)
    assert "Total time on 1 thread or 4 threads. At 128 cells" in text
    # the third of the set-up and of the solve, 24 numbers later; the third of the differences
    assert "semi-periodic, contactstudy, 1 thread 0.003 s with a difference of 5e-03" in text
    one = labelled(panels("peers", dataset.isel(threads=[0]))[0])
    assert list(one) == ["contactstudy"]


def effects() -> xr.Dataset:
    """Half of the set-up of one cell along, and a quarter of its solve."""
    names = ["smooth, 1-D", "smooth, 2-D", "waviness", "one step of wear", YIELD]
    axes = {"effect": names, "grid": [64, 128, 256]}
    dataset = numbered(axes, "setup_time", "solve_time", "memory", "iterations", "convolutions")
    for name in ("memory", "iterations", "convolutions"):
        dataset[name] = (dataset[name] * 1e4).round()
    dataset["setup_time"].loc[{"grid": 256}] = [1.0, 2.0, 3.0, 4.0, 5.0]
    dataset["solve_time"].loc[{"grid": 256}] = [0.25, 1.0, 7.0, 8.0, 9.0]
    return dataset


def test_effects_are_bars_of_the_finest_grid_with_their_numbers() -> None:
    dataset = effects()
    time, *others = panels("effect_cost", dataset)
    set_up, solve = np.array([1.0, 2, 3, 4, 5]), np.array([0.25, 1, 7, 8, 9])
    bars = [
        (bar.get_x(), bar.get_width(), bar.get_y() + bar.get_height() / 2) for bar in time.patches
    ]
    place = np.arange(5.0)
    assert np.array(bars[:5]) == pytest.approx(np.transpose([0 * place, set_up, place]))
    assert np.array(bars[5:]) == pytest.approx(np.transpose([set_up, solve, place]))
    ends = [(text.get_position(), text.get_text()) for text in time.texts]
    assert [place for place, _ in ends] == [*zip(set_up + solve, place, strict=True)]
    assert [text for _, text in ends] == [" 1.2", " 3", " 10", " 12", " 14"]
    for ax, name in zip(others, ("memory", "iterations", "convolutions"), strict=True):
        stored = dataset[name].sel(grid=256).values
        assert [bar.get_width() for bar in ax.patches] == stored.tolist()
        assert [text.get_text() for text in ax.texts] == [f" {value:.0f}" for value in stored]
        assert [text.get_position() for text in ax.texts] == [*zip(stored, place, strict=True)]
    assert [label.get_text() for label in time.get_yticklabels()] == [
        "smooth, 1-D", "smooth, 2-D", "+ waviness", "one step of wear", YIELD
    ]  # fmt: skip
    text = caption("effect_cost", dataset)
    assert "256 x 64 cells over 3.6 a x 0.9 a (256 x 1 for the first)" in text
    # 1.25 s over 3 s
    assert "in 42 % of the time" in text
    assert "one cell along and 64 across" in text
    assert "Creep and wear are alone" in text
    assert "of the time" in caption("effect_cost", dataset.isel(effect=[0, 1]))
    few = caption("effect_cost", dataset.isel(effect=[0, 2]))
    assert "of the time" not in few
    assert "Creep and wear" not in few
    assert "Yield is alone" not in few


PERIODS, TOLERANCES = [0.6, 2.4, 9.6], [1e-4, 1e-8]
SOLVERS = ["preconditioned_cg", "polonsky_keer"]


def pareto() -> xr.Dataset:
    """Two grids and two n; the error is of the window or of the grid, and the time of both.

    Exact: 1e-2 in 1.1 s, 1e-4 in 4.4 s. Circular: 1e-2 in 0.5 s, 1e-3 in 0.8 s. Superposed: the same in 0.9 s
    and 1.6 s. Zero: 0.3 in 0.48 s. One cell along: the same as exact in less than a tenth. The corrected errors
    are a half of these. The other solver takes 3.1 times as long; the looser tolerance leaves all at 0.5.
    """
    time = {
        "zero": [[0.48, 8.8]] * 2,
        "superposed": [[0.9, 3.0], [1.6, 4.0]],
        "circular": [[0.5, 1.5], [0.8, 2.0]],
        "exact": [[1.1, 4.4]] * 2,
        "line": [[0.1, 0.4]] * 2,
    }
    error = {
        "zero": [[0.3, 0.2]] * 2,
        "superposed": [[1e-2, 1e-2], [1e-3, 1e-3]],
        "circular": [[1e-2, 1e-2], [1e-3, 1e-3]],
        "exact": [[1e-2, 1e-4]] * 2,
        "line": [[1e-2, 1e-4]] * 2,
    }
    dims = ("padding", "images", "grid")
    here = xr.Dataset(
        {"solve_time": (dims, [*time.values()]), "pressure_error_l1": (dims, [*error.values()])},
        coords={"padding": list(time), "images": [1, 6], "grid": [32, 128]},
    )
    slower = xr.DataArray([1.0, 3.1], coords={"solver": SOLVERS})
    loose = xr.DataArray([0.5, 0.0], coords={"solver_tolerance": TOLERANCES})
    alike = xr.DataArray(np.ones(3), coords={"period": PERIODS})
    dataset = xr.Dataset(
        {
            "solve_time": here["solve_time"] * slower * (1 + 0 * loose) * alike,
            "pressure_error_l1": np.maximum(here["pressure_error_l1"], loose)
            * alike
            * (1 + 0 * slower),
        }
    ).transpose("padding", "images", "period", "grid", "solver_tolerance", "solver")
    dataset["setup_time"] = 0.5 * dataset["solve_time"]
    dataset["solve_time"] = 0.5 * dataset["solve_time"]
    dataset["corrected_error_l1"] = dataset["pressure_error_l1"] / 2
    # one with a sign
    dataset["peak_pressure_error"] = -dataset["pressure_error_l1"]
    dataset["half_width_error"] = 3 * dataset["pressure_error_l1"]
    for name in ("setup_time", "solve_time"):
        # the slowest repeat takes half as much again
        dataset[f"{name}_all"] = dataset[name] * xr.DataArray([1.0, 1.5], dims="repeat")
    return dataset


def test_the_front_is_of_the_settings_that_no_other_beats() -> None:
    axes = panels("pareto", pareto())
    assert len(axes) == 6
    for row, share in ((axes[:3], 1.0), (axes[3:], 0.5)):
        for ax in row:
            shown = labelled(ax)
            # of one cell along, by time: 0.1 s, then 0.4 s
            assert same(shown["front"], [0.1, 0.4], [share * 1e-2, share * 1e-4])
            assert same(
                shown["front, cells along the length"],
                [0.48, 0.5, 0.8, 4.4],
                [share * 0.3, share * 1e-2, share * 1e-3, share * 1e-4],
            )
            # filled marks: the preconditioned solver, 2 tolerances of 2 grids; open ones take 3.1 times as long
            time, error = shown["exact"]
            assert sorted(time) == pytest.approx([1.1, 1.1, 4.4, 4.4])
            assert sorted(error) == pytest.approx([share * e for e in (1e-4, 1e-2, 0.5, 0.5)])
            hollow = [line for line in ax.lines if line.get_markerfacecolor() == "none"]
            assert sorted(hollow[3].get_xdata()) == pytest.approx(
                3.1 * np.array([1.1, 1.1, 4.4, 4.4])
            )
            # bars from the least to the slowest repeat
            spans = [segment[:, 0] for bar in ax.collections for segment in bar.get_segments()]
            for start, end in spans:
                assert end == pytest.approx(1.5 * start)
            assert len(spans) == 6
    times, errors = "wall time, set-up and solve [s]", ("L1 error as solved", "L1 error, corrected")
    assert [named(ax) for ax in axes] == [
        (times if row else "", errors[row] if period == 0.6 else "", "" if row else f"period L = {period:g} a")
        for row in (0, 1)
        for period in PERIODS
    ]  # fmt: skip


def test_the_cost_of_a_decade_is_that_of_the_cheapest_setting_that_reaches_it() -> None:
    axes = panels("pareto", pareto(), 1)
    assert [ax.get_title() for ax in axes] == [
        "of the peak pressure", "of the pressure in L1", "of the half-width",
    ]  # fmt: skip
    # the smallest errors of each, and the dearest request that is met; requests are a fiftieth of a decade apart
    for ax, share in zip(axes, (1.0, 0.5, 3.0), strict=True):
        target, cost = labelled(ax)["exact"]
        assert target.max() == pytest.approx(0.1)
        assert share * 1e-4 <= target.min() < share * 1e-4 * 10**0.02
        assert np.diff(np.log10(target)) == pytest.approx(np.full(len(target) - 1, -0.02))
        assert cost == pytest.approx(np.where(target >= share * 1e-2, 1.1, 4.4))
        low, high = bands(ax)[list(labelled(ax)).index("exact")]
        assert low == pytest.approx(cost[::-1])
        assert high == pytest.approx(1.5 * cost[::-1])
    assert [named(ax)[:2] for ax in axes] == [
        ("requested error", "shortest wall time that reaches it [s]"),
        ("requested error", ""),
        ("requested error", ""),
    ]
    text = caption("pareto", pareto(), 1)
    assert "at L = 2.4 a" in text
    assert "peak pressure 0.010 % (exact, 128 cells)" in text
    assert "pressure in L1 0.0050 % (exact, 128 cells)" in text
    assert "half-width 0.030 % (exact, 128 cells)" in text


def test_the_table_of_decades_and_what_a_mode_saves() -> None:
    dataset = pareto()
    bought = decades(dataset)
    # 0.1, 0.01, 1e-3, 1e-4, 1e-5 of the corrected error, a half of that as solved
    assert len(DECADES) == 5
    assert bought["exact", "2.4 a"] == pytest.approx((1.1, 1.1, 4.4, 4.4, np.inf))
    assert bought["circular", "0.6 a"] == pytest.approx((0.5, 0.5, 0.8, np.inf, np.inf))
    assert bought["line", "any"] == pytest.approx((0.1, 0.1, 0.4, 0.4, np.inf))
    assert bought["zero", "9.6 a"][:2] == pytest.approx((8.8, np.inf))
    assert ("exact", "2.4 a", "1.1", "1.1", "4.4", "4.4", "none") in rows("pareto", dataset)
    saved = savings(dataset)
    assert saved["exact"][2.4] == (np.inf, pytest.approx(5e-5))
    # 1.6 s of the sum that is not circular over 0.8 s, and 0.5 s over 0.9 s and over 0.48 s of it
    assert saved["circular"][0.6] == pytest.approx((2.0, 5e-4))
    assert saved["superposed"][9.6] == pytest.approx((0.5 / 0.9, 5e-3))
    assert saved["zero"][2.4][0] == pytest.approx(0.5 / 0.48)
    claim, measured = dominated_modes(dataset)
    assert claim == "Zero and superposed padding are never the cheapest."
    measured = words(measured)
    assert "superposed padding, at its best, takes 1.8 times as long as another mode" in measured
    assert "(at an error of 0.50 %)" in measured
    # within what two times of one computation may differ by
    assert "zero padding, at its best, is no faster than another mode" in measured
    assert (
        "circular saves up to a factor of 2, at L = 0.6, 2.4, 9.6 a, for errors of 0.050 %"
        in measured
    )
    assert "exact is the only one at the smallest errors at L = 0.6, 2.4, 9.6 a" in measured
    # at 0.005 % in both: 4.4 s over 0.4 s
    assert "one cell along it is 11 times faster, for an error of 0.0050 %" in measured
