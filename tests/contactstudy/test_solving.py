"""What `solve` reports, and the keywords that it takes for each kind of scene."""

from dataclasses import replace

import numpy as np
import pytest

import contactstudy as cs
from contactstudy.domain.device import threads
from tests.contactstudy.evolution.creeping import LOAD, SOLID, rolling_cylinder
from tests.contactstudy.evolution.test_roll_repeatedly import scene as yielding_cylinder
from tests.contactstudy.lubrication import scenes as films

EXACT = cs.ExactPeriodicity()
# A scene of each of these kinds, with its grid.
KINDS = {
    "creep": (
        rolling_cylinder(SOLID, load=cs.LoadHistory((-2.0, -1.0), (0.5 * LOAD, LOAD))),
        cs.Grid((24, 1), (0.6, 1.0)),
    ),
    "static": (films.DRY, films.grid(24, 1.2)),
    "rolling": (
        rolling_cylinder(SOLID, rolling=cs.Rolling(speed=0.1)),
        cs.Grid((24, 1), (0.6, 1.0)),
    ),
    "passes": (
        replace(yielding_cylinder(2.2), rolling=cs.Rolling(passes=2, distance=0.4)),
        cs.Grid((24, 1), (4.8, 1.0)),
    ),
    "film": (films.by_moes(20, 2), films.grid(64, 3.0)),
}


@pytest.mark.cases(5)
@pytest.mark.parametrize("kind", KINDS)
def test_a_solve_reports_its_progress(kind: str) -> None:
    seen: list[cs.Progress] = []
    cs.solve(*KINDS[kind], EXACT, progress=seen.append)
    fractions = [progress.fraction for progress in seen]
    assert 0 <= min(fractions) < 1
    assert fractions[-1] == 1
    assert all(progress.text for progress in seen)


@pytest.mark.parametrize("kind", KINDS)
def test_a_solve_uses_the_threads_of_its_device(kind: str) -> None:
    seen: set[int] = set()
    cs.solve(*KINDS[kind], EXACT, device=cs.Cpu(threads=2), progress=lambda _: seen.add(threads()))
    assert seen == {2}
    assert threads() == 1


def test_a_keyword_that_a_scene_cannot_use_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, grid = KINDS["static"]
    problem = scene.problem(grid, EXACT)
    with pytest.raises(cs.InvalidInput, match=r"^solve\.period is given, .*: leave it out\.$"):
        cs.solve(problem, period=1.0)  # type: ignore[call-overload]
    with pytest.raises(cs.InvalidInput, match=r"^solve\.times is given, .*: leave it out\.$"):
        cs.solve(scene, grid, EXACT, times=[0.0])
    film = KINDS["film"]
    history = cs.LoadHistory((0.0, 1.0), (1.0, 2.0))
    in_time = replace(film[0], load=history)
    for arguments, option, value in (
        (film, "solver", cs.PolonskyKeer()),
        (film, "precision", "single"),
        ((in_time, film[1]), "max_iterations", 5),
        (film, "start", np.zeros((64, 1))),
    ):
        with pytest.raises(cs.InvalidInput, match=rf"^solve\.{option} is .*\.$"):
            cs.solve(*arguments, EXACT, **{option: value})  # type: ignore[call-overload]
    monkeypatch.setattr(cs.Gpu, "__post_init__", lambda _: None)
    with pytest.raises(cs.InvalidInput, match=r"^solve\.device is given, .*: leave it out\.$"):
        cs.solve(*KINDS["film"], EXACT, device=cs.Gpu())
    history = cs.LoadHistory((0.0, 100.0), (0.5 * LOAD, LOAD))
    rolling = replace(KINDS["rolling"][0], load=history), KINDS["rolling"][1]
    for (scene, grid), named in (
        (KINDS["creep"], {"step": 1e-3}),
        (rolling, {"error": 1e-2}),
        (rolling, {"scheme": cs.Scheme.EXPLICIT}),
    ):
        with pytest.raises(
            cs.InvalidInput, match=rf"^TimeSteps\.{next(iter(named))} is .*: leave it out\.$"
        ):
            cs.solve(scene, grid, EXACT, times=cs.TimeSteps(**named))


def test_a_smooth_film_has_the_period_that_is_given() -> None:
    scene, _ = KINDS["film"]
    assert cs.solve(scene, error=0.3, period=7e-3).grid.length == 7e-3
