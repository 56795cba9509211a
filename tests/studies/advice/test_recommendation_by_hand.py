"""What is tried, expected and chosen, by hand."""

from collections.abc import Iterator
from dataclasses import replace
from math import inf, log10
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.accuracy.expected_error import Edges, ErrorParts, Metric
from contactstudy.accuracy.truncation import expected_truncation
from contactstudy.planning.grid_search import GridForecast
from contactstudy.planning.plan import SHARE
from studies.advice import recommendation
from studies.advice.recommendation import (
    ACROSS,
    TOLERANCES,
    Limits,
    RoughContact,
    Setting,
    SmoothContact,
    candidates,
    choose,
    contact_of,
)

EXACT = cs.ExactPeriodicity()
GRID = cs.Grid((64, 32), (4.0, 2.0))


def setting(mode: str, error: float, seconds: float, size: int = 100) -> Setting:
    parts = ErrorParts(0.0, error, 0.0)
    return Setting(mode, EXACT, GRID, 1e-8, Edges.AS_SOLVED, parts, seconds, size)


def test_of_what_meets_the_error_the_quickest_is_best_and_then_the_more_accurate() -> None:
    quick, quicker = setting("a", 0.009, 2.0), setting("a", 0.001, 2.0)
    other, dear = setting("b", 0.01, 3.0), setting("b", 1e-6, 4.0)
    wrong = setting("c", 0.011, 1.0)
    found = choose([dear, other, quick, quicker, wrong], Limits(0.01))
    assert (found.best, found.runner_up) == (quicker, other)
    assert found.meets
    assert found.affordable
    assert choose([quick, quicker], Limits(0.01)).runner_up is None


def test_limits_of_memory_and_time_may_be_met_exactly() -> None:
    one, large, slow = (
        setting("a", 0.01, 2.0),
        setting("b", 1e-3, 1.0, 101),
        setting("c", 1e-3, 2.1),
    )
    found = choose([one, large, slow], Limits(0.01, memory=100, seconds=2.0))
    assert (found.best, found.runner_up, found.meets) == (one, None, True)


def test_of_what_misses_the_error_the_most_accurate_to_two_digits_is_best() -> None:
    # 0.021 and 0.0214 are alike; 0.0216 is 0.022
    near, nearer, far = (
        setting("a", 0.0214, 1.0),
        setting("b", 0.021, 2.0),
        setting("c", 0.0216, 0.1),
    )
    found = choose([far, nearer, near], Limits(0.01))
    assert (found.best, found.runner_up) == (near, nearer)
    assert (found.meets, found.affordable) == (False, True)
    none = choose([far, nearer, near], Limits(0.01, seconds=0.05))
    assert none.best == far
    assert (none.meets, none.affordable) == (False, False)


class Known:
    """A contact of one way, whose cells leave 0.004 and whose solver leaves a tenth of the root of its tolerance."""

    convolutions = 30.0
    tolerances = (1e-4, 1e-6, 1e-8)

    def __init__(self, cells: float = 0.004, grid: cs.Grid = GRID) -> None:
        self.cells, self.grid = cells, grid

    def ways(self, _: Limits) -> Iterator[tuple[cs.Grid, cs.Padding, Edges]]:
        yield self.grid, EXACT, Edges.AS_SOLVED

    def error(self, *words: Any) -> ErrorParts:
        return ErrorParts(0.001, self.cells, 0.1 * words[-1] ** 0.5)


COSTS: Any = SimpleNamespace(seconds=lambda grid, padding, convolutions: convolutions)


@pytest.mark.parametrize(
    ("error", "tolerance"),
    [(0.1, 1e-4), (0.0052, 1e-6), (0.0051, 1e-6), (0.00502, 1e-8), (0.001, 1e-8)],
)
def test_the_largest_tolerance_that_keeps_to_the_error_is_taken(
    error: float, tolerance: float
) -> None:
    """0.005, and 1e-3, 1e-4 and 1e-5 by the solver."""
    [found] = candidates(Known(), Limits(error), COSTS)  # type: ignore[arg-type]
    assert found.tolerance == tolerance
    assert found.error.total == pytest.approx(0.005 + 0.1 * tolerance**0.5)
    assert found.seconds == pytest.approx(30 * -log10(tolerance) / 8)


def test_what_has_no_error_or_too_many_cells_is_no_candidate() -> None:
    assert not [*candidates(Known(inf), Limits(0.1), COSTS)]  # type: ignore[arg-type]
    large = cs.Grid((2**13, 2**13), (1.0, 1.0))
    assert len([*candidates(Known(grid=large), Limits(0.1), COSTS)]) == 1  # type: ignore[arg-type]
    larger = cs.Grid((2**13, 2**13 + 1), (1.0, 1.0))
    assert not [*candidates(Known(grid=larger), Limits(0.1), COSTS)]  # type: ignore[arg-type]


