"""Single changes of a source text: a sign, a factor, an index or a comparison."""

import ast
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SWAPPED = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
}
COMPARED = {
    ast.Lt: ("<", ">="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", "<="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
}
EXTREMES = {"max": "min", "min": "max", "maximum": "minimum", "minimum": "maximum"}
# Where nothing is computed: what is said, and what types are.
SPOKEN = (ast.Raise, ast.JoinedStr, ast.AnnAssign, ast.Import, ast.ImportFrom)


@dataclass(frozen=True)
class Mutation:
    """Of the file at ``path`` the text from ``start`` to ``end``, ``old``, becomes ``new``."""

    path: str
    line: int
    start: int
    end: int
    old: str
    new: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.old!r} -> {self.new!r}"

    def applied(self, text: str) -> str:
        """The changed text."""
        assert text[self.start : self.end] == self.old
        return text[: self.start] + self.new + text[self.end :]


def mutations(path: str, text: str) -> list[Mutation]:
    """All single changes of a source text, in its order."""
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    lines = text.splitlines(keepends=True)

    def at(line: int, column: int) -> int:
        # columns count bytes
        return starts[line - 1] + len(lines[line - 1].encode()[:column].decode())

    def span(node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return at(node.lineno, node.col_offset), at(node.end_lineno, node.end_col_offset)

    found = []
    for start, end, new in _changes(ast.parse(text), text, span):
        line = text.count("\n", 0, start) + 1
        found.append(Mutation(path, line, start, end, text[start:end], new))
    return sorted(set(found), key=lambda one: (one.start, one.end))


def _changes(tree: ast.Module, text: str, span) -> Iterator[tuple[int, int, str]]:  # noqa: ANN001
    for node in _computing(tree):
        if isinstance(node, ast.BinOp | ast.AugAssign) and type(node.op) in SWAPPED:
            left, right = (
                (node.left, node.right)
                if isinstance(node, ast.BinOp)
                else (node.target, node.value)
            )
            yield from _between(text, span(left)[1], span(right)[0], *SWAPPED[type(node.op)])
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARED:
            before, after = span(node.left)[1], span(node.comparators[0])[0]
            yield from _between(text, before, after, *COMPARED[type(node.ops[0])])
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            start, _ = span(node)
            yield start, start + 1, "+"
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            start, end = span(node)
            more = node.value + 1 if type(node.value) is int else 2 * node.value or 1.0
            yield start, end, str(more)
        elif isinstance(node, ast.Call):
            called = node.func
            name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
            if name in EXTREMES:
                _, end = span(called)
                yield end - len(name), end, EXTREMES[name]


def _between(text: str, start: int, end: int, old: str, new: str) -> Iterator[tuple[int, int, str]]:
    place = text.find(old, start, end)
    if place >= 0 and "#" not in text[start:place]:
        yield place, place + len(old), new


def _computing(node: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those that say something or declare a type."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST):
                continue
            if isinstance(child, ast.AnnAssign) and child.value is not None:
                yield from (child.value, *_computing(child.value))
            elif not isinstance(child, SPOKEN):
                yield child
                yield from _computing(child)


def chosen(root: Path, count: int, seed: int, only: str = "") -> list[Mutation]:
    """``count`` changes drawn from all of both packages; the same for the same code and seed."""
    found = []
    for path in sorted([*root.glob("contactstudy/**/*.py"), *root.glob("studies/**/*.py")]):
        name = path.relative_to(root).as_posix()
        if name.startswith(only):
            found += mutations(name, path.read_text(encoding="utf-8"))
    drawn = random.Random(seed).sample(found, min(count, len(found)))
    return sorted(drawn, key=lambda one: (one.path, one.start))
