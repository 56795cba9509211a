import xarray as xr

from studies.model.outcome import CaseStatus
from studies.registry import load_drawing
from tests.studies.report.drawings.drawn import findings, numbered


def speed(device: str = "cpu") -> xr.Dataset:
    axes = {
        "surface": ["rough", "self-affine"], "hurst": [0.2, 0.8], "cut_off": [2.0], "fraction": [0.2],
        "precision": ["double"], "device": [device], "threads": [1, 2], "grid": [16, 32, 128],
    }  # fmt: skip
    names = ("solve_time", "iterations", "transform_ratio", "contact_fraction", "memory")
    dataset = numbered(axes, *names)
    dataset["iterations"] = (1e4 * dataset["iterations"]).round()
    dataset["transform_ratio"] *= 1e3
    dataset["memory"] *= 1e4
    return dataset.assign(case_status=xr.full_like(dataset["memory"], CaseStatus.OK, dtype=int))


def test_of_three_numbers_of_threads_the_first_and_the_last_are_compared() -> None:
    four = speed().isel(threads=[0]).assign_coords(threads=[4])
    four["solve_time"] = four["solve_time"] / 2.5
    [said] = findings("speed", xr.concat([speed(), four], "threads"))
    assert "is 2.5 to 2.5 times as fast on 4 threads as on 1 thread" in said


def test_iterations_are_drawn_on_each_device() -> None:
    both = xr.concat([speed(), speed("gpu")], "device")
    (drawn,) = load_drawing("speed").figure(both)
    labels = {line.get_label() for line in drawn.figure.axes[1].lines}
    assert {"rough, cpu, 1 thread", "rough, gpu"} <= labels


def test_the_speed_is_said_from_the_coarsest_grid_to_the_finest() -> None:
    [said] = findings("speed", speed())
    # 27 over 25 of the first surface is the largest growth
    assert "From 16 to 128 cells" in said
    assert "by a factor of at most 1.1." in said
    assert "rough: 25 to 27" in said
    assert "H = 0.8: 43 to 45" in said
    # 5.1 of the first to 6.9 of the last on one thread
    assert "a solve takes 5.1 to 6.9 times the time of its bare transforms" in said
    # 3 / 6 to 21 / 24 of the time, over all surfaces
    assert "is 0.5 to 0.9 times as fast on 2 threads as on 1 thread" in said
    for part in (speed("gpu"), speed().isel(threads=[0])):
        assert "times as fast" not in findings("speed", part)[0]
    assert not findings("speed", speed().isel(grid=[0]))