def test_a_smooth_contact_is_tried_with_every_mode_and_edges_in_l1_alone() -> None:
    contact = SmoothContact(0.5, 3.0, ("line", "circular", "zero"), (32, 40), (1, 2), (1e-6,))
    ways = [*contact.ways(Limits(0.1))]
    # two grids of one cell along, two n by two grids, two grids; each with two treatments of the edges
    assert len(ways) == 2 * (2 + 4 + 2)
    assert {grid.cells for grid, _, _ in ways} == {(32, 1), (40, 1), (32, 32), (40, 40)}
    # a fifth more than the contact
    for grid, _, _ in ways:
        assert grid.extent == pytest.approx((1.2, 3.0))
    assert ways[0][1] == EXACT
    assert all((grid.cells[1] == 1) == (padding == EXACT) for grid, padding, _ in ways)
    assert len([*contact.ways(Limits(0.1, Metric.HALF_WIDTH))]) == 8


NEEDS = SimpleNamespace(roller=False, varies=True, half_width=0.3, padding=lambda: EXACT)
PLANNED = GridForecast(
    GRID, (0.005, 0.005), (1.0, 1.0), (16, 16), cut_off=False, message="", seconds=1.0
)


def test_a_rough_contact_is_tried_on_the_plan_s_grid_on_finer_ones_and_on_those_that_miss() -> None:
    contact: Any = RoughContact(NEEDS, PLANNED)  # type: ignore[arg-type]
    ways = [*contact.ways(Limits(0.02))]
    grids = [*dict.fromkeys(grid.cells[0] for grid, _, _ in ways)]
    # 0.01 over shares of 0.02: 0.019, 0.016, 0.01, 0.04 and so on; of the coarser ones those beyond 0.02
    assert grids[0] == 64
    wanted = [PLANNED.grid_for(0.02 * share) for share in (0.95, 0.8, 0.5, 2.0, 5.0, 20.0, 100.0)]
    kept = [one for one in wanted if one.cells[0] > 64 or PLANNED.error_of(one.cell) > 0.02]
    assert [grid for grid in grids[1:] if grid != 64] == [
        *dict.fromkeys(one.cells[0] for one in kept if one.cells[0] != 64)
    ]
    # every padding, those that count images with thirteen n
    of_plan = [padding for grid, padding, _ in ways if grid == GRID]
    assert len(of_plan) % (2 * 13 + 3) == 0
    strict = [*contact.ways(Limits(0.005))]
    assert max(grid.cells[0] for grid, _, _ in strict) > 128


def test_another_grid_of_a_rough_contact_has_more_cells_or_misses_the_error() -> None:
    asked: list[float] = []
    offered = iter(
        [
            cs.Grid((65, 8), (4.0, 2.0)),
            # more cells, though fewer across
            cs.Grid((63, 64), (4.0, 2.0)),
            cs.Grid((63, 16), (4.0, 2.0)),
            cs.Grid((64, 4), (4.0, 2.0)),
        ]
    )

    def grid_for(error: float) -> cs.Grid:
        asked.append(error)
        return next(offered, GRID)

    # what is kept to is not beyond it
    errors = {2.0 / 16: 0.021, 2.0 / 4: 0.02}
    planned = SimpleNamespace(
        grid=GRID, error=0.01, grid_for=grid_for, error_of=lambda cell: errors.get(cell[1], 0.001)
    )
    contact: Any = RoughContact(NEEDS, planned)  # type: ignore[arg-type]
    grids = dict.fromkeys(grid.cells for grid, _, _ in contact.ways(Limits(0.02)))
    assert [*grids] == [(64, 32), (63, 64), (63, 16)]
    # a little less than all of it to a half for the cells, and what then fails by little and by much
    assert asked == pytest.approx([0.019, 0.016, 0.01, 0.04, 0.1, 0.4, 2.0])


