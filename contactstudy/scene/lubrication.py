"""Lubrication of a contact: the lubricant with its laws, and the motion that entrains it."""

from dataclasses import dataclass
from math import inf
from typing import Protocol, runtime_checkable

import numpy as np

from contactstudy.domain.checks import (
    InvalidInput,
    each,
    finite,
    in_range,
    in_range_from_zero,
    set_fields,
    suggest_fields,
)
from contactstudy.domain.fields import Array
from contactstudy.domain.units import (
    Metres,
    MetresPerSecond,
    Number,
    Pascals,
    PascalSeconds,
    PressureViscosity,
    Seconds,
)
from contactstudy.scene.bodies import BodyContext, creeps, yields
from contactstudy.scene.film_heat import LEAST_VISCOSITY, FilmHeat
from contactstudy.scene.load import History


class FilmContext(BodyContext, Protocol):
    """Properties of a scene that decide whether it can have a film."""

    @property
    def friction(self) -> object | None:
        """Dry friction, or None."""

    @property
    def time_dependent_field(self) -> str | None:
        """Name of a field that changes in time, or None."""

    @property
    def shapes(self) -> tuple[object, ...]:
        """Contributions to the undeformed gap."""


@runtime_checkable
class ViscosityLaw(Protocol):
    """Viscosity as a function of pressure."""

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa], at least 0 Pa.

        ``coefficient`` [1/Pa] is the derivative at zero pressure.
        """

    def temperature_factor(self, pressure: Array) -> Array:
        """Return the relative fall of viscosity with temperature at ``pressure`` [Pa], over that at zero pressure."""


@suggest_fields
@dataclass(frozen=True)
class Barus:
    """Viscosity that grows by ``eta = eta0 exp(alpha p)`` (Barus 1893): too fast beyond some 0.5 GPa."""

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        return coefficient * pressure, np.full_like(pressure, coefficient)

    def temperature_factor(self, pressure: Array) -> Array:
        """Return one: the pressure coefficient does not depend on the temperature."""
        return np.ones_like(pressure)


@suggest_fields
@dataclass(frozen=True)
class Roelands:
    """Viscosity that grows by ``ln(eta / eta0) = alpha p0 / z ((1 + p / p0)^z - 1)`` (Roelands 1966).

    Parameters
    ----------
    exponent
        z, above 0 and up to 1, where the law is that of :class:`Barus`.
    reference_pressure
        p0 [Pa], above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    exponent: Number = 0.6
    reference_pressure: Pascals = 1.96e8

    def __post_init__(self) -> None:
        remedy = "give an exponent above 0 and up to 1, such as 0.6"
        exponent = in_range("Roelands.exponent", self.exponent, remedy)
        if exponent > 1:
            raise InvalidInput(f"Roelands.exponent is {self.exponent!r}: {remedy}.")
        pressure = in_range(
            "Roelands.reference_pressure", self.reference_pressure, "give a pressure above 0 Pa"
        )
        set_fields(self, exponent=exponent, reference_pressure=pressure)

    def log_ratio(self, pressure: Array, coefficient: float) -> tuple[Array, Array]:
        """Return ``ln(eta / eta0)`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        z, p0 = self.exponent, self.reference_pressure
        stretched = 1 + pressure / p0
        return (coefficient * p0 / z * (stretched**z - 1), coefficient * stretched ** (z - 1))

    def temperature_factor(self, pressure: Array) -> Array:
        """Return ``(1 + p / p0)^z``: Roelands' pressure coefficient falls as the temperature rises."""
        return np.asarray((1 + pressure / self.reference_pressure) ** self.exponent)


@runtime_checkable
class DensityLaw(Protocol):
    """Density as a function of pressure."""

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return ``rho / rho0`` and its derivative [1/Pa] at ``pressure`` [Pa], at least 0 Pa."""


@suggest_fields
@dataclass(frozen=True)
class ConstantDensity:
    """An incompressible lubricant."""

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return one, and zero [1/Pa]."""
        return np.ones_like(pressure), np.zeros_like(pressure)


@suggest_fields
@dataclass(frozen=True)
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

    compressibility: PressureViscosity = 0.6e-9
    saturation: PressureViscosity = 1.7e-9

    def __post_init__(self) -> None:
        set_fields(
            self,
            compressibility=in_range_from_zero(
                "DowsonHigginson.compressibility",
                self.compressibility,
                "give a compressibility of at least 0 1/Pa",
            ),
            saturation=in_range("DowsonHigginson.saturation", self.saturation, "give 1/Pa above 0"),
        )

    def ratio(self, pressure: Array) -> tuple[Array, Array]:
        """Return ``rho / rho0`` and its derivative [1/Pa] at ``pressure`` [Pa]."""
        spread = 1 + self.saturation * pressure
        return 1 + self.compressibility * pressure / spread, self.compressibility / spread**2


