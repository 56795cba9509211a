"""Bodies: how their surfaces respond to pressure, hardness by depth, and ends with free faces."""

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import isclose
from typing import TYPE_CHECKING, Annotated, Any, Protocol, TypeGuard, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from contactstudy.analytic import HertzLine
from contactstudy.domain import validation
from contactstudy.domain.grid import Array, Grid, Padding, Paddings
from contactstudy.domain.validation import InvalidInput, Metres, readable, valid, validated
from contactstudy.elasticity.convolution import BoussinesqCoefficients, Coefficients, FreeFaceCoefficients
from contactstudy.scene.shapes.roller import FiniteLength
from contactstudy.scene.shapes.shape import Shape

if TYPE_CHECKING:
    from contactstudy.elasticity.tangential import ShearCompliance

# Hardness at the case depth (ISO 18203): 550 HV [Pa]; tensile yield stress over hardness (Tabor 1951).
CASE_LIMIT, YIELD_OVER_HARDNESS = 550 * 9.80665e6, 1 / 3


@validated
class HardnessProfile:
    """Hardness or yield stress of a body by its depth: a table, or surface, core and case depth.

    The table is straight between its points and constant beyond the last one. With a case depth the hardness falls
    straight from the surface through 550 HV there to the core. Measured profiles lie above that line.

    Parameters
    ----------
    depths
        Depths of the table [m], growing from zero.
    hardness
        Hardness at each of them [Pa], of which a third is the yield stress (Tabor 1951).
    yield_stresses
        Tensile yield stress at each of them [Pa], in place of the hardness.
    surface, core
        Hardness at the surface and in the core [Pa], in place of a table: above and below 550 HV.
    case_depth
        Case-hardening depth [m], at which the hardness is 550 HV (ISO 18203).

    Raises
    ------
    InvalidInput
        If neither or both are given, or a number is outside these limits.
    """

    depths: tuple[Annotated[validation.Metres, validation.AT_LEAST_ZERO], ...] = ()
    hardness: tuple[validation.Hardness, ...] = ()
    yield_stresses: tuple[validation.Pascals, ...] = ()
    surface: validation.Hardness | None = None
    core: validation.Hardness | None = None
    case_depth: validation.Metres | None = None

    def check_together(self) -> None:
        """Check that there is one description, and that a table has one value for each depth."""
        case = [name for name in ("surface", "core", "case_depth") if getattr(self, name) is not None]
        tables = [name for name in ("hardness", "yield_stresses") if getattr(self, name)]
        if (len(case), len(tables), bool(self.depths)) not in ((3, 0, False), (0, 1, True)):
            raise InvalidInput(
                f"HardnessProfile has {', '.join([*case, *tables]) or 'no values'}: give depths with hardness or "
                "yield_stresses, or surface, core and case_depth."
            )
        if case:
            if not self.core < CASE_LIMIT < self.surface:  # type: ignore[operator]
                raise InvalidInput(
                    f"HardnessProfile.surface is {self.surface!r} Pa and its core {self.core!r} Pa: a case depth is "
                    "where the hardness is 550 HV, 5.394e9 Pa, give depths and hardness in their place."
                )
            return
        (name,) = tables
        depths, values = self.depths, getattr(self, name)
        if len(values) != len(depths) or depths[0] or any(np.diff(depths) <= 0):
            raise InvalidInput(
                f"HardnessProfile.depths is {depths!r}: give as many as {name}, from 0 m, each larger than the last."
            )

    @property
    def points(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Depths [m] and yield stresses [Pa] between which the yield stress is straight."""
        if self.surface is None or self.core is None or self.case_depth is None:
            hardness = tuple(value * YIELD_OVER_HARDNESS for value in self.hardness)
            return self.depths, self.yield_stresses or hardness
        end = self.case_depth * (self.surface - self.core) / (self.surface - CASE_LIMIT)
        return (0.0, end), (self.surface * YIELD_OVER_HARDNESS, self.core * YIELD_OVER_HARDNESS)

    def yield_stress(self, depths: Array) -> Array:
        """Return the yield stress [Pa] at `depths` [m]."""
        return np.interp(depths, *self.points)


PoissonRatio = Annotated[validation.Number, validation.Limits("above -1 and up to 0.5", lambda x: -1 < x <= 0.5)]


@runtime_checkable
class Body(Protocol):
    """Body, described by the instantaneous displacement of its surface under pressure."""

    @property
    def compliance(self) -> float:
        """Contribution of the body to 1/E* [1/Pa], zero if it is rigid; it sets the scales of a problem."""

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return the surface displacement under unit pressure: coefficients [m] with their weights [1/Pa].

        Equal coefficients of both bodies are computed once. Displacement is relative to a point at the lateral
        distance `datum` [m] where an infinite row of images leaves a constant undefined.
        """


@validated
class HalfSpace:
    """Homogeneous, isotropic elastic half-space.

    Parameters
    ----------
    youngs_modulus
        Young's modulus [Pa], above zero; ``math.inf`` is a rigid body.
    poisson_ratio
        Poisson's ratio, above -1 and up to 0.5 (incompressible).
    yield_stress
        Tensile stress [Pa] at which the material yields, infinite if it is not known. The body stays elastic: the
        largest von Mises stress is compared with it.
    hardness
        Indentation hardness [Pa], infinite if it is not known: the peak pressure is compared with it. It does not limit
        the pressure, which ``Scene.hardness`` does.
    free_faces
        Length [m] of the body between two faces free of traction, at ``|y| = free_faces / 2``, where contact ends too;
        infinite for a body without, see :func:`~contactstudy.FreeFaces`.
    thickness
        Thickness of the body [m], infinite if it is not known. It stays a half-space: an answer says by how much that is
        wrong for a contact whose half-width is more than a quarter of it.
    hardness_profile
        Yield stress by depth, in place of `yield_stress`, as of a case-hardened body; None for one at all depths. An
        answer says where the safety against yield is least.

    Raises
    ------
    InvalidInput
        If a number is outside these limits; in a scene that faces cannot be combined with.
    """

    youngs_modulus: Annotated[validation.Pascals, validation.OR_INFINITE]
    poisson_ratio: PoissonRatio
    yield_stress: Annotated[validation.Pascals, validation.OR_INFINITE] = math.inf
    hardness: Annotated[validation.Hardness, validation.OR_INFINITE] = math.inf
    free_faces: Annotated[validation.Metres, validation.OR_INFINITE] = math.inf
    thickness: Annotated[validation.Metres, validation.OR_INFINITE] = math.inf
    hardness_profile: HardnessProfile | None = None

    @property
    def compliance(self) -> float:
        """Compliance (1 - nu^2) / E [1/Pa]."""
        return (1 - self.poisson_ratio**2) / self.youngs_modulus

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return Boussinesq's coefficients and weight, ``u = (1 - nu^2) / (pi E) sum I p`` (Johnson 1985, eq. 3.22).

        Those of a body with free faces say its length and Poisson's ratio as well, and have a datum of their own.
        """
        if not self.compliance:
            return {}
        coefficients: Coefficients = BoussinesqCoefficients(datum)
        if self.free_faces < math.inf:
            coefficients = FreeFaceCoefficients.of(self.free_faces, self.poisson_ratio)
        return {coefficients: self.compliance / math.pi}

    def shear_compliance(self, datum: float) -> "ShearCompliance":
        """Return Cerruti's coefficients and weights (Johnson 1985, eqs. 3.75), by the names of ``ShearCompliance``."""
        # imported only where there is friction
        from contactstudy.elasticity.tangential import half_space_shear_compliance

        return half_space_shear_compliance(self.compliance, self.poisson_ratio, datum)


@runtime_checkable
class Layered(Protocol):
    """Body of layers, whose compliance depends on the width of the contact."""

    @property
    def layers(self) -> tuple[HalfSpace, ...]:
        """Layers from the surface down, each with its thickness."""

    @property
    def parts(self) -> Mapping[str, tuple[str, HalfSpace, float, float]]:
        """Name, material, top and bottom [m] of each layer and the substrate, by the prefix of its quantities."""

    @property
    def thickness(self) -> float:
        """Thickness of the layer at the surface [m]."""

    @property
    def substrate(self) -> HalfSpace:
        """Half-space below the coating."""

    def compliance_at(self, half_width: float) -> float:
        """Return the contribution to 1/E* [1/Pa] in a contact of `half_width` [m]."""


def in_part(depths: Array, top: float, bottom: float) -> NDArray[np.bool_]:
    """Return which depths [m] lie between `top` and `bottom` of a part, to which its lower interface belongs."""
    return np.asarray((depths <= bottom) & ((depths > top) | (top <= 0)))


def is_layered(solid: object) -> TypeGuard[Layered]:
    """Return whether a body has layers; ``isinstance`` of a protocol takes as long as a tenth of a set-up."""
    return hasattr(solid, "layers")


def creeps(solid: object) -> bool:
    """Return whether a body creeps: its displacement follows its pressure with a delay."""
    return getattr(solid, "creeps", False)


def yields(solid: object) -> bool:
    """Return whether a body yields: it keeps a plastic strain."""
    return getattr(solid, "yields", False)


class SceneContext(Protocol):
    """Properties of a scene that its bodies and effects read, to say whether they are defined together."""

    @property
    def solids(self) -> tuple[Body, Body]:
        """Both bodies."""

    @property
    def shapes(self) -> tuple[Shape, ...]:
        """Contributions to the undeformed gap."""

    @property
    def load(self) -> Any:
        """Load of the scene."""

    @property
    def largest_load(self) -> float:
        """Largest load over time [N/m]."""

    @property
    def friction(self) -> Any:
        """Law of friction, or None."""

    @property
    def lubrication(self) -> Any:
        """Film between the bodies, or None."""

    @property
    def adhesion(self) -> Any:
        """Adhesion, or None."""

    @property
    def rolling(self) -> Any:
        """Rolling, or None."""

    @property
    def roller_length(self) -> float | None:
        """Length of the roller [m]; None if endless."""

    def loaded_length(self, grid: Grid, padding: Padding | Paddings) -> float:
        """Return the length [m] on which loads and forces per length act."""

    @property
    def radius(self) -> float | None:
        """Equivalent radius R [m] of a line contact, 1/R the sum of its curvatures; None of flats, and of a ball."""

    @property
    def hertz(self) -> HertzLine | None:
        """Smooth line contact of the scene, or None."""


def instantaneous(solids: tuple[Body, Body]) -> tuple[Body, Body]:
    """Return both bodies with each inelastic one replaced by the elastic half-space of its instantaneous response."""
    first, second = (getattr(body, "instantaneous", body) for body in solids)
    return first, second


def contact_modulus(solids: tuple[Body, ...], half_width: float | None = None) -> float:
    """Return E* [Pa] of the bodies together: compliances add (Johnson 1985, sect. 4.2).

    A body with a method ``compliance_at``, which is :class:`Layered` or creeps in rolling, enters with its compliance at
    `half_width` [m], or without one as its coating alone or with its instantaneous compliance. Raises
    :class:`~contactstudy.InvalidInput` if all bodies are rigid.
    """
    total = sum(
        solid.compliance
        if half_width is None or not hasattr(solid, "compliance_at")
        else solid.compliance_at(half_width)
        for solid in solids
    )
    if total == 0:
        raise InvalidInput("Scene.solids are all rigid: give at least one body a finite Young's modulus.")
    return 1 / total


def hertz_line(load: float, radius: float, solids: tuple[Body, ...]) -> HertzLine:
    """Return the smooth line contact under a `load` [N/m], with the modulus of the bodies at its own half-width.

    Its half-width a solves ``a^2 E*(a) = 4 W R / pi``, where E* varies with it as :func:`contact_modulus` says.
    """

    def half_width(modulus: float) -> float:
        return HertzLine(load, radius, modulus).half_width

    return HertzLine(load, radius, modulus_at_own_width(half_width, solids))


def modulus_at_own_width(width: Callable[[float], float], solids: tuple[Body, ...]) -> float:
    """Return the E* [Pa] of the bodies at a width [m] that follows from E* itself by the function `width`."""
    at_surface = contact_modulus(solids)
    if not any(hasattr(solid, "compliance_at") for solid in solids):
        return at_surface
    from scipy.optimize import brentq  # imported late, since it is slow

    def modulus(log_width: float) -> float:
        return contact_modulus(solids, math.exp(log_width))

    def excess(log_width: float) -> float:
        return log_width - math.log(width(modulus(log_width)))

    # bracket the logarithm of the width
    low = high = math.log(width(at_surface))
    while excess(low) > 0:
        low -= 1
    while excess(high) < 0:
        high += 1
    return modulus(float(brentq(excess, low, high, xtol=1e-9)))


def response(solids: tuple[Body, ...], datum: float) -> Mapping[Coefficients, float]:
    """Return the displacement coefficients of all bodies together, with their summed weights [1/Pa]."""
    total: Counter[Coefficients] = Counter()
    for solid in solids:
        total.update(solid.response(datum))
    return total


# Least length between two faces over the half-width of the contact, down to which the pressure was compared with finite
# elements.
SHORTEST = 4.0


def FreeFaces(solid: HalfSpace, length: float) -> HalfSpace:
    """Return a body of the material of `solid` that ends along the length, with faces free of traction.

    The faces are at ``|y| = length / 2``, at right angles to the surface, and contact ends there: no
    :class:`~contactstudy.FiniteLength` is needed. Beside the faces the body is softer, up to two and a half times. Each
    face is that of a quarter-space, with the load mirrored evenly about both. A load that varies over long waves at one
    face also acts on the other, by a fit whose error is not in the bounds: 0.4 % of the pressure in L1 in bodies of 20
    half-widths, 1.4 % in those of 4. Displacement counts from points on the surface at three body lengths from the axis.
    Sources: Hetenyi (1970), Journal of Applied Mechanics 37, 89; Wang, Guo, Wong & Zhang (2017), Tribology International
    114, 358.

    Parameters
    ----------
    solid
        Elastic half-space, whose fields it keeps.
    length
        Length between the faces [m], above zero, in a scene at least 4 half-widths of the contact.

    Raises
    ------
    InvalidInput
        For a body that is no elastic half-space, and a length that is not above zero.
    """
    if not isinstance(solid, HalfSpace):
        raise InvalidInput(
            f"FreeFaces.solid is of the type {type(solid).__name__}: faces are known of a HalfSpace without coating, "
            "creep or yielding, give one, or a FiniteLength among the shapes, which ends the contact alone."
        )
    return replace(solid, free_faces=valid("FreeFaces.length", length, Metres))


def check_free_faces(length: float, shapes: tuple[Shape, ...], hertz: HertzLine | None) -> None:
    """Raise InvalidInput for a roller whose length is not that of a body with free faces, or for faces too near.

    The `length` [m] is that between the faces, `shapes` are those of the scene. Faces are too near if they are closer
    than `SHORTEST` half-widths of its smooth line contact `hertz`; None is a scene without one.
    """
    for number, shape in enumerate(shapes):
        if isinstance(shape, FiniteLength) and not isclose(shape.length, length):
            raise InvalidInput(
                f"Scene.shapes[{number}] is {shape!r}, and contact ends at free faces {readable(length)} apart: leave "
                "it out, or give the body that it ends faces of that length."
            )
    if hertz is not None and length < SHORTEST * hertz.half_width:
        raise InvalidInput(
            f"HalfSpace.free_faces is {readable(length)}, and in a contact of the half-width "
            f"{readable(hertz.half_width)} the faces load each other: give {readable(SHORTEST * hertz.half_width)} or "
            "more, or leave free_faces out and end the contact by a FiniteLength."
        )
