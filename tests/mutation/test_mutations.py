import ast
from pathlib import Path

from tests.mutation.campaign import stages
from tests.mutation.mutations import chosen, mutations

ROOT = Path(__file__).parents[2]

SOURCE = '''"""Halves 3."""
LIMIT: float = 1.5


def half(x: int) -> float:
    """Of 2."""
    if x <= 0:
        raise ValueError(f"{x + 1} is 3")
    return max(-x, x) / 2
'''


def test_signs_factors_indices_comparisons_and_extremes_are_changed_and_words_are_not() -> None:
    found = [(one.line, one.old, one.new) for one in mutations("half.py", SOURCE)]
    assert found == [
        (2, "1.5", "3.0"),
        (7, "<=", "<"),
        (7, "0", "1"),
        (9, "max", "min"),
        (9, "-", "+"),
        (9, "/", "*"),
        (9, "2", "3"),
    ]


def test_a_hundred_changes_are_the_same_each_time_spread_over_modules_and_valid() -> None:
    found = chosen(ROOT, 100, seed=1)
    assert found == chosen(ROOT, 100, seed=1)
    assert len(set(found)) == 100
    assert len({one.path for one in found}) > 60
    for one in found:
        text = (ROOT / one.path).read_text(encoding="utf-8")
        assert ast.dump(ast.parse(one.applied(text))) != ast.dump(ast.parse(text)), one


def test_every_module_has_tests_that_are_there() -> None:
    for one in chosen(ROOT, 200, seed=2):
        for tests in stages(one.path):
            assert all((ROOT / test).exists() for test in tests), one.path
