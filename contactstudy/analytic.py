"""Reference solutions under their authors' names: closed forms, quadratures and fits.

Each is a contact of smooth elastic or viscoelastic bodies, or a film between such, in SI units; combined values are
those of both bodies together: ``1/R = 1/R1 + 1/R2`` and ``1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2``. Stresses are
tension positive, and z runs into the body.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from contactstudy.domain.grid import Array
from contactstudy.domain.validation import Limits, Metres, Newtons, NewtonsPerMetre, Pascals, Unit, valid, validated

# Number of Gauss points in a panel of Lee & Radok's integral over time, and of panels to each end of the time in
# contact: they leave 1e-13 of the pressure for relaxation times from 1e-4 of the time on.
GAUSS, PANELS = 10, 16
# Number of bisections that find the time at which the contact reached a place, down to rounding.
BISECTIONS = 60

# Limits of combined values, which may exceed those of one body.
POSITIVE = Limits("above 0", lambda x: 0 < x < inf)
CombinedRadius = Annotated[Metres, POSITIVE]
CombinedModulus = Annotated[Pascals, POSITIVE]
Curvature = Annotated[float, Unit("1/m", "a curvature", "100 1/m")]


@validated
class HertzLine:
    """Hertz's (1881) contact of parallel cylinders, in plane strain (Johnson 1985, sect. 4.2(c)).

    Parameters
    ----------
    load_per_length
        Load W per length [N/m].
    radius
        Combined radius R [m].
    contact_modulus
        Contact modulus E* [Pa].

    Raises
    ------
    InvalidInput
        If a value is not above 0.
    """

    load_per_length: NewtonsPerMetre
    radius: CombinedRadius
    contact_modulus: CombinedModulus

    @property
    def half_width(self) -> float:
        """Half-width of the contact [m], ``a = sqrt(4 W R / (pi E*))``."""
        return float(np.sqrt(4 * self.load_per_length * self.radius / np.pi / self.contact_modulus))

    @property
    def peak_pressure(self) -> float:
        """Peak pressure [Pa], ``p_H = 2 W / (pi a)``."""
        return 2 * self.load_per_length / (np.pi * self.half_width)

    def pressure(self, x: ArrayLike) -> Array:
        """Return the pressure [Pa] at `x` [m] from the axis, ``p_H sqrt(1 - x^2 / a^2)``, zero outside the contact."""
        t = np.asarray(x, dtype=np.float64) / self.half_width
        return self.peak_pressure * np.sqrt(np.clip((1 - t) * (1 + t), 0, None))

    def displacement(self, x: ArrayLike, datum: float) -> Array:
        """Return the displacement [m] at `x` [m] from the axis, that of both bodies together, positive into them.

        It counts from the distance `datum` [m], at which the surface would not move if W acted on the axis alone. It is
        Flamant's displacement of a line load, ``2 / (pi E*) log(datum / x)`` a unit of load, over the pressure.
        """
        t = np.abs(np.asarray(x, dtype=np.float64)) / self.half_width
        out = np.maximum(t, 1)
        beyond = out * np.sqrt((out - 1) * (out + 1)) - np.arccosh(out)
        rigid = np.log(2 * datum / self.half_width) + 0.5
        scale = 2 * self.load_per_length / (np.pi * self.contact_modulus)
        return np.asarray(scale * (rigid - t**2 + beyond))

    def stress(self, x: ArrayLike, depth: ArrayLike, friction: float = 0.0) -> Array:
        """Return the stress xx, zz and xz (3, ...) [Pa] at `x` from the axis and at a `depth` [m], which broadcast.

        `friction` is the traction along +x on the body over the pressure, as in full sliding. Source: McEwen (1949), by
        way of Johnson (1985), eqs. 4.49 and 7.7, whose m and n are those here.
        """
        x, z = np.broadcast_arrays(*(np.asarray(c, dtype=np.float64) for c in (x, depth)))
        x, z = x / self.half_width, z / self.half_width
        difference = (1 - x) * (1 + x) + z**2
        root = np.hypot(difference, 2 * x * z)
        m, n = np.sqrt((root + difference) / 2), np.copysign(np.sqrt((root - difference) / 2), x)
        root = np.where(root, root, 1.0)  # at the edge of the contact the stress is 0
        fraction = (z**2 + n**2) / root
        xx, zz = 2 * z - m * (1 + fraction), -m * (1 - fraction)
        xz = -n * (m**2 - z**2) / root
        # xz by traction is xx by pressure
        of_traction = np.stack([n * (2 - (z**2 - m**2) / root) - 2 * x, xz, xx])
        return self.peak_pressure * (np.stack([xx, zz, xz]) + friction * of_traction)


def first_yield(
    radius: float, contact_modulus: float, yield_stress: float, poisson_ratio: float, friction: float = 0.0
) -> HertzLine:
    """Return the line contact in which a half-space first yields, after von Mises.

    The largest von Mises stress of a line contact is on its axis of symmetry, 0.558 of the peak pressure and 0.7
    half-widths deep at a Poisson's ratio of 0.3 (Johnson 1985, sect. 6.1). In sliding it is larger and nearer to the
    surface. The load at first yield is the contact's ``load_per_length``.

    Parameters
    ----------
    radius
        Combined radius R [m].
    contact_modulus
        Contact modulus E* [Pa].
    yield_stress
        Tensile stress [Pa] at which the half-space yields.
    poisson_ratio
        Its Poisson's ratio.
    friction
        Tangential traction over the pressure.

    Raises
    ------
    InvalidInput
        If the radius, the modulus or the stress is not above 0.
    """
    yield_stress = valid("yield_stress", yield_stress, Pascals)
    unit = HertzLine(1.0, radius, contact_modulus)
    # steps of 0.01 and 0.005 half-widths find the largest stress to 6e-6, twice these to 5e-5
    x = (np.linspace(-1.2, 1.2, 241) if friction else np.zeros(1))[:, None]
    xx, zz, xz = unit.stress(x * unit.half_width, np.linspace(0, 2, 401) * unit.half_width, friction)
    yy = poisson_ratio * (xx + zz)
    mises = np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * xz**2)
    # stresses grow as the square root of the load
    return HertzLine((yield_stress / float(mises.max())) ** 2, radius, contact_modulus)


def first_yield_of_ball(yield_stress: float, poisson_ratio: float) -> float:
    """Return the peak pressure [Pa] at which a half-space with a tensile `yield_stress` [Pa] first yields below a ball.

    The largest von Mises stress is 0.62 of the peak pressure at a Poisson's ratio of 0.3 (Johnson 1985, sect. 4.2(a));
    below an ellipse it lies between that and the 0.558 of a line contact.
    """
    unit = HertzPoint(1.0, 1.0, 1.0)
    # it is 0.38 to 0.55 contact radii deep for Poisson's ratios up to 0.5; steps of 0.005 find it to 1e-5
    rr, zz = unit.axis_stress(np.linspace(0.1, 1.5, 281) * unit.contact_radius, poisson_ratio)
    return float(yield_stress * unit.peak_pressure / np.abs(rr - zz).max())


@dataclass(frozen=True)
class LeeRadok:
    """Lee & Radok's (1960) line contact under a load that is applied suddenly and held, in plane strain.

    The bodies together relax as ``E*(t) = equilibrium + sum(E_i exp(-t / tau_i))``. Their `creep` must be that of this
    relaxation, which is not checked.

    Parameters
    ----------
    load_per_length
        Load W per length [N/m].
    radius
        Combined radius R [m].
    equilibrium
        Contact modulus after infinite time [Pa].
    relaxation
        Pairs (E_i [Pa], tau_i [s]).
    creep
        Creep function of the bodies together [1/Pa], of time [s].
    """

    load_per_length: float
    radius: float
    equilibrium: float
    relaxation: tuple[tuple[float, float], ...]
    creep: Callable[[Array], Array]

    def half_width(self, time: ArrayLike) -> Array:
        """Return the half-width of the contact [m] at a `time` [s], ``a = sqrt(4 W R creep(t) / pi)``."""
        creep = self.creep(np.asarray(time, dtype=np.float64))
        return np.asarray(np.sqrt(4 * self.load_per_length * self.radius * creep / np.pi))

    def pressure(self, x: ArrayLike, time: float) -> Array:
        """Return the pressure [Pa] at `x` [m] from the axis and one `time` [s].

        It is ``1 / (2 R) int E*(t - s) d sqrt(a(s)^2 - x^2)`` over the time s in contact.
        """
        x = np.abs(np.asarray(x, dtype=np.float64))
        inside = x < self.half_width(time)
        inside_x = np.where(inside, x, 0.0)[..., None]
        # Integrated by parts. Over the root of the time in contact the integrand has no square root, and panels
        # that shrink towards both ends resolve relaxation times much shorter than the whole.
        nodes, weights = _graded()
        contact_time = self._time_of_contact(inside_x, time)
        span = np.sqrt(time - contact_time)
        root = span * nodes
        instants = contact_time + root**2
        elapsed = span**2 * (1 - nodes) * (1 + nodes)
        slope = sum(e / tau * np.exp(-elapsed / tau) for e, tau in self.relaxation)
        half_chord = np.sqrt(np.maximum(self.half_width(instants) ** 2 - inside_x**2, 0))
        relaxed = (half_chord * slope * 2 * root * weights * span).sum(axis=-1)
        present_half_chord = np.sqrt(self.half_width(time) ** 2 - inside_x[..., 0] ** 2)
        instantaneous = self.equilibrium + sum(e for e, _ in self.relaxation)
        return np.where(inside, (instantaneous * present_half_chord - relaxed) / (2 * self.radius), 0.0)

    def _time_of_contact(self, x: Array, time: float) -> Array:
        """Return the time [s] at which the contact reached `x`, by bisection down to rounding."""
        low = np.zeros_like(x)
        high = np.where(x > self.half_width(0.0), time, 0.0)
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            is_outside = self.half_width(middle) < x
            low, high = np.where(is_outside, middle, low), np.where(is_outside, high, middle)
        return high


def _graded() -> tuple[Array, Array]:
    """Return the points and weights (n,) of a quadrature from 0 to 1, in panels that halve towards both ends."""
    halves = 0.5 ** np.arange(PANELS, 0, -1.0)
    edges = np.concatenate([[0.0], halves, 1 - halves[-2::-1], [1.0]])
    points, gauss = np.polynomial.legendre.leggauss(GAUSS)
    sizes = np.diff(edges)[:, None]
    return (edges[:-1, None] + sizes * (points + 1) / 2).ravel(), (sizes * gauss / 2).ravel()


@validated
class HertzPoint:
    """Hertz's (1881) contact of a sphere on a flat (Johnson 1985, sect. 4.2(a)).

    Parameters
    ----------
    load
        Load P [N].
    radius
        Combined radius R [m].
    contact_modulus
        Contact modulus E* [Pa].

    Raises
    ------
    InvalidInput
        If a value is not above 0.
    """

    load: Newtons
    radius: CombinedRadius
    contact_modulus: CombinedModulus

    @property
    def contact_radius(self) -> float:
        """Radius of the contact [m], ``a = (3 P R / (4 E*))^(1/3)``."""
        return float(np.cbrt(0.75 * self.load * self.radius / self.contact_modulus))

    @property
    def peak_pressure(self) -> float:
        """Peak pressure [Pa], ``p0 = 3 P / (2 pi a^2)``."""
        return 1.5 * self.load / (np.pi * self.contact_radius**2)

    @property
    def approach(self) -> float:
        """Approach of the bodies [m], ``a^2 / R``, which is also the displacement at the centre."""
        return self.contact_radius**2 / self.radius

    def pressure(self, r: ArrayLike) -> Array:
        """Return the pressure [Pa] at `r` [m] from the centre, ``p0 sqrt(1 - r^2 / a^2)``, zero outside the contact."""
        t = np.asarray(r, dtype=np.float64) / self.contact_radius
        return self.peak_pressure * np.sqrt(np.clip((1 - t) * (1 + t), 0, None))

    def displacement(self, r: ArrayLike) -> Array:
        """Return the displacement [m] at `r` [m] from the centre, zero at infinity (Johnson 1985, eqs. 3.41, 3.42)."""
        t = np.abs(np.asarray(r, dtype=np.float64)) / self.contact_radius
        inside = 1 - t**2 / 2
        out = np.maximum(t, 1)
        outside = (2 - out**2) * np.arcsin(1 / out) + np.sqrt((out - 1) * (out + 1))
        return self.approach * np.where(t <= 1, inside, outside / np.pi)

    def axis_stress(self, depth: ArrayLike, poisson_ratio: float) -> Array:
        """Return the stress rr, equal to the hoop stress, and zz (2, ...) [Pa] at `depth` [m] > 0 below the centre.

        Source: Huber (1904), by way of Johnson (1985), eqs. 3.45.
        """
        z = np.asarray(depth, dtype=np.float64) / self.contact_radius
        zz = -1 / (1 + z**2)
        rr = -(1 + poisson_ratio) * (1 - z * np.arctan(1 / z)) - zz / 2
        return self.peak_pressure * np.stack([rr, zz])


@validated
class HertzEllipse:
    """Hertz's (1881) contact of two bodies with parallel principal axes (Johnson 1985, sect. 4.2(b)).

    Parameters
    ----------
    load
        Load P [N].
    curvature_across, curvature_along
        Sums of the curvatures of both bodies in the two principal planes [1/m].
    contact_modulus
        Contact modulus E* [Pa].

    Raises
    ------
    InvalidInput
        If a value is not above 0.
    """

    load: Newtons
    curvature_across: Curvature
    curvature_along: Curvature
    contact_modulus: CombinedModulus

    @cached_property
    def semi_axes(self) -> tuple[float, float]:
        """Semi-axes (across, along) of the contact [m], by Johnson's (1985) eqs. 4.26; b / a by Brent's method."""
        from scipy.optimize import brentq  # imported late, since they are slow
        from scipy.special import ellipe, ellipkm1

        curvatures = self.curvature_across, self.curvature_along
        least, largest = sorted(curvatures)

        def excess(log_ratio: float) -> float:
            """Return the ratio of curvatures that ``b / a = exp(log_ratio)`` leads to, less the given one."""
            square = np.exp(2 * log_ratio)  # 1 - e^2
            e, k = ellipe(1 - square), ellipkm1(square)
            return float((e / square - k) / (k - e) - largest / least)

        # k - e vanishes for round contacts; a ratio b / a of 1e-7 is that of curvatures 6e12 times as large
        nearly_round = largest / least < 1 + 1e-6
        ratio = 1.0 if nearly_round else float(np.exp(brentq(excess, np.log(1e-7), -1e-7)))
        mean_curvature = sum(curvatures) / 2
        numerator = 1.5 * self.load * ellipe(1 - ratio**2)
        major = float(np.cbrt(numerator / (np.pi * self.contact_modulus * mean_curvature)) * ratio ** (-2 / 3))
        minor = ratio * major
        return (minor, major) if curvatures[0] >= curvatures[1] else (major, minor)

    @property
    def peak_pressure(self) -> float:
        """Peak pressure [Pa], ``3 P / (2 pi a b)``."""
        across, along = self.semi_axes
        return 1.5 * self.load / (np.pi * across * along)

    @property
    def line(self) -> HertzLine:
        """Line contact of the same half-width across and the same peak pressure."""
        half_width, peak, modulus = self.semi_axes[0], self.peak_pressure, self.contact_modulus
        return HertzLine(np.pi / 2 * half_width * peak, half_width * modulus / (2 * peak), modulus)


@validated
class Westergaard:
    """Westergaard's (1939) contact of a wavy surface with a flat, in plane strain (Johnson 1985, sect. 13.2).

    The heights are ``amplitude cos(2 pi x / wavelength)``.

    Parameters
    ----------
    mean_pressure
        Mean pressure [Pa].
    amplitude
        Amplitude of the heights [m].
    wavelength
        Wavelength [m].
    contact_modulus
        Contact modulus E* [Pa].

    Raises
    ------
    InvalidInput
        If a value is not above 0.
    """

    mean_pressure: Pascals
    amplitude: Metres
    wavelength: Metres
    contact_modulus: CombinedModulus

    @property
    def closing_pressure(self) -> float:
        """Mean pressure [Pa] for complete contact, ``p* = pi E* amplitude / wavelength``."""
        return np.pi * self.contact_modulus * self.amplitude / self.wavelength

    @property
    def half_width(self) -> float:
        """Half-width of a strip of contact [m], ``(wavelength / pi) asin(sqrt(mean / p*))``.

        Half a wavelength in complete contact.
        """
        fraction = min(self.mean_pressure / self.closing_pressure, 1.0)
        return float(self.wavelength / np.pi * np.arcsin(np.sqrt(fraction)))

    @property
    def peak_pressure(self) -> float:
        """Peak pressure [Pa], ``2 sqrt(mean p*)``, or ``mean + p*`` in complete contact."""
        mean, closing = self.mean_pressure, self.closing_pressure
        return mean + closing if mean >= closing else 2 * float(np.sqrt(mean * closing))

    def pressure(self, x: ArrayLike) -> Array:
        """Return the pressure [Pa] at `x` [m] from a crest.

        It is ``2 p* cos(t) sqrt(mean / p* - sin(t)^2)`` with ``t = pi x / wavelength``, and ``mean + p* cos(2 t)`` when
        closed.
        """
        mean, closing = self.mean_pressure, self.closing_pressure
        angle = np.pi * np.asarray(x, dtype=np.float64) / self.wavelength
        if mean >= closing:
            return np.asarray(mean + closing * np.cos(2 * angle))
        inside = np.clip(mean / closing - np.sin(angle) ** 2, 0, None)
        return np.asarray(2 * closing * np.abs(np.cos(angle)) * np.sqrt(inside))


def moes_film(load_parameter: float, viscosity_parameter: float) -> float:
    """Return the central film thickness of a lubricated line contact, ``(h / R) (eta0 u_s / (E' R))^(-1/2)``.

    E' = 2 E*, R is the combined radius, W the load per length, u_s the sum of the surface speeds, eta0 the viscosity at
    no pressure, and alpha its pressure coefficient. Fitted between four asymptotes: rigid or elastic bodies, an
    isoviscous or a Barus lubricant. Source: Moes (1992), Venner & Lubrecht (2000).

    Parameters
    ----------
    load_parameter
        ``M = W / (E' R) (eta0 u_s / (E' R))^(-1/2)``.
    viscosity_parameter
        ``L = alpha E' (eta0 u_s / (E' R))^(1/4)``.
    """
    limits = film_asymptotes(load_parameter, viscosity_parameter)
    rigid, elastic = limits["rigid, isoviscous"], limits["elastic, isoviscous"]
    exponent = (7 + 8 * np.exp(-2 * elastic / rigid)) / 5
    film = (rigid ** (7 / 3) + elastic ** (7 / 3)) ** (3 * exponent / 7)
    if viscosity_parameter > 0:
        both = limits["rigid, piezoviscous"] ** -3.5 + limits["elastic, piezoviscous"] ** -3.5
        film += both ** (-2 * exponent / 7)
    return float(film ** (1 / exponent))


def film_asymptotes(load_parameter: float, viscosity_parameter: float) -> dict[str, float]:
    """Return the four asymptotes of film thickness between which :func:`moes_film` is fitted, by their regimes.

    The smaller of the piezoviscous ones counts: see :func:`film_regime`. Unit, source and parameters are those of
    :func:`moes_film`.
    """
    return {
        "rigid, isoviscous": 3 / load_parameter,
        "elastic, isoviscous": 2.621 * load_parameter**-0.2,
        "rigid, piezoviscous": 1.287 * viscosity_parameter ** (2 / 3),
        "elastic, piezoviscous": 1.311 * load_parameter ** (-1 / 8) * viscosity_parameter**0.75,
    }


def film_regime(load_parameter: float, viscosity_parameter: float) -> str:
    """Return the regime of a lubricated line contact: the name of its asymptote among :func:`film_asymptotes`.

    Parameters are those of :func:`moes_film`.
    """
    limits = film_asymptotes(load_parameter, viscosity_parameter)
    piezoviscous = [name for name in limits if name.endswith("piezoviscous")]
    limits.pop(max(piezoviscous, key=lambda name: limits[name]))
    return max(limits, key=lambda name: limits[name])


def dowson_higginson_film(load_parameter: float, viscosity_parameter: float) -> float:
    """Return the minimum film thickness of a lubricated line contact in the unit of :func:`moes_film`.

    ``h / R = 2.65 U^0.7 G^0.54 W^-0.13`` with U = eta0 u_m / (E' R), G = alpha E' and W = load / (E' R), for elastic
    bodies in a piezoviscous lubricant. Source: Dowson (1968), Proc. Inst. Mech. Eng. 182 (3A), 151. Parameters are
    those of :func:`moes_film`.
    """
    # u_m is half of Moes' u_s; by M, L and his unit all powers of U cancel but this factor 2
    return float(2.65 / 2**0.7 * viscosity_parameter**0.54 * load_parameter**-0.13)


def image_error(half_width: ArrayLike, reach: ArrayLike) -> Array:
    """Return the relative error ``a^2 / (8 D^2)`` of the peak pressure of a line contact whose images reach only to D.

    Images beyond D would have divided the cylinder's curvature by ``1 + a^2 / (4 D^2)``: leading term of the
    logarithmic potential's remainder, within 10 % from D = 3 a on.

    Parameters
    ----------
    half_width
        Half-width a of the contact.
    reach
        Distance D to each side, in the same unit.
    """
    return np.asarray(np.asarray(half_width) ** 2 / (8 * np.asarray(reach) ** 2))