def test_cells_across_halve_to_at_most_56_and_tolerances_are_decades_from_1e_4_to_1e_11() -> None:
    assert len(set(ACROSS)) == 64
    assert max(ACROSS) == 56 * 2**15
    assert {cells for cells in ACROSS if cells // 2 not in ACROSS} == {32, 40, 48, 56}
    assert all(cells % 2 == 0 for cells in ACROSS)
    assert pytest.approx([1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11]) == TOLERANCES
    contact = SmoothContact(1.0, 1.0)
    assert (contact.across, contact.tolerances) == (ACROSS, TOLERANCES)


@pytest.fixture
def needed(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """What the scene is said to need: a smooth contact of half-width 0.3, whose pressure peaks at 5."""
    needs = SimpleNamespace(smooth=True, hertz=SimpleNamespace(peak_pressure=5.0, half_width=0.3))
    monkeypatch.setattr(recommendation, "needs_of", lambda _: needs)
    return needs


def scene(hardness: float) -> Any:
    return SimpleNamespace(hardness=hardness, changing=None)


@pytest.mark.usefixtures("needed")
def test_a_smooth_contact_has_the_period_given_or_is_as_long_as_the_grid_is_wide() -> None:
    given, chosen = (contact_of(scene(5.1), period, Limits(0.1)) for period in (2.0, None))
    assert isinstance(given, SmoothContact)
    assert isinstance(chosen, SmoothContact)
    assert (given.half_width, given.period) == (0.3, 2.0)
    # a fifth more than the contact
    assert chosen.period == pytest.approx(0.72)


@pytest.mark.parametrize(("memory", "most"), [(inf, 1000 * SHARE), (10.0, 10.0)])
def test_a_contact_that_yields_is_planned_within_the_memory_there_is(
    memory: float, most: float, needed: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []
    planned = SimpleNamespace(error=0.02, cut_off=False, message="")

    def reaching(*words: Any) -> Any:
        asked.append(words)
        return planned

    monkeypatch.setattr(recommendation, "available_bytes", lambda: 1000)
    monkeypatch.setattr(recommendation, "reaching", reaching)
    monkeypatch.setattr(recommendation, "cheapest", lambda *words: asked.append(words) or planned)
    body = scene(5.0)
    limits = Limits(0.1, memory=memory)
    found = contact_of(body, 2.0, limits)
    assert isinstance(found, RoughContact)
    assert (found.needs, found.planned) == (needed, planned)
    assert asked == [(body, needed, 0.1, 2.0, most), (body, needed, planned, 0.1)]
    with pytest.raises(cs.InvalidInput, match="give l1"):
        contact_of(body, 2.0, replace(limits, metric=Metric.HALF_WIDTH))
    planned.error = inf
    with pytest.raises(cs.NotDefined, match="small solutions do not show the surface"):
        contact_of(body, 2.0, limits)


def test_a_roller_has_one_padding_and_a_plan_without_an_error_one_grid() -> None:
    roller: Any = RoughContact(SimpleNamespace(**(vars(NEEDS) | {"roller": True})), PLANNED)  # type: ignore[arg-type]
    assert {padding for _, padding, _ in roller.ways(Limits(0.02))} == {EXACT}
    uniform: Any = RoughContact(SimpleNamespace(**(vars(NEEDS) | {"varies": False})), PLANNED)  # type: ignore[arg-type]
    assert {padding for _, padding, _ in uniform.ways(Limits(0.02))} == {EXACT}
    for error in (0.0, inf):
        unknown: Any = RoughContact(NEEDS, replace(PLANNED, errors=(error, 0.0)))  # type: ignore[arg-type]
        assert {grid for grid, _, _ in unknown.ways(Limits(0.02))} == {GRID}
    little: Any = RoughContact(NEEDS, replace(PLANNED, errors=(0.5, 0.0)))  # type: ignore[arg-type]
    assert len({grid for grid, _, _ in little.ways(Limits(0.02))}) > 1


def test_a_rough_contact_s_error_is_that_of_the_window_of_the_plan_s_cells_and_of_the_solver() -> (
    None
):
    contact: Any = RoughContact(NEEDS, PLANNED)  # type: ignore[arg-type]
    padding = cs.CircularSuperposition(2)
    found = contact.error(Limits(0.02), GRID, padding, Edges.AS_SOLVED, 1e-5)
    assert found.truncation == expected_truncation(0.3, GRID, padding).l1 > 0
    assert found.discretisation == pytest.approx(0.01)
    assert found.residual == pytest.approx(20e-5)
    assert contact.error(Limits(0.02), GRID, padding, Edges.AS_SOLVED, 2e-5).residual == inf
    free = cs.ZeroPadding(), cs.ZeroPadding()
    assert contact.error(Limits(0.02), GRID, free, Edges.AS_SOLVED, 1e-6).truncation == 0


@pytest.mark.parametrize("field", ["rolling", "lubrication"])
def test_a_scene_whose_error_is_not_known_is_refused(field: str) -> None:
    body = SimpleNamespace(hardness=inf, changing=None, **{field: "given"})
    with pytest.raises(cs.NotDefined, match=rf"^Scene\.{field} is given: a recommendation knows"):
        contact_of(body, None, Limits(0.1))  # type: ignore[arg-type]
    changing: Any = SimpleNamespace(hardness=inf, changing="Scene.wear")
    with pytest.raises(cs.NotDefined, match=r"^Scene\.wear is given"):
        contact_of(changing, None, Limits(0.1))
