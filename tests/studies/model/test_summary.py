from dataclasses import dataclass

import xarray as xr

import contactstudy as cs
from studies.model.case import solver_status
from studies.model.outcome import CaseStatus, summary_messages


@dataclass(frozen=True)
class Solved:
    """A stored case whose solve ended in a status."""

    status: cs.Status
    case_status: CaseStatus = CaseStatus.OK
    error: str = ""

    def variable(self, name: str) -> xr.Variable | None:
        return (
            solver_status(self.status, "how the solver ended") if name == "solver_status" else None
        )


def test_a_run_names_the_statuses_of_solves_that_did_not_converge() -> None:
    ended = [
        cs.Status.CONVERGED,
        cs.Status.CONTACT_AT_EDGE,
        cs.Status.STALLED,
        cs.Status.CONTACT_AT_EDGE,
    ]
    assert list(summary_messages(map(Solved, ended))) == [
        "2 of 4 solves ended with CONTACT_AT_EDGE; see 'solver_status'",
        "1 of 4 solves ended with STALLED; see 'solver_status'",
    ]
    assert not list(summary_messages([Solved(cs.Status.CONVERGED)]))
