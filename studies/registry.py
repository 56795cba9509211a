"""The studies there are: by name, or in a Python file."""

import importlib
import importlib.util
import sys
from pathlib import Path
from types import ModuleType

from contactstudy import InvalidInput
from contactstudy.domain.checks import remedy
from studies.model.study import Study, silent

# Those the report is made of, in its order, and those that need more than this project installs.
BUILT_IN = {
    "paper": "studies.definitions.periodicity.paper",
    "padding": "studies.definitions.periodicity.padding",
    "images": "studies.definitions.periodicity.images",
    "period": "studies.definitions.periodicity.period",
    "grid": "studies.definitions.periodicity.grid",
    "kernels": "studies.definitions.periodicity.kernels",
    "speed": "studies.definitions.cost.speed",
    "roughness": "studies.definitions.scenes.roughness",
    "effects": "studies.definitions.scenes.effects",
    "pareto": "studies.definitions.cost.pareto",
    "stability": "studies.definitions.scenes.stability",
}
OPTIONAL = {"peers": "studies.definitions.cost.peers"}


def load(name: str) -> Study:
    """The built-in study of that name, or the one in a Python file.

    Raises :class:`~contactstudy.InvalidInput` where there is none, or one of its four names is missing.
    """
    if name.endswith(".py"):
        if Path(name).stem in BUILT_IN | OPTIONAL:
            raise InvalidInput(f"Study file {name!r} has the name of a built-in study: rename it.")
        return _study(Path(name).stem, _from_file(Path(name)))
    known_studies = BUILT_IN | OPTIONAL
    if name not in known_studies:
        known = remedy(name, sorted(known_studies))
        raise InvalidInput(f"Study {name!r} is not known: {known}, or give a .py file.")
    return _study(name, importlib.import_module(known_studies[name]))


def _from_file(path: Path) -> ModuleType:
    # a name of its own, lest a file called time.py be taken for Python's
    name = f"study_in_file_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if not path.is_file() or spec is None or spec.loader is None:
        raise InvalidInput(
            f"Study file {str(path)!r} cannot be read: give the path of a Python file."
        )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    # workers know nothing of this file: send its functions by value, not by name
    from cloudpickle import register_pickle_by_value

    sys.modules[name] = module
    register_pickle_by_value(module)
    return module


def _study(name: str, module: ModuleType) -> Study:
    for part in ("points", "scene_at", "measures", "figure"):
        if not hasattr(module, part):
            raise InvalidInput(
                f"Study {name!r} has no {part!r}: define it at the file's top level."
            )
    title = (module.__doc__ or name).strip().split("\n")[0]
    return Study(
        name,
        title,
        tuple(module.points),
        module.scene_at,
        module.measures,
        module.figure,
        getattr(module, "findings", silent),
        getattr(module, "tables", silent),
        getattr(module, "times", "taken"),
    )
