"""Reference pages made from the program itself: public names, keys of a scene file, studies, statuses."""

import ast
import re
from dataclasses import MISSING, fields
from enum import Enum
from importlib import import_module
from importlib.util import find_spec
from inspect import getdoc, isclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from key_meanings import described_by, meanings
from numpy.typing import ArrayLike, DTypeLike, NDArray
from sphinx.application import Sphinx
from sphinx.util.typing import stringify_annotation

import contactstudy as cs
from contactstudy.domain.validation import notes
from contactstudy.io.scene_files.scene_schema import KINDS, NO_KIND, SceneDocument, materials
from studies.advice.verdict import COLUMNS
from studies.engine.options import RunOptions
from studies.engine.run import run
from studies.model.outcome import CaseStatus
from studies.model.study import Study
from studies.registry import BUILT_IN, SCENES, load

# Where a public name is documented, by the folder of its module; what is not listed here goes to the last.
GROUPS = {
    "answers": "Answers",
    "scene": "What a scene is made of",
    "evolution": "Histories and state variables",
    "domain": "Grids, paddings, checks",
    "solvers": "Solving",
    "accuracy": "Errors",
    "planning": "Plans",
    "io": "Files and datasets",
    "problem": "Problems, constraints, controls",
    "elasticity": "Operators and influence coefficients",
    "": "Other names",
}


CASES = {
    CaseStatus.NOT_RUN: "this combination of values was never computed",
    CaseStatus.OK: "computed and stored",
    CaseStatus.FAILED: "raised an error or gave NaN; the variable `error` has the sentence",
    CaseStatus.TIMEOUT: "took longer than `--time-limit`",
    CaseStatus.KILLED: "its process was killed, or died, twice",
}
# What signatures and docstrings of public names refer to often, and a user need not import.
ARRAYS = (
    ".. py:currentmodule:: None",
    "",
    ".. py:class:: Array",
    "",
    "   A numpy array of real numbers, of the shape that the docstring gives.",
    "",
    ".. py:class:: ArrayLike",
    "",
    "   What numpy makes an array of: a number, a sequence of numbers, an array.",
    "",
)
INNER = (
    "domain.errors.ErrorParts",
    "elasticity.convolution.superposed",
    "io.compare.Comparison",
    "io.quantities.quantity.Quantity",
    "planning.planned.Plan",
    "problem.constraint.Gap",
    "problem.constraint.PrescribedApproach",
    "problem.problem.Operator",
    "scene.scene.Output",
    "scene.surfaces.text_surface.Reading",
    "accuracy.coarser.coarse_solution",
    "accuracy.estimate.error_estimate",
    "answers.answer.Answer",
    "accuracy.coarser.edge_error",
    "accuracy.coarser.discretisation_errors",
    "accuracy.error_terms.image_errors",
    "domain.device.Device",
    "domain.device.Namespace",
    "elasticity.tangential.GeneralConvolution",
    "elasticity.tangential.ShearResponse",
    "elasticity.viscoelastic.Creep",
    "evolution.time_stepper.Frame",
    "evolution.states.plastic.PlasticState",
    "io.scene_files.scene_schema.PlanSettings",
    "problem.problem.Derived",
    "problem.problem.Field",
    "problem.problem.OuterSolver",
    "problem.problem.Source",
    "scene.solids.bodies.SceneContext",
    "scene.scene.Friction",
    "scene.scene.PosedScene",
    "scene.shapes.shape.ShapesSource",
    "scene.shapes.roughness.Profile",
    "scene.stress.SubsurfaceStressOperator",
    "elasticity.kernels.stress.HalfSpaceStress",
    "scene.solids.coated.CoatedStress",
    "solvers.fretting.PartialSlipShear",
    "solvers.coulomb.FullSliding",
    "solvers.solve.LaggedSolution",
    "solvers.solve.solve_with_mixing",
    "solvers.solution.TangentialTraction",
)


def group_of(name: str) -> str:
    """The folder of the module that defines a public name, from the list of public names."""
    folder = (MODULES.get(name, "") + ".").split(".")[0]
    return folder if folder in GROUPS else ""


