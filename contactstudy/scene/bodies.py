"""Bodies, described by how their surfaces respond to pressure."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from contactstudy.domain.checks import InvalidInput, finite, in_range, set_fields
from contactstudy.domain.units import Number, Pascals
from contactstudy.elasticity.coefficients import Coefficients, Displacement


@runtime_checkable
class Body(Protocol):
    """One of the two bodies in contact."""

    @property
    def compliance(self) -> float:
        """What the body adds to 1/E* [1/Pa]; zero if it is rigid. It sets the scales of a problem."""
        ...

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """The displacement of its surface [m] under unit pressure: coefficients [m] times weights [1/Pa].

        Bodies with equal coefficients share their evaluation. ``datum`` [m] is the lateral distance from which
        displacement is counted, where an infinite row of images leaves that open.
        """
        ...


@runtime_checkable
class Homogeneous(Body, Protocol):
    """A body of one material, whose stress follows from the pressure and Poisson's ratio."""

    @property
    def youngs_modulus(self) -> float:
        """[Pa], that for a sudden load if it changes."""
        ...

    @property
    def poisson_ratio(self) -> float:
        """Constant in time."""
        ...


@dataclass(frozen=True)
class HalfSpace:
    """A homogeneous, isotropic elastic half-space.

    ``youngs_modulus`` [Pa], above zero; ``math.inf`` is a rigid body. ``poisson_ratio`` from above -1
    to 0.5 (incompressible). Raises :class:`~contactstudy.InvalidInput` for anything else.
    """

    youngs_modulus: Pascals
    poisson_ratio: Number

    def __post_init__(self) -> None:
        remedy = "give a modulus above 0 Pa, or inf for a rigid body"
        if self.youngs_modulus != math.inf:
            modulus = in_range("HalfSpace.youngs_modulus", self.youngs_modulus, remedy)
            set_fields(self, youngs_modulus=modulus)
        ratio = poisson_ratio("HalfSpace.poisson_ratio", self.poisson_ratio)
        set_fields(self, poisson_ratio=ratio)

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa]."""
        return (1 - self.poisson_ratio**2) / self.youngs_modulus

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Boussinesq's: ``u = (1 - nu^2) / (pi E) sum I p`` (Johnson 1985, eq. 3.22)."""
        return {Displacement(datum): self.compliance / math.pi} if self.compliance else {}


def poisson_ratio(field: str, value: object) -> float:
    """``value`` as a ratio from above -1 to 0.5, or :class:`~contactstudy.InvalidInput`."""
    remedy = "give a ratio above -1 and up to 0.5"
    ratio = finite(field, value, remedy)
    if not -1 < ratio <= 0.5:
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return ratio


@runtime_checkable
class Layered(Protocol):
    """A body whose compliance depends on how wide the contact is."""

    @property
    def thickness(self) -> float:
        """Of its coating [m]."""
        ...

    @property
    def substrate(self) -> HalfSpace:
        """What its coating is on."""
        ...

    @property
    def compliance(self) -> float:
        """That of its coating alone [1/Pa]."""
        ...

    def compliance_at(self, half_width: float) -> float:
        """What it adds to 1/E* [1/Pa] in a contact of ``half_width`` [m]."""
        ...


@runtime_checkable
class Inelastic(Protocol):
    """A body that an elastic half-space stands for, as long as nothing has changed."""

    @property
    def sudden(self) -> HalfSpace:
        """The elastic half-space that it is for a first, sudden load."""
        ...


@runtime_checkable
class Particular(Protocol):
    """A body that not every scene can have."""

    def check(self, scene: "Surroundings") -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a scene in which it is not defined."""
        ...


class Surroundings(Protocol):
    """What such a body asks of a scene."""

    @property
    def solids(self) -> tuple[Body, Body]:
        """Both bodies."""
        ...

    @property
    def hardness(self) -> float:
        """[Pa]"""
        ...

    @property
    def rolling(self) -> object | None:
        """Whether it rolls."""
        ...


def sudden(solids: tuple[Body, Body]) -> tuple[Body, Body]:
    """The bodies that ``solids`` are for a first, sudden load."""
    first, second = (body.sudden if isinstance(body, Inelastic) else body for body in solids)
    return first, second


def contact_modulus(solids: tuple[Body, ...], half_width: float | None = None) -> float:
    """E* [Pa] of the bodies together: compliances add (Johnson 1985, eq. 4.3).

    ``half_width`` [m] is that of the contact, for bodies that are :class:`Layered`.
    """
    total = sum(
        solid.compliance_at(half_width)
        if half_width is not None and isinstance(solid, Layered)
        else solid.compliance
        for solid in solids
    )
    if total == 0:
        raise InvalidInput(
            "Scene.solids are all rigid: give at least one body a finite Young's modulus."
        )
    return 1 / total


def response(solids: tuple[Body, ...], datum: float) -> Mapping[Coefficients, float]:
    """The displacements of all bodies together, by their coefficients."""
    total: Counter[Coefficients] = Counter()
    for solid in solids:
        total.update(solid.response(datum))
    return total
