"""Random accuracy cases of each kind, by seed; no margin of an estimate is fitted to them."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, tau

import numpy as np
from scipy import ndimage

import contactstudy as cs
from contactstudy.domain.fields import Array
from studies.reference.line_contact import HERTZ_HEIGHT, P_H, SCENE, A
from tests.accuracy.case import EXACT, FREE, MODULUS, AccuracyCase, Finer, scene
from tests.accuracy.matrix import FINER

PROFILES = ("flat", "parabolic", "cosine")
SAMPLING = 0.05 * A  # interval of the measured surface
# Cases of each kind.
EACH = 30
CaseParts = tuple[cs.Scene, cs.Grid, cs.Padding | cs.Paddings, Finer]


@dataclass(frozen=True)
class Slits:
    """Slits along the length, as a user-defined shape: places, width and depth [m]."""

    places: tuple[float, ...]
    width: float
    depth: float
    curvature = 0.0

    def gap(self, grid: cs.Grid) -> Array:
        """Return the depth within half a width of a place."""
        away = np.min([np.abs(grid.x - place) for place in self.places], axis=0)
        return np.asarray(np.where(away < self.width / 2, self.depth, 0.0)[:, None])


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


def rough(rms: float, hurst: float, roll_off: float, cut_off: float, seed: int) -> cs.Roughness:
    """Return a random roughness; its rms and wavelengths in m."""
    return cs.Roughness(rms, hurst=hurst, roll_off=roll_off, cut_off=cut_off, seed=seed)


def ground(points: tuple[int, int], seed: int) -> Array:
    """Return heights of a ground surface with unit rms: a lay along the length, and waves down to its points."""
    rng = np.random.default_rng(seed)
    heights = np.zeros(points)
    for across, along, weight in ((8.0, 30.0, 1.0), (2.5, 10.0, 0.5), (0.7, 3.0, 0.25)):
        noise = ndimage.gaussian_filter(rng.standard_normal(points), (across, along), mode="wrap")
        heights += weight * noise / noise.std()
    heights += 0.05 * rng.standard_normal(points)
    return np.asarray(heights / heights.std())


def _ratio(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, evenly in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _waves(rng: np.random.Generator, cells: tuple[float, float]) -> CaseParts:
    """Return waves across or along, of a wavelength between these numbers of cells."""
    height, phase = _ratio(rng, 1e-3, 1.0) * HERTZ_HEIGHT, rng.uniform(0, tau)
    width = (2.6 + 2 * (height / HERTZ_HEIGHT) ** 0.5) * A
    if rng.random() < 0.6:
        grid = cs.Grid((int(rng.integers(40, 200)), 1), (width, A))
        wave = cs.Waviness(height, across=_ratio(rng, *cells) * grid.cell_size[0], phase=phase)
        return scene(wave), grid, EXACT, Finer((32, 1), EXACT)
    grid = cs.Grid((int(rng.integers(30, 60)), int(rng.integers(12, 30))), (width, A))
    count = max(1, round(grid.cells[1] / _ratio(rng, *cells)))
    wave = cs.Waviness(height, along=A / count, phase=phase)
    return scene(wave), grid, EXACT, Finer((4, 12), EXACT)


def waves(rng: np.random.Generator) -> CaseParts:
    """Return waves of four to forty cells."""
    return _waves(rng, (4.0, 40.0))


def waves_of_few_cells(rng: np.random.Generator) -> CaseParts:
    """Return waves of one to three cells, a third of them at random of about two."""
    return _waves(rng, (2.0, 2.0) if rng.random() < 1 / 3 else (1.0, 3.0))


def slits(rng: np.random.Generator) -> CaseParts:
    """Return slits of a tenth of a cell to three cells."""
    grid = cs.Grid((int(rng.integers(40, 250)), 1), (rng.uniform(2.6, 3.4) * A, A))
    places = tuple(rng.uniform(-1, 1, int(rng.integers(1, 4))) * A)
    width, depth = rng.uniform(0.1, 3) * grid.cell_size[0], _ratio(rng, 0.01, 10) * HERTZ_HEIGHT
    shape = Slits(places, width, depth)
    return scene(shape), grid, EXACT, Finer((64, 1), EXACT)


def needles(rng: np.random.Generator) -> CaseParts:
    """Return bumps of a third of a cell to one and a half."""
    cells = int(rng.integers(30, 50)), int(rng.integers(14, 30))
    grid = cs.Grid(cells, (3 * A, 3 * A * cells[1] / cells[0]))
    shape = Bumps(
        _ratio(rng, 1e-3, 0.3) * HERTZ_HEIGHT,
        rng.uniform(0.3, 1.5) * grid.cell_size[0],
        (rng.uniform(5, 20) * grid.cell_size[0], grid.length / int(rng.integers(1, 4))),
        (rng.uniform(-1, 1) * A, rng.uniform(-1, 1) * A),
    )
    return scene(shape), grid, EXACT, Finer((12, 12), EXACT)


def textures(rng: np.random.Generator) -> CaseParts:
    """Return grooves or dimples with one of three flanks."""
    profile = PROFILES[int(rng.integers(3))]
    depth = _ratio(rng, 0.02, 5) * HERTZ_HEIGHT
    if rng.random() < 0.5:
        grid = cs.Grid((int(rng.integers(50, 400)), 1), (2.9 * A, A))
        pitch = _ratio(rng, 4, 60) * grid.cell_size[0]
        groove = cs.Groove(depth, rng.uniform(0.3, 1) * pitch, profile)
        return scene(cs.Texture(groove, (pitch, inf))), grid, EXACT, Finer((24, 1), EXACT)
    across, along = rng.uniform(0.3, 0.9, 2) * A
    cells = int(rng.integers(40, 90))
    grid = cs.Grid((cells, max(8, round(cells * along / (2.6 * A)))), (2.6 * A, along))
    dimple = cs.Dimple(depth, rng.uniform(0.4, 1) * min(across, along), profile)
    return scene(cs.Texture(dimple, (across, along))), grid, EXACT, Finer((6, 6), EXACT)


def roughness(rng: np.random.Generator) -> CaseParts:
    """Return roughness cut off at one to sixteen cells."""
    cells = int(rng.integers(60, 110))
    grid = cs.Grid((cells, cells // 2), (3.6 * A, 1.8 * A))
    cut_off = _ratio(rng, 1, 16) * grid.cell_size[0]
    rms, hurst = _ratio(rng, 0.02, 1) * HERTZ_HEIGHT, rng.uniform(0.3, 0.9)
    roll_off = max(rng.uniform(0.3, 0.9) * A, cut_off)
    shape = rough(rms, hurst, roll_off, cut_off, int(rng.integers(1_000_000)))
    return scene(shape), grid, EXACT, FINER


def measured(rng: np.random.Generator) -> CaseParts:
    """Return a ground surface at one to three cells per sampling interval."""
    heights = ground((80, 40), int(rng.integers(1_000_000))) * _ratio(rng, 0.01, 0.8) * HERTZ_HEIGHT
    surface = cs.MeasuredSurface(heights, (80 * SAMPLING, 40 * SAMPLING), seam=cs.Tapered())
    per_point = rng.uniform(1, 3)
    cells = round(72 * per_point), round(40 * per_point)
    grid = cs.Grid(cells, (72 * SAMPLING, 40 * SAMPLING))
    return scene(surface), grid, EXACT, Finer((3, 3), EXACT)


def coatings(rng: np.random.Generator) -> CaseParts:
    """Return coatings 2 to 200 times stiffer than the substrate, of a tenth of a cell to thirty."""
    stiffer, cells = _ratio(rng, 2, 200), int(rng.integers(30, 150))
    coating, substrate = (cs.HalfSpace(2e11 * stiffer**power, 0.3) for power in (0.5, -0.5))
    thickness = _ratio(rng, 0.1, 30) * 3 * A / cells
    body = cs.CoatedHalfSpace(coating, thickness, substrate)
    coated = cs.Scene(SCENE.load, (body, SCENE.solids[1]), SCENE.shapes)
    hertz = coated.hertz
    assert hertz is not None
    grid = cs.Grid((cells, 1), (rng.uniform(2.7, 3.6) * hertz.half_width, A))
    return coated, grid, EXACT, Finer((16, 1), EXACT, 1e-8)


def point_contacts(rng: np.random.Generator) -> CaseParts:
    """Return spheres that touch in a few cells to some hundred."""
    point = cs.analytic.HertzPoint(30.0, 0.01, MODULUS)
    width = rng.uniform(2.2, 10) * point.contact_radius
    across, along = (int(count) for count in rng.integers(5, 40, 2))
    grid = cs.Grid((across, along), (width, width))
    ball = cs.Scene(cs.LineLoad(30.0 / width), SCENE.solids, (cs.Sphere(0.01),))
    return ball, grid, (FREE, FREE), Finer((8, 8), (FREE, FREE))


def rollers(rng: np.random.Generator) -> CaseParts:
    """Return rollers of a cell to all of the length, straight or crowned."""
    period = rng.uniform(3, 16) * A
    grid = cs.Grid((int(rng.integers(28, 60)), int(rng.integers(16, 80))), (4 * A, period))
    is_short = rng.random() < 0.3
    length = rng.uniform(1, 3) * grid.cell_size[1] if is_short else rng.uniform(0.6, 1) * period
    shapes: list[cs.Shape] = [cs.FiniteLength(length)]
    if rng.random() < 0.4:
        shapes.append(cs.Crown.of_drop(_ratio(rng, 0.5, 30) * HERTZ_HEIGHT, length))
    ended = replace(SCENE, shapes=(*SCENE.shapes, *shapes))
    return ended, grid, (FREE, FREE), Finer((3, 12), (FREE, FREE))


def hard(rng: np.random.Generator) -> CaseParts:
    """Return roughness on a body with a hardness."""
    cells = int(rng.integers(40, 100))
    grid = cs.Grid((cells, cells // 2), (3.6 * A, 1.8 * A))
    rms, cut_off = _ratio(rng, 0.05, 0.8) * HERTZ_HEIGHT, rng.uniform(0.1, 0.4) * A
    shape = rough(rms, 0.8, 0.9 * A, cut_off, int(rng.integers(1_000_000)))
    soft = scene(shape, hardness=rng.uniform(0.7, 4) * P_H)
    return soft, grid, EXACT, FINER


MAKERS: tuple[Callable[[np.random.Generator], CaseParts], ...] = (
    waves, waves_of_few_cells, slits, needles, textures, roughness, measured, coatings, point_contacts, rollers, hard,
)  # fmt: skip
RANDOM = {f"random {make.__name__.replace('_', ' ')}": make for make in MAKERS}
NAMES = tuple(f"{kind} {number}" for kind in RANDOM for number in range(EACH))


def random_case(name: str, seed: int) -> AccuracyCase:
    """Return the case of a name, one of `NAMES`, under a seed."""
    kind = name.rpartition(" ")[0]
    rng = np.random.default_rng([seed, NAMES.index(name)])
    return AccuracyCase(kind, *RANDOM[kind](rng))
