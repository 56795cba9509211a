"""Bodies that creep under a load and recover after it."""

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
from contactstudy.scene.bodies.solids import HalfSpace, poisson_ratio


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
