"""Materials by name, with their elastic constants and where these are from."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from contactstudy.domain.checks import InvalidInput, suggestion
from contactstudy.scene.bodies import HalfSpace


@dataclass(frozen=True)
class Material:
    """Elastic constants of a material.

    Parameters
    ----------
    name
        Name in scene files.
    youngs_modulus
        Young's modulus [Pa].
    poisson_ratio
        Poisson's ratio.
    source
        Where the constants are from.
    also
        Other names.
    """

    name: str
    youngs_modulus: float
    poisson_ratio: float
    source: str
    also: tuple[str, ...] = ()


@cache
def materials() -> Mapping[str, Material]:
    """Return all materials by their names."""
    text = (files("contactstudy.io") / "materials.toml").read_text(encoding="utf-8")
    return {
        name: Material(
            name,
            entry["youngs_modulus"] * 1e9,
            entry["poisson_ratio"],
            entry["source"],
            tuple(entry["also"]),
        )
        for name, entry in tomllib.loads(text).items()
    }


def material(name: str) -> HalfSpace:
    """Return the half-space of a material, such as ``material("steel")``.

    Raises :class:`~contactstudy.InvalidInput` for a name that is not in the table.
    """
    constants = _named("material", name)
    return HalfSpace(constants.youngs_modulus, constants.poisson_ratio)


def _named(field: str, name: object) -> Material:
    """Return the material of that name, or of another name for it, in any case."""
    names = {
        alias.lower(): entry
        for entry in materials().values()
        for alias in (entry.name, *entry.also)
    }
    if not isinstance(name, str) or name.lower() not in names:
        hint = suggestion(
            str(name), [alias for m in materials().values() for alias in (m.name, *m.also)]
        )
        raise InvalidInput(
            f"{field} is {name!r}: {hint}, or give youngs_modulus and poisson_ratio."
        )
    return names[name.lower()]


def with_materials(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return tables of a scene file with the constants of each ``material`` beside the keys given there."""

    def solid(value: Any, place: str) -> Any:
        if not isinstance(value, Mapping):
            return value
        inner = {key: solid(entry, f"{place}.{key}") for key, entry in value.items()}
        if "material" not in inner:
            return inner
        constants = _named(f"{place}.material", inner.pop("material"))
        elastic = {
            "youngs_modulus": constants.youngs_modulus,
            "poisson_ratio": constants.poisson_ratio,
        }
        return elastic | inner

    solids = table.get("solids")
    if not isinstance(solids, list):
        return dict(table)
    return dict(table) | {
        "solids": [solid(entry, f"solids[{n}]") for n, entry in enumerate(solids)]
    }