MODULES = {
    alias.name: node.module or ""
    for node in ast.walk(ast.parse(Path(cs.__file__).with_suffix(".pyi").read_text(encoding="utf-8")))
    if isinstance(node, ast.ImportFrom)
    for alias in node.names
}


def names() -> str:
    """A page with every public name."""
    groups: dict[str, list[str]] = {}
    for name in cs.__all__:
        if name != "__version__":
            groups.setdefault(group_of(name), []).append(name)
    text = ["# Public names", "", "`import contactstudy as cs`. Everything is in SI units.", ""]
    for group, title in GROUPS.items():
        if group not in groups:
            continue
        text += [f"## {title}", ""]
        for name in sorted(groups[group], key=str.lower):
            thing = getattr(cs, name)
            if isclass(thing):
                directive = f".. autoclass:: contactstudy.{name}\n   :members:"
                if issubclass(thing, Enum):
                    directive += "\n   :undoc-members:"
            elif callable(thing):
                directive = f".. autofunction:: contactstudy.{name}"
            elif (
                getdoc(thing)
                and hasattr(thing, "__name__")
                and hasattr(thing, "__path__") is False
                and type(thing).__name__ == "module"
            ):
                directive = f".. automodule:: contactstudy.{name}\n   :members:"
            else:
                directive = f".. autodata:: contactstudy.{name}\n   :no-value:"
            text += ["```{eval-rst}", directive, "```", ""]
    return "\n".join([*text, *inner_names()])


def inner_names() -> list[str]:
    """The part of the page with the types that are seen in signatures alone."""
    text = ["## Types in signatures", "", "They need not be imported.", "", "```{eval-rst}", *ARRAYS]
    for name in INNER:
        module, _, last = name.rpartition(".")
        kind = "class" if isclass(getattr(import_module(f"contactstudy.{module}"), last)) else "function"
        text += [f".. auto{kind}:: contactstudy.{name}", ""]
    return [*text, "```", ""]


def _type(wanted: Any) -> str:
    """A type as a person writes it in a scene file."""
    if get_origin(wanted) is Annotated:
        unit, limits = notes(wanted)
        what = "a whole number" if unit is None else unit.quantity
        symbol = "" if unit is None else f" ({unit.symbol or 'no unit'})"
        return f"{what} {limits.text}".strip() + symbol
    if get_origin(wanted) is Literal:
        return "one of " + ", ".join(f'`"{one}"`' for one in get_args(wanted))
    if wanted in KINDS:
        text = "a table with a `kind`: " + ", ".join(f"`{kind}`" for kind in KINDS[wanted] if kind)
        without = KINDS[wanted].get(NO_KIND)
        return text + (f" (`{without.__name__}` if left out)" if without else "")
    if get_origin(wanted) is tuple:
        several = [one for one in get_args(wanted) if one is not ...]
        return "a list of: " + "; ".join(dict.fromkeys(_type(one) for one in several))
    if args := [one for one in get_args(wanted) if one is not type(None)]:
        return " or ".join(_type(one) for one in args)
    return {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}.get(
        wanted, f"a table: `{getattr(wanted, '__name__', wanted)}`"
    )


def _table(kind: type) -> list[str]:
    hints = get_type_hints(kind, include_extras=True)
    meaning = meanings(kind)
    rows = ["| key | value | default | meaning |", "|---|---|---|---|"]
    for field in fields(kind):
        if not field.init:
            continue
        if field.default is not MISSING:
            default = (
                f"`{field.default!r}`" if not isinstance(field.default, Enum) else f'`"{field.default.name.lower()}"`'
            )
        elif field.default_factory is not MISSING:
            made = field.default_factory()
            default = f"`{made!r}`" if len(repr(made)) < 40 else f"`{type(made).__name__}` with its defaults"
        else:
            default = "required"
        rows.append(
            f"| `{field.name}` | {_type(hints[field.name])} | {default} | {meaning.get(field.name, '')} |".replace(
                "\n", " "
            )
        )
    return rows


