"""Reynolds' equation on the cells of a grid: flow through faces, balance of each cell, and its linearisation.

Everything is in Hertz units: lengths across and along over the half-width a, film thickness over a^2 / R with the radius
R, pressure over the largest pressure p_H, all of Hertz's contact; density rho and viscosity eta over those at zero
pressure, ``eta0`` for the latter; flow per length over the mean speed u_m and a^2 / R. Across is along x, in which the
surfaces move, and upstream towards smaller x; along the length is y, periodic.

A film of thickness ``H`` holds the content ``m = (1 - theta) rho H`` of lubricant per area; the void fraction ``theta``
is zero under pressure. The flow through the face between two cells across, 0 upstream of 1, at the distance dX is
``q = -rho C phi (P1 - P0) / (lambda dX) + W`` (Reynolds 1886, discretised here), with the speed parameter lambda of
:class:`FilmScales`:

- ``phi`` is the logarithmic mean of the fluidity ``eta0 / eta``: the exact mean for Barus' law;
- ``C = 2 H0^2 H1^2 / (H0 + H1)`` is the exact conductance of a wedge; it vanishes with either film;
- ``W`` is the Couette (wedge) flow, of second order and never negative: the content of cell 0 and of the next one
  upstream, extrapolated to the face. With the content ``m`` of cell 0 and the ratio ``r`` of the other one to it, its
  logarithm is extrapolated where the content falls (r >= 1), ``W = m r^(-1/2)``, else itself, ``W = m (3 - r) / 2``.

Through faces along the length there is only the Poiseuille flow. Cavitation is that of Elrod & Adams (1974): as much
lubricant leaves each cell as enters it, cavitated or not. With Reynolds cavitation the film is full where the pressure
is zero, and lubricant may appear in such a cell: the unknown in place of the void fraction is that source per area. One
column of cells (ny = 1) is plane strain.

On a boundary film ``H_b`` asperities carry a pressure where ``H = H_b``. The content that is entrained is at least that
of the boundary film: the second-order extrapolation from upstream could fall below it, and the contact would cavitate.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sqrt
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import toeplitz

from contactstudy.analytic import HertzLine, moes_film
from contactstudy.domain.device import Precision
from contactstudy.domain.grid import Array, Grid, Paddings
from contactstudy.elasticity.convolution import (
    Coefficients,
    Convolution,
    GeneralConvolution,
    by_symmetry,
    general_convolutions,
    superposed,
)
from contactstudy.scene.lubrication import Cavitation, ElrodAdams, Lubrication

# The logarithmic mean is a series where half the difference u of the logarithms is below this: there the next term of
# the series, u^4 / 120, is below 1e-14.
SERIES = 1e-3
# Cells across at the inlet and at the outlet without pressure or a balance of the flow: the wedge term needs two
# upstream. They are called fixed.
INLET_CELLS, OUTLET_CELLS = 2, 1

# One boolean for each cell (x, y).
Mask = NDArray[np.bool_]
Scalar = TypeVar("Scalar", bound=np.generic)
# Derivatives (x, y) of a value of each cell by one of a cell beside it, by the offset (across, along) of that cell.
Bands = Mapping[tuple[int, int], Array]


@dataclass(frozen=True)
class FilmScales:
    """Hertz's units of a lubricated contact and the parameters of Moes (1992), at a load and a mean speed [m/s]."""

    hertz: HertzLine
    lubrication: Lubrication
    mean_speed: float

    @property
    def film(self) -> float:
        """Unit of the film, ``a^2 / R`` [m]."""
        return self.hertz.half_width**2 / self.hertz.radius

    @property
    def speed_parameter(self) -> float:
        """Dimensionless speed parameter, ``lambda = 12 eta0 u_m R^2 / (a^3 p_H)`` (Venner & Lubrecht 2000)."""
        hertz, motion = self.hertz, self.lubrication
        viscous = 12 * motion.lubricant.viscosity * self.mean_speed * hertz.radius**2
        return viscous / (hertz.half_width**3 * hertz.peak_pressure)

    @property
    def load_parameter(self) -> float:
        """Load parameter, ``M = W / (E' R) (eta0 u_s / (E' R))^(-1/2)`` with E' = 2 E*, u_s = 2 u_m (Moes 1992)."""
        # by Hertz: a^2 = 8 W R / (pi E'), p_H = 2 W / (pi a)
        speed = self.speed_parameter
        return sqrt(3 * pi**2 / (8 * speed)) if speed else inf

    @property
    def viscosity_parameter(self) -> float:
        """Material parameter, ``L = alpha E' (eta0 u_s / (E' R))^(1/4)`` (Moes 1992).

        It is not Hamrock's viscosity parameter.
        """
        alpha = self.lubrication.lubricant.pressure_viscosity
        # L / (alpha E') = root(W / (E' R) / M), and p_H / E' = root(W / (2 pi E' R)) by Hertz
        return alpha * self.hertz.peak_pressure * sqrt(2 * pi / self.load_parameter)

    @property
    def expected_film(self) -> float:
        """Central film thickness over ``a^2 / R`` by the formula of Moes (1992)."""
        if not self.mean_speed:
            return 0.0
        film = moes_film(self.load_parameter, self.viscosity_parameter)  # h / R over (eta0 u_s / (E' R))^(1/2)
        return film * pi / (8 * self.load_parameter)

    @property
    def relative_half_width(self) -> float:
        """Half-width that carries load, over that of Hertz.

        In a thick film H it is ``sqrt(2 H)``, where the gap ``X^2 / 2`` of the rigid bodies is as large as the film.
        """
        return max(1.0, sqrt(2 * self.expected_film))


