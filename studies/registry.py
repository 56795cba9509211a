"""The studies there are: by name, or in a Python file.

Definitions and drawings are imported when they are asked for: what lists, runs or distributes studies
imports no plotting library.
"""

import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from contactstudy import InvalidInput
from contactstudy.domain.checks import suggestion
from studies.model.axis import one_of
from studies.model.drawing import Drawing, nothing
from studies.model.study import Study
from studies.study_file import module_in, module_name, study_in


class Modules(NamedTuple):
    """Where a built-in study is defined, and where it is drawn."""

    definition: str
    drawing: str


# The studies of the report, in its order, and those that need more than this project installs.
BUILT_IN = {
    "paper": Modules(
        "studies.definitions.periodicity.paper", "studies.report.drawings.periodicity.paper"
    ),
    "padding": Modules(
        "studies.definitions.periodicity.padding", "studies.report.drawings.periodicity.padding"
    ),
    "images": Modules(
        "studies.definitions.periodicity.images", "studies.report.drawings.periodicity.images"
    ),
    "period": Modules(
        "studies.definitions.periodicity.period", "studies.report.drawings.periodicity.period"
    ),
    "grid": Modules(
        "studies.definitions.periodicity.grid", "studies.report.drawings.periodicity.grid"
    ),
    "kernels": Modules(
        "studies.definitions.periodicity.kernels", "studies.report.drawings.periodicity.kernels"
    ),
    "solvers": Modules("studies.definitions.cost.solvers", "studies.report.drawings.cost.solvers"),
    "speed": Modules("studies.definitions.cost.speed", "studies.report.drawings.cost.speed"),
    "roughness": Modules(
        "studies.definitions.effects.roughness", "studies.report.drawings.effects.roughness"
    ),
    "creep": Modules("studies.definitions.effects.creep", "studies.report.drawings.effects.creep"),
    "wear": Modules("studies.definitions.effects.wear", "studies.report.drawings.effects.wear"),
    "coating": Modules(
        "studies.definitions.effects.coating", "studies.report.drawings.effects.coating"
    ),
    "plastic": Modules(
        "studies.definitions.effects.plastic", "studies.report.drawings.effects.plastic"
    ),
    "friction": Modules(
        "studies.definitions.effects.friction", "studies.report.drawings.effects.friction"
    ),
    "effects": Modules("studies.definitions.cost.effects", "studies.report.drawings.cost.effects"),
    "pareto": Modules("studies.definitions.cost.pareto", "studies.report.drawings.cost.pareto"),
    "stability": Modules("studies.definitions.stability", "studies.report.drawings.stability"),
    "accuracy": Modules("studies.definitions.accuracy", "studies.report.drawings.accuracy"),
}
OPTIONAL = {
    "peers": Modules("studies.definitions.cost.peers", "studies.report.drawings.cost.peers"),
}


def load(name: str) -> Study:
    """The built-in study of that name, or the one in a Python file.

    Raises :class:`~contactstudy.InvalidInput` if there is none, or if a file lacks one of its names.
    """
    if name.endswith(".py"):
        if Path(name).stem in BUILT_IN | OPTIONAL:
            raise InvalidInput(f"Study file {name!r} has the name of a built-in study: rename it.")
        return study_in(Path(name))
    return _study(name, importlib.import_module(_modules(name).definition))


def load_drawing(name: str, figures: str = "curves") -> Drawing:
    """How the study of that name, or the one in a Python file, is drawn.

    A scene, and a file without a figure of its own, have the default ``figures``: "curves" or "maps".
    """
    if name.endswith(".toml"):
        return default_drawing(figures)
    if name.endswith(".py"):
        module = sys.modules.get(module_name(Path(name))) or module_in(Path(name))
        if not hasattr(module, "figure"):
            return default_drawing(figures)
    else:
        module = importlib.import_module(_modules(name).drawing)
    return Drawing(
        module.figure, getattr(module, "findings", nothing), getattr(module, "tables", nothing)
    )


def default_drawing(figures: str = "curves") -> Drawing:
    """Figures that are chosen by what was varied."""
    # by name: pages draw what is registered here
    drawn = importlib.import_module("studies.report.default_drawing").FIGURES
    return Drawing(drawn[one_of("figures", figures, drawn)])


def _modules(name: str) -> Modules:
    known = BUILT_IN | OPTIONAL
    if name not in known:
        hint = suggestion(name, sorted(known))
        raise InvalidInput(f"Study {name!r} is not known: {hint}, or give a .py file.")
    return known[name]


def _study(name: str, module: ModuleType) -> Study:
    title = (module.__doc__ or name).strip().split("\n")[0]
    return Study(
        name,
        title,
        tuple(module.points),
        module.scene_at,
        module.measures,
        getattr(module, "times", "taken"),
    )