@runtime_checkable
class ShearLaw(Protocol):
    """Shear stress of a lubricant as a function of the shear rate."""

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa] where that of a Newtonian lubricant is ``newtonian`` [Pa]."""


@suggest_fields
@dataclass(frozen=True)
class Newtonian:
    """A shear stress in proportion to the shear rate, without a limit."""

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the stress itself."""
        return newtonian.copy()


@suggest_fields
@dataclass(frozen=True)
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

    def __post_init__(self) -> None:
        remedy = "give an Eyring stress above 0 Pa, such as 5e6"
        set_fields(self, reference=in_range("Eyring.reference", self.reference, remedy))

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]."""
        return np.asarray(self.reference * np.arcsinh(newtonian / self.reference))


@suggest_fields
@dataclass(frozen=True)
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
    exponent: Number = 0.5

    def __post_init__(self) -> None:
        reference = in_range("Carreau.reference", self.reference, "must be above 0 Pa, such as 5e6")
        remedy = "must be above 0 and at most 1, such as 0.5"
        exponent = in_range("Carreau.exponent", self.exponent, remedy)
        if exponent > 1:
            raise InvalidInput(f"Carreau.exponent is {self.exponent!r}: {remedy}.")
        set_fields(self, reference=reference, exponent=exponent)

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]."""
        # hypot does not overflow
        thinning = np.hypot(1, newtonian / self.reference) ** (self.exponent - 1)
        return np.asarray(newtonian * thinning)


@suggest_fields
@dataclass(frozen=True)
class LimitingShear:
    """Shear stress ``tau = tau_L tanh(eta rate / tau_L)`` with a limit ``tau_L`` in proportion to the pressure.

    Source of such a limit: Bair & Winer (1979).

    Parameters
    ----------
    coefficient
        Limiting shear stress over pressure, above 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    coefficient: Number = 0.07

    def __post_init__(self) -> None:
        remedy = "give the limiting shear stress over pressure, above 0, such as 0.07"
        set_fields(
            self, coefficient=in_range("LimitingShear.coefficient", self.coefficient, remedy)
        )

    def stress(self, newtonian: Array, pressure: Array) -> Array:
        """Return the shear stress [Pa]; zero without pressure."""
        limit = self.coefficient * pressure
        bounded = np.divide(newtonian, limit, out=np.zeros_like(limit), where=limit > 0)
        return np.asarray(limit * np.tanh(bounded))


@suggest_fields
@dataclass(frozen=True)
class ElrodAdams:
    """Cavitation that conserves mass: where the pressure is zero, lubricant fills a fraction of the film.

    Source: Jakobsson & Floberg (1957), Elrod & Adams (1974).
    """


@suggest_fields
@dataclass(frozen=True)
class ReynoldsCavitation:
    """Cavitation that only forbids negative pressures: the film counts as full where the pressure is zero.

    Lubricant appears wherever such a film opens and is lost nowhere, so that the flow is not the same through every
    section. It differs from :class:`ElrodAdams` where the film forms again, as behind waves. Source: Swift (1932),
    Stieber (1933).
    """


Cavitation = ElrodAdams | ReynoldsCavitation


@suggest_fields
@dataclass(frozen=True)
class Boundary:
    """Adsorbed boundary film, on which asperities carry load where the fluid film is as thin.

    Parameters
    ----------
    film
        Thickness [m] below which the surfaces cannot come closer, above 0, such as 5e-9.
    coefficient
        Coefficient of friction of the asperities, at least 0.

    Raises
    ------
    InvalidInput
        For other values.
    """

    film: Metres
    coefficient: Number = 0.12

    def __post_init__(self) -> None:
        film = in_range("Boundary.film", self.film, "give a thickness above 0 m, such as 5e-9")
        coefficient = in_range_from_zero(
            "Boundary.coefficient", self.coefficient, "must be at least 0, such as 0.12"
        )
        set_fields(self, film=film, coefficient=coefficient)


@runtime_checkable
class ChangingSpeed(History, Protocol):
    """Mean speed [m/s] as a function of time [s]."""


@suggest_fields
@dataclass(frozen=True)
class SpeedHistory:
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

    times: tuple[Seconds, ...]
    mean_speed: tuple[MetresPerSecond, ...]

    def __post_init__(self) -> None:
        for name in ("times", "mean_speed"):
            values = getattr(self, name)
            if not isinstance(values, tuple | list) or len(values) < 2:
                raise InvalidInput(
                    f"SpeedHistory.{name} is {values!r}: give a tuple of two or more numbers, one for each instant."
                )
        times = each("SpeedHistory.times", self.times, finite, "give a time [s]")
        remedy = "give a speed of at least 0 m/s"
        speeds = each("SpeedHistory.mean_speed", self.mean_speed, in_range_from_zero, remedy)
        if len(times) != len(speeds):
            raise InvalidInput(
                f"SpeedHistory.mean_speed has {len(speeds)} speeds for {len(times)} times: give one for each."
            )
        if sorted(set(times)) != list(times):
            raise InvalidInput(f"SpeedHistory.times is {self.times!r}: give ascending times.")
        if speeds[0] == 0:
            raise InvalidInput(
                "SpeedHistory.mean_speed[0] is 0 m/s, where no film is steady: give a speed above it."
            )
        set_fields(self, times=times, mean_speed=speeds)

    @property
    def largest(self) -> float:
        """Largest speed [m/s]."""
        return max(self.mean_speed)

    @property
    def start(self) -> float:
        """First instant [s]."""
        return self.times[0]

    @property
    def end(self) -> float:
        """Last instant [s]."""
        return self.times[-1]

    def at(self, time: float) -> float:
        """Return the speed [m/s] at ``time`` [s]."""
        return float(np.interp(time, self.times, self.mean_speed))


@suggest_fields
@dataclass(frozen=True)
class Lubricant:
    """Lubricant at one temperature.

    Parameters
    ----------
    viscosity
        eta0 [Pa s] at zero pressure, above 0.
    pressure_viscosity
        alpha [1/Pa], the relative growth of viscosity with pressure at zero pressure, at least 0 (0: isoviscous).
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
    pressure_viscosity: PressureViscosity
    viscosity_law: ViscosityLaw = Roelands()
    density: DensityLaw = DowsonHigginson()
    shear: ShearLaw = Newtonian()

    def __post_init__(self) -> None:
        viscosity = in_range("Lubricant.viscosity", self.viscosity, "give a viscosity above 0 Pa s")
        remedy = "give a coefficient of at least 0 1/Pa, such as 2e-8"
        coefficient = in_range_from_zero(
            "Lubricant.pressure_viscosity", self.pressure_viscosity, remedy
        )
        set_fields(self, viscosity=viscosity, pressure_viscosity=coefficient)
        for name, kind, example in (
            ("viscosity_law", ViscosityLaw, "Roelands()"),
            ("density", DensityLaw, "DowsonHigginson()"),
            ("shear", ShearLaw, "Eyring(5e6)"),
        ):
            law = getattr(self, name)
            if isinstance(law, type) or not isinstance(law, kind):
                raise InvalidInput(f"Lubricant.{name} is {law!r}: give a law, such as {example}.")


