"""Lubrication of a contact: cavitation, boundary film, and the motion that entrains the lubricant."""

from math import inf
from typing import Annotated

import numpy as np

from contactstudy.domain.checks import InvalidInput
from contactstudy.domain.units import Metres, MetresPerSecond, Number
from contactstudy.domain.validation import AT_LEAST_ZERO, FINITE, validated
from contactstudy.scene.loads.load_history import Times
from contactstudy.scene.lubrication.lubricant import LEAST_VISCOSITY, FilmHeat, Lubricant, Roelands
from contactstudy.scene.solids.bodies import SceneContext, creeps, yields

# Relative difference up to which a given exponent of Roelands counts as that of alpha, which may have been rounded.
EXPONENT_TOLERANCE = 0.02
# Effects that a film is not combined with, and why.
CONFLICTS = {
    "rolling": "Lubrication.mean_speed moves the surfaces already: leave rolling out",
    "friction": "Lubricant.shear and the boundary film give the friction: leave Scene.friction out",
}


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

    film: Metres
    coefficient: Annotated[Number, AT_LEAST_ZERO] = 0.12


@validated
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

    times: Times
    mean_speed: tuple[Annotated[MetresPerSecond, AT_LEAST_ZERO], ...]

    def check_together(self) -> None:
        """Check that times ascend, with a speed for each, and that the film is steady at the first."""
        times, speeds = self.times, self.mean_speed
        if len(times) != len(speeds) or len(times) < 2:
            raise InvalidInput(
                f"SpeedHistory.mean_speed has {len(speeds)} speeds for {len(times)} times: give two times or more, "
                "and one speed for each."
            )
        if sorted(set(times)) != list(times):
            raise InvalidInput(f"SpeedHistory.times is {self.times!r}: give ascending times.")
        if speeds[0] == 0:
            raise InvalidInput("SpeedHistory.mean_speed[0] is 0 m/s, where no film is steady: give a speed above it.")

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
    mean_speed: MetresPerSecond | SpeedHistory
    slide_roll_ratio: Annotated[Number, FINITE] = 0.0
    cavitation: Cavitation = ElrodAdams()
    boundary: Boundary | None = None
    supply: Metres | None = None
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
        """Raise :class:`~contactstudy.InvalidInput` for a scene with an effect that is not supported with a film."""
        named = [name for name in CONFLICTS if getattr(scene, name) is not None]
        refused = {f"Scene.{name}": CONFLICTS[name] for name in named}
        if scene.hardness < inf:
            refused["Scene.hardness"] = (
                "the pressure of a lubricant follows from its flow, which a limit would interrupt: leave the hardness "
                "out, and compare the peak pressure with it"
            )
        for number, solid in enumerate(scene.solids):
            if yields(solid):
                reason = "plastic strain is computed in dry contacts only: give an elastic HalfSpace"
                refused[f"Scene.solids[{number}]"] = reason
        changing = None if scene.wear is not None else scene.time_dependent_field
        if changing is not None and any(map(creeps, scene.solids)):
            reason = "creep is supported under a steady film only: give elastic bodies, or keep this field constant"
            refused[changing] = reason
        for field, reason in refused.items():
            raise InvalidInput(f"{field} is not supported together with Scene.lubrication, since {reason}.")
        if self.thermal is not None:
            self.thermal.check(scene.solids)
        if isinstance(self.mean_speed, SpeedHistory):
            changing = "Lubrication.mean_speed"
        for name in ("boundary", "thermal"):
            if changing is not None and getattr(self, name) is not None:
                raise InvalidInput(
                    f"Lubrication.{name} is supported for a steady film only, and {changing} changes in time: leave one "
                    "of them out."
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
        return speed.largest if isinstance(speed, SpeedHistory) else speed

    def speed_at(self, time: float) -> float:
        """Return the mean speed [m/s] at ``time`` [s]."""
        speed = self.mean_speed
        return speed.at(time) if isinstance(speed, SpeedHistory) else speed
