"""Lubrication of a contact: the lubricant with its laws, cavitation, boundary film, and the motion that entrains it."""

from dataclasses import replace
from math import exp, inf, log
from typing import Annotated

import numpy as np

from contactstudy.domain import validation
from contactstudy.domain.grid import Array
from contactstudy.domain.validation import InvalidInput, validated
from contactstudy.scene.loads import PiecewiseLinear, Times, check_one_each
from contactstudy.scene.solids.bodies import Body, Layered, SceneContext

# Viscosity [Pa s] of Roelands' pole, the limit at high temperature, and the temperature [K] at which his viscosity
# diverges (Roelands 1966).
LEAST_VISCOSITY, LEAST_TEMPERATURE = exp(-9.67), 138.0
# Young's moduli [Pa] between which a body without thermal properties of its own is taken for steel.
STEEL_MODULI = (1.9e11, 2.2e11)
ABOVE_LEAST = validation.Limits(f"above {LEAST_TEMPERATURE:g} K", lambda x: LEAST_TEMPERATURE < x < inf)


@validated
class ThermalBody:
    """Thermal properties of a body, those of steel by default.

    Parameters
    ----------
    conductivity
        Thermal conductivity [W/(m K)], above 0.
    heat_capacity
        Heat capacity per volume [J/(m^3 K)], density times specific heat, above 0.
    coating
        Properties of the coating of a :class:`~contactstudy.CoatedHalfSpace`; None without one.

    Raises
    ------
    InvalidInput
        For other values.
    """

    conductivity: validation.ThermalConductivity = 46.0
    heat_capacity: validation.VolumetricHeatCapacity = 3.6e6
    coating: "ThermalBody | None" = None

    def check_together(self) -> None:
        """Check that there is one coating at the most."""
        if self.coating is not None and self.coating.coating is not None:
            raise InvalidInput(
                f"ThermalBody.coating.coating is {self.coating.coating!r}: give the ThermalBody of one coating."
            )


@validated
class FilmHeat:
    """Heat of a sheared film, which lowers its viscosity and with it the friction.

    Pressure and film thickness are those of the isothermal film. The friction is that of a film thinned by its heated
    inlet. The defaults are values of mineral oils, at 40 C.

    Parameters
    ----------
    temperature_viscosity
        Temperature-viscosity coefficient beta [1/K], the relative fall of viscosity with temperature at the supply, at
        least 0 (0: temperatures change nothing).
    conductivity
        Thermal conductivity of the lubricant [W/(m K)], above 0.
    first, second
        :class:`ThermalBody` of each body; None for steel, without a coating.
    supply_temperature
        Temperature of the lubricant's supply [K], above 138, at which viscosity and beta are given.

    Raises
    ------
    InvalidInput
        For other values.
    """

    temperature_viscosity: Annotated[validation.TemperatureCoefficient, validation.AT_LEAST_ZERO] = 0.04
    conductivity: validation.ThermalConductivity = 0.14
    first: ThermalBody | None = None
    second: ThermalBody | None = None
    supply_temperature: Annotated[validation.Kelvins, ABOVE_LEAST] = 313.15

    @property
    def bodies(self) -> tuple[ThermalBody, ThermalBody]:
        """Properties of both bodies."""
        return self.first or ThermalBody(), self.second or ThermalBody()

    def check(self, solids: tuple[Body, Body]) -> None:
        """Raise :class:`~contactstudy.InvalidInput` where a body or its coating has no properties of its own."""
        for number, (name, solid) in enumerate(zip(("first", "second"), solids, strict=True)):
            body, coated = getattr(self, name), isinstance(solid, Layered)
            is_steel = not coated and STEEL_MODULI[0] <= getattr(solid, "youngs_modulus", 0.0) <= STEEL_MODULI[1]
            fault = "" if body is not None or is_steel else "None, the properties of steel"
            if body is not None and (body.coating is None) == coated:
                fault = f"with{'out' * coated} a coating"
            elif getattr(solid, "interlayers", ()):
                fault = "for a body without interlayers, as heat is conducted through one coating alone"
            if fault:
                raise InvalidInput(
                    f"FilmHeat.{name} is {fault}, and Scene.solids[{number}] is {solid!r}: give ThermalBody("
                    "conductivity=..., heat_capacity=...), with its coating if it has one, or leave the FilmHeat out."
                )

    def thinning(self, rise: Array, viscosity: float) -> Array:
        """Return the change of ``ln(eta)`` at zero pressure by a temperature `rise` [K] above the supply's.

        The `viscosity` [Pa s] is that at the supply. ``ln(eta / eta_l)`` falls as ``(T - T_l)^(-S)``, with eta_l and T_l
        its limits, and S the slope that `temperature_viscosity` gives at the supply (Roelands 1966).
        """
        above = self.supply_temperature - LEAST_TEMPERATURE
        height = log(viscosity / LEAST_VISCOSITY)
        slope = self.temperature_viscosity * above / height
        return np.asarray(height * np.expm1(-slope * np.log1p(rise / above)))