@dataclass(frozen=True, eq=False)
class Deflection:
    """Displacement of both surfaces under a pressure, positive where they move apart.

    The influence coefficients that are ``even`` across are those of elastic bodies; bodies that creep while they move
    have ``odd`` ones too, None if both are elastic.
    """

    even: Convolution
    odd: GeneralConvolution | None

    @classmethod
    def on(cls, grid: Grid, paddings: Paddings, response: Mapping[Coefficients, float], factor: float) -> "Deflection":
        """Return the deflection on a grid, times a ``factor``, such as one to Hertz units.

        The ``response`` of both bodies is a sum of influence coefficients with weights.
        """
        even, odd = by_symmetry(response)
        return cls(
            superposed(even, grid, paddings).scaled(factor, Precision.DOUBLE),
            general_convolutions([odd], grid, paddings)[0].scaled(factor) if odd else None,
        )

    @cached_property
    def influence(self) -> Array:
        """Displacement (x, x') at x under a unit pressure at x', in plane strain."""
        n = self.even.cells[0]
        unit = np.zeros((n, 1))
        unit[0] = 1
        downstream, upstream = (self(end)[:, 0] for end in (unit, unit[::-1]))
        return np.asarray(toeplitz(downstream, upstream[::-1]))

    def __call__(self, pressure: Array) -> Array:
        """Return the displacement (x, y) under a pressure (x, y)."""
        displacement = self.even(pressure)
        return displacement if self.odd is None else displacement + self.odd(pressure)


@dataclass(frozen=True, eq=False)
class Film:
    """State of a film: pressure of the lubricant, void fraction and thickness (x, y), and the separation of the bodies.

    Under Reynolds' cavitation ``void`` is the source of lubricant per area in place of a void fraction. The
    thickness is the separation, the gap and the deflection together. ``asperity_pressure`` (x, y) is carried by
    asperities; zero without a boundary film.
    """

    pressure: Array
    void: Array
    separation: float
    thickness: Array
    asperity_pressure: Array

    @property
    def total_pressure(self) -> Array:
        """Pressure (x, y) of lubricant and asperities."""
        return self.pressure + self.asperity_pressure


@dataclass(frozen=True)
class SqueezeTerm:
    """Time derivative of the content m by a backward difference, ``rate * m + history`` (x, y), for times in a / u_m."""

    rate: float
    history: Array


class _FaceSide(NamedTuple):
    """Fields (x, y) of the cells on one side of faces; a slope is a derivative by the pressure."""

    pressure: Array
    log_fluidity: Array
    log_fluidity_slope: Array
    density: Array
    density_slope: Array
    thickness: Array


class _FaceFlow(NamedTuple):
    """Flow (x, y) through the face behind each cell, and its derivatives by pressure and thickness of both cells.

    Behind is downstream across, and towards larger y along the length; "upstream" is the cell before a face.
    """

    flux: Array
    pressure_upstream: Array
    pressure_downstream: Array
    thickness_upstream: Array
    thickness_downstream: Array


