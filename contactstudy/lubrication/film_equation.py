"""Reynolds' equation on the cells of a grid: flow through faces, balance of each cell, and its linearisation.

Everything is in Hertz units: lengths across and along over a, film over a^2 / R, pressure over p_H. A film ``H`` holds
a lubricant of the content ``m = (1 - theta) rho H``, with the void fraction ``theta`` zero under pressure. Through the
face between two neighbours across flows ``q = -rho C phi (P1 - P0) / (lambda dX) + W``:

- ``phi``, the logarithmic mean of the fluidity ``eta0 / eta``: the exact mean for Barus' law;
- ``C = 2 H0^2 H1^2 / (H0 + H1)``, the exact conductance of a wedge, zero where either film is;
- ``W``, the Couette (entrainment) flow, of second order and never negative: with ``r`` the content of the cell
  upstream over the cell's own, ``W = m r^(-1/2)`` where the film falls (r >= 1), else ``m (3 - r) / 2``.

The balance is that of Elrod & Adams (1974): as much lubricant leaves each cell as enters it, cavitated or not. With
plain cavitation the film is full where the pressure is zero, and lubricant may appear in such a cell: as much of it,
per area, stands in place of the void fraction. One row of cells (ny = 1) is plane strain.

Where the film is as thin as the boundary film ``H_b``, asperities carry a pressure. The entrained content is at least
that of the boundary film: the second-order extrapolation from upstream could fall below it, and the contact would
cavitate.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, pi, sqrt
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from contactstudy.analytic import HertzLine, moes_film
from contactstudy.domain.fields import Array
from contactstudy.scene.lubrication.lubrication import Cavitation, ElrodAdams, Lubrication

# Below this half difference of logarithms the mean of two fluidities is a series.
SERIES = 1e-3

Mask = NDArray[np.bool_]
Scalar = TypeVar("Scalar", bound=np.generic)
# A cell's neighbours, as offsets across and along, and what multiplies a change in them.
Bands = Mapping[tuple[int, int], Array]


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
    def relative_half_width(self) -> float:
        """Half-width of the pressure in units of that of Hertz; a thick film carries load over ``sqrt(2 H)``."""
        return max(1.0, sqrt(2 * self.expected_film))


@dataclass(frozen=True, eq=False)
class Film:
    """A state of the film: fields (x, y) of pressure, void fraction and film, and the separation H0.

    ``asperity_pressure`` (x, y) is that of asperities; None without a boundary film.
    """

    pressure: Array
    void: Array
    separation: float
    film: Array
    asperity_pressure: Array | None = None

    @property
    def total_pressure(self) -> Array:
        """Pressure (x, y) of lubricant and asperities."""
        return (
            self.pressure
            if self.asperity_pressure is None
            else self.pressure + self.asperity_pressure
        )


@dataclass(frozen=True)
class Storage:
    """A time derivative of the content: ``rate * m + history`` (x, y), in units of u_m / a."""

    rate: float
    history: Array


class _FaceSide(NamedTuple):
    """Values of cells that a face needs."""

    pressure: Array
    log_fluidity: Array
    log_fluidity_slope: Array
    density: Array
    density_slope: Array
    film: Array

    def rows(self, rows: slice) -> "_FaceSide":
        return _FaceSide(*(values[rows] for values in self))

    def next_along(self) -> "_FaceSide":
        return _FaceSide(*(np.roll(values, -1, axis=1) for values in self))


class _FaceFlow(NamedTuple):
    """Flow through faces, and its derivatives by pressure and film of the cells upstream and downstream."""

    flux: Array
    pressure_upstream: Array
    pressure_downstream: Array
    film_upstream: Array
    film_downstream: Array


@dataclass(frozen=True, eq=False)
class Linearised:
    """The balance of the cells to first order in changes of pressure, film and void fraction.

    ``pressure`` at a constant film, ``film`` and ``void`` are bands of coefficients (x, y): one of offset (i, j)
    multiplies the change in the cell that far away. Rows of fixed cells are zero. ``inverse_time_step`` is that
    of an implicit step, zero for none.
    """

    residual: Array
    flux: Array
    pressure: Bands
    film: Bands
    void: Bands
    content_slopes: tuple[Array, Array, Array]
    equation: "FilmEquation"
    inverse_time_step: float = 0.0

    def with_time_step(self, inverse: float, moved: Array | float = 0.0) -> "Linearised":
        """Add ``inverse`` times the change of content: an implicit step in time of length 1 / inverse.

        The change is from a film that is lower by ``moved`` (x, y).
        """
        scaled = inverse * self.equation.cell[0] * ~self.equation.fixed
        bands = (
            {**band, (0, 0): band[0, 0] + scaled * slope}
            for band, slope in zip(
                (self.pressure, self.film, self.void), self.content_slopes, strict=True
            )
        )
        pressure, film, void = bands
        residual = self.residual + scaled * self.content_slopes[1] * moved
        return replace(
            self,
            residual=residual,
            pressure=pressure,
            film=film,
            void=void,
            inverse_time_step=inverse,
        )

    def change(self, pressure: Array, void: Array, separation: float) -> Array:
        """Return the change of the balance under changes of pressure, void fraction and separation."""
        return self.change_with(pressure, void, self.equation.deflection(pressure) + separation)

    def change_with(self, pressure: Array, void: Array, film: Array) -> Array:
        """Return the change of the balance under changes of pressure, void fraction and film (x, y)."""
        changed = np.zeros_like(pressure)
        for bands, values in ((self.pressure, pressure), (self.film, film), (self.void, void)):
            for (rows, columns), coefficient in bands.items():
                shifted = np.roll(values, -columns, axis=1) if columns else values
                first, end = max(0, -rows), len(values) - max(0, rows)
                changed[first:end] += coefficient[first:end] * shifted[first + rows : end + rows]
        return changed


@dataclass(frozen=True, eq=False)
class FilmEquation:
    """The lubricated contact in Hertz units, on a grid.

    ``gap`` (x, y) is undeformed, ``deflection`` maps a pressure (x, y) to a displacement, ``cell`` is the size of a
    cell, ``resistance`` lambda = 12 eta0 u_m R^2 / (a^3 p_H), ``load`` the mean over y of the sum of P dX.
    ``speed`` is the mean speed over that in lambda, ``cavitation`` a value of the scene. ``log_viscosity`` and
    ``density`` return a ratio to the value at zero pressure and its derivative. The first two cells across and the
    last have no pressure; the inlet is flooded, or holds no more than a layer ``supplied_film``. The thickness of the
    boundary film ``boundary_film`` is zero without one.
    """

    gap: Array
    deflection: Callable[[Array], Array]
    cell: tuple[float, float]
    resistance: float
    load: float
    log_viscosity: Callable[[Array], tuple[Array, Array]]
    density: Callable[[Array], tuple[Array, Array]]
    speed: float = 1.0
    cavitation: Cavitation = ElrodAdams()  # noqa: RUF009 (a frozen value)
    boundary_film: float = 0.0
    supplied_film: float = inf

    @property
    def conserves(self) -> bool:
        """True if the balance of cavitated cells is closed."""
        return isinstance(self.cavitation, ElrodAdams)

    @cached_property
    def fixed(self) -> Mask:
        """Cells (x, y) without pressure at the inlet and the outlet."""
        fixed = np.zeros(self.gap.shape, dtype=bool)
        fixed[[0, 1, -1]] = True
        return fixed

    def film_of(
        self,
        pressure: Array,
        void: Array,
        separation: float,
        asperity_pressure: Array | None = None,
    ) -> Film:
        """Return the state with the film under ``pressure``, and ``asperity_pressure``."""
        total = pressure if asperity_pressure is None else pressure + asperity_pressure
        film = separation + self.gap + self.deflection(total)
        return Film(pressure, void, separation, film, asperity_pressure)

    def content(self, film: Film) -> Array:
        """Return the content of each cell, ``(1 - theta) rho H``."""
        return np.asarray(self.film_fraction(film) * self.density(film.pressure)[0] * film.film)

    def film_fraction(self, film: Film) -> Array:
        """Return the fraction of the film that holds lubricant."""
        film_fraction = 1 - film.void if self.conserves else np.ones_like(film.void)
        film_fraction[:2] = np.minimum(film_fraction[:2], self.supplied_film / film.film[:2])
        return film_fraction

    def load_residual(self, film: Film) -> float:
        """Return the load less what the pressure carries."""
        carried = film.total_pressure.sum() * self.cell[0] / film.pressure.shape[1]
        return float(self.load - carried)

    def linearise(self, film: Film, storage: Storage | None = None) -> Linearised:
        """Return the balance at ``film`` with its derivatives; ``storage`` adds a time derivative."""
        density, density_slope = self.density(film.pressure)
        log_viscosity, log_slope = self.log_viscosity(film.pressure)
        cells = _FaceSide(
            film.pressure, -log_viscosity, -log_slope, density, density_slope, film.film
        )
        film_fraction = self.film_fraction(film)
        content = film_fraction * density * film.film
        by_void = -density * film.film if self.conserves else np.zeros_like(content)
        by_film = film_fraction * density
        by_film[:2] *= film.film[:2] <= self.supplied_film
        slopes = (film_fraction * density_slope * film.film, by_film, by_void)
        dx, dy = self.cell
        across = _poiseuille_flow(
            cells.rows(slice(None, -1)), cells.rows(slice(1, None)), 1 / (self.resistance * dx)
        )
        wedge, wedge_own, wedge_upstream = (
            self.speed * values for values in _couette_flow(content)
        )
        least = self.speed * (film_fraction * density * self.boundary_film)[:-1]
        on_boundary = wedge < least
        wedge[on_boundary] = least[on_boundary]
        wedge_own[on_boundary] = wedge_upstream[on_boundary] = 0
        flux = across.flux + wedge

        residual = np.zeros_like(content)
        residual[1:-1] = flux[1:] - flux[:-1]
        downstream, upstream = _downstream_face, _upstream_face
        pressure = {
            (0, 0): downstream(across.pressure_upstream) - upstream(across.pressure_downstream),
            (1, 0): downstream(across.pressure_downstream),
            (-1, 0): -upstream(across.pressure_upstream),
        }
        height = {
            (0, 0): downstream(across.film_upstream) - upstream(across.film_downstream),
            (1, 0): downstream(across.film_downstream),
            (-1, 0): -upstream(across.film_upstream),
        }
        if content.shape[1] > 1:
            residual += _balance_along(cells, dx / (self.resistance * dy**2), pressure, height)
        drawn = {
            (0, 0): downstream(wedge_own),
            (-1, 0): downstream(wedge_upstream) - upstream(wedge_own),
            (-2, 0): -upstream(wedge_upstream),
        }
        if storage is not None:
            residual += dx * (storage.rate * content + storage.history)
            drawn[0, 0] = drawn[0, 0] + dx * storage.rate
        void: dict[tuple[int, int], Array] = {}
        for offset, coefficient in drawn.items():
            for bands, slope in zip((pressure, height, void), slopes, strict=True):
                term = coefficient * neighbour(slope, offset)
                bands[offset] = bands[offset] + term if offset in bands else term
        if on_boundary.any():
            held_faces: Array = self.speed * on_boundary.astype(float)
            held_bands = {(0, 0): downstream(held_faces), (-1, 0): -upstream(held_faces)}
            held_slopes = (
                film_fraction * density_slope * self.boundary_film,
                -density * self.boundary_film,
            )
            for offset, coefficient in held_bands.items():
                for bands, held_slope in zip((pressure, void), held_slopes, strict=True):
                    bands[offset] = bands[offset] + coefficient * neighbour(held_slope, offset)
        if not self.conserves:
            residual -= dx * film.void
            void[0, 0] = void[0, 0] - dx
        free = ~self.fixed
        pressure, height, void = (
            {offset: band * free for offset, band in bands.items()}
            for bands in (pressure, height, void)
        )
        return Linearised(residual * free, flux, pressure, height, void, slopes, self)


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


def _downstream_face(faces: Array) -> Array:
    """Return for each row of cells the value of the face downstream; zero for the last."""
    return np.concatenate((faces, np.zeros_like(faces[:1])))


def _upstream_face(faces: Array) -> Array:
    """Return for each row of cells the value of the face upstream; zero for the first."""
    return np.concatenate((np.zeros_like(faces[:1]), faces))


def _poiseuille_flow(before: _FaceSide, behind: _FaceSide, factor: float) -> _FaceFlow:
    """Return the Poiseuille flow through the faces between two sets of cells."""
    half = (behind.log_fluidity - before.log_fluidity) / 2
    small = np.abs(half) < SERIES
    safe = np.where(small, 1.0, half)
    # sinh(u) / u exp(-|u|), which does not overflow, and the derivative of ln(sinh(u) / u)
    size = 2 * np.abs(safe)
    ratio = np.where(small, (1 + half**2 / 6) * np.exp(-np.abs(half)), -np.expm1(-size) / size)
    tilt = np.where(small, half / 3, 1 / np.tanh(safe) - 1 / safe)
    fluidity = np.exp(np.maximum(before.log_fluidity, behind.log_fluidity)) * ratio
    both = before.film + behind.film
    conductance = factor * 2 * (before.film * behind.film) ** 2 / both * fluidity
    density = (before.density + behind.density) / 2
    total = density * conductance
    fall = before.pressure - behind.pressure

    def by_pressure(side: _FaceSide, weight: Array) -> Array:
        slope = total * weight * side.log_fluidity_slope + conductance * side.density_slope / 2
        return np.asarray(slope * fall)

    return _FaceFlow(
        total * fall,
        by_pressure(before, (1 - tilt) / 2) + total,
        by_pressure(behind, (1 + tilt) / 2) - total,
        total * (2 / before.film - 1 / both) * fall,
        total * (2 / behind.film - 1 / both) * fall,
    )


def _balance_along(
    cells: _FaceSide,
    factor: float,
    pressure: dict[tuple[int, int], Array],
    film: dict[tuple[int, int], Array],
) -> Array:
    """Return the balance of the flow along the length, and add its derivatives to the bands."""
    along = _poiseuille_flow(cells, cells.next_along(), factor)
    last = _FaceFlow(*(np.roll(values, 1, axis=1) for values in along))
    for bands, by_behind, by_before, last_by_behind, last_by_before in (
        (pressure, along.pressure_downstream, along.pressure_upstream, *last[1:3]),
        (film, along.film_downstream, along.film_upstream, *last[3:5]),
    ):
        bands[0, 0] = bands[0, 0] + by_before - last_by_before
        bands[0, 1], bands[0, -1] = by_behind, -last_by_behind
    return np.asarray(along.flux - last.flux)


def _couette_flow(content: Array) -> tuple[Array, Array, Array]:
    """Return the Couette flow through each face, and its derivatives by the cell upstream and the one before it.

    The first face has one cell upstream and is of first order.
    """
    flux, at_cell, upstream = (
        content[:-1].copy(),
        np.ones_like(content[1:]),
        np.zeros_like(content[1:]),
    )
    nearest, further = content[1:-1], content[:-2]
    falls = further >= nearest
    # a cell may hold nothing, to rounding
    root = np.sqrt(np.divide(nearest, further, out=np.zeros_like(nearest), where=further > 0))
    flux[1:] = np.where(falls, nearest * root, 1.5 * nearest - 0.5 * further)
    at_cell[1:] = np.where(falls, 1.5 * root, 1.5)
    upstream[1:] = np.where(falls, -0.5 * root**3, -0.5)
    return flux, at_cell, upstream
