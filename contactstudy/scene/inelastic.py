"""Viscoelastic and elastic-plastic half-spaces."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

from contactstudy.domain.checks import (
    InvalidInput,
    in_range,
    in_range_from_zero,
    in_range_or_infinite,
    pair,
    sequence,
    set_fields,
    suggest_fields,
)
from contactstudy.domain.units import Number, Pascals, Seconds
from contactstudy.elasticity.coefficients import BoussinesqCoefficients, Coefficients
from contactstudy.elasticity.viscoelastic import Creep, creep_from_relaxation, retarded
from contactstudy.scene.bodies import Body, BodyContext, HalfSpace, poisson_ratio

if TYPE_CHECKING:
    from contactstudy.elasticity.tangential import ShearCompliance


@suggest_fields
@dataclass(frozen=True)
class ViscoelasticHalfSpace:
    """Linear viscoelastic half-space with the relaxation modulus ``E(t) = E_inf + sum(E_i exp(-t / tau_i))``.

    A scene with one changes in time: see :func:`~contactstudy.solve` and :class:`~contactstudy.Rolling`.

    Parameters
    ----------
    equilibrium_modulus
        E_inf [Pa], at least zero; zero is a Maxwell fluid.
    poisson_ratio
        Poisson's ratio, constant in time, above -1 and up to 0.5.
    relaxation
        Pairs (E_i [Pa], tau_i [s]) of a Prony series, all above zero. Without pairs the body is elastic.

    Raises
    ------
    InvalidInput
        If a number is outside these limits, or there is no modulus at all.
    """

    equilibrium_modulus: Pascals
    poisson_ratio: Number
    relaxation: tuple[tuple[Pascals, Seconds], ...] = ()

    def __post_init__(self) -> None:
        field = "ViscoelasticHalfSpace.equilibrium_modulus"
        remedy = "give a modulus above 0 Pa, or 0 for a Maxwell fluid"
        equilibrium = in_range_from_zero(field, self.equilibrium_modulus, remedy)
        ratio = poisson_ratio("ViscoelasticHalfSpace.poisson_ratio", self.poisson_ratio)
        field = "ViscoelasticHalfSpace.relaxation"
        remedy = "give pairs of a modulus [Pa] and a time [s], such as ((1e6, 0.1), (2e6, 1.0))"
        terms = []
        for number, term in enumerate(sequence(field, self.relaxation, remedy)):
            first, second = pair(f"{field}[{number}]", term, remedy)
            modulus = in_range(f"{field}[{number}][0]", first, "give a modulus above 0 Pa")
            time = in_range(f"{field}[{number}][1]", second, "give a time above 0 s")
            terms.append((modulus, time))
        if equilibrium == 0 and not terms:
            raise InvalidInput(
                "ViscoelasticHalfSpace.equilibrium_modulus is 0 and there is no relaxation: give a "
                "modulus above 0 Pa, or pairs of a modulus and a time."
            )
        set_fields(
            self, equilibrium_modulus=equilibrium, poisson_ratio=ratio, relaxation=tuple(terms)
        )

    @cached_property
    def creep(self) -> Creep:
        """Creep function ``(1 - nu^2) J(t)`` [1/Pa], where J is the strain under a unit stress held from t = 0 on."""
        return creep_from_relaxation(self.equilibrium_modulus, self.relaxation).times(
            1 - self.poisson_ratio**2
        )

    @property
    def compliance(self) -> float:
        """Instantaneous compliance, (1 - nu^2) / E(0) [1/Pa]."""
        return self.creep.instantaneous

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return Boussinesq's coefficients of the instantaneous response, with their weight [1/Pa]."""
        return {BoussinesqCoefficients(datum): self.compliance / math.pi}

    @property
    def youngs_modulus(self) -> float:
        """Instantaneous Young's modulus E(0) [Pa]."""
        return self.equilibrium_modulus + sum(modulus for modulus, _ in self.relaxation)

    @property
    def instantaneous(self) -> HalfSpace:
        """Elastic half-space with the instantaneous response of this one."""
        return HalfSpace(self.youngs_modulus, self.poisson_ratio)

    @property
    def creeps(self) -> bool:
        """True if the modulus relaxes."""
        return bool(self.relaxation)