@dataclass(frozen=True, eq=False)
class Linearised:
    """The flow balance of the cells to first order in changes of pressure, thickness and void fraction.

    ``residual`` (x, y) is the balance of each cell, what flows out less what flows in per length along; its terms per
    area, squeeze and source, are times the width of a cell. ``flux`` (x - 1, y) is the flow through the faces across.
    ``pressure`` at constant thickness, ``thickness`` and ``void`` are the derivatives of the balance by these three:
    the coefficient of offset (i, j) multiplies the change in the cell that far away. Rows of fixed cells are zero.
    ``content_slopes`` are the derivatives of the content by the three. ``inverse_time_step`` is that of an implicit
    step in pseudo-time, zero for none.
    """

    residual: Array
    flux: Array
    pressure: Bands
    thickness: Bands
    void: Bands
    content_slopes: tuple[Array, Array, Array]
    equation: "FilmEquation"
    inverse_time_step: float = 0.0

    def with_time_step(self, inverse: float, moved: Array, stored: Array | float) -> "Linearised":
        """Return the balance with the squeeze term of an implicit Euler step of the length 1 / ``inverse``.

        The film before the step is thinner than that of the linearisation by ``moved`` (x, y). A unit change of pressure
        adds further content ``stored`` (x, y), besides that of a compressible lubricant.
        """
        scaled = inverse * self.equation.cell[0] * ~self.equation.fixed
        bands = (
            {**band, (0, 0): band[0, 0] + scaled * slope}
            for band, slope in zip((self.pressure, self.thickness, self.void), self.content_slopes, strict=True)
        )
        pressure, thickness, void = bands
        residual = self.residual + scaled * self.content_slopes[1] * moved
        pressure[0, 0] = pressure[0, 0] + scaled * stored
        return replace(
            self, residual=residual, pressure=pressure, thickness=thickness, void=void, inverse_time_step=inverse
        )

    def change_with(self, pressure: Array, void: Array, thickness: Array) -> Array:
        """Return the change of the balance under changes of pressure, void fraction and thickness (x, y)."""
        changed = np.zeros_like(pressure)
        for bands, values in ((self.pressure, pressure), (self.thickness, thickness), (self.void, void)):
            for offset, coefficient in bands.items():
                changed += coefficient * neighbour(values, offset)
        return changed


