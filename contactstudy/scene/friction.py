"""Friction between the bodies: Coulomb's law, sliding everywhere or sticking in part."""

from dataclasses import dataclass
from math import inf, isinf, log
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.checks import InvalidInput, finite, in_range, set_fields, suggest_fields
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Paddings
from contactstudy.domain.units import NewtonsPerMetre, Number
from contactstudy.elasticity.tangential import (
    GeneralConvolution,
    SurfaceField,
    general_convolution,
    shear_response,
)
from contactstudy.problem.problem import FrictionLaw
from contactstudy.scene.bodies import Body, BodyContext, HalfSpace, Homogeneous, is_layered
from contactstudy.scene.shapes.shape import Shape
from contactstudy.solvers.friction import CiavarellaJaeger, CoulombDisks, FullSliding

if TYPE_CHECKING:
    from contactstudy.scene.motion import Wear

# Bodies are alike in shear where Dundurs' beta is below this: the difference is rounding.
ALIKE = 1e-14


class Load(Protocol):
    """Load per length, as a friction law reads it."""

    @property
    def largest(self) -> float:
        """Largest load [N/m]."""
        ...


class FrictionContact(BodyContext, Protocol):
    """Properties of a scene that a friction law reads."""

    @property
    def load(self) -> Load:
        """Load of the scene."""
        ...

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """Shapes of the scene."""
        ...

    @property
    def contact_modulus(self) -> float:
        """Contact modulus E* [Pa]."""
        ...

    @property
    def changing(self) -> str | None:
        """Name of a field that changes in time, or None."""
        ...

    @property
    def wear(self) -> "Wear | None":
        """Wear of the scene."""
        ...


