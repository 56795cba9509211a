"""What the study of rough surfaces records of pressures that are written here."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import contactstudy as cs
from studies.definitions import roughness
from studies.definitions.roughness import P_H, A
from studies.reference.line_contact import SCENE

# cells of a half of a half-width by a third
GRID = cs.Grid((4, 3), (2.0 * A, 1.0 * A))
# at -3, -1, 1 and 3 quarters of a half-width
PRESSURE = P_H * np.array([[0.0, 0.0, 0.2], [0.9, 0.4, 1.5], [0.6, 0.0, 0.4], [0.0, 0.0, 0.0]])


def test_answers_are_over_hertz_s() -> None:
    smooth = np.array([[0.0], [0.7 * P_H], [0.7 * P_H], [0.0]])
    found = roughness._answers(PRESSURE, smooth, GRID)
    # six of twelve cells of a sixth, of two half-widths by one
    assert found["contact_area"] == pytest.approx(6 * (1 / 6) / 2)
    # the farthest centre, and half a cell
    assert found["contact_extent"] == pytest.approx(0.75 + 0.25)
    assert found["peak_pressure"] == pytest.approx(1.5)
    # loads along of 1.5, 0.4 and 2.1
    spread = np.sqrt(((1.5 - 4 / 3) ** 2 + (0.4 - 4 / 3) ** 2 + (2.1 - 4 / 3) ** 2) / 3)
    assert found["load_spread"] == pytest.approx(spread / (4 / 3))
    # 0.2; 0.2, 0.3 and 0.8; 0.1, 0.7 and 0.3, of three times 1.4
    assert found["smooth_difference"] == pytest.approx(2.6 / 4.2)
    # 0.2 at nine sixteenths, and 3.8 at one, of 4; Hertz's second moment is a quarter of his half-width's
    moment = (0.2 * 9 + 3.8) / 16 / 4
    assert found["half_width"] == pytest.approx(2 * moment**0.5)


def test_errors_are_over_the_exact_answer() -> None:
    exact = PRESSURE + P_H * np.array([[0, 0, 0], [0.1, 0, 0.5], [0, 0, -0.4], [0, 0, 0]])
    found = roughness._errors(PRESSURE, exact, GRID)
    assert found["pressure_error_l1"] == pytest.approx(1.0 / 4.2)
    assert found["pressure_error_max"] == pytest.approx(0.5)
    assert found["peak_pressure_error"] == pytest.approx(1.5 / 2.0 - 1)
    # second moments over sixteenths: 1.8 + 3.8 of 4, and 1.8 + 4.0 of 4.2
    assert found["half_width_error"] == pytest.approx((5.6 / 4 / (5.8 / 4.2)) ** 0.5 - 1)


def test_a_window_that_reaches_d_opens_the_gap_by_a_share_a2_over_4_d2(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    exact = roughness.Case(SCENE, GRID, cs.ExactPeriodicity())
    seen: list[cs.Problem] = []
    monkeypatch.setattr(roughness.Case, "run", lambda _, problem: seen.append(problem))
    problem = exact.prepare()
    roughness._more_curved(exact, problem, cs.CircularSuperposition(2))
    reach = 2.5
    parabola = GRID.x[:, None] ** 2 / (2 * 0.01)
    more = seen[0].undeformed_gap - problem.undeformed_gap
    np.testing.assert_allclose(
        more, np.broadcast_to(parabola / (4 * reach**2), more.shape), rtol=1e-6
    )


@pytest.mark.parametrize(
    ("status", "at_edge", "converged"),
    [
        (cs.Status.CONVERGED, False, 1),
        (cs.Status.CONTACT_AT_EDGE, False, 1),
        (cs.Status.CONVERGED, True, 0),
        (cs.Status.STALLED, False, 0),
    ],
)
def test_a_padding_is_done_where_it_converged_within_the_width(
    status: cs.Status,
    at_edge: bool,  # noqa: FBT001
    converged: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    point = {"rms": 0.1, "hurst": 0.8, "peklenik": 1.0, "seed": 1, "images": 6, "period": 2.4}
    case = roughness.scene_at(point | {"grid": 4})
    pressure = np.ones(case.grid.cells)
    pressure[0] = 1.0 if at_edge else 0.0
    solution: Any = SimpleNamespace(
        pressure=pressure, problem=SimpleNamespace(open_edges=(0,)), status=status
    )
    monkeypatch.setattr(roughness.Case, "run", lambda *_: solution)
    monkeypatch.setattr(roughness, "_more_curved", lambda *_: solution)
    found = roughness.measures(case, solution)
    assert found["converged"].values.tolist() == 5 * [converged]
    assert found["curved_difference"].values.tolist() == 5 * [0.0]


def test_two_cells_across_and_no_images_are_a_case() -> None:
    point = {"rms": 0.0, "hurst": 0.8, "peklenik": 1.0, "seed": 1, "images": 0, "period": 2.4}
    case = roughness.scene_at(point | {"grid": 2})
    assert (case.grid.cells[0], case.images) == (2, 0)
    with pytest.raises(cs.InvalidInput, match="at least 2 cells"):
        roughness.scene_at(point | {"grid": 1})