@dataclass(frozen=True, eq=False)
class FilmEquation:
    """Discrete Reynolds' equation of a lubricated contact in Hertz units.

    ``gap`` (x, y) is undeformed, ``deflection`` maps a pressure (x, y) to a displacement, ``cell`` is the size of a
    cell (across, along), ``speed_parameter`` that of :class:`FilmScales`, ``load`` the mean over y of the sum of P dX.
    ``speed`` is the present mean speed over the one in ``speed_parameter``. ``log_viscosity`` returns
    ln(eta / eta0) and its derivative by pressure, ``density`` the same for the ratio to the density at zero pressure.
    The first two cells across and the last have no pressure; the inlet is flooded, or holds no more than a layer
    ``supplied_film``. ``boundary_film`` is the thickness of the boundary film, zero without one.
    """

    gap: Array
    deflection: Deflection
    cell: tuple[float, float]
    speed_parameter: float
    load: float
    log_viscosity: Callable[[Array], tuple[Array, Array]]
    density: Callable[[Array], tuple[Array, Array]]
    speed: float = 1.0
    cavitation: Cavitation = ElrodAdams()  # noqa: RUF009 (a frozen value)
    boundary_film: float = 0.0
    supplied_film: float = inf

    @property
    def conserves(self) -> bool:
        """True if cavitation conserves mass, as that of Elrod & Adams; False for that of Reynolds."""
        return isinstance(self.cavitation, ElrodAdams)

    @cached_property
    def fixed(self) -> Mask:
        """Cells (x, y) without pressure at the inlet and the outlet."""
        fixed = np.zeros(self.gap.shape, dtype=bool)
        fixed[:INLET_CELLS] = fixed[-OUTLET_CELLS:] = True
        return fixed

    def film_of(
        self,
        pressure: Array,
        void: Array,
        separation: float,
        asperity_pressure: Array | None = None,
        least: float = -inf,
    ) -> Film:
        """Return the film with the thickness that follows from both pressures and the separation.

        The asperity pressure (x, y) is zero by default. The separation is raised where the film would be thinner than
        the thickness ``least``.
        """
        if asperity_pressure is None:
            asperity_pressure = np.zeros_like(pressure)
        thickness = separation + self.gap + self.deflection(pressure + asperity_pressure)
        rise = max(0.0, least - float(thickness.min()))
        return Film(pressure, void, separation + rise, thickness + rise, asperity_pressure)

    def content(self, film: Film) -> Array:
        """Return the content (x, y) of the cells, ``(1 - theta) rho H``."""
        return np.asarray(self.film_fraction(film) * self.density(film.pressure)[0] * film.thickness)

    def film_fraction(self, film: Film) -> Array:
        """Return the fraction (x, y) of the gap that lubricant fills, in the inlet no more than the supply does."""
        film_fraction = 1 - film.void if self.conserves else np.ones_like(film.void)
        inlet = film.thickness[:INLET_CELLS]
        film_fraction[:INLET_CELLS] = np.minimum(film_fraction[:INLET_CELLS], self.supplied_film / inlet)
        return film_fraction

    def load_residual(self, film: Film) -> float:
        """Return the load less what lubricant and asperities carry, over ``p_H a``."""
        carried = film.total_pressure.sum() * self.cell[0] / film.pressure.shape[1]
        return float(self.load - carried)

    def linearise(self, film: Film, squeeze: SqueezeTerm | None = None) -> Linearised:
        """Return the flow balance at ``film`` with its derivatives; ``squeeze`` adds a squeeze term."""
        density, density_slope = self.density(film.pressure)
        log_viscosity, log_slope = self.log_viscosity(film.pressure)
        cells = _FaceSide(film.pressure, -log_viscosity, -log_slope, density, density_slope, film.thickness)
        film_fraction = self.film_fraction(film)
        content = film_fraction * density * film.thickness
        by_void = -density * film.thickness if self.conserves else np.zeros_like(content)
        by_thickness = film_fraction * density
        by_thickness[:INLET_CELLS] *= film.thickness[:INLET_CELLS] <= self.supplied_film
        slopes = (film_fraction * density_slope * film.thickness, by_thickness, by_void)
        dx, dy = self.cell
        # Couette flow, and the derivatives of its balance by the contents of the cell and of two upstream
        wedge, by_nearest, by_further = (self.speed * values for values in _couette_flow(content))
        least = self.speed * film_fraction * density * self.boundary_film
        on_boundary = wedge < least
        wedge[on_boundary], by_nearest[on_boundary], by_further[on_boundary] = least[on_boundary], 0, 0
        entrained = {
            (0, 0): by_nearest,
            (-1, 0): by_further - np.roll(by_nearest, 1, axis=0),
            (-2, 0): -np.roll(by_further, 1, axis=0),
        }

        # Poiseuille flow; np.roll joins the ends across, where faces lie beside fixed cells alone, whose rows are zero
        residual, fluxes = np.zeros_like(content), []
        pressure: dict[tuple[int, int], Array] = {}
        thickness: dict[tuple[int, int], Array] = {}
        for axis, factor in enumerate((1 / (self.speed_parameter * dx), dx / (self.speed_parameter * dy**2))):
            if content.shape[axis] == 1:
                break
            face = _poiseuille_flow(cells, _FaceSide(*np.roll(cells, -1, axis=axis + 1)), factor)
            last = _FaceFlow(*np.roll(face, 1, axis=axis + 1))
            fluxes.append(face.flux if axis else face.flux + wedge)
            residual += fluxes[-1] - np.roll(fluxes[-1], 1, axis=axis)
            after, before = ((0, 1), (0, -1)) if axis else ((1, 0), (-1, 0))
            for bands, (by_upstream, by_downstream), (last_by_upstream, last_by_downstream) in (
                (pressure, face[1:3], last[1:3]),
                (thickness, face[3:5], last[3:5]),
            ):
                bands[0, 0] = bands.get((0, 0), 0.0) + by_upstream - last_by_downstream
                bands[after], bands[before] = by_downstream, -last_by_upstream
        if squeeze is not None:
            residual += dx * (squeeze.rate * content + squeeze.history)
            entrained[0, 0] = entrained[0, 0] + dx * squeeze.rate
        # what moves with the surfaces changes by the slopes of the content
        void: dict[tuple[int, int], Array] = {}
        moved = [(entrained, zip((pressure, thickness, void), slopes, strict=True))]
        if on_boundary.any():  # faces through which a boundary film flows, which is given with ElrodAdams alone
            faces, least_film = self.speed * on_boundary.astype(float), np.full_like(density, self.boundary_film)
            dragged = {(0, 0): faces, (-1, 0): -np.roll(faces, 1, axis=0)}
            by_boundary = film_fraction * density_slope * least_film, -density * least_film
            moved.append((dragged, zip((pressure, void), by_boundary, strict=True)))
        for coefficients, of_bands in moved:
            for bands, slope in of_bands:
                for offset, coefficient in coefficients.items():
                    bands[offset] = bands.get(offset, 0.0) + coefficient * neighbour(slope, offset)
        if not self.conserves:
            residual -= dx * film.void
            void[0, 0] = void[0, 0] - dx
        free = ~self.fixed
        pressure, thickness, void = (
            {offset: band * free for offset, band in bands.items()} for bands in (pressure, thickness, void)
        )
        return Linearised(residual * free, fluxes[0][:-1], pressure, thickness, void, slopes, self)


