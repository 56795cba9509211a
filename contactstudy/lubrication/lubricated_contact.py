"""The result of a lubricated contact: fields, film, friction, and a status that says how far they can be trusted."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import pi, sqrt
from typing import TYPE_CHECKING, Literal

import numpy as np

from contactstudy.analytic import HertzLine, moes_film
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import Grid, Padding, Paddings
from contactstudy.domain.imports import presentation
from contactstudy.scene.lubrication import Lubrication
from contactstudy.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


class FilmStatus(Enum):
    """The outcome of a lubricated contact; ``str(status)`` is a sentence with cause and remedy."""

    CONVERGED = "the residual is below the tolerance"
    STARVED_INLET = (
        "converged, but the inlet is so short that its film is more than 5 % too thin: "
        "give Grid.extent a larger width"
    )
    FILM_BELOW_CELL = (
        "converged, but the film is thinner than the surfaces part over one cell, in the inlet or beside the "
        "smallest film, which may be more than 10 % off: give more cells across"
    )
    NOT_CONVERGED = (
        "the residual stayed above the tolerance: give more cells across where a spike of pressure is "
        "unresolved, more iterations, or start from the film at a higher speed"
    )

    def __str__(self) -> str:
        return f"{self.name}: {self.value}."


@dataclass(frozen=True)
class FilmScales:
    """Hertz's units of a lubricated contact and the parameters of Moes (1992), at the largest load and speed."""

    hertz: HertzLine
    lubrication: Lubrication

    @property
    def film(self) -> float:
        """Unit of the film, ``a^2 / R`` [m]."""
        return self.hertz.half_width**2 / self.hertz.radius

    @property
    def resistance(self) -> float:
        """``lambda = 12 eta0 u_m R^2 / (a^3 p_H)``."""
        hertz, motion = self.hertz, self.lubrication
        viscous = 12 * motion.lubricant.viscosity * motion.largest_speed * hertz.radius**2
        return viscous / (hertz.half_width**3 * hertz.peak_pressure)

    @property
    def load_parameter(self) -> float:
        """``M = W / (E' R) (eta0 u_s / (E' R))^(-1/2)`` with E' = 2 E* and u_s = 2 u_m (Moes 1992)."""
        return sqrt(3 * pi**2 / (8 * self.resistance))

    @property
    def viscosity_parameter(self) -> float:
        """``L = alpha E' (eta0 u_s / (E' R))^(1/4)`` (Moes 1992)."""
        alpha = self.lubrication.lubricant.pressure_viscosity
        return alpha * self.hertz.peak_pressure * sqrt(2 * pi / self.load_parameter)

    @property
    def expected_film(self) -> float:
        """Central film over ``a^2 / R`` by the formula of Moes."""
        film = moes_film(self.load_parameter, self.viscosity_parameter)
        return film * pi / (8 * self.load_parameter)

    @property
    def reach(self) -> float:
        """Half-width of the pressure in units of that of Hertz; a thick film bears it over ``sqrt(2 H)``."""
        return max(1.0, sqrt(2 * self.expected_film))


@dataclass(frozen=True)
class FilmErrorParts:
    """Relative errors by cause.

    ``discretisation`` is that of the cells, ``inlet`` that of a finite inlet, ``residual`` that of the iteration.
    """

    discretisation: float
    inlet: float
    residual: float

    @property
    def total(self) -> float:
        """Sum of the parts."""
        return self.discretisation + self.inlet + self.residual


@dataclass(frozen=True)
class FilmError:
    """Estimated relative errors of a lubricated contact; ``peak_pressure`` is infinite beside a spike.

    ``reason`` says why a part is infinite, and is empty where none is.
    """

    central_film: FilmErrorParts
    minimum_film: FilmErrorParts
    friction: FilmErrorParts
    pressure_l1: FilmErrorParts
    peak_pressure: FilmErrorParts
    reason: str = ""


