"""Lubricant with its laws of viscosity, density and shear stress."""

from dataclasses import replace
from math import inf, log
from typing import Annotated, Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.fields import Array
from contactstudy.domain.units import (
    Compressibility,
    Number,
    Pascals,
    PascalSeconds,
    PressureViscosity,
)
from contactstudy.domain.validation import AT_LEAST_ZERO, UP_TO_ONE, validated
from contactstudy.scene.lubrication.film_heat import LEAST_VISCOSITY


@runtime_checkable
class ViscosityLaw(Protocol):
    """Viscosity as a function of pressure."""

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa], at least 0 Pa.

        ``coefficient`` [1/Pa] is the derivative at zero pressure.
        """

    def temperature_factor(self, pressure: Array) -> Array:
        """Return the relative fall of viscosity with temperature at ``pressure`` [Pa], over that at zero pressure."""


@validated
class Barus:
    """Viscosity that grows by ``eta = eta0 exp(alpha p)`` (Barus 1893): too fast beyond some 0.5 GPa."""

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        return coefficient * pressure, np.full_like(pressure, coefficient)

    def temperature_factor(self, pressure: Array) -> Array:
        """Return one: the pressure coefficient does not depend on the temperature."""
        return np.ones_like(pressure)


@validated
class Roelands:
    """Viscosity that grows by ``ln(eta / eta0) = alpha p0 / z ((1 + p / p0)^z - 1)`` (Roelands 1966).

    Parameters
    ----------
    exponent
        z, above 0 and up to 1, where the law is that of :class:`Barus`. None: ``alpha p0 / (ln(eta0) + 9.67)``, by which
        heat and pressure act on one viscosity.
    reference_pressure
        p0 [Pa], above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    exponent: Annotated[Number, UP_TO_ONE] | None = None
    reference_pressure: Pascals = 1.96e8

    def consistent_exponent(self, viscosity: float, coefficient: float) -> float:
        """Return the exponent z that a viscosity [Pa s] and its coefficient alpha [1/Pa] have in common.

        It is infinite where the viscosity is no higher than that of Roelands' pole.
        """
        if coefficient == 0:
            return 0.0
        height = log(viscosity / LEAST_VISCOSITY)
        return coefficient * self.reference_pressure / height if height > 0 else inf

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa], by an exponent that is given."""
        z, p0 = self.exponent, self.reference_pressure
        assert z is not None
        stretched = 1 + pressure / p0
        return (coefficient * p0 / z * (stretched**z - 1), coefficient * stretched ** (z - 1))

    def temperature_factor(self, pressure: Array) -> Array:
        """Return ``(1 + p / p0)^z``: Roelands' pressure coefficient falls as the temperature rises."""
        assert self.exponent is not None
        return np.asarray((1 + pressure / self.reference_pressure) ** self.exponent)


@runtime_checkable
class DensityLaw(Protocol):
    """Density as a function of pressure."""

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return ``rho / rho0`` and its derivative [1/Pa] at ``pressure`` [Pa], at least 0 Pa."""


@validated
class ConstantDensity:
    """An incompressible lubricant."""

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return one, and zero [1/Pa]."""
        return np.ones_like(pressure), np.zeros_like(pressure)


@validated
class DowsonHigginson:
    """Density that grows by ``rho / rho0 = 1 + c p / (1 + d p)`` (Dowson & Higginson 1966), of mineral oil by default.

    Parameters
    ----------
    compressibility
        c [1/Pa], at zero pressure, at least 0.
    saturation
        d [1/Pa], above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    compressibility: Annotated[Compressibility, AT_LEAST_ZERO] = 0.6e-9
    saturation: Compressibility = 1.7e-9

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return ``rho / rho0`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        spread = 1 + self.saturation * pressure
        return 1 + self.compressibility * pressure / spread, self.compressibility / spread**2


@runtime_checkable
class ShearLaw(Protocol):
    """Shear stress of a lubricant as a function of the shear rate."""

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa] where that of a Newtonian lubricant is ``newtonian`` [Pa]."""