@validated
class Barus:
    """Viscosity that grows by ``eta = eta0 exp(alpha p)`` (Barus 1893): too fast beyond some 0.5 GPa."""

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        return coefficient * pressure, np.full_like(pressure, coefficient)

    def temperature_factor(self, pressure: Array) -> Array:
        """Return one, the factor of pressure on :meth:`FilmHeat.thinning`: alpha does not depend on the temperature."""
        return np.ones_like(pressure)


@validated
class Roelands:
    """Viscosity that grows by ``ln(eta / eta0) = alpha p0 / z ((1 + p / p0)^z - 1)`` (Roelands 1966).

    Parameters
    ----------
    exponent
        z, above 0 and up to 1, where the law is that of :class:`Barus`. None: ``alpha p0 / (ln(eta0) + 9.67)``, with
        which heat and pressure change ``ln(eta) + 9.67`` by independent factors.
    reference_pressure
        p0 [Pa], above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    exponent: Annotated[validation.Number, validation.UP_TO_ONE] | None = None
    reference_pressure: validation.Pascals = 1.96e8

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
        """Return ``(1 + p / p0)^z``, the factor of pressure on :meth:`FilmHeat.thinning`: heat lowers alpha."""
        assert self.exponent is not None
        return np.asarray((1 + pressure / self.reference_pressure) ** self.exponent)


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

    compressibility: Annotated[validation.Compressibility, validation.AT_LEAST_ZERO] = 0.6e-9
    saturation: validation.Compressibility = 1.7e-9

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return ``rho / rho0`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        spread = 1 + self.saturation * pressure
        return 1 + self.compressibility * pressure / spread, self.compressibility / spread**2


@validated
class Newtonian:
    """A shear stress in proportion to the shear rate, without a limit."""

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]: the `newtonian` one itself, viscosity times shear rate [Pa]."""
        return newtonian.copy()


@validated
class Eyring:
    """Shear stress ``tau = tau0 asinh(eta rate / tau0)`` (Eyring 1936), by default of a mineral oil.

    Parameters
    ----------
    reference
        Eyring stress tau0 [Pa], above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    reference: validation.Pascals = 5e6

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

    reference: validation.Pascals = 5e6
    exponent: Annotated[validation.Number, validation.UP_TO_ONE] = 0.5

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
        Lambda, growth of the limiting shear stress with pressure, above 0; of oils some 0.04 to 0.1.
    ambient
        Limiting shear stress tau_0 [Pa] at ambient pressure, at least 0; 1 to 10 MPa are measured.

    Raises
    ------
    InvalidInput
        For other values.
    """

    coefficient: validation.Number = 0.07
    ambient: Annotated[validation.Pascals, validation.AT_LEAST_ZERO] = 3e6

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]."""
        limit = self.ambient + self.coefficient * pressure
        bounded = np.divide(newtonian, limit, out=np.zeros_like(limit), where=limit > 0)
        return np.asarray(limit * np.tanh(bounded))


ViscosityLaw = Roelands | Barus
DensityLaw = DowsonHigginson | ConstantDensity
ShearLaw = Newtonian | Eyring | Carreau | LimitingShear


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

    viscosity: validation.PascalSeconds
    pressure_viscosity: Annotated[validation.PressureViscosity, validation.AT_LEAST_ZERO]
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
        """The law of viscosity; without an exponent Roelands' law has that of alpha, and is Barus' for an alpha of 0."""
        law = self.viscosity_law
        if not isinstance(law, Roelands) or law.exponent is not None:
            return law
        exponent = law.consistent_exponent(self.viscosity, self.pressure_viscosity)
        return replace(law, exponent=exponent) if exponent else Barus()


# Relative difference up to which a given exponent of Roelands counts as that of alpha, which may have been rounded.
EXPONENT_TOLERANCE = 0.02


@validated
class ElrodAdams:
    """Cavitation that conserves mass: where the pressure is zero, lubricant fills a fraction of the gap.

    Source: Jakobsson & Floberg (1957), Elrod & Adams (1974).
    """


@validated
class ReynoldsCavitation:
    """Cavitation that only forbids negative pressures: the film counts as full where the pressure is zero.

    Lubricant appears wherever such a film opens and is lost nowhere, so that the flow is not the same through every
    section. It differs from :class:`ElrodAdams` where the film forms again, as behind waves. Source: Swift (1932),
    Stieber (1933).
    """


Cavitation = ElrodAdams | ReynoldsCavitation


@validated
class Boundary:
    """Adsorbed boundary film, on which asperities carry load where the fluid film is no thicker than it.

    Parameters
    ----------
    film
        Smallest distance of the surfaces [m], above 0, such as 5e-9.
    coefficient
        Coefficient of friction of the asperities, at least 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    film: validation.Metres
    coefficient: Annotated[validation.Number, validation.AT_LEAST_ZERO] = 0.12


