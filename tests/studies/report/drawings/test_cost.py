"""What the drawings of time, memory and accuracy plot and say of numbers that are written here."""

import numpy as np
import pytest
import xarray as xr

from studies.definitions.effect_cost import YIELD
from studies.model.outcome import CaseStatus
from tests.studies.report.drawings.drawn import (
    caption,
    curves,
    findings,
    labelled,
    named,
    numbered,
    panels,
    same,
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
