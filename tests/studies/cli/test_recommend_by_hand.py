"""What is said of a recommendation that is written here."""

import re
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import contactstudy as cs
from contactstudy.accuracy.expected_error import Edges, ErrorParts, Metric
from studies.advice.recommendation import Limits, Recommendation, Setting
from studies.cli import recommend

EXAMPLES = Path(__file__).parents[3] / "examples"
FITTED: Any = SimpleNamespace(timings=("one",))
MEASURED: Any = SimpleNamespace(timings=())


def setting(mode: str, padding: Any, edges: Edges = Edges.AS_SOLVED) -> Setting:
    grid = cs.Grid((64, 32), (4e-4, 2e-4))
    parts = ErrorParts(3e-4, 5e-4, 1e-5)
    return Setting(mode, padding, grid, 1e-6, edges, parts, 0.25, 3_400_000)


EXACT = setting("exact", cs.ExactPeriodicity())
SIX = setting("circular", cs.CircularSuperposition(6), Edges.CORRECTED)
FREE = setting("free", (cs.ZeroPadding(), cs.ZeroPadding()))


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        (Limits(1e-3), "here: pressure in L1 to 0.001"),
        (Limits(1e-3, memory=2.5e9), "here: pressure in L1 to 0.001 in 2.5e+03 MB"),
        (Limits(1e-3, seconds=12.0), "here: pressure in L1 to 0.001 in 12 s"),
        (Limits(1e-3, memory=2e6, seconds=12), "here: pressure in L1 to 0.001 in 2 MB in 12 s"),
    ],
)
def test_the_first_line_has_what_is_asked_and_no_limit_that_is_none(
    limits: Limits, said: str
) -> None:
    found = Recommendation(limits, EXACT, None, meets=True, affordable=True)
    lines = recommend._report_lines(found, "here", None, MEASURED)
    assert lines[0].replace(Metric.L1.value, "pressure in L1") == said
    assert lines[3] == "  seconds are measured on a small case now"
    assert "against the pressure at the cell centres" in lines[4]
    assert lines[5] == "  in Python:"
    asked = recommend._fields(found, None, FITTED)["asked"]
    limited = {name: of for name in ("memory", "seconds") if (of := getattr(limits, name)) < inf}
    assert asked == {"error": 1e-3, "metric": "l1"} | limited


@pytest.mark.parametrize(
    ("meets", "affordable", "first", "second"),
    [
        (True, True, "use", "runner-up"),
        (False, True, "no setting meets the requested error; the most accurate setting", "next"),
        (
            False,
            False,
            "no setting fits the time and memory limits; the fastest setting",
            "next",
        ),
    ],
)
def test_a_setting_is_said_with_its_cost(
    meets: bool,  # noqa: FBT001
    affordable: bool,  # noqa: FBT001
    first: str,
    second: str,
) -> None:
    found = Recommendation(Limits(1e-3), SIX, FREE, meets=meets, affordable=affordable)
    lines = recommend._report_lines(found, "here", None, FITTED)
    where = "64 x 32 cells over 0.0004 m x 0.0002 m, tolerance 1e-06"
    cost = (
        "    estimated error <= 0.00081 (truncation 0.0003, discretisation 0.0005, residual 1e-05), "
        "0.25 s on one thread, 3.4 MB"
    )
    assert lines[1:6] == [
        f"  {first}: circular, n = 6; {where}, pressure corrected at its edges",
        cost,
        f"  {second}: zero padding along both axes; {where}",
        cost,
        "  seconds are fitted to the times in pareto.nc",
    ]


def test_the_lines_of_python_have_the_setting_s_own_numbers() -> None:
    first, where, *rest = recommend.python(EXACT, None)
    assert first == "import contactstudy as cs"
    assert where == "from studies.reference.line_contact import SCENE as scene"
    assert rest == [
        "grid = cs.Grid((64, 32), (0.0004, 0.0002))",
        "problem = scene.problem(grid, cs.ExactPeriodicity())",
        "solution = cs.solve(problem, tolerance=1e-06)",
        "pressure = solution.pressure",
    ]
    corrected = recommend.python(SIX, Path("a.toml"))
    assert corrected[:3] == [
        first,
        "from contactstudy.accuracy.contact_edge import corrected_pressure",
        "scene = cs.read_scene('a.toml').scene",
    ]
    assert corrected[-3] == "problem = scene.problem(grid, cs.CircularSuperposition(images=6))"
    assert corrected[-1] == "pressure = corrected_pressure(solution.pressure)"
    assert len(corrected) == 7
    assert "problem(grid, (cs.ZeroPadding(), cs.ZeroPadding()))" in recommend.python(FREE, None)[3]


@pytest.mark.parametrize("setting_of", [EXACT, SIX, FREE])
def test_the_tables_for_a_scene_file_are_read_back(setting_of: Setting, tmp_path: Path) -> None:
    text = (EXAMPLES / "smooth.toml").read_text(encoding="utf-8")
    bare = re.sub(r"\[(plan|solve|grid|padding)\]\n(\w.*\n)*", "", text)
    path = tmp_path / "chosen.toml"
    path.write_text("\n".join([bare, *recommend.toml(setting_of)]), encoding="utf-8")
    found = cs.read_scene(path)
    assert found.grid == setting_of.grid
    assert found.padding == setting_of.padding
    assert found.settings.tolerance == setting_of.tolerance