@dataclass(frozen=True, eq=False)
class LubricatedContact:
    """Fields (x, y) of a lubricated contact: ``pressure`` [Pa], ``film`` [m], ``film_fraction``.

    The film fraction is the share of the film that holds lubricant: one under pressure, less where the lubricant is
    torn into streamers. ``shear`` [Pa] is the stress in the middle of the film, positive where it drags the first
    body back; ``mean_speed`` [m/s] is that of the instant. ``residual`` is the larger of the flow that is not balanced
    over the flow along x, and the load that is missing over the load of Hertz's peak pressure on one half-width.
    ``flow`` [m^2/s] is the lubricant that passes per length, at the density of zero pressure, and ``flux_spread`` its
    range over x, with plain cavitation up to the end of the pressure, over its mean. ``linear_iterations`` counts those
    of all linear systems. ``error`` is None unless an error was asked for.
    """

    scene: Scene
    grid: Grid
    padding: Padding | Paddings
    scales: FilmScales
    pressure: Array
    film: Array
    film_fraction: Array
    shear: Array
    mean_speed: float
    separation: float
    status: FilmStatus
    iterations: int
    linear_iterations: int
    residual: float
    flow: float
    flux_spread: float
    error: FilmError | None = None

    @property
    def is_smooth(self) -> bool:
        """True in plane strain, with one cell along the length."""
        return self.grid.cells[1] == 1

    @property
    def central_film(self) -> float:
        """Film on the axis, mean over the length [m]."""
        return float(_on_axis(self.film.mean(axis=1)))

    @property
    def minimum_film(self) -> float:
        """Smallest film [m], from a parabola of its logarithm across the lowest cell and its neighbours."""
        row, column = np.unravel_index(np.argmin(self.film), self.film.shape)
        if not 0 < row < len(self.film) - 1:
            return float(self.film[row, column])
        # of logarithms, which keep the film above zero
        before, lowest, after = np.log(self.film[row - 1 : row + 2, column])
        curvature = before + after - 2 * lowest
        drop = (after - before) ** 2 / (8 * curvature) if curvature > 0 else 0.0
        return float(np.exp(lowest - drop))

    @property
    def peak_pressure(self) -> float:
        """Largest pressure of a cell [Pa]; beside a spike it depends on the cells."""
        return float(self.pressure.max())

    @property
    def load_per_length(self) -> float:
        """Load that the pressure carries, mean over the length [N/m]."""
        return float(self.pressure.sum() * self.grid.cell[0] / self.grid.cells[1])

    @property
    def sliding_speed(self) -> float:
        """Speed of the first surface less that of the second [m/s]."""
        return self.mean_speed * self.scales.lubrication.slide_roll_ratio

    @property
    def friction(self) -> float:
        """Friction force over load, negative where the second body is the faster one."""
        return float(self.shear.sum() / self.pressure.sum())

    @property
    def power_loss(self) -> float:
        """Power lost in the film per length [W/m], by sliding, and by the flow that pressure drives.

        All at one temperature: heating, and with it the flash temperature, is not modelled.
        """
        oil = self.scales.lubrication.lubricant
        dx, dy = self.grid.cell
        across = np.gradient(self.pressure, dx, axis=0)
        along = (np.roll(self.pressure, -1, 1) - np.roll(self.pressure, 1, 1)) / (2 * dy)
        log_viscosity, _ = oil.viscosity_law.log_ratio(self.pressure, oil.pressure_viscosity)
        fluidity = self.film**3 / (12 * oil.viscosity) * np.exp(-log_viscosity)
        density = self.shear * self.sliding_speed + fluidity * (across**2 + along**2)
        return float(density.sum() * dx / self.grid.cells[1])

    def thinner_than(self, film: float) -> tuple[float, float]:
        """Return the shares of the area of Hertz's contact and of the load where the film is below ``film`` [m]."""
        thin = self.film < film
        hertz_area = 2 * self.scales.hertz.half_width * self.grid.period
        return (
            float(np.count_nonzero(thin) * self.grid.cell_area / hertz_area),
            float(self.pressure[thin].sum() / self.pressure.sum()),
        )

    def __repr__(self) -> str:
        nx, ny = self.pressure.shape
        return (
            f"<LubricatedContact {self.status.name}: {nx} x {ny} cells, central film {self.central_film:.4g} m, "
            f"minimum film {self.minimum_film:.4g} m, {self.iterations} iterations, residual {self.residual:.1e}>"
        )

    def to_dataset(self) -> "xr.Dataset":
        """Return the fields, labelled, with units and the scene."""
        dataset: xr.Dataset = presentation("LubricatedContact.to_dataset")(self)
        return dataset

    def plot(
        self,
        *,
        colours: Literal["pressure", "interference"] = "pressure",
        refractive_index: float = 1.5,
        wavelengths: Sequence[float] | None = None,
    ) -> "Figure":
        """Return a picture of pressure and film, as a matplotlib figure.

        Parameters
        ----------
        colours
            Map of the pressure, or of the film in the colours of two-beam interference, dark where it vanishes.
        refractive_index
            Refractive index of the lubricant, for interference.
        wavelengths
            Wavelengths [m] of the light, for interference; white light if None.
        """
        draw = presentation("LubricatedContact.plot")
        figure: Figure = draw(self.to_dataset(), colours, refractive_index, wavelengths)
        return figure


def _on_axis(values: Array) -> float:
    """Return the value at x = 0 of values at cell centres across, exact for a cubic."""
    middle = len(values) // 2
    if len(values) % 2:
        return float(values[middle])
    near, far = values[middle - 1 : middle + 1].mean(), values[middle - 2 : middle + 2 : 3].mean()
    return float(9 * near - far) / 8


def rise_beside_lowest(film: Array) -> float:
    """Return how much the film (x, y) rises from its lowest cell to the higher of its neighbours across, over itself."""
    row, column = np.unravel_index(np.argmin(film), film.shape)
    beside = film[max(row - 1, 0) : row + 2, column]
    return float(beside.max() / film[row, column] - 1)


def shear_stress(
    scales: FilmScales, mean_speed: float, pressure: Array, film: Array, film_fraction: Array
) -> Array:
    """Return the shear stress [Pa] of sliding in the middle of the film, by the shear law of the lubricant.

    Only the share of the film that holds lubricant is sheared.
    """
    motion = scales.lubrication
    oil = motion.lubricant
    log_viscosity, _ = oil.viscosity_law.log_ratio(pressure, oil.pressure_viscosity)
    with np.errstate(over="ignore"):  # Barus' law knows no end
        sliding = mean_speed * motion.slide_roll_ratio
        newtonian = oil.viscosity * np.exp(log_viscosity) * sliding / film
    return film_fraction * oil.shear.stress(newtonian, pressure)