@validated
class Newtonian:
    """A shear stress in proportion to the shear rate, without a limit."""

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the stress itself."""
        return newtonian.copy()


@validated
class Eyring:
    """Shear stress ``tau = tau0 asinh(eta rate / tau0)`` (Eyring 1936).

    Parameters
    ----------
    reference
        Eyring stress tau0 [Pa], above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    reference: Pascals = 5e6

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]."""
        return np.asarray(self.reference * np.arcsinh(newtonian / self.reference))


@validated
class Carreau:
    """Shear stress ``tau = tau_N (1 + (tau_N / tau0)^2)^((n - 1) / 2)`` of the Newtonian stress tau_N (Carreau 1972).

    Parameters
    ----------
    reference
        Newtonian stress tau0 [Pa] where the viscosity begins to fall, above 0.
    exponent
        n, above 0 and up to 1, where the law is that of :class:`Newtonian`.

    Raises
    ------
    InvalidInput
        For other values.
    """

    reference: Pascals = 5e6
    exponent: Annotated[Number, UP_TO_ONE] = 0.5

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]."""
        # hypot does not overflow
        thinning = np.hypot(1, newtonian / self.reference) ** (self.exponent - 1)
        return np.asarray(newtonian * thinning)


@validated
class LimitingShear:
    """Shear stress ``tau = tau_L tanh(eta rate / tau_L)`` with a limit ``tau_L = tau_0 + Lambda p`` (Bair & Winer 1979).

    Parameters
    ----------
    coefficient
        Lambda, growth of the limiting shear stress with pressure, above 0.
    ambient
        Limiting shear stress tau_0 [Pa] at ambient pressure, at least 0; 1 to 10 MPa are measured.

    Raises
    ------
    InvalidInput
        For other values.
    """

    coefficient: Number = 0.07
    ambient: Annotated[Pascals, AT_LEAST_ZERO] = 3e6

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]."""
        limit = self.ambient + self.coefficient * pressure
        bounded = np.divide(newtonian, limit, out=np.zeros_like(limit), where=limit > 0)
        return np.asarray(limit * np.tanh(bounded))


@validated
class Lubricant:
    """Lubricant at one temperature.

    Parameters
    ----------
    viscosity
        eta0 [Pa s] at zero pressure, above 0.
    pressure_viscosity
        Pressure-viscosity coefficient alpha [1/Pa], the relative growth of viscosity with pressure at zero pressure, at
        least 0 (0: isoviscous).
    viscosity_law
        :class:`Roelands` or :class:`Barus`.
    density
        :class:`DowsonHigginson` or :class:`ConstantDensity`.
    shear
        :class:`Newtonian`, :class:`Eyring`, :class:`Carreau` or :class:`LimitingShear`, for the friction and not for
        the film.

    Raises
    ------
    InvalidInput
        For other values.
    """

    viscosity: PascalSeconds
    pressure_viscosity: Annotated[PressureViscosity, AT_LEAST_ZERO]
    viscosity_law: ViscosityLaw = Roelands()
    density: DensityLaw = DowsonHigginson()
    shear: ShearLaw = Newtonian()

    def check_together(self) -> None:
        """Check that Roelands' exponent that follows from viscosity and coefficient is one."""
        law = self.viscosity_law
        if isinstance(law, Roelands) and law.exponent is None:
            exponent = law.consistent_exponent(self.viscosity, self.pressure_viscosity)
            if exponent > 1:
                raise InvalidInput(
                    f"Lubricant.pressure_viscosity is {self.pressure_viscosity:g} 1/Pa, for which Roelands' exponent is "
                    f"{exponent:.3g} at a viscosity of {self.viscosity:g} Pa s, above 1: give a smaller coefficient, "
                    "a larger viscosity, Roelands(exponent=0.6), or Barus()."
                )

    @property
    def law(self) -> ViscosityLaw:
        """The law of viscosity, that of Roelands with the exponent that follows from alpha where none is given."""
        law = self.viscosity_law
        if not isinstance(law, Roelands) or law.exponent is not None:
            return law
        exponent = law.consistent_exponent(self.viscosity, self.pressure_viscosity)
        return replace(law, exponent=exponent) if exponent else Barus()
