"""Viscoelastic and elastic-plastic half-spaces."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated

from contactstudy.domain.validation import AT_LEAST_ZERO, OR_INFINITE, InvalidInput, Pascals, Seconds, validated
from contactstudy.elasticity.convolution import BoussinesqCoefficients, Coefficients
from contactstudy.elasticity.viscoelastic import Creep, creep_from_relaxation, retarded
from contactstudy.scene.solids.bodies import Body, HalfSpace, PoissonRatio

if TYPE_CHECKING:
    from contactstudy.elasticity.tangential import ShearCompliance


@validated
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

    equilibrium_modulus: Annotated[Pascals, AT_LEAST_ZERO]
    poisson_ratio: PoissonRatio
    relaxation: tuple[tuple[Pascals, Seconds], ...] = ()

    def check_together(self) -> None:
        """Check that there is a modulus."""
        if self.equilibrium_modulus == 0 and not self.relaxation:
            raise InvalidInput(
                "ViscoelasticHalfSpace.equilibrium_modulus is 0 and there is no relaxation: give a "
                "modulus above 0 Pa, or pairs of a modulus and a time."
            )

    @cached_property
    def creep(self) -> Creep:
        """Creep function ``(1 - nu^2) J(t)`` [1/Pa], where J is the strain under a unit stress held from t = 0 on."""
        return creep_from_relaxation(self.equilibrium_modulus, self.relaxation).scaled(1 - self.poisson_ratio**2)

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

    def relaxed(self, duration: float) -> HalfSpace:
        """Return the elastic half-space of the equilibrium modulus; of a fluid, that after a `duration` [s] of load."""
        of_fluid = (1 - self.poisson_ratio**2) / float(self.creep(duration))
        modulus = self.equilibrium_modulus or of_fluid
        return HalfSpace(modulus, self.poisson_ratio)

    @property
    def creeps(self) -> bool:
        """True if the modulus relaxes."""
        return bool(self.relaxation)


@dataclass(frozen=True)
class RollingHalfSpace:
    """Viscoelastic half-space under a contact that rolls steadily over it at the speed V: d/dt = -V d/dx.

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
        """Return the compliance [1/Pa] in a contact of `half_width` a [m], for the scales of a problem.

        It is that in phase with a wave ``exp(i x / a)`` of pressure at rest in the contact: each retarded part of the
        creep function with the time tau, over ``1 + (V tau / a)^2``.
        """
        ratios = ((size, self.speed * time / half_width) for size, time in self.body.creep.terms)
        return self.compliance + sum(size / (1 + ratio**2) for size, ratio in ratios)

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Return coefficients of the normal displacement under pressure, even and odd along x, with weights [1/Pa]."""
        total = Counter(self.body.response(datum))
        for size, time in self.body.creep.terms:
            total.update(retarded({BoussinesqCoefficients(datum): size / math.pi}, self.speed * time))
        return total

    def shear_compliance(self, datum: float) -> "ShearCompliance":
        """Return coefficients of the displacement under traction, even and odd along x, with weights [1/Pa]."""
        from contactstudy.elasticity.tangential import half_space_shear_compliance

        creep, ratio = self.body.creep, self.body.poisson_ratio
        instantaneous = half_space_shear_compliance(creep.instantaneous, ratio, datum)
        total = {name: Counter(weights) for name, weights in instantaneous.items()}
        for size, time in creep.terms:
            for name, weights in half_space_shear_compliance(size, ratio, datum).items():
                total[name].update(retarded(weights, self.speed * time))
        return total


def creeping(solids: Iterable[Body]) -> list["ViscoelasticHalfSpace"]:
    """Return the viscoelastic bodies that creep."""
    return [body for body in solids if isinstance(body, ViscoelasticHalfSpace) and body.creeps]


def relaxed(solids: tuple[Body, Body], duration: float) -> tuple[Body, Body]:
    """Return both bodies, where each that creeps is :meth:`ViscoelasticHalfSpace.relaxed` after a `duration` [s]."""
    first, second = (body.relaxed(duration) if isinstance(body, ViscoelasticHalfSpace) else body for body in solids)
    return first, second


def rolling_bodies(solids: tuple[Body, Body], speeds: tuple[float, float]) -> tuple[Body, Body]:
    """Return both bodies under a contact that moves over each at its speed [m/s] along x.

    Raises
    ------
    InvalidInput
        For a fluid at a finite speed.
    """
    for number, (solid, speed) in enumerate(zip(solids, speeds, strict=True)):
        if isinstance(solid, ViscoelasticHalfSpace) and solid.creep.fluidity and not math.isinf(speed):
            raise InvalidInput(
                f"Scene.solids[{number}] is a fluid (equilibrium modulus 0 Pa), whose indentation in steady rolling is "
                "unbounded: give an equilibrium modulus above 0 Pa."
            )
    first, second = (
        RollingHalfSpace(solid, speed) if isinstance(solid, ViscoelasticHalfSpace) and solid.creeps else solid
        for solid, speed in zip(solids, speeds, strict=True)
    )
    return first, second


@validated
class ElasticPlasticHalfSpace:
    """Half-space that yields by the criterion of von Mises, with linear hardening.

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
        If a number is outside these limits; in a scene with a hardness, steady rolling, or outputs beside passes.
    """

    youngs_modulus: Pascals
    poisson_ratio: PoissonRatio
    yield_stress: Annotated[Pascals, OR_INFINITE]
    hardening_modulus: Annotated[Pascals, AT_LEAST_ZERO] = 0.0
    kinematic_modulus: Annotated[Pascals, AT_LEAST_ZERO] = 0.0

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