def neighbour(values: NDArray[Scalar], offset: tuple[int, int]) -> NDArray[Scalar]:
    """Return the value of the cell at ``offset`` from each cell: zero beyond the ends across, periodic along."""
    rows, columns = offset
    shifted = np.roll(values, -columns, axis=1) if columns else values
    if not rows:
        return shifted
    result = np.zeros_like(shifted)
    if rows > 0:
        result[:-rows] = shifted[rows:]
    else:
        result[-rows:] = shifted[:rows]
    return result


def _poiseuille_flow(upstream: _FaceSide, downstream: _FaceSide, factor: float) -> _FaceFlow:
    """Return the Poiseuille flow through faces, from the cells ``upstream`` of them to those ``downstream``.

    The ``factor`` is 1 / (lambda dX) across. Along it is dX / (lambda dY^2), as a balance per length along takes the
    flow through a face of the width dX over dY.
    """
    half = (downstream.log_fluidity - upstream.log_fluidity) / 2
    small = np.abs(half) < SERIES
    safe = np.where(small, 1.0, half)
    # u is half: sinh(u) / u exp(-|u|), which does not overflow, and the derivative of ln(sinh(u) / u)
    size = 2 * np.abs(safe)
    ratio = np.where(small, (1 + half**2 / 6) * np.exp(-np.abs(half)), -np.expm1(-size) / size)
    tilt = np.where(small, half / 3, 1 / np.tanh(safe) - 1 / safe)
    fluidity = np.exp(np.maximum(upstream.log_fluidity, downstream.log_fluidity)) * ratio
    both = upstream.thickness + downstream.thickness
    conductance = factor * 2 * (upstream.thickness * downstream.thickness) ** 2 / both * fluidity
    density = (upstream.density + downstream.density) / 2
    total = density * conductance
    fall = upstream.pressure - downstream.pressure

    def by_pressure(side: _FaceSide, weight: Array) -> Array:
        slope = total * weight * side.log_fluidity_slope + conductance * side.density_slope / 2
        return np.asarray(slope * fall)

    return _FaceFlow(
        total * fall,
        by_pressure(upstream, (1 - tilt) / 2) + total,
        by_pressure(downstream, (1 + tilt) / 2) - total,
        total * (2 / upstream.thickness - 1 / both) * fall,
        total * (2 / downstream.thickness - 1 / both) * fall,
    )


def _couette_flow(content: Array) -> tuple[Array, Array, Array]:
    """Return the Couette flow through the face downstream of each cell, and its derivatives by two contents.

    These are the contents of that cell and of the next one upstream; upstream of the first cell lies the last one.
    """
    nearest, further = content, np.roll(content, 1, axis=0)
    falls = further >= nearest
    # a cell may hold nothing, to rounding
    root = np.sqrt(np.divide(nearest, further, out=np.zeros_like(nearest), where=further > 0))
    flux = np.where(falls, nearest * root, 1.5 * nearest - 0.5 * further)
    return flux, np.where(falls, 1.5 * root, 1.5), np.where(falls, -0.5 * root**3, -0.5)