def keys() -> str:
    """A page with every key of a scene file."""
    text = [
        "# Keys of a scene file",
        "",
        'Numbers are in SI units; a text with a unit, such as `"10 mm"`, is converted. A table that may be of several '
        "kinds says which by its key `kind`.",
        "",
        "## Top level",
        "",
        *_table(SceneDocument),
        "",
        "A solid may name its `material`, whose constants stand beside the keys given there: see [materials](materials.md). "
        "A table `vary` holds the fields and values of a sweep, `[[vary]]` groups of fields that change together.",
    ]
    done: set[type] = set()
    described = [one for kinds in KINDS.values() for kind in kinds.values() for one in described_by(kind)]
    plain = [one for hint in get_type_hints(SceneDocument).values() for one in _plain(hint)]
    queue = plain + [kind for kinds in KINDS.values() for kind in kinds.values()]
    for kind in queue:  # which grows by the tables inside
        if kind in done or kind in described:
            continue
        done.add(kind)
        queue += [one for hint in get_type_hints(kind).values() for one in _plain(hint)]
        name = next((n for kinds in KINDS.values() for n, k in kinds.items() if k is kind), kind.__name__)
        first = (getdoc(kind) or "").split("\n\n")[0].replace("\n", " ")
        text += [
            "",
            f"## `{name}`",
            "",
            re.sub(r":\w+:`~?(?:\w+\.)*(\w+)`", r"`\1`", first).replace("``", "`"),
            "",
            *(_table(kind) if fields(kind) else []),
        ]
    return "\n".join(text)


def _plain(hint: Any) -> list[type]:
    found = [hint, *get_args(hint)]
    return [one for one in found if isclass(one) and hasattr(one, "__dataclass_fields__")]


VARIABLES = ("| variable | meaning | units |", "|---|---|---|")


def variables(study: Study) -> list[str]:
    """A row for each variable of a study, which is run at its last point."""
    last = study.override({axis.name: axis.values[-1:] for axis in study.axes})
    options = RunOptions(workers=0, repeats=1)
    with TemporaryDirectory() as folder:
        dataset = run(last, Path(folder), options=options, log=lambda _: None)
    return [
        f"| `{name}` | {one.attrs.get('long_name', '')} | {one.attrs.get('units', '')} |"
        for name, one in dataset.data_vars.items()
    ]


def studies() -> str:
    """A page with every study and its axes, and the variables of those that are no scene file."""
    text = ["# Studies", "", "Every axis can be varied: `contactstudy run STUDY --vary AXIS=VALUES`.", ""]
    for name in BUILT_IN:
        study = load(name)
        text += [f"## `{name}`", "", study.title, "", "| axis | values | meaning |", "|---|---|---|"]
        for axis in study.axes:
            values = ", ".join(str(value) for value in axis.values)
            unit = f" [{axis.units}]" if getattr(axis, "units", "1") not in ("", "1") else ""
            text.append(f"| `{axis.name}` | {values} | {axis.long_name}{unit} |")
        if name not in SCENES:
            text += ["", *VARIABLES, *variables(study)]
        text.append("")
    text += ["## `settings`", "", "The file of `contactstudy report --scene`, by settings.", ""]
    text += VARIABLES
    text += [f"| `{name}` | {meaning} | {units} |" for name, (units, meaning) in COLUMNS.items()]
    return "\n".join(text)


def statuses() -> str:
    """A page with every status of a solution and of a case."""
    text = ["# Statuses", "", "## Of a solution", "", "| status | meaning |", "|---|---|"]
    text += [f"| `{one.name}` | {one.value} |" for one in cs.Status]
    text += [
        "",
        "## Of a case in a sweep",
        "",
        "The variable's CF attributes `flag_values` and `flag_meanings` say the same in every file.",
        "",
    ]
    text += ["| `case_status` | value | meaning |", "|---|---|---|"]
    text += [f"| `{one.name}` | {one.value} | {CASES[one]} |" for one in CaseStatus]
    return "\n".join(text)