@validated
class SpeedHistory(PiecewiseLinear):
    """Mean speed given at instants, linear between them, and held before the first and after the last.

    Parameters
    ----------
    times
        Instants [s], ascending.
    mean_speed
        Speed [m/s] at each instant, at least zero; above zero at the first, where the film is steady.

    Raises
    ------
    InvalidInput
        For other values.
    """

    times: Times
    mean_speed: tuple[Annotated[validation.MetresPerSecond, validation.AT_LEAST_ZERO], ...]

    def check_together(self) -> None:
        """Check that times ascend, with a speed for each, and that the film is steady at the first."""
        times, speeds = self.times, self.mean_speed
        check_one_each("SpeedHistory.mean_speed", speeds, "times", times, least=2)
        if sorted(set(times)) != list(times):
            raise InvalidInput(f"SpeedHistory.times is {self.times!r}: give ascending times.")
        if speeds[0] == 0:
            raise InvalidInput("SpeedHistory.mean_speed[0] is 0 m/s, where no film is steady: give a speed above it.")

    @property
    def values(self) -> tuple[float, ...]:  # type: ignore[override]
        """Speed [m/s] at each instant."""
        return self.mean_speed

    def _between(self, count: int, time: float) -> float:
        """Return the speed [m/s] at `time` [s], before which there are `count` instants; the first one if none."""
        return float(np.interp(time, self.times, self.mean_speed))


@validated
class Lubrication:
    """Lubricant of a contact, and the mean motion of the surfaces to larger x that entrains it.

    Heights are fixed in the frame of the contact, unless they are :class:`~contactstudy.MovingShape`. See
    :func:`~contactstudy.solve`.

    Parameters
    ----------
    lubricant
        The lubricant, which enters from the side of smaller x.
    mean_speed
        Entrainment speed u_m [m/s], the mean of both surface speeds, above 0; or a :class:`SpeedHistory`.
    slide_roll_ratio
        Difference of the surface speeds, first body less second, over their mean.
    cavitation
        :class:`ElrodAdams`, which conserves mass, or :class:`ReynoldsCavitation`, to compare with.
    boundary
        :class:`Boundary` on which asperities carry load; None for no lower limit of the film.
    supply
        Inlet film thickness [m] of starved lubrication, on both surfaces together, above 0; None is fully flooded.
    thermal
        :class:`FilmHeat` of sliding and of the inlet; None for one temperature.

    Raises
    ------
    InvalidInput
        For other values.
    """

    lubricant: Lubricant
    mean_speed: validation.MetresPerSecond | SpeedHistory
    slide_roll_ratio: Annotated[validation.Number, validation.FINITE] = 0.0
    cavitation: Cavitation = ElrodAdams()
    boundary: Boundary | None = None
    supply: validation.Metres | None = None
    thermal: FilmHeat | None = None

    def check_together(self) -> None:
        """Check fields against each other."""
        for name in ("supply", "boundary"):
            if getattr(self, name) is not None and not isinstance(self.cavitation, ElrodAdams):
                raise InvalidInput(
                    f"Lubrication.{name} is supported with ElrodAdams() only, which conserves the lubricant: "
                    "leave one out."
                )
        if self.thermal is None:
            return
        if self.lubricant.viscosity <= LEAST_VISCOSITY:
            raise InvalidInput(
                f"Lubricant.viscosity is {self.lubricant.viscosity:g} Pa s, where Roelands' law has no temperature: "
                f"give one above {LEAST_VISCOSITY:.4g}, or leave Lubrication.thermal out."
            )
        oil, law = self.lubricant, self.lubricant.viscosity_law
        if isinstance(law, Roelands) and law.exponent is not None:
            consistent = law.consistent_exponent(oil.viscosity, oil.pressure_viscosity)
            if abs(law.exponent - consistent) > EXPONENT_TOLERANCE * law.exponent:
                raise InvalidInput(
                    f"Roelands.exponent is {law.exponent:g}, and heat and pressure act on one viscosity with "
                    f"alpha p0 / (ln(eta0) + 9.67) = {consistent:.3g} alone: give that, or None, or leave "
                    "Lubrication.thermal out."
                )
        if abs(self.slide_roll_ratio) == 2:
            raise InvalidInput(
                f"Lubrication.slide_roll_ratio is {self.slide_roll_ratio:g}, where a surface stands still and heats up "
                "without limit: give another one, or leave Lubrication.thermal out."
            )

    def check(self, scene: SceneContext) -> None:
        """Raise :class:`~contactstudy.InvalidInput` for bodies without thermal properties of their own."""
        if self.thermal is not None:
            self.thermal.check(scene.solids)

    @property
    def contact_speeds(self) -> tuple[float, float]:
        """Speed [m/s] along x of the contact over each body, opposite to its surface, at the largest mean speed."""
        mean, slide = self.largest_speed, self.slide_roll_ratio / 2
        return -mean * (1 + slide), -mean * (1 - slide)

    @property
    def largest_speed(self) -> float:
        """Largest mean speed [m/s]."""
        speed = self.mean_speed
        return max(speed.mean_speed) if isinstance(speed, SpeedHistory) else speed

    def speed_at(self, time: float) -> float:
        """Return the mean speed [m/s] at ``time`` [s]."""
        speed = self.mean_speed
        return speed.at(time) if isinstance(speed, SpeedHistory) else speed
