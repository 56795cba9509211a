"""Changes a clone of the code in one place at a time and tells which changes no test notices.

Of the tests of the default tier those run that execute the changed line: first the module's own, then those of its
folder, then the quickest.
"""

import argparse
import ast
import os
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

from coverage import CoverageData

ROOT = Path(__file__).parents[1]
OTHER = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult, ast.Lt: ast.GtE,
    ast.GtE: ast.Gt, ast.Gt: ast.LtE, ast.LtE: ast.Lt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.USub: ast.UAdd,
}  # fmt: skip
EXTREMES = {"max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum"}
# Where nothing is computed: what is said, and what types are.
SPOKEN = (ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom)
DECLARED = ("annotation", "returns", "decorator_list")
Change = tuple[Path, int, bytes, bytes]  # of a file the bytes from a place on, and what they become


def change(node: ast.AST) -> bool:
    """Change a sign, a factor, an index, a comparison or an extreme; False where the node is none of them."""
    match node:
        case ast.BinOp(op=op) | ast.AugAssign(op=op) | ast.UnaryOp(op=op) if type(op) in OTHER:
            node.op = OTHER[type(op)]()
        case ast.Compare(ops=[op, *others]) if type(op) in OTHER:
            node.ops = [OTHER[type(op)](), *others]
        case ast.Constant(value=value) if type(value) in (int, float):
            node.value = value + 1 if type(value) is int else 2 * value or 1.0
        case ast.Call(func=ast.Name(id=name) as called) if name in EXTREMES:
            called.id = EXTREMES[name]
        case ast.Call(func=ast.Attribute(attr=name) as called) if name in EXTREMES:
            called.attr = EXTREMES[name]
        case _:
            return False
    return True


def computing(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those that say something or declare a type."""
    for name, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST) and not isinstance(child, SPOKEN) and name not in DECLARED:
                yield child
                yield from computing(child)


def changes(path: Path) -> Iterator[Change]:
    """All single changes of a file."""
    content = path.read_bytes()
    lines = content.splitlines(keepends=True)
    for node in computing(ast.parse(content)):
        if change(node):
            ends = ((node.lineno, node.col_offset), (node.end_lineno, node.end_col_offset))
            start, end = (len(b"".join(lines[: line - 1])) + column for line, column in ends)
            yield path, start, content[start:end], ast.unparse(node).encode()


def pytest(clone: Path, *words: str, seconds: float = 7200) -> subprocess.CompletedProcess[str]:
    """Run tests of the clone; after so long they and what they started are ended."""
    return subprocess.run(
        ["timeout", "--kill-after=9", str(seconds), sys.executable, "-m", "pytest", "-q", *words],
        cwd=clone, env=os.environ | {"PYTHONPATH": str(clone)}, capture_output=True, text=True,
    )  # fmt: skip


def times(clone: Path) -> dict[str, float]:
    """Seconds of each test that passes on the unchanged code; a new clone is made and its tests are run once."""
    record = clone / "tests.xml"
    if not record.exists():
        subprocess.run(["git", "clone", "-q", ROOT, clone], check=True)
        covered = ("--cov=contactstudy", "--cov=studies", "--cov-context=test", "--cov-report=")
        pytest(clone, *covered, f"--junitxml={record}")
    return {
        f"{case.attrib['classname'].replace('.', '/')}.py::{case.attrib['name']}": float(case.attrib["time"])
        for case in ElementTree.parse(record).iter("testcase")
        if not len(case)
    }  # fmt: skip


def chosen(path: Path, line: int, clone: Path, took: dict[str, float], seconds: float) -> list[str]:
    """Tests that execute a line; of what is executed at the import, those of the module's folder."""
    data = CoverageData(str(clone / ".coverage"))
    data.read()
    lines = data.contexts_by_lineno(str(path.relative_to(clone)))
    executed = max((one for one in lines if one <= line), default=0)
    calling = set[str]()
    for test, _, phase in (context.rpartition("|") for context in lines.get(executed, ())):
        # what a fixture of a module does counts for the first test that takes it, and all of the module may judge it
        of_module = f"{test.partition('::')[0]}::"
        calling |= {other for other in took if other == test or (phase == "setup" and other.startswith(of_module))}
    folder = f"tests/{path.relative_to(clone).parent.as_posix()}/"
    own = f"{folder}test_{path.stem}"
    tests = []
    for test in sorted(
        calling or {test for test in took if test.startswith(folder)},
        key=lambda test: (not test.startswith((f"{own}.py", f"{own}_")), not test.startswith(folder), took[test]),
    ):
        tests += [test] * (seconds > 0)
        seconds -= took[test]
    return tests


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=70)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="modules whose path begins so")
    parser.add_argument("--seconds", type=float, default=30.0, help="of tests on each change")
    parser.add_argument("--clone", type=Path, default=ROOT / ".mutation", help="remove it to begin anew")
    asked = parser.parse_args()
    clone = asked.clone.absolute()
    took = times(clone)
    files = sorted(path for name in ("contactstudy", "studies") for path in (clone / name).rglob("*.py"))
    found = [one for path in files if str(path.relative_to(clone)).startswith(asked.only) for one in changes(path)]
    survived = 0
    for path, start, old, new in random.Random(asked.seed).sample(found, asked.count):
        content = path.read_bytes()
        line = content.count(b"\n", 0, start) + 1
        tests = chosen(path, line, clone, took, asked.seconds)
        limit = 60 + 10 * sum(took[test] for test in tests)
        try:
            path.write_bytes(content[:start] + new + content[start + len(old) :])
            done = pytest(clone, "-x", "-n", "0", "-p", "no:cacheprovider", *tests, seconds=limit)
        finally:
            path.write_bytes(content)
        survived += done.returncode == 0
        failed = [word for word in done.stdout.splitlines() if word.startswith(("FAILED", "ERROR"))]
        fate = (failed or [f"noticed, code {done.returncode}"])[0] if done.returncode else "survived"
        print(
            f"{path.relative_to(clone)}:{line}: {old.decode()} -> {new.decode()}: {fate}",
            flush=True,
        )
    print(f"{survived} of {asked.count} changes survived")


if __name__ == "__main__":
    main()