@dataclass(frozen=True)
class RollingHalfSpace:
    """Viscoelastic half-space under a contact that moves over it steadily: distance ahead is time past.

    Parameters
    ----------
    body
        The half-space.
    speed
        Speed [m/s] of the contact over the body, negative to smaller x; infinite for the instantaneous response.
    """

    body: ViscoelasticHalfSpace
    speed: float

    @property
    def compliance(self) -> float:
        """Instantaneous compliance, (1 - nu^2) / E(0) [1/Pa]."""
        return self.body.compliance

    def compliance_at(self, half_width: float) -> float:
        """Return the compliance [1/Pa] for waves of the length of a contact of `half_width` [m]."""
        ratios = ((size, self.speed * time / half_width) for size, time in self.body.creep.terms)
        return self.compliance + sum(size / (1 + ratio**2) for size, ratio in ratios)

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return coefficients of the normal displacement under pressure, even and odd along x, with weights [1/Pa]."""
        total = Counter(self.body.response(datum))
        for size, time in self.body.creep.terms:
            total.update(
                retarded({BoussinesqCoefficients(datum): size / math.pi}, self.speed * time)
            )
        return total

    def shear_compliance(self, datum: float) -> "ShearCompliance":
        """Return coefficients of the displacement under shear, even and odd along x, with weights [1/Pa]."""
        from contactstudy.elasticity.tangential import half_space_shear_compliance

        creep, ratio = self.body.creep, self.body.poisson_ratio
        instantaneous = half_space_shear_compliance(creep.instantaneous, ratio, datum)
        total = {name: Counter(weights) for name, weights in instantaneous.items()}
        for size, time in creep.terms:
            for name, weights in half_space_shear_compliance(size, ratio, datum).items():
                total[name].update(retarded(weights, self.speed * time))
        return total


def rolling_bodies(solids: tuple[Body, Body], speeds: tuple[float, float]) -> tuple[Body, Body]:
    """Return both bodies under a contact that moves over each at its speed [m/s] along x.

    Raises
    ------
    InvalidInput
        For a fluid at a finite speed.
    """
    bodies: list[Body] = []
    for number, (solid, speed) in enumerate(zip(solids, speeds, strict=True)):
        if not isinstance(solid, ViscoelasticHalfSpace) or not solid.creeps:
            bodies.append(solid)
            continue
        if solid.creep.fluidity and not math.isinf(speed):
            raise InvalidInput(
                f"Scene.solids[{number}] is a fluid (equilibrium modulus 0 Pa), whose indentation in steady rolling is "
                "unbounded: give an equilibrium modulus above 0 Pa."
            )
        bodies.append(RollingHalfSpace(solid, speed))
    first, second = bodies
    return first, second


@suggest_fields
@dataclass(frozen=True)
class ElasticPlasticHalfSpace:
    """Half-space that yields after von Mises, with linear hardening.

    A scene with one has a history: see :func:`~contactstudy.solve`.

    Parameters
    ----------
    youngs_modulus
        Young's modulus [Pa], above zero and finite.
    poisson_ratio
        Poisson's ratio, above -1 and up to 0.5.
    yield_stress
        Yield stress in tension [Pa], above zero; infinite for an elastic half-space.
    hardening_modulus
        Stress over plastic strain in tension [Pa], at least zero, by which the yield surface grows
        (isotropic hardening).
    kinematic_modulus
        The same [Pa] for a yield surface that moves (Prager's rule). With both moduli at zero the body is
        perfectly plastic.

    Raises
    ------
    InvalidInput
        If a number is outside these limits; in a scene with a hardness, partial slip, or steady rolling.
    """

    youngs_modulus: Pascals
    poisson_ratio: Number
    yield_stress: Pascals
    hardening_modulus: Pascals = 0.0
    kinematic_modulus: Pascals = 0.0

    def __post_init__(self) -> None:
        name = "ElasticPlasticHalfSpace"
        remedy = "give a modulus above 0 Pa, or a rigid HalfSpace for a body that does not yield"
        modulus = in_range(f"{name}.youngs_modulus", self.youngs_modulus, remedy)
        ratio = poisson_ratio(f"{name}.poisson_ratio", self.poisson_ratio)
        remedy = "give a stress above 0 Pa, or inf for a body that does not yield"
        stress = in_range_or_infinite(f"{name}.yield_stress", self.yield_stress, remedy)
        set_fields(self, youngs_modulus=modulus, poisson_ratio=ratio, yield_stress=stress)
        for field in ("hardening_modulus", "kinematic_modulus"):
            remedy = "give a modulus of at least 0 Pa"
            value = in_range_from_zero(f"{name}.{field}", getattr(self, field), remedy)
            set_fields(self, **{field: value})

    @property
    def instantaneous(self) -> HalfSpace:
        """Elastic half-space that responds like this one until it yields."""
        return HalfSpace(self.youngs_modulus, self.poisson_ratio)

    @property
    def compliance(self) -> float:
        """Compliance before yielding, (1 - nu^2) / E [1/Pa]."""
        return self.instantaneous.compliance

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return Boussinesq's coefficients, valid before yielding, with their weight [1/Pa]."""
        return self.instantaneous.response(datum)

    @property
    def yields(self) -> bool:
        """True if some finite load makes the body yield."""
        return self.yield_stress < math.inf

    def check(self, scene: BodyContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for an effect that is not supported together with plastic strain."""
        if not self.yields:
            return
        if scene.hardness < math.inf:
            raise InvalidInput(
                f"Scene.hardness is {scene.hardness!r} together with a body that yields, which limits the pressure "
                "by itself: leave the hardness out, or give an elastic HalfSpace."
            )
        if scene.rolling is not None and scene.rolling.passes is None:
            raise InvalidInput(
                f"Scene.rolling is {scene.rolling!r}, which is steady, together with a body that yields, whose strain "
                "has a history: give Rolling its passes, or leave rolling out."
            )
        if scene.rolling is not None and scene.outputs:
            raise InvalidInput(
                f"Scene.outputs are {scene.outputs!r} together with passes over a body that yields, whose residual "
                "stress is in the answer: leave them out."
            )
