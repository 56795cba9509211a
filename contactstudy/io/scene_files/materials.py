"""Table of materials: names, elastic constants, strength and their sources."""

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from math import inf
from typing import Annotated, Any

from contactstudy.domain import validation
from contactstudy.domain.validation import InvalidInput, in_si, suggestion, validated
from contactstudy.scene.solids.bodies import HalfSpace
from contactstudy.scene.solids.inelastic import ElasticPlasticHalfSpace


@validated
class Material:
    """Elastic constants and strength of a material.

    Parameters
    ----------
    name
        Name in scene files.
    youngs_modulus
        Young's modulus [Pa].
    poisson_ratio
        Poisson's ratio.
    source
        Publications that give the constants and the strength.
    synonyms
        Further names that scene files may use.
    yield_stress
        Tensile stress at which it yields [Pa], infinite for brittle materials.
    hardness
        Indentation hardness [Pa].
    """

    name: str
    youngs_modulus: validation.Pascals
    poisson_ratio: float
    source: str
    synonyms: tuple[str, ...] = ()
    yield_stress: Annotated[validation.Pascals, validation.OR_INFINITE] = inf
    hardness: Annotated[validation.Hardness, validation.OR_INFINITE] = inf

    def body_fields(self, kind: object = None) -> dict[str, Any]:
        """Return the fields of a body of this material, by name; `kind` is that of the body in a file."""
        elastic = {"youngs_modulus": self.youngs_modulus, "poisson_ratio": self.poisson_ratio}
        if kind == ElasticPlasticHalfSpace.__name__:
            return elastic | ({"yield_stress": self.yield_stress} if self.yield_stress < inf else {})
        return elastic | {"yield_stress": self.yield_stress, "hardness": self.hardness}


@cache
def materials() -> Mapping[str, Material]:
    """Return all materials by their names."""
    text = (files("contactstudy.io.scene_files") / "materials.toml").read_text(encoding="utf-8")
    return {name: Material(name, **entry) for name, entry in tomllib.loads(text).items()}


def material(name: str) -> HalfSpace:
    """Return the half-space of a material, such as ``material("steel")``.

    Raises :class:`~contactstudy.InvalidInput` for a name that is not in the table.
    """
    return HalfSpace(**_material_named("material", name).body_fields())


def _material_named(field: str, name: object) -> Material:
    """Return the material of this name or synonym, in upper or lower case; errors speak of `field`."""
    names = {alias: m for m in materials().values() for alias in (m.name, *m.synonyms)}
    lower_case = {alias.lower(): m for alias, m in names.items()}
    if not isinstance(name, str) or name.lower() not in lower_case:
        hint = suggestion(str(name), names)
        raise InvalidInput(f"{field} is {name!r}: {hint}, or give youngs_modulus and poisson_ratio.")
    return lower_case[name.lower()]


def with_materials(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return tables of a scene file with the constants of each ``material`` beside the keys given there.

    A hardness in HV or HRC also gives the yield stress, where neither that nor a material is named. A material of a body
    without elastic constants of its own is refused here, where the file is known, with what to give instead.
    """

    def solid(value: Any, path: str) -> Any:
        if isinstance(value, list):
            return [solid(entry, f"{path}[{n}]") for n, entry in enumerate(value)]
        if not isinstance(value, Mapping):
            return value
        inner = {key: solid(entry, f"{path}.{key}") for key, entry in value.items()}
        hardness = str(inner.get("hardness", ""))
        if hardness.endswith(("HV", "HRC")) and not {"material", "yield_stress"} & set(inner):
            # a third of the hardness is about the yield stress of a metal (Tabor 1951)
            inner["yield_stress"] = in_si(f"{path}.hardness", hardness, validation.HARDNESS) / 3
        if "material" not in inner:
            return inner
        constants = _material_named(f"{path}.material", inner.pop("material"))
        if (kind := inner.get("kind")) in ("CoatedHalfSpace", "ViscoelasticHalfSpace"):
            raise InvalidInput(
                f"{path}.material is {constants.name!r}, and a {kind} has no constants of its own there: give it to a "
                "HalfSpace, an ElasticPlasticHalfSpace, or the coating and the substrate."
            )
        return constants.body_fields(inner.get("kind")) | inner

    solids = table.get("solids")
    if not isinstance(solids, list):
        return dict(table)
    return dict(table) | {"solids": [solid(entry, f"solids[{n}]") for n, entry in enumerate(solids)]}