@suggest_fields
@dataclass(frozen=True)
class Lubrication:
    """Lubricant of a contact, and the motion of the surfaces to larger x that entrains it.

    Heights are fixed in the frame of the contact, unless they are :class:`~contactstudy.MovingShape`. See
    :func:`~contactstudy.solve`.

    Parameters
    ----------
    lubricant
        The lubricant, which enters from the side of smaller x.
    mean_speed
        u_m [m/s], the mean of both surface speeds, above 0; or a :class:`SpeedHistory`.
    slide_roll_ratio
        Difference of the surface speeds, first body less second, over their mean.
    cavitation
        :class:`ElrodAdams`, which conserves mass, or :class:`ReynoldsCavitation`, to compare with.
    boundary
        :class:`Boundary` on which asperities carry load; None for a film that is as thin as it becomes.
    supply
        Thickness [m] of the layer of lubricant that enters, on both surfaces together, above 0; None floods the inlet.
    thermal
        :class:`FilmHeat` of sliding and of the inlet; None for one temperature.

    Raises
    ------
    InvalidInput
        For other values.
    """

    lubricant: Lubricant
    mean_speed: MetresPerSecond | ChangingSpeed
    slide_roll_ratio: Number = 0.0
    cavitation: Cavitation = ElrodAdams()
    boundary: Boundary | None = None
    supply: Metres | None = None
    thermal: FilmHeat | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.lubricant, Lubricant):
            raise InvalidInput(
                f"Lubrication.lubricant is {self.lubricant!r}: give a Lubricant(viscosity=..., pressure_viscosity=...)."
            )
        speed = self.mean_speed
        if not isinstance(speed, ChangingSpeed):
            remedy = "give a speed above 0 m/s, or a SpeedHistory; the dry contact is contactstudy.solve's"
            speed = in_range("Lubrication.mean_speed", speed, remedy)
        remedy = "give the sliding speed over the mean speed, such as 0.1"
        ratio = finite("Lubrication.slide_roll_ratio", self.slide_roll_ratio, remedy)
        set_fields(self, mean_speed=speed, slide_roll_ratio=ratio)
        if not isinstance(self.cavitation, Cavitation):
            raise InvalidInput(
                f"Lubrication.cavitation is {self.cavitation!r}: give ElrodAdams() or ReynoldsCavitation()."
            )
        if self.supply is not None:
            remedy = "give the thickness of a layer above 0 m, or None for a flooded inlet"
            set_fields(self, supply=in_range("Lubrication.supply", self.supply, remedy))
            if not isinstance(self.cavitation, ElrodAdams):
                raise InvalidInput(
                    "Lubrication.supply is supported with ElrodAdams() only, which conserves the lubricant: "
                    "leave one out."
                )
        if self.thermal is not None:
            self._check_thermal(self.thermal)
        if self.boundary is None:
            return
        if not isinstance(self.boundary, Boundary):
            raise InvalidInput(
                f"Lubrication.boundary is {self.boundary!r}: give a Boundary(film=...), or None."
            )
        if not isinstance(self.cavitation, ElrodAdams) or isinstance(speed, ChangingSpeed):
            raise InvalidInput(
                "Lubrication.boundary is supported for a steady film with ElrodAdams() only: leave it out."
            )

    def _check_thermal(self, thermal: object) -> None:
        """Raise :class:`~contactstudy.InvalidInput` where temperatures have no meaning."""
        if not isinstance(thermal, FilmHeat):
            raise InvalidInput(f"Lubrication.thermal is {thermal!r}: give a FilmHeat(), or None.")
        if isinstance(self.mean_speed, ChangingSpeed):
            raise InvalidInput(
                "Lubrication.thermal is supported at a steady speed only: give one, or leave it out."
            )
        if self.lubricant.viscosity <= LEAST_VISCOSITY:
            raise InvalidInput(
                f"Lubricant.viscosity is {self.lubricant.viscosity:g} Pa s, where Roelands' law has no temperature: "
                "give one above 6.3e-5, or leave Lubrication.thermal out."
            )
        if abs(self.slide_roll_ratio) == 2:
            raise InvalidInput(
                f"Lubrication.slide_roll_ratio is {self.slide_roll_ratio:g}, where a surface stands still and heats up "
                "for ever: give another one, or leave Lubrication.thermal out."
            )

    def check(self, scene: "FilmContext") -> None:
        """Raise :class:`~contactstudy.InvalidInput` for a scene with an effect that is not supported with a film."""
        for present, field, reason in (
            (
                scene.rolling is not None,
                "Scene.rolling",
                "Lubrication.mean_speed moves the surfaces already: leave rolling out",
            ),
            (
                scene.friction is not None,
                "Scene.friction",
                "Lubricant.shear and the boundary film give the friction: leave Scene.friction out",
            ),
            (
                scene.hardness != inf,
                "Scene.hardness",
                "the pressure of a lubricant follows from its flow, which a limit would interrupt: leave the hardness "
                "out, and compare the peak pressure with it",
            ),
            (
                any(map(creeps, scene.solids))
                and scene.time_dependent_field not in (None, "Scene.wear"),
                scene.time_dependent_field,
                "a body creeps below a steady film only: leave one of them out",
            ),
        ):
            if present:
                raise InvalidInput(
                    f"{field} is not supported together with Scene.lubrication, since {reason}."
                )
        for number, solid in enumerate(scene.solids):
            if yields(solid):
                self._check_yielding(scene, number)

    def _check_yielding(self, scene: "FilmContext", number: int) -> None:
        """Raise InvalidInput unless the body that yields, of this `number`, stands still below a steady film."""
        at_rest = -2.0 if number == 0 else 2.0
        if self.slide_roll_ratio != at_rest:
            raise InvalidInput(
                f"Scene.solids[{number}] yields, and its surface moves at a Lubrication.slide_roll_ratio of "
                f"{self.slide_roll_ratio:g}, which carries its strain out of the contact: give {at_rest:g}, at which it "
                "stands still, or an elastic body."
            )
        moves = any(hasattr(shape, "gap_after") for shape in scene.shapes)
        wears = getattr(scene, "wear", None) is not None
        if isinstance(self.mean_speed, ChangingSpeed) or moves or wears or scene.outputs:
            raise InvalidInput(
                f"Scene.solids[{number}] yields below a film, which is steady at each instant: give one speed, shapes "
                "that stand still, no wear and no outputs."
            )

    @property
    def contact_speeds(self) -> tuple[float, float]:
        """Speed [m/s] along x of the contact over each body, opposite to its surface, at the largest mean speed."""
        mean, slide = self.largest_speed, self.slide_roll_ratio / 2
        return -mean * (1 + slide), -mean * (1 - slide)

    @property
    def largest_speed(self) -> float:
        """Largest mean speed [m/s]."""
        speed = self.mean_speed
        return speed.largest if isinstance(speed, ChangingSpeed) else speed

    def speed_at(self, time: float) -> float:
        """Return the mean speed [m/s] at ``time`` [s]."""
        speed = self.mean_speed
        return speed.at(time) if isinstance(speed, ChangingSpeed) else speed
