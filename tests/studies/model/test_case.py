import numpy as np
import xarray as xr

import contactstudy as cs
from contactstudy.io.dataset import flags
from studies.model.case import solver_status
from studies.model.outcome import CaseStatus, TimedRun, summary_messages, timing_variables


def test_a_status_is_a_flag_of_all_that_there_are() -> None:
    for place, status in enumerate(cs.Status):
        found = solver_status(status, "how it ended")
        assert int(found) == place
        assert found.attrs["flag_meanings"].split()[place] == status.name.lower()
        np.testing.assert_array_equal(found.attrs["flag_values"], np.arange(len(cs.Status)))
    two = flags(("x",), np.array([1, 0]), ("no", "yes"), "whether")
    assert two.dims == ("x",)
    assert two.dtype == np.int8


def ended(*statuses: cs.Status, **measured: list[float]) -> xr.Dataset:
    """Stored cases whose solves ended so."""
    variables = [xr.DataArray(solver_status(status, "how it ended")) for status in statuses]
    return xr.Dataset(
        {
            "case_key": ("load", [f"{number}" for number in range(len(statuses))]),
            "case_status": ("load", [CaseStatus.OK] * len(statuses)),
            "solver_status": xr.concat(variables, "load"),
            **{name: ("load", values) for name, values in measured.items()},
        }
    )


def test_a_run_names_the_statuses_of_solves_that_did_not_converge() -> None:
    at_edge = cs.Status.CONTACT_AT_EDGE
    dataset = ended(cs.Status.CONVERGED, at_edge, cs.Status.STALLED, at_edge)
    assert list(summary_messages(dataset)) == [
        "2 of 4 solves ended with CONTACT_AT_EDGE; see 'solver_status'",
        "1 of 4 solves ended with STALLED; see 'solver_status'",
    ]
    assert not list(summary_messages(ended(cs.Status.CONVERGED)))


def test_a_run_says_which_cases_miss_their_accuracy_and_which_have_no_bound() -> None:
    inf, nan = np.inf, np.nan
    dataset = ended(
        *[cs.Status.CONVERGED] * 3,
        accuracy_met=[1, 0, 1],
        accuracy_missed=["", "1 % not met: 3 % in L1", ""],
        peak_pressure=[1.0, 2.0, nan],
        peak_pressure_bound=[0.1, inf, inf],
        approach=[1.0, 2.0, 3.0],
        approach_bound=[inf, inf, inf],  # of which the bound is never known
        kind=["a", "b", "c"],
        kind_bound=["d", "e", "f"],  # text of the study's own
    )
    assert list(summary_messages(dataset)) == [
        "1 of 3 cases misses the requested accuracy, the first with 1 % not met: 3 % in L1",
        "no bound of peak_pressure in 1 of 3 cases",
    ]


def sample(wall: float, cpu: float | None = None) -> TimedRun:
    """A quarter of it to set up."""
    cpu = wall if cpu is None else cpu
    return TimedRun(wall / 4, 3 * wall / 4, cpu / 4, 3 * cpu / 4)


def test_the_least_time_of_each_case_stands_at_its_points() -> None:
    cases = [[sample(4.0), sample(8.0, 3.2), sample(40.0)], [sample(2.0, 1.96), sample(2.1)], []]
    found = timing_variables(("x",), np.array([1, 0, 0, 2]), cases)
    nan = np.nan
    for name, expected in {
        "setup_time": [0.5, 1, 1, nan],
        "solve_time": [1.5, 3, 3, nan],
        "solve_time_cpu": [1.47, 2.4, 2.4, nan],
    }.items():
        np.testing.assert_allclose(found[name].values, expected, rtol=1e-12)
        assert found[name].attrs["units"] == "s"
    every = [[1.5, 1.575, nan], [3, 6, 30], [3, 6, 30], [nan] * 3]
    np.testing.assert_allclose(found["solve_time_all"].values, every, rtol=1e-12)
