"""The part of a study file that can change a number: its syntax tree without the statements for axes and figures."""

import ast
import re
from collections.abc import Iterator

from studies.store.fingerprint.modules import PYTHON, digest

ALWAYS_USED = frozenset({"case_at", "measures"})
# words by which a file may use a name that it does not contain
REFLECTIVE = frozenset((
    "globals", "locals", "vars", "eval", "exec", "dir", "__dict__", "__globals__", "f_globals", "f_locals", "modules",
    "inspect", "__import__",
))  # fmt: skip
PURE = frozenset((
    "np.arange", "np.array", "np.geomspace", "np.linspace", "np.logspace",
    "Axis", "abs", "dict", "enumerate", "float", "frozenset", "int", "len", "list", "max", "min", "range", "reversed",
    "round", "set", "sorted", "str", "sum", "tuple", "zip",
))  # fmt: skip
WORD = re.compile(r"\w+")
Names = frozenset[str]


def numerical_part(source: bytes) -> str:
    """Return a digest of the statements of a study file that can change a number.

    A statement that does nothing but define names is left out unless a statement that counts uses one of the names.
    Comments, layout and documentation do not count.
    """
    body = ast.parse(source).body
    words = [frozenset(_words(statement)) for statement in body]
    everything = frozenset().union(*words[1:] if body and _is_text(body[0]) else words)
    if "__doc__" not in everything:
        body = [statement for statement in body if not _is_text(statement)]
        _remove_docstrings(body)
        words = [frozenset(_words(statement)) for statement in body]
    bound = frozenset(_bound(body))
    pure = frozenset(name for name in PURE if not bound & {"*", name.split(".")[0]})
    is_reflective = any(map(_is_reflective, body))
    defined = [_defined(statement, pure) for statement in body]
    always = (names is None or names & ALWAYS_USED or is_reflective for names in defined)
    selected = {index for index, is_used in enumerate(always) if is_used}
    reached: set[int] = set()
    while selected != reached:
        reached = set(selected)
        used_names = frozenset().union(*(words[index] for index in selected))
        selected |= {index for index, names in enumerate(defined) if names and names & used_names}
    statements = (ast.dump(body[index]) for index in sorted(selected))
    return digest("\n".join([PYTHON, *statements]).encode())


def _words(node: ast.AST) -> Iterator[str]:
    """Yield every name, attribute and word of a text in a statement."""
    for part in ast.walk(node):
        match part:
            case ast.Name(id=name) | ast.Attribute(attr=name):
                yield name
            case ast.Constant(value=str(value)):
                yield from WORD.findall(value)
            case ast.alias(name=name):
                yield from name.split(".")
            case ast.Global(names=names) | ast.Nonlocal(names=names):
                yield from names


def _is_reflective(statement: ast.stmt) -> bool:
    """Return whether a statement may use names that it does not contain."""
    parts = [vars(part) for part in ast.walk(statement)]
    used = (part.get(word) for part in parts for word in ("id", "attr", "name", "module", "value"))
    return any(isinstance(word, str) and word in REFLECTIVE for word in used)


def _bound(body: list[ast.stmt]) -> Iterator[str]:
    """Yield the names that a file binds itself, and "*"; not those of studies, nor np for numpy."""
    for node in (part for statement in body for part in ast.walk(statement)):
        match node:
            case (
                ast.Name(id=name, ctx=ast.Store() | ast.Del())
                | ast.FunctionDef(name=name)
                | ast.AsyncFunctionDef(name=name)
                | ast.ClassDef(name=name)
            ):
                yield name
            case ast.ImportFrom(module=str(module), names=aliases) if (
                module.split(".")[0] == "studies"
            ):
                yield from (alias.asname for alias in aliases if alias.asname)
            case ast.ImportFrom(names=aliases) | ast.Import(names=aliases):
                yield from (
                    alias.asname or alias.name
                    for alias in aliases
                    if ast.unparse(alias) != "numpy as np"
                )


def _defined(statement: ast.stmt, pure: Names) -> Names | None:
    """Return the names that a statement defines; None if it does anything else."""
    match statement:
        case ast.FunctionDef(decorator_list=[]) | ast.AsyncFunctionDef(decorator_list=[]):
            # an argument is evaluated by its annotation and its default
            evaluated, names = [statement.args, statement.returns], [statement.name]
        case ast.Assign(targets=targets) if all(isinstance(part, ast.Name) for part in targets):
            evaluated, names = [statement.value], [ast.unparse(part) for part in targets]
        case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr()):
            evaluated, names = [statement.value, statement.annotation], [name]
        case _:
            return None
    parts = (
        part
        for expression in evaluated
        if expression is not None
        for part in _evaluated(expression)
    )
    return frozenset(names) if all(_is_pure(part, pure) for part in parts) else None


def _evaluated(node: ast.AST) -> Iterator[ast.AST]:
    """Yield every part of an expression that is evaluated with it: not the body of a lambda."""
    yield node
    for part in [node.args] if isinstance(node, ast.Lambda) else ast.iter_child_nodes(node):
        yield from _evaluated(part)


def _is_pure(node: ast.AST, pure: Names) -> bool:
    """Return whether evaluating this part of an expression has no effect but its value."""
    if isinstance(node, ast.NamedExpr | ast.Await | ast.Yield | ast.YieldFrom):
        return False
    return not isinstance(node, ast.Call) or ast.unparse(node.func) in pure


def _is_text(statement: ast.stmt) -> bool:
    """Return whether a statement is a string literal."""
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _remove_docstrings(body: list[ast.stmt]) -> None:
    """Remove texts that document functions and classes."""
    for node in (part for statement in body for part in ast.walk(statement)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            node.body = [part for part in node.body if not _is_text(part)]
