"""The matrix of accuracy cases: textures, roughness, rollers and bumps against much finer grids, and all by name."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from math import inf, pi

import numpy as np
from scipy import ndimage

import contactstudy as cs
from contactstudy.domain.fields import Array
from studies.reference.line_contact import HERTZ, HERTZ_HEIGHT, P_H, SCENE, A
from tests.accuracy import smooth
from tests.accuracy.case import EXACT, FREE, MODULUS, AccuracyCase, Finer, scene

PROFILES = ("flat", "parabolic", "cosine")
SAMPLING = 0.05 * A  # interval of the measured surface
FINER = Finer((4, 4), EXACT)


def textured_waves() -> Iterator[AccuracyCase]:
    """Yield waves across, along and oblique."""
    for height in (0.3, 1.0, 5.0):
        for length, cells in ((0.5, 97), (0.5, 256), (0.23, 150), (0.23, 320)):
            wavy = scene(cs.Waviness(height * HERTZ_HEIGHT, across=length * A, phase=0.4))
            grid = cs.Grid((cells, 1), (2.4 * A + A * (2 * height / 1.2) ** 0.5, A))
            yield AccuracyCase("waves", wavy, grid, EXACT, Finer((16, 1), EXACT))
    for height in (0.2, 1.0):
        for across, along, cells in ((inf, 0.6, 48), (0.5, 1.2, 64), (0.7, 0.6, 90)):
            wavy = scene(cs.Waviness(height * HERTZ_HEIGHT, across=across * A, along=along * A))
            grid = cs.Grid((cells, cells // 2), (3.4 * A, 1.2 * A))
            yield AccuracyCase("waves", wavy, grid, EXACT, FINER)


def grooves() -> Iterator[AccuracyCase]:
    """Yield grooves of every cross-section, along the length, from narrow grooves to narrow lands, on two grids."""
    number = 0
    for profile in PROFILES:
        for fraction in (0.2, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995):
            for depth in (0.1, 0.5, 20.0):
                # pitches and cells by turns, so that lands fall anywhere between the centres
                pitch = (0.45, 0.1, 0.23)[number % 3]
                cells = (60, 131, 256, 701)[number % 4]
                number += 1
                groove = cs.Groove(depth * HERTZ_HEIGHT, fraction * pitch * A, profile)
                grooved = scene(cs.Texture(groove, (pitch * A, inf)))
                grid = cs.Grid((cells, 1), (2.6 * A + (depth == 20.0) * 0.4 * A, A))
                factor = max(16, round(8 * grid.extent[0] / cells / ((1 - fraction) * pitch * A)))
                truth = Finer((min(factor, 200), 1), EXACT)
                yield AccuracyCase("grooves along", grooved, grid, EXACT, truth)


def grooves_across() -> Iterator[AccuracyCase]:
    """Yield grooves across the length."""
    for profile in PROFILES:
        for fraction, depth, cells in ((0.3, 0.3, 24), (0.7, 1.0, 50), (0.9, 0.2, 37)):
            groove = cs.Groove(depth * HERTZ_HEIGHT, fraction * 0.6 * A, profile)
            grooved = scene(cs.Texture(groove, (inf, 0.6 * A)))
            grid = cs.Grid((2 * cells, cells), (3.0 * A, 0.6 * A))
            yield AccuracyCase("grooves across", grooved, grid, EXACT, Finer((4, 6), EXACT))


def dimples() -> Iterator[AccuracyCase]:
    """Yield dimples of every profile, shallow and deep, on coarse and fine grids."""
    for profile in PROFILES:
        for fraction in (0.4, 0.9):
            for depth in (0.1, 1.0):
                for cells in (48, 100):
                    dimple = cs.Dimple(depth * HERTZ_HEIGHT, fraction * 0.6 * A, profile)
                    dimpled = scene(cs.Texture(dimple, (0.6 * A, 0.6 * A)))
                    grid = cs.Grid((cells, cells // 4), (2.6 * A, 0.6 * A))
                    yield AccuracyCase("dimples", dimpled, grid, EXACT, Finer((6, 6), EXACT))


def windows() -> Iterator[AccuracyCase]:
    """Yield every padding on a uniform and on a wavy contact, against all images."""
    paddings: list[cs.Padding] = [
        cs.ZeroPadding(),
        cs.DuplicatedPadding(),
        *(cs.Superposition(images) for images in (0, 1, 6)),
        *(cs.CircularSuperposition(images) for images in (1, 6)),
    ]
    for padding in paddings:
        for period in (0.3, 1.2, 4.8):
            grid = cs.Grid((48, 4 if padding.wraps else 32), (2.6 * A, period * A))
            yield AccuracyCase("every padding", scene(), grid, padding, Finer((8, 1), EXACT))
        if padding == cs.ZeroPadding():
            continue  # free ends, which cut off what varies along the length
        for height in (0.3, 2.0):
            wavy = scene(cs.Waviness(height * HERTZ_HEIGHT, along=2.4 * A, phase=pi))
            grid = cs.Grid((90, 48), (4.6 * A, 2.4 * A))
            yield AccuracyCase("every padding", wavy, grid, padding, FINER)


def rollers() -> Iterator[AccuracyCase]:
    """Yield flat ends, profiles and crowns between free ends, the grid as long as the roller or longer."""
    length = 12 * A
    truth = Finer((4, 4), (FREE, FREE))
    lundberg = cs.LundbergProfile.for_load(
        SCENE.largest_load, contact_modulus=MODULUS, radius=HERTZ.radius, length=length
    )
    ended = cs.FiniteLength(length)
    for cells in ((32, 48), (60, 100)):
        for shapes, width, longer in (
            ((ended,), 3.2, 1.0),
            ((ended,), 3.2, 1.25),
            ((lundberg,), 3.2, 1.0),
            ((lundberg, ended), 3.2, 1.25),
            ((ended, cs.Crown.of_drop(2 * HERTZ_HEIGHT, length)), 3.6, 1.0),
            ((ended, cs.Crown.of_drop(30 * HERTZ_HEIGHT, length)), 5.0, 1.0),
            ((ended, cs.Crown.of_drop(300 * HERTZ_HEIGHT, length)), 8.0, 1.0),
            ((cs.Crown.of_drop(100 * HERTZ_HEIGHT, length),), 6.0, 1.0),
        ):
            grid = cs.Grid(cells, (width * A, longer * length))
            yield AccuracyCase("rollers", scene(*shapes), grid, (FREE, FREE), truth)


def rough(rms: float, hurst: float, roll_off: float, cut_off: float, seed: int) -> cs.Roughness:
    """Return a random roughness; its rms and wavelengths in m."""
    return cs.Roughness(rms, hurst=hurst, roll_off=roll_off, cut_off=cut_off, seed=seed)


def roughness() -> Iterator[AccuracyCase]:
    """Yield roughness cut off at one cell to sixteen, from a light roughness to one that leaves a tenth in contact."""
    for number, cut_off in enumerate((0.3, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0)):
        for rms in (0.05, 0.3, 1.0):
            for hurst, cells in ((0.8, 90), (0.4, 128)):
                grid = cs.Grid((cells, cells // 2), (3.6 * A, 1.8 * A))
                shortest = cut_off * grid.cell_size[0]
                longest = max(0.9 * A, shortest)
                shape = rough(rms * HERTZ_HEIGHT, hurst, longest, shortest, number)
                yield AccuracyCase("roughness", scene(shape), grid, EXACT, FINER)
    for number, lay in enumerate((0.2, 0.5, 2.0, 5.0)):
        shape = replace(rough(0.3 * HERTZ_HEIGHT, 0.7, 0.6 * A, 0.1 * A, number), peklenik=lay)
        grid = cs.Grid((120, 64), (3.6 * A, 1.8 * A))
        yield AccuracyCase("roughness", scene(shape), grid, EXACT, FINER)


def hard() -> Iterator[AccuracyCase]:
    """Yield a hardness that no cell reaches, some do, or most do; smooth and rough."""
    for fraction in (0.6, 0.8, 0.95, 1.5):
        for cells in (50, 128):
            grid = cs.Grid((cells, 1), (3.0 * A, A))
            soft = scene(hardness=fraction * P_H)
            yield AccuracyCase("hardness", soft, grid, EXACT, Finer((32, 1), EXACT, 1e-7))
    for number, fraction in enumerate((0.8, 1.2, 2.0, 5.0)):
        for rms in (0.2, 0.8):
            shape = rough(rms * HERTZ_HEIGHT, 0.8, 0.9 * A, 0.15 * A, number)
            grid = cs.Grid((100, 50), (3.6 * A, 1.8 * A))
            soft = scene(shape, hardness=fraction * P_H)
            yield AccuracyCase("hardness", soft, grid, EXACT, FINER)


def ground(points: tuple[int, int], seed: int) -> Array:
    """Return heights of a ground surface with unit rms: a lay along the length, and waves down to its points."""
    rng = np.random.default_rng(seed)
    heights = np.zeros(points)
    for across, along, weight in ((8.0, 30.0, 1.0), (2.5, 10.0, 0.5), (0.7, 3.0, 0.25)):
        noise = ndimage.gaussian_filter(rng.standard_normal(points), (across, along), mode="wrap")
        heights += weight * noise / noise.std()
    heights += 0.05 * rng.standard_normal(points)
    return np.asarray(heights / heights.std())


def measured() -> Iterator[AccuracyCase]:
    """Yield a measured surface at one, two and three cells per point, and at cells between."""
    for seed in range(3):
        heights = ground((80, 40), seed)
        for rms in (0.02, 0.1, 0.5):
            surface = cs.MeasuredSurface(
                heights * rms * HERTZ_HEIGHT, (80 * SAMPLING, 40 * SAMPLING), seam=cs.Tapered()
            )
            for per_point in (1.0, 1.35, 2.0, 3.0):
                cells = round(72 * per_point), round(40 * per_point)
                grid = cs.Grid(cells, (72 * SAMPLING, 40 * SAMPLING))
                yield AccuracyCase("measured surface", scene(surface), grid, EXACT, FINER)
    for seed in (3, 4):
        grid = cs.Grid((80, 40), (80 * SAMPLING, 40 * SAMPLING))
        surface = cs.MeasuredSurface(ground((80, 40), seed) * 0.1 * HERTZ_HEIGHT)
        yield AccuracyCase("measured surface", scene(surface), grid, EXACT, FINER)


@dataclass(frozen=True)
class Bumps:
    """Gaussian bumps on a lattice, as a user-defined shape; lengths in m, places from the axis."""

    height: float
    width: float
    pitch: tuple[float, float]
    place: tuple[float, float]
    curvature = 0.0

    def gap(self, grid: cs.Grid) -> Array:
        """Return the heights of the bumps, which are a negative gap [m]."""
        x, y = (
            (points - place + pitch / 2) % pitch - pitch / 2
            for points, place, pitch in zip((grid.x, grid.y), self.place, self.pitch, strict=True)
        )
        return np.asarray(-self.height * np.exp(-(x[:, None] ** 2 + y**2) / self.width**2))


def bumps() -> Iterator[AccuracyCase]:
    """Yield bumps from a tenth of a cell to some cells wide, on the lines of the grid and between them."""
    sizes = itertools.product((0.12, 0.4, 1.2, 3.0), (0.002, 0.02, 0.3))
    for number, (width, height) in enumerate(sizes):
        cells = 48 + 5 * number, 40 + 3 * number
        grid = cs.Grid(cells, (3.2 * A, 3.2 * A * cells[1] / cells[0]))
        dx, dy = grid.cell_size
        pitch, place = (5 * dx, grid.length / (cells[1] // 5)), (number / 12 * dx, dy / 2)
        shape = Bumps(height * HERTZ_HEIGHT, width * dx, pitch, place)
        yield AccuracyCase("bumps", scene(shape), grid, EXACT, Finer((6, 6), EXACT))


def ended() -> Iterator[AccuracyCase]:
    """Yield crowned rollers that end inside a cell."""
    for cells, longer, length in (
        (64, 1.1, 16.4), (51, 1.1, 2.0), (45, 1.25, 8.0), (28, 1.3, 6.0), (47, 1.07, 20.0),
    ):  # fmt: skip
        roller = cs.Crown.of_drop(3 * HERTZ_HEIGHT, length * A), cs.FiniteLength(length * A)
        grid = cs.Grid((40, cells), (5 * A, longer * length * A))
        truth = Finer((4, 8), (FREE, FREE))
        yield AccuracyCase("rollers", scene(*roller), grid, (FREE, FREE), truth)


def logarithmic() -> Iterator[AccuracyCase]:
    """Yield rollers whose profile drops steeply at the ends, where the mean of its heights depends on the cells."""
    for cells, length in (((60, 64), 12.0), ((38, 24), 30.0), ((44, 58), 8.0)):
        profile = cs.LundbergProfile.iso_16281(2 * HERTZ.radius, length * A)
        grid = cs.Grid(cells, (6 * A, length * A))
        roller = scene(profile, cs.FiniteLength(length * A))
        yield AccuracyCase("rollers", roller, grid, (FREE, FREE), Finer((6, 6), (FREE, FREE)))


def gaps() -> Iterator[AccuracyCase]:
    """Yield smooth contacts with mean gaps from small to large: bare, coated and under friction."""
    aluminium = cs.HalfSpace(70e9, 0.2)
    for cells, width, thickness, fraction in (
        (99, 2.3, 0.0, 0.0), (40, 3.3, 0.0, 0.0), (43, 3.6, 0.1, 0.02), (109, 5.0, 1.0, 0.05), (56, 2.6, 0.3, 0.8),
    ):  # fmt: skip
        steel = SCENE.solids[0]
        assert isinstance(steel, cs.HalfSpace)
        coating = cs.HalfSpace(fraction * steel.youngs_modulus, 0.3) if fraction else steel
        body = cs.CoatedHalfSpace(coating, thickness * A, steel) if fraction else steel
        smooth_scene = cs.Scene(SCENE.load, (body, steel), SCENE.shapes)
        grid = cs.Grid((cells, 1), (width * A, A))
        yield AccuracyCase("mean gaps", smooth_scene, grid, EXACT, Finer((16, 1), EXACT))
    for cells, width in ((62, 3.2), (137, 4.4)):
        slid = replace(SCENE, solids=(SCENE.solids[0], aluminium), friction=cs.Sliding(0.4))
        grid = cs.Grid((cells, 1), (width * A, A))
        yield AccuracyCase("mean gaps", slid, grid, EXACT, Finer((16, 1), EXACT))


def point_loads() -> Iterator[AccuracyCase]:
    """Yield a rough sphere between free ends."""
    point = cs.analytic.HertzPoint(30.0, 0.01, MODULUS)
    size = 2.6 * point.contact_radius
    grown = point.peak_pressure * point.contact_radius / MODULUS
    for number, cut_off in enumerate((3.0, 8.0)):
        grid = cs.Grid((72, 72), (size, size))
        shape = rough(0.05 * grown, 0.8, size / 4, cut_off * grid.cell_size[0], number)
        ball = cs.Scene(cs.LineLoad(30.0 / size), SCENE.solids, (cs.Sphere(0.01), shape))
        yield AccuracyCase("sphere", ball, grid, (FREE, FREE), Finer((4, 4), (FREE, FREE)))


BUILDERS = (
    smooth.cylinders, smooth.few_cells, smooth.spheres, smooth.waves, smooth.sharp, smooth.yielding, textured_waves,
    grooves, grooves_across, dimples, windows, rollers, roughness, hard, measured, point_loads, smooth.powers,
    smooth.full, ended, bumps, logarithmic, gaps,
)  # fmt: skip


@cache
def matrix() -> dict[str, AccuracyCase]:
    """Return all cases by their name, a kind and a number."""
    cases: dict[str, AccuracyCase] = {}
    for build in BUILDERS:
        for case in build():
            number = sum(previous.kind == case.kind for previous in cases.values())
            cases[f"{case.kind} {number}"] = case
    return cases
