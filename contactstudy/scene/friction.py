"""Friction between the bodies: Coulomb's law, sliding everywhere or sticking in part."""

from dataclasses import dataclass
from math import inf, isinf, log
from typing import Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.checks import InvalidInput, finite, in_range, set_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid
from contactstudy.domain.padding import Paddings
from contactstudy.domain.units import NewtonsPerMetre, Number
from contactstudy.elasticity.tangential import (
    Correlated,
    SurfaceField,
    correlated,
    shear_response,
)
from contactstudy.problem.problem import FrictionLaw
from contactstudy.scene.bodies import Body, HalfSpace
from contactstudy.solvers.friction import CoulombDisks, FullSliding, Superposed

# Bodies are alike in shear where Dundurs' beta is below this: the difference is rounding.
ALIKE = 1e-14


class Load(Protocol):
    """A load per length."""

    @property
    def largest(self) -> float:
        """[N/m]."""
        ...


class Contact(Protocol):
    """What friction asks of a scene."""

    @property
    def load(self) -> Load:
        """Its load."""
        ...

    @property
    def solids(self) -> tuple[Body, Body]:
        """Its bodies."""
        ...

    @property
    def hardness(self) -> float:
        """[Pa]."""
        ...

    @property
    def contact_modulus(self) -> float:
        """[Pa]."""
        ...

    @property
    def rolling(self) -> object | None:
        """Whether it rolls."""
        ...

    @property
    def changing(self) -> str | None:
        """A field that changes in time."""
        ...