def material_table() -> str:
    """Return a page with every material that a scene file can name."""
    text = [
        "# Materials",
        "",
        '`material = "steel"` in a solid of a scene file, `cs.material("steel")` in Python. Keys beside it take the place of these',
        "values. Moduli of one batch differ by some per cent, those of coatings and polymers by far more. A body of a material",
        "stays elastic; a warning says where the peak pressure is beyond its hardness or its first yield. Strength depends on",
        "grade and heat treatment: give `yield_stress` and `hardness` of yours.",
        "",
        "| material | Young's modulus [GPa] | Poisson's ratio | yield stress [GPa] | hardness [GPa] | synonyms | source |",
        "|---|---|---|---|---|---|---|",
    ]
    text += [
        f"| `{m.name}` | {m.youngs_modulus / 1e9:g} | {m.poisson_ratio:g} | {_known(m.yield_stress)} | {_known(m.hardness)} | "
        f"{', '.join(m.synonyms)} | {m.source} |"
        for m in materials().values()
    ]
    return "\n".join(text)


def _known(pressure: float) -> str:
    """Return a pressure in GPa, nothing where it is not known."""
    return f"{pressure / 1e9:g}" if pressure < float("inf") else ""


def write(app: Sphinx) -> None:
    """Write the pages where their text has changed."""
    folder = Path(app.srcdir) / "reference"
    pages = {
        "names": names(),
        "scene-file-keys": keys(),
        "studies": studies(),
        "materials": material_table(),
        "statuses": statuses(),
    }
    for name, text in pages.items():
        path = folder / f"{name}.md"
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text)


# Texts in signatures, and what a person reads instead: a quantity is a float, a field an Array; units are in the docstring.
PLAINER = (
    (
        r"~?(?:typing\.)?Annotated\[(float|int)(?:, ~?contactstudy\.domain\.\w+\.\w+"
        r"\((?:[^()]|\([^()]*\))*\))+\]",
        r"\1",
    ),
    # an example for messages, with brackets in it
    (
        r"~?[\w.]*Annotated\[([^\[\],]+), ~?contactstudy\.domain\.validation\.Example"
        r"\((?:[^()]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))*\)\]",
        r"\1",
    ),
    (re.escape(stringify_annotation(NDArray[np.floating[Any]], "smart")), "Array"),
    (re.escape(stringify_annotation(ArrayLike, "smart")), "ArrayLike"),
    (re.escape(stringify_annotation(DTypeLike, "smart")), "~numpy.typing.DTypeLike"),
    (r"<[^<>]*>", "..."),  # the repr of a default is not Python
    # types that are imported for checking alone
    (r"(?<![\w.])xr\.Dataset\b", "~xarray.Dataset"),
    (r"(?<![\w.])Figure\b", "~matplotlib.figure.Figure"),
    (r"(?<![\w.])FirstGrids\b", "~contactstudy.planning.refinement.FirstGrids"),
)


def shorten(
    app: Sphinx, what: str, name: str, obj: object, options: object, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Signatures as a person reads them; a protocol is not called."""
    if what == "class" and getattr(obj, "_is_protocol", False):
        return "", None

    def short(text: str | None) -> str | None:
        for pattern, plainer in PLAINER:
            text = text and re.sub(pattern, plainer, text)
        return text

    return short(signature), short(returns)


def escape(app: Sphinx, context: object, lines: list[str]) -> None:
    """Asterisks in the help of options are file patterns, not emphasis; a default that is a path is its text."""
    plain = [re.sub(r"\w*Path\('([^']*)'\)", r"'\1'", line) for line in lines]
    lines[:] = [line.replace("/*.", "/\\*.") for line in plain]


def inner(app: Sphinx, env: object, node: Any, contnode: Any) -> Any:
    """A name inside the project that is documented nowhere is shown without a link, if the code has it."""
    module, _, last = str(node.get("reftarget")).rpartition(".")
    if not module.startswith(("contactstudy.", "studies.")):
        return None
    return contnode if find_spec(module) and hasattr(import_module(module), last) else None


def setup(app: Sphinx) -> dict[str, object]:
    """Write the pages before anything is read."""
    app.connect("builder-inited", write)
    app.connect("autodoc-process-signature", shorten)
    app.connect("sphinx-click-process-options", escape)
    app.connect("missing-reference", inner)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
