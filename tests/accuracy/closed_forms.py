"""Contacts with a closed form: cylinders, spheres, waves, a flat punch, a wedge, a strip that yields."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, pi

import numpy as np

import contactstudy as cs
from contactstudy.analytic import Westergaard
from contactstudy.domain.grid import Array
from studies.reference.line_contact import HERTZ, HERTZ_HEIGHT, P_H, SCENE, A
from tests.accuracy.case import EXACT, FREE, MODULUS, AccuracyCase, ClosedForm, Pressure, scene

STEEL = SCENE.solids


@dataclass(frozen=True)
class Power:
    """A gap ``h |x / a|^n`` about a shifted axis, as a user-defined shape without length scales."""

    factor: float  # h [m]
    power: float
    offset: float = 0.0
    curvature: float = 1 / HERTZ.radius  # for the scales alone

    def gap(self, grid: cs.Grid) -> Array:
        """Return the gap [m]."""
        return np.asarray(self.factor * np.abs((grid.x - self.offset) / A) ** self.power)[:, None]


def cylinders() -> Iterator[AccuracyCase]:
    """Yield contacts with their edge anywhere in its cell."""
    for cells in (25, 48, 96, 192):
        for width in (2.2, 2.47, 2.8, 3.1):
            grid = cs.Grid((cells, 1), (width * A, A))
            truth = ClosedForm(lambda x, y: HERTZ.pressure(x), highest=P_H, area=2 / width)
            yield AccuracyCase(SCENE, grid, EXACT, truth)


def few_cells() -> Iterator[AccuracyCase]:
    """Yield contacts from a part of a cell to ten cells wide, in the middle of the grid and 0.37 cells beside it."""
    for touching in (0.3, 0.6, 1.0, 1.4, 2.0, 2.6, 3.5, 5.0, 7.0, 10.0):
        for fraction in (0.0, 0.37):
            grid = cs.Grid((32, 1), (32 * 2 * A / touching, A))
            offset = fraction * grid.cell_size[0]
            truth = ClosedForm(_cylinder(offset), highest=P_H, area=touching / 32, points=512)
            shifted = cs.Scene(SCENE.load, STEEL, (Power(HERTZ_HEIGHT, 2.0, offset),))
            yield AccuracyCase(shifted, grid, EXACT, truth)


def spheres() -> Iterator[AccuracyCase]:
    """Yield point contacts between free ends."""
    point = cs.analytic.HertzPoint(30.0, 0.01, MODULUS)
    for cells in (24, 33, 64):
        for width in (2.2, 2.6, 3.1):
            length = width * point.contact_radius
            load = cs.LineLoad(30.0 / length)
            truth = ClosedForm(
                lambda x, y: point.pressure(np.hypot(x, y)), highest=point.peak_pressure, area=pi / width**2
            )
            ball = cs.Scene(load, STEEL, (cs.Sphere(0.01),))
            grid = cs.Grid((cells, cells), (length, length))
            yield AccuracyCase(ball, grid, (FREE, FREE), truth)


def waves() -> Iterator[AccuracyCase]:
    """Yield Westergaard's wave, from a strip of contact to nearly no gap left."""
    height, length = 1e-6, 1e-3
    for cells in (25, 64):
        for fraction in (0.05, 0.3, 0.6, 0.9, 0.97):
            closing = pi * MODULUS * height / length
            wave = cs.analytic.Westergaard(fraction * closing, height, length, MODULUS)
            truth = ClosedForm(_wave(wave), highest=wave.peak_pressure, area=2 * wave.half_width / length)
            load = cs.LineLoad(wave.mean_pressure * length)
            wavy = cs.Scene(load, STEEL, (cs.Waviness(height, across=length),))
            grid = cs.Grid((cells, 1), (length, length))
            yield AccuracyCase(wavy, grid, (EXACT, EXACT), truth)