@runtime_checkable
class Friction(Protocol):
    """Friction law, as a value in ``Scene.friction``."""

    def check(self, scene: FrictionContact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the law is not defined in this scene."""
        ...

    def law(
        self, scene: FrictionContact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> FrictionLaw:
        """Return the law for this scene on a grid."""
        ...

    def explanation(self, scene: FrictionContact, *, varies: bool, paddings: Paddings) -> str:
        """Return a sentence on how shear is solved and why; `varies`: whether the gap varies along the length."""
        ...


@suggest_fields
@dataclass(frozen=True)
class Sliding:
    """Full sliding: the first body is dragged along +x, shear is the coefficient times the pressure.

    Between bodies that are unlike in shear (Dundurs' beta) shear makes the pressure asymmetric; between like bodies the
    pressure is that without friction.

    Parameters
    ----------
    coefficient
        Coefficient of friction, from 0 on and below 1.

    Raises
    ------
    InvalidInput
        For other coefficients; in a scene with unlike bodies one of which is coated or creeps, or that roll.
    """

    coefficient: Number

    def __post_init__(self) -> None:
        set_fields(self, coefficient=coefficient("Sliding", self.coefficient, zero=True))

    def check(self, scene: FrictionContact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the coupling of these bodies is not supported."""
        beta = dundurs(scene.solids)
        if scene.rolling is not None and scene.rolling.passes is not None:
            raise InvalidInput(
                f"Scene.rolling has {scene.rolling.passes} passes together with Sliding: shear by repeated rolling is "
                "not supported, leave one of both out."
            )
        if abs(beta) <= ALIKE or self.coefficient == 0:
            return
        if any(getattr(solid, "creeps", False) for solid in scene.solids):
            raise InvalidInput(
                f"Scene.solids are unlike in shear (Dundurs' beta {beta:.3g}) together with Sliding, and one creeps: "
                "creep of their coupling is not supported, give equal bodies, or an incompressible one on a rigid one."
            )
        if scene.rolling is not None:
            raise InvalidInput(
                f"Scene.solids are unlike in shear (Dundurs' beta {beta:.3g}) together with Sliding and Scene.rolling: "
                "both move the pressure forwards, which is not supported, give bodies of one material, or "
                "TractiveRolling."
            )

    def law(
        self, scene: FrictionContact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> FullSliding:
        """Return the law for this scene on a grid, with the coupling of shear and normal displacement."""
        beta = dundurs(scene.solids)
        if abs(beta) <= ALIKE or self.coefficient == 0:
            return FullSliding(self.coefficient, None)
        field = general_convolution(SurfaceField("x", datum), grid, paddings)
        weight = beta / (np.pi * scene.contact_modulus)
        coupling = GeneralConvolution(field.spectrum * weight, field.cells, field.padded)
        return FullSliding(self.coefficient, coupling)

    def explanation(self, scene: FrictionContact, *, varies: bool, paddings: Paddings) -> str:
        """Return a sentence on the solves: one if the bodies are alike in shear, else a sequence of them."""
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


@suggest_fields
@dataclass(frozen=True)
class PartialSlip:
    """Partial slip under a tangential force that friction holds back.

    The bodies are pressed first, sheared after, and never unloaded. Shear is found by Ciavarella and Jaeger's
    superposition where that is exact (nothing varies along the length, or Poisson's ratio is 0, and no hardness limits
    the pressure), and else for both components of shear.

    Parameters
    ----------
    coefficient
        Coefficient of friction, above 0 and below 1.
    tangential
        Force along x on the first body [N/m], of either sign, less than the coefficient times the load.

    Raises
    ------
    InvalidInput
        For other values; in a scene with bodies that are unlike in shear or coated, or a change in time.
    """

    coefficient: Number
    tangential: NewtonsPerMetre

    def __post_init__(self) -> None:
        remedy = "give a force along x [N/m]"
        set_fields(
            self,
            coefficient=coefficient("PartialSlip", self.coefficient, zero=False),
            tangential=finite("PartialSlip.tangential", self.tangential, remedy),
        )

    def check(self, scene: FrictionContact) -> None:
        """Raise :class:`~contactstudy.InvalidInput` if the contact cannot stick, or its shear is not supported."""
        check_still(scene, "PartialSlip")
        check_half_spaces(scene, "PartialSlip", ", or Sliding")
        check_alike(scene, "PartialSlip", ", or Sliding")
        most = self.coefficient * scene.load.largest
        if not abs(self.tangential) < most:
            raise InvalidInput(
                f"PartialSlip.tangential is {self.tangential!r}: friction bears less than {most:g} N/m, give "
                "less, or Sliding."
            )

    def law(
        self, scene: FrictionContact, gap: Array, grid: Grid, paddings: Paddings, datum: float
    ) -> CiavarellaJaeger | CoulombDisks:
        """Return superposition where it is exact for this gap, else the problem of two components."""
        ratio = self.tangential / (self.coefficient * scene.load.largest)
        if self.superposes(scene, varies=bool((gap != gap[:, :1]).any()), paddings=paddings):
            return CiavarellaJaeger(self.coefficient, ratio)
        bodies = tuple(
            (solid.compliance, solid.poisson_ratio)
            for solid in scene.solids
            if isinstance(solid, HalfSpace)
        )
        response = shear_response(bodies, grid, paddings, datum)
        return CoulombDisks(self.coefficient, ratio, response)

    def explanation(self, scene: FrictionContact, *, varies: bool, paddings: Paddings) -> str:
        """Return a sentence on the solves: two normal contacts where they are exact, else two components of shear."""
        if self.superposes(scene, varies=varies, paddings=paddings):
            return (
                "friction: partial slip by Ciavarella and Jaeger's superposition, two solves, which is exact as "
                + ("Poisson's ratio is 0." if varies else "nothing varies along the length.")
            )
        return (
            "friction: partial slip for both components of shear, for "
            + (
                "a hardness limits the pressure;"
                if scene.hardness != inf
                else "something varies along the length and Poisson's ratio is not 0;"
            )
            + " 30 to 80 applications of four transforms each, in addition to the normal solve."
        )

    @staticmethod
    def superposes(scene: FrictionContact, *, varies: bool, paddings: Paddings) -> bool:
        """Return whether two normal contacts make up the shear exactly."""
        elastic = [
            solid
            for solid in scene.solids
            if isinstance(solid, HalfSpace) and not isinf(solid.youngs_modulus)
        ]
        if scene.hardness != inf:
            return False  # a capped pressure is no difference of two contacts
        if all(solid.poisson_ratio == 0 for solid in elastic):
            return True
        return not varies and paddings[1].window is None


def dundurs(solids: tuple[Body, ...]) -> float:
    """Return Dundurs' beta of two homogeneous bodies under a sudden load, 0 for two equal bodies of any kind.

    Source: Dundurs (1969); Johnson (1985), sect. 5.4. Raises :class:`~contactstudy.InvalidInput` for other bodies,
    whose coupling between shear and normal displacement is not supported.
    """
    first, second = solids
    if first == second:
        return 0.0
    if not (isinstance(first, Homogeneous) and isinstance(second, Homogeneous)) or any(
        map(is_layered, solids)
    ):
        raise InvalidInput(
            "Scene.solids are unlike and not both homogeneous together with friction: how shear moves a coated surface "
            "along its normal is not supported, give two equal bodies, or two HalfSpace."
        )
    (soft1, hard1), (soft2, hard2) = (
        ((1 - 2 * solid.poisson_ratio) / shear, (1 - solid.poisson_ratio) / shear)
        for solid in (first, second)
        for shear in (solid.youngs_modulus / (2 * (1 + solid.poisson_ratio)),)
    )
    return float((soft1 - soft2) / (2 * (hard1 + hard2)))


def _passes(product: float) -> int:
    """Return the number of passes to a tolerance of 1e-8, each of which leaves about the product of beta and mu."""
    return max(2, round(log(1e-8) / log(min(1.1 * product, 0.9))))


def coefficient(name: str, value: object, *, zero: bool) -> float:
    """Return a coefficient of friction of the law `name`, which may be 0 if `zero`."""
    remedy = f"give a coefficient of friction {'from' if zero else 'above'} 0, and below 1"
    field = f"{name}.coefficient"
    number = finite(field, value, remedy)
    if number < 0 or number >= 1 or (number == 0 and not zero):
        raise InvalidInput(f"{field} is {value!r}: {remedy}.")
    return number if number == 0 else in_range(field, number, remedy)


def check_half_spaces(scene: FrictionContact, name: str, otherwise: str = "") -> None:
    """Raise InvalidInput for a body whose response to shear the law of friction `name` does not support."""
    for number, solid in enumerate(scene.solids):
        if not isinstance(solid, HalfSpace):
            raise InvalidInput(
                f"Scene.solids[{number}] is a {type(solid).__name__} together with {name}: its response to shear is "
                f"not supported, give a HalfSpace{otherwise}."
            )


def check_alike(scene: FrictionContact, name: str, otherwise: str = "") -> None:
    """Raise InvalidInput for bodies that slip when they are pressed, which the law of friction `name` excludes."""
    if abs(beta := dundurs(scene.solids)) > ALIKE:
        raise InvalidInput(
            f"Scene.solids are unlike in shear (Dundurs' beta {beta:.3g}) together with {name}: pressing them makes "
            f"them slip already, give bodies of one material{otherwise}."
        )


def check_still(scene: FrictionContact, name: str, remedy: str = "") -> None:
    """Raise :class:`~contactstudy.InvalidInput` if `scene` changes in time or rolls, together with the law `name`."""
    if scene.rolling is not None:
        raise InvalidInput(
            f"Scene.rolling is {scene.rolling!r} together with {name}: shear is carried through a contact that rolls, "
            "give TractiveRolling without Scene.rolling."
        )
    if (changing := scene.changing) is not None:
        raise InvalidInput(
            f"{changing} changes in time together with {name}: shear depends on the path of its forces, "
            f"{remedy or 'give Fretting with times'}."
        )
