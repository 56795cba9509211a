"""Viscoelastic and elastic-plastic half-spaces."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from contactstudy.domain.checks import (
    InvalidInput,
    in_range,
    in_range_from_zero,
    set_fields,
)
from contactstudy.domain.units import Number, Pascals, Seconds
from contactstudy.elasticity.coefficients import Coefficients, Displacement
from contactstudy.elasticity.viscoelastic import Creep, creep
from contactstudy.scene.bodies import (
    HalfSpace,
    Inelastic,
    Layered,
    Surroundings,
    poisson_ratio,
)


@dataclass(frozen=True)
class ViscoelasticHalfSpace:
    """A linear viscoelastic half-space: ``E(t) = E_inf + sum(E_i exp(-t / tau_i))``.

    ``equilibrium_modulus`` E_inf [Pa] from 0 on, where 0 is a Maxwell fluid; ``relaxation`` are pairs
    (E_i [Pa], tau_i [s]), all above zero. ``poisson_ratio``, from above -1 to 0.5, is constant in time. Without
    pairs this is an elastic half-space. A scene with one changes in time: see
    :func:`~contactstudy.evolve` and :class:`~contactstudy.Rolling`.
    Raises :class:`~contactstudy.InvalidInput` for anything else.
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
        if not isinstance(self.relaxation, tuple | list):
            raise InvalidInput(f"{field} is {self.relaxation!r}: {remedy}.")
        pairs = []
        for number, pair in enumerate(self.relaxation):
            if not isinstance(pair, tuple | list) or len(pair) != 2:
                raise InvalidInput(f"{field}[{number}] is {pair!r}: {remedy}.")
            modulus = in_range(f"{field}[{number}][0]", pair[0], "give a modulus above 0 Pa")
            time = in_range(f"{field}[{number}][1]", pair[1], "give a time above 0 s")
            pairs.append((modulus, time))
        if equilibrium == 0 and not pairs:
            raise InvalidInput(
                "ViscoelasticHalfSpace.equilibrium_modulus is 0 and there is no relaxation: give a "
                "modulus above 0 Pa, or pairs of a modulus and a time."
            )
        set_fields(
            self, equilibrium_modulus=equilibrium, poisson_ratio=ratio, relaxation=tuple(pairs)
        )

    @cached_property
    def creep(self) -> Creep:
        """``(1 - nu^2) J(t)`` [1/Pa], where J is the strain under a unit stress held from t = 0 on."""
        return creep(self.equilibrium_modulus, self.relaxation).times(1 - self.poisson_ratio**2)

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E(0) [1/Pa]: the response to a sudden load."""
        return self.creep.instantaneous

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Boussinesq's, for a sudden load."""
        return {Displacement(datum): self.compliance / math.pi}

    @property
    def youngs_modulus(self) -> float:
        """E(0) [Pa]."""
        return self.equilibrium_modulus + sum(modulus for modulus, _ in self.relaxation)

    @property
    def sudden(self) -> HalfSpace:
        """The elastic half-space that it is for a sudden load."""
        return HalfSpace(self.youngs_modulus, self.poisson_ratio)

    @property
    def creeps(self) -> bool:
        """Whether it has terms that relax."""
        return bool(self.relaxation)


@dataclass(frozen=True)
class ElasticPlasticHalfSpace:
    """An elastic half-space that yields after von Mises, with linear hardening.

    ``youngs_modulus`` [Pa] above zero and finite, ``poisson_ratio`` from above -1 to 0.5, ``yield_stress`` [Pa] in
    tension, above zero; infinite, it is an elastic half-space. ``hardening_modulus`` [Pa] from 0 on, stress over plastic
    strain in tension, makes the yield surface grow (isotropic hardening), ``kinematic_modulus`` moves it
    (Prager's rule); with both at 0 the body is perfectly plastic. A scene with one has a history: see
    :func:`~contactstudy.evolve`.
    Raises :class:`~contactstudy.InvalidInput` for anything else, and in a scene with a hardness, friction, rolling,
    or a coated or viscoelastic body.
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
        if self.yield_stress != math.inf:
            remedy = "give a stress above 0 Pa, or inf for a body that does not yield"
            set_fields(
                self, yield_stress=in_range(f"{name}.yield_stress", self.yield_stress, remedy)
            )
        ratio = poisson_ratio(f"{name}.poisson_ratio", self.poisson_ratio)
        set_fields(self, youngs_modulus=modulus, poisson_ratio=ratio)
        for field in ("hardening_modulus", "kinematic_modulus"):
            remedy = "give a modulus from 0 Pa on"
            value = in_range_from_zero(f"{name}.{field}", getattr(self, field), remedy)
            set_fields(self, **{field: value})

    @property
    def sudden(self) -> HalfSpace:
        """The elastic half-space that it is before it yields."""
        return HalfSpace(self.youngs_modulus, self.poisson_ratio)

    @property
    def compliance(self) -> float:
        """(1 - nu^2) / E [1/Pa]."""
        return self.sudden.compliance

    def response(self, datum: float) -> Mapping[Coefficients, float]:
        """Boussinesq's, before it yields."""
        return self.sudden.response(datum)

    @property
    def yields(self) -> bool:
        """Whether any load makes it yield."""
        return self.yield_stress < math.inf

    def check(self, scene: Surroundings) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for what is not known beside plastic strain."""
        if not self.yields:
            return
        place = next(n for n, solid in enumerate(scene.solids) if solid is self)
        other = scene.solids[1 - place]
        kinds = (HalfSpace, ElasticPlasticHalfSpace)
        if isinstance(other, Layered) or (
            isinstance(other, Inelastic) and not isinstance(other, kinds)
        ):
            raise InvalidInput(
                f"Scene.solids[{1 - place}] is a {type(other).__name__} beside a body that yields: how they "
                "change together is not known here, give an elastic or a rigid HalfSpace."
            )
        if scene.hardness < math.inf:
            raise InvalidInput(
                f"Scene.hardness is {scene.hardness!r} beside a body that yields, which limits the pressure "
                "by itself: leave the hardness out, or give an elastic HalfSpace."
            )
        if scene.rolling is not None:
            raise InvalidInput(
                f"Scene.rolling is {scene.rolling!r}, which is steady, beside a body that yields, whose strain "
                "has a history: leave rolling out."
            )