def sharp() -> Iterator[AccuracyCase]:
    """Yield a flat punch and a wedge, whose peak pressure is infinite."""
    load = SCENE.largest_load
    for cells in (64, 128, 250, 512):
        grid = cs.Grid((cells, 1), (4 * A, A))
        heights = np.where(np.abs(grid.x) < A, 0.0, -50 * HERTZ_HEIGHT)[:, None]
        punch = cs.Scene(SCENE.load, STEEL, (cs.MeasuredSurface(heights),))
        edge = (np.abs(grid.x) < A).sum() * grid.cell_size[0] / 2

        def under(x: Array, _: Array, edge: float = edge) -> Array:
            inside = np.maximum(edge**2 - x**2, 1e-9 * edge**2)
            return np.where(np.abs(x) < edge, load / pi / np.sqrt(inside), 0.0)

        truth = ClosedForm(under, highest=inf, area=edge / (2 * A), points=512)
        yield AccuracyCase(punch, grid, EXACT, truth)
    for cells in (64, 128, 250, 512):
        for width in (2.5, 2.9):
            grid = cs.Grid((cells, 1), (width * A, A))
            wedge = cs.Scene(SCENE.load, STEEL, (Power(load / MODULUS, 1.0),))
            truth = ClosedForm(_under_wedge, highest=inf, area=2 / width, points=512)
            yield AccuracyCase(wedge, grid, EXACT, truth)


def full() -> Iterator[AccuracyCase]:
    """Yield waves pressed flat, over both axes and over one."""
    length, mean = 1e-4, 1e9
    for cells, fraction, across, along in (
        ((36, 36), 0.25, 1, 1), ((50, 80), 0.4, 2, 1), ((96, 64), 0.3, 1, 2), ((48, 1), 0.35, 2, 0),
    ):  # fmt: skip
        wave = 2 * pi / length * np.hypot(across, along)
        height, lengths = (2 * fraction * mean / (MODULUS * wave), (length / across, length / along if along else inf))
        shape = cs.Waviness(height, across=lengths[0], along=lengths[1])
        phase = 2 * pi / length
        pressure = _flat(mean, fraction, phase * across, phase * along)
        truth = ClosedForm(pressure, highest=mean * (1 + fraction), area=1.0)
        pressed = cs.Scene(cs.LineLoad(mean * length), STEEL, (shape,))
        grid = cs.Grid(cells, (length, length))
        yield AccuracyCase(pressed, grid, (EXACT, EXACT), truth)


def yielding() -> Iterator[AccuracyCase]:
    """Yield contacts whose cells are all at the hardness: a strip of a known width."""
    for fraction in (0.3, 0.4, 0.5):
        half = SCENE.largest_load / (2 * fraction * P_H)
        for cells in (40, 101, 256):
            grid = cs.Grid((cells, 1), (2.6 * half, A))
            truth = ClosedForm(_strip(half, fraction * P_H), highest=fraction * P_H, area=1 / 1.3, points=512)
            yield AccuracyCase(scene(hardness=fraction * P_H), grid, EXACT, truth)


def _cylinder(offset: float) -> Pressure:
    return lambda x, y: HERTZ.pressure(x - offset)


def _under_wedge(x: Array, _: Array) -> Array:
    pressure = SCENE.largest_load / pi / A * np.arccosh(1 / np.minimum(np.abs(x / A), 1))
    return np.asarray(pressure)


def _wave(wave: Westergaard) -> Pressure:
    return lambda x, y: wave.pressure(x)


def _flat(mean: float, fraction: float, across: float, along: float) -> Pressure:
    return lambda x, y: mean * (1 + fraction * np.cos(across * x + along * y))


def _strip(half: float, pressure: float) -> Pressure:
    return lambda x, y: np.where(np.abs(x) < half, pressure, 0.0)


MAKERS = (cylinders, few_cells, spheres, waves, sharp, full, yielding)
CLOSED_FORMS = {
    f"{make.__name__.replace('_', ' ')} {number}": case for make in MAKERS for number, case in enumerate(make())
}