@runtime_checkable
class Friction(Protocol):
    """A value in ``Scene.friction``."""

    def check(self, scene: Contact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a scene in which it is not defined."""
        ...

    def law(
        self, scene: Contact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> FrictionLaw:
        """The same for this scene on a grid."""
        ...

    def said(self, scene: Contact, *, varies: bool, paddings: Paddings) -> str:
        """How it is solved and why, in a sentence; ``varies`` along the length or not."""
        ...


@dataclass(frozen=True)
class Sliding:
    """The first body is dragged along +x over its whole contact: shear is ``coefficient`` times pressure.

    ``coefficient`` from 0 on, below 1. Bodies that are unlike in shear (Dundurs' beta) press each other
    asymmetrically; alike ones as without friction. Raises :class:`~contactstudy.InvalidInput` for other
    coefficients; a scene with it for unlike bodies one of which is coated, and for one that changes in time.
    """

    coefficient: Number

    def __post_init__(self) -> None:
        set_fields(self, coefficient=_coefficient("Sliding", self.coefficient, zero=True))

    def check(self, scene: Contact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for bodies whose coupling is not known."""
        _check_still(scene, "Sliding")
        dundurs(scene.solids)

    def law(
        self, scene: Contact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> FullSliding:
        """With the coupling of these bodies, if they have any."""
        beta = dundurs(scene.solids)
        if abs(beta) <= ALIKE or self.coefficient == 0:
            return FullSliding(self.coefficient, None)
        field = correlated(SurfaceField("x", datum), grid, paddings)
        weight = beta / (np.pi * scene.contact_modulus)
        coupling = Correlated(field.spectrum * weight, field.cells, field.padded)
        return FullSliding(self.coefficient, coupling)

    def said(self, scene: Contact, *, varies: bool, paddings: Paddings) -> str:
        """One solve where the bodies are alike in shear, else a sequence of them."""
        beta = dundurs(scene.solids)
        if abs(beta) <= ALIKE or self.coefficient == 0:
            return (
                "friction: full sliding of bodies that are alike in shear, so the pressure is that without "
                "friction, in one solve."
            )
        return (
            f"friction: full sliding of unlike bodies (Dundurs' beta {beta:.3g}), solved again with the shear of "
            f"the last pass until it stays, of the order of {_passes(abs(beta) * self.coefficient)} passes."
        )


@dataclass(frozen=True)
class PartialSlip:
    """Shear that is held back by friction: ``tangential`` [N/m] of contact length along x on the first body.

    ``coefficient`` above 0 and below 1; ``tangential`` of either sign, less than the coefficient times the
    load. Pressed first, sheared after, and never unloaded. Solved by Ciavarella and Jaeger's superposition
    where that is exact (nothing varies along the length, or Poisson's ratio is 0), and else for both
    components of shear. Raises :class:`~contactstudy.InvalidInput` for other values; a scene with it for
    bodies that are unlike in shear or coated, a hardness, and one that changes in time.
    """

    coefficient: Number
    tangential: NewtonsPerMetre

    def __post_init__(self) -> None:
        coefficient = _coefficient("PartialSlip", self.coefficient, zero=False)
        remedy = "give a force along x [N/m]"
        set_fields(
            self,
            coefficient=coefficient,
            tangential=finite("PartialSlip.tangential", self.tangential, remedy),
        )

    def check(self, scene: Contact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` where part of the contact cannot stick, or is not known to."""
        _check_still(scene, "PartialSlip")
        if scene.hardness != inf:
            raise InvalidInput(
                f"Scene.hardness is {scene.hardness!r} beside PartialSlip: how a yielding cell sticks is not "
                "defined here, give Sliding or no hardness."
            )
        for number, solid in enumerate(scene.solids):
            if not isinstance(solid, HalfSpace):
                raise InvalidInput(
                    f"Scene.solids[{number}] is a {type(solid).__name__} beside PartialSlip: its response to "
                    "shear is not known, give a HalfSpace, or Sliding."
                )
        if abs(beta := dundurs(scene.solids)) > ALIKE:
            raise InvalidInput(
                f"Scene.solids are unlike in shear (Dundurs' beta {beta:.3g}) beside PartialSlip: pressing them "
                "makes them slip already, give bodies of one material, or Sliding."
            )
        most = self.coefficient * scene.load.largest
        if not abs(self.tangential) < most:
            raise InvalidInput(
                f"PartialSlip.tangential is {self.tangential!r}: friction bears less than {most:g} N/m, give "
                "less, or Sliding."
            )

    def law(
        self, scene: Contact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> Superposed | CoulombDisks:
        """Superposition where it is exact for this gap, else the problem of two components."""
        share = self.tangential / (self.coefficient * scene.load.largest)
        if self.superposes(scene, varies=bool((gap != gap[:, :1]).any()), paddings=paddings):
            return Superposed(self.coefficient, share)
        bodies = tuple(
            (solid.compliance, solid.poisson_ratio)
            for solid in scene.solids
            if isinstance(solid, HalfSpace)
        )
        response = shear_response(bodies, grid, paddings, datum)
        return CoulombDisks(self.coefficient, share, response)

    def said(self, scene: Contact, *, varies: bool, paddings: Paddings) -> str:
        """Two normal contacts where they are exact, else the problem of two components."""
        if self.superposes(scene, varies=varies, paddings=paddings):
            return (
                "friction: partial slip by Ciavarella and Jaeger's superposition, two solves, which is exact as "
                + ("Poisson's ratio is 0." if varies else "nothing varies along the length.")
            )
        return (
            "friction: partial slip for both components of shear, for something varies along the length and "
            "Poisson's ratio is not 0; some hundred iterations of four transforms each beside the normal solve."
        )

    @staticmethod
    def superposes(scene: Contact, *, varies: bool, paddings: Paddings) -> bool:
        """Whether two normal contacts make up the shear exactly."""
        elastic = [
            solid
            for solid in scene.solids
            if isinstance(solid, HalfSpace) and not isinf(solid.youngs_modulus)
        ]
        if all(solid.poisson_ratio == 0 for solid in elastic):
            return True
        return not varies and paddings[1].window is None


def dundurs(solids: tuple[Body, ...]) -> float:
    """Dundurs' beta of two half-spaces, 0 for two equal bodies of any kind.

    Source: Dundurs (1969); Johnson (1985), sect. 5.4. Raises :class:`~contactstudy.InvalidInput` for
    others, whose coupling between shear and normal displacement is not known.
    """
    first, second = solids
    if first == second:
        return 0.0
    if not (isinstance(first, HalfSpace) and isinstance(second, HalfSpace)):
        raise InvalidInput(
            "Scene.solids are unlike and not both HalfSpace beside a friction: how shear moves a coated surface "
            "along its normal is not known, give two equal bodies, or two HalfSpace."
        )
    (soft1, hard1), (soft2, hard2) = (
        ((1 - 2 * solid.poisson_ratio) / shear, (1 - solid.poisson_ratio) / shear)
        for solid in (first, second)
        for shear in (solid.youngs_modulus / (2 * (1 + solid.poisson_ratio)),)
    )
    return float((soft1 - soft2) / (2 * (hard1 + hard2)))


def _passes(product: float) -> int:
    """Passes to a tolerance of 1e-8, of which each leaves the product of beta and mu, or a little more."""
    return max(2, round(log(1e-8) / log(min(1.1 * product, 0.9))))


def _coefficient(name: str, value: object, *, zero: bool) -> float:
    remedy = f"give a coefficient of friction {'from' if zero else 'above'} 0, and below 1"
    field = f"{name}.coefficient"
    number = finite(field, value, remedy)
    if number < 0 or number >= 1 or (number == 0 and not zero):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return number if number == 0 else in_range(field, number, remedy)


def _check_still(scene: Contact, name: str) -> None:
    if (changing := scene.changing) is not None:
        raise InvalidInput(
            f"{changing} changes in time beside {name}: shear in a contact that changes is not defined here, "
            "leave one of both out."
        )
    if scene.rolling is not None:
        raise InvalidInput(
            f"Scene.rolling is {scene.rolling!r} beside {name}: rolling with friction is not defined here, leave "
            "one of both out."
        )
