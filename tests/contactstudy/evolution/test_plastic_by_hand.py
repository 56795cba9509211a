"""What bodies that yield keep and say, of numbers that are written here."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.elasticity.eigenstrain.volume import Moduli, Volume
from contactstudy.evolution.plastic import (
    ABRUPT,
    PlasticMemory,
    YieldingBody,
    _meets_edge,
    step_solution,
)
from contactstudy.solvers.settle import Settled
from contactstudy.solvers.yielding_bodies import Hardening
from tests.conftest import STEEL, LineContact

GRID = cs.Grid((6, 2), (12.0, 3.0))
BODY = cs.ElasticPlasticHalfSpace(200.0, 0.25, 3.0, 20.0, 10.0)


def test_bodies_that_yield_are_known_by_their_place(line_contact: LineContact) -> None:
    scene = replace(line_contact.scene, solids=(STEEL, BODY))
    known = YieldingBody(1, Moduli(200.0, 0.25), Hardening(3.0, 20.0, 10.0))
    assert YieldingBody.in_scene(scene) == (known,)
    both = YieldingBody.in_scene(replace(scene, solids=(BODY, BODY)))
    assert [one.place for one in both] == [0, 1]


def test_a_step_is_abrupt_when_what_flows_is_several_times_more() -> None:
    memory: Any = PlasticMemory.__new__(PlasticMemory)
    before, enough = {"flow": np.array([2.0])}, 2.0 * (1 + ABRUPT)
    assert not memory.abrupt(before, {"flow": np.array([enough])})
    assert memory.abrupt(before, {"flow": np.array([enough + 0.1])})
    assert memory.abrupt({"flow": np.zeros(1)}, {"flow": np.array([0.1])})


def cells(across: int, at: int) -> np.ndarray:
    found = np.zeros((3, across, 2), dtype=bool)
    found[1, at, 1] = True
    return found


@pytest.mark.parametrize(
    ("first", "last", "at", "meets"),
    [
        (0, 4, 0, True),
        (0, 4, 1, False),
        (0, 4, -1, False),
        (1, 5, 0, False),
        (1, 5, -1, False),
        (2, 6, -1, True),
        (2, 6, -2, False),
        (2, 6, 0, False),
        (0, 6, 1, False),
        (0, 6, 5, True),
    ],
)
def test_strain_meets_the_edge_in_the_first_and_the_last_row_of_the_grid(
    first: int,
    last: int,
    at: int,
    meets: bool,  # noqa: FBT001
) -> None:
    volume = Volume(GRID, first, last, (0.0, 1.0, 2.0, 3.0))
    assert _meets_edge(volume, cells(last - first, at)) == meets


def contact(status: cs.Status, residual: float) -> cs.Solution:
    field = np.ones((6, 2))
    problem: Any = None
    return cs.Solution(problem, field, field, field, 0.5, status, 4, 5.5, residual, "contact.")


def settled(*contacts: cs.Solution, residual: float = 1e-9) -> Settled:
    nothing = np.zeros((3, 8))
    return Settled(contacts[-1], nothing, nothing[0], residual, 7, contacts)


CONVERGED = contact(cs.Status.CONVERGED, 1e-10)


def test_a_step_took_what_all_its_contacts_took() -> None:
    found = step_solution(settled(CONVERGED, CONVERGED, CONVERGED), 1e-8)
    assert (found.iterations, found.convolutions) == (12, 16.5)
    # the larger of the contact's and that of plastic strain
    assert (found.status, found.residual, found.note) == (cs.Status.CONVERGED, 1e-9, "contact.")
    closer = step_solution(settled(contact(cs.Status.CONVERGED, 3e-9)), 1e-8)
    assert closer.residual == 3e-9


@pytest.mark.parametrize(
    ("status", "residual", "said"),
    [
        (cs.Status.STALLED, 1e-8, cs.Status.CONVERGED),
        (cs.Status.PRECISION_LIMIT, 1e-9, cs.Status.CONVERGED),
        (cs.Status.ITERATION_LIMIT, 1e-9, cs.Status.CONVERGED),
        (cs.Status.STALLED, 1.1e-8, cs.Status.STALLED),
        (cs.Status.CONTACT_AT_EDGE, 1e-9, cs.Status.CONTACT_AT_EDGE),
        (cs.Status.NOT_FINITE, 1e-9, cs.Status.NOT_FINITE),
    ],
)
def test_a_contact_had_been_asked_for_more_than_the_tolerance(
    status: cs.Status, residual: float, said: cs.Status
) -> None:
    assert step_solution(settled(contact(status, residual)), 1e-8).status is said


def test_plastic_strain_that_did_not_settle_is_said_with_how_far_it_came() -> None:
    assert step_solution(settled(CONVERGED, residual=1e-8), 1e-8).status is cs.Status.CONVERGED
    for residual, text in ((2e-8, "2.0e-08"), (np.nan, "nan")):
        found = step_solution(settled(CONVERGED, residual=residual), 1e-8)
        assert found.status is cs.Status.NOT_CONVERGED
        assert f"settled to {text} of the yield strain in 7 iterations" in found.note
