"""Random accuracy cases of each kind, by seed; no margin of an estimate is fitted to them."""

from dataclasses import dataclass, replace
from math import inf, tau

import numpy as np
from scipy import ndimage

import contactstudy as cs
from contactstudy.domain.grid import Array
from contactstudy.scene.shapes.roughness import Profile
from studies.reference.line_contact import HERTZ, HERTZ_HEIGHT, P_H, SCENE, A
from tests.accuracy.case import EXACT, FREE, MODULUS, AccuracyCase, Finer, scene
from tests.accuracy.closed_forms import Power

PROFILES: tuple[Profile, ...] = ("flat", "parabolic", "cosine")
# Cases of each kind.
EACH = 40
FINER = Finer((4, 4), EXACT)


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


def _ratio(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, evenly in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def waves(rng: np.random.Generator) -> AccuracyCase:
    """Return a wave across or along of one to forty cells, one in five of exactly two."""
    height, phase = _ratio(rng, 1e-3, 1.0) * HERTZ_HEIGHT, rng.uniform(0, tau)
    width = (2.6 + 2 * (height / HERTZ_HEIGHT) ** 0.5) * A
    cells = 2.0 if rng.random() < 0.2 else _ratio(rng, 1, 40)
    if rng.random() < 0.6:
        grid = cs.Grid((int(rng.integers(40, 200)), 1), (width, A))
        wave = cs.Waviness(height, across=cells * grid.cell_size[0], phase=phase)
        return AccuracyCase(scene(wave), grid, EXACT, Finer((32, 1), EXACT))
    grid = cs.Grid((int(rng.integers(30, 60)), int(rng.integers(12, 30))), (width, A))
    wave = cs.Waviness(height, along=A / max(1, round(grid.cells[1] / cells)), phase=phase)
    return AccuracyCase(scene(wave), grid, EXACT, Finer((4, 12), EXACT))


def needles(rng: np.random.Generator) -> AccuracyCase:
    """Return bumps of a third of a cell to one and a half."""
    cells = int(rng.integers(30, 50)), int(rng.integers(14, 30))
    grid = cs.Grid(cells, (3 * A, 3 * A * cells[1] / cells[0]))
    height, width = _ratio(rng, 1e-3, 0.3) * HERTZ_HEIGHT, rng.uniform(0.3, 1.5) * grid.cell_size[0]
    pitch = rng.uniform(5, 20) * grid.cell_size[0], grid.length / int(rng.integers(1, 4))
    shape = Bumps(height, width, pitch, (rng.uniform(-1, 1) * A, rng.uniform(-1, 1) * A))
    return AccuracyCase(scene(shape), grid, EXACT, Finer((12, 12), EXACT))


def textures(rng: np.random.Generator) -> AccuracyCase:
    """Return grooves of a tenth of a cell or more, or dimples, with one of three flanks."""
    profile = PROFILES[int(rng.integers(3))]
    depth = _ratio(rng, 0.02, 5) * HERTZ_HEIGHT
    if rng.random() < 0.5:
        grid = cs.Grid((int(rng.integers(50, 400)), 1), (2.9 * A, A))
        pitch = _ratio(rng, 4, 60) * grid.cell_size[0]
        groove = cs.Groove(depth, _ratio(rng, 0.1 * grid.cell_size[0], pitch), profile)
        return AccuracyCase(scene(cs.Texture(groove, (pitch, inf))), grid, EXACT, Finer((32, 1), EXACT))
    across, along = rng.uniform(0.3, 0.9, 2) * A
    cells = int(rng.integers(40, 90))
    grid = cs.Grid((cells, max(8, round(cells * along / (2.6 * A)))), (2.6 * A, along))
    dimple = cs.Dimple(depth, rng.uniform(0.4, 1) * min(across, along), profile)
    return AccuracyCase(scene(cs.Texture(dimple, (across, along))), grid, EXACT, Finer((6, 6), EXACT))


def roughness(rng: np.random.Generator) -> AccuracyCase:
    """Return roughness cut off at one to sixteen cells, one in three on a body with a hardness."""
    cells = int(rng.integers(60, 110))
    grid = cs.Grid((cells, cells // 2), (3.6 * A, 1.8 * A))
    cut_off = _ratio(rng, 1, 16) * grid.cell_size[0]
    rms, hurst, seed = _ratio(rng, 0.02, 1) * HERTZ_HEIGHT, rng.uniform(0.3, 0.9), int(rng.integers(1_000_000))
    shape = cs.Roughness(rms, hurst, max(rng.uniform(0.3, 0.9) * A, cut_off), cut_off, seed=seed)
    hardness = rng.uniform(0.7, 4) * P_H if rng.random() < 1 / 3 else inf
    return AccuracyCase(scene(shape, hardness=hardness), grid, EXACT, FINER)


def measured(rng: np.random.Generator) -> AccuracyCase:
    """Return a surface ground along its length at one to three cells per sampling interval."""
    interval, per_point = 0.05 * A, rng.uniform(1, 3)
    heights = ndimage.gaussian_filter(rng.standard_normal((80, 40)), (1.5, 6.0), mode="wrap")
    heights = heights / heights.std() + 0.1 * rng.standard_normal(heights.shape)
    heights *= _ratio(rng, 0.01, 0.8) * HERTZ_HEIGHT
    surface = cs.MeasuredSurface(heights, (80 * interval, 40 * interval), seam=cs.Tapered())
    grid = cs.Grid((round(72 * per_point), round(40 * per_point)), (72 * interval, 40 * interval))
    return AccuracyCase(scene(surface), grid, EXACT, Finer((3, 3), EXACT))


def coatings(rng: np.random.Generator) -> AccuracyCase:
    """Return coatings 2 to 200 times stiffer than the substrate, of a tenth of a cell to thirty."""
    stiffer, cells = _ratio(rng, 2, 200), int(rng.integers(30, 150))
    coating, substrate = (cs.HalfSpace(2e11 * stiffer**power, 0.3) for power in (0.5, -0.5))
    body = cs.CoatedHalfSpace(coating, _ratio(rng, 0.1, 30) * 3 * A / cells, substrate)
    coated = replace(SCENE, solids=(body, SCENE.solids[1]))
    assert coated.hertz is not None
    grid = cs.Grid((cells, 1), (rng.uniform(2.7, 3.6) * coated.hertz.half_width, A))
    return AccuracyCase(coated, grid, EXACT, Finer((16, 1), EXACT))


def point_contacts(rng: np.random.Generator) -> AccuracyCase:
    """Return spheres that touch in a few cells to some hundred."""
    width = rng.uniform(2.2, 10) * cs.analytic.HertzPoint(30.0, 0.01, MODULUS).contact_radius
    across, along = (int(count) for count in rng.integers(5, 40, 2))
    ball = cs.Scene(cs.LineLoad(30.0 / width), SCENE.solids, (cs.Sphere(0.01),))
    return AccuracyCase(ball, cs.Grid((across, along), (width, width)), (FREE, FREE), Finer((8, 8), (FREE, FREE)))


def rollers(rng: np.random.Generator) -> AccuracyCase:
    """Return rollers of a cell to all of the length, straight, crowned or profiled."""
    period = rng.uniform(3, 16) * A
    grid = cs.Grid((int(rng.integers(28, 60)), int(rng.integers(16, 80))), (4 * A, period))
    is_short = rng.random() < 0.3
    length = rng.uniform(1, 3) * grid.cell_size[1] if is_short else rng.uniform(0.6, 1) * period
    profiles: tuple[tuple[cs.Shape, ...], ...] = (
        (),
        (cs.Crown.of_drop(_ratio(rng, 0.5, 30) * HERTZ_HEIGHT, length),),
        (cs.LundbergProfile.iso_16281(2 * HERTZ.radius, length),),
    )
    ended = scene(cs.FiniteLength(length), *profiles[int(rng.integers(3))])
    return AccuracyCase(ended, grid, (FREE, FREE), Finer((3, 12), (FREE, FREE)))


def apexes(rng: np.random.Generator) -> AccuracyCase:
    """Return apexes between a wedge and a cylinder, whose peak pressure is finite and reached slowly."""
    apex = Power(_ratio(rng, 1, 3) * HERTZ_HEIGHT, rng.uniform(1.2, 1.95), rng.uniform(-0.1, 0.1) * A)
    grid = cs.Grid((int(rng.integers(20, 200)), 1), (7 * A, A))
    return AccuracyCase(replace(SCENE, shapes=(apex,)), grid, EXACT, Finer((32, 1), EXACT))


def paddings(rng: np.random.Generator) -> AccuracyCase:
    """Return a wave along, or none, with a padding that leaves out images, against all of them."""
    images, height = int(rng.integers(7)), rng.choice([0.0, 0.3, 2.0]) * HERTZ_HEIGHT
    kinds = cs.DuplicatedPadding(), cs.Superposition(images), cs.CircularSuperposition(max(images, 1))
    period = _ratio(rng, 0.3, 4.8) * A
    wavy = scene(cs.Waviness(float(height), along=period))
    grid = cs.Grid((int(rng.integers(40, 90)), int(rng.integers(12, 40))), (4.6 * A, period))
    return AccuracyCase(wavy, grid, kinds[int(rng.integers(3))], FINER)


MAKERS = (waves, needles, textures, roughness, measured, coatings, point_contacts, rollers, apexes, paddings)
RANDOM = {f"random {make.__name__.replace('_', ' ')}": make for make in MAKERS}
NAMES = tuple(f"{kind} {number}" for kind in RANDOM for number in range(EACH))


def random_case(name: str, seed: int) -> AccuracyCase:
    """Return the case of a name, one of `NAMES`, under a seed."""
    return RANDOM[name.rpartition(" ")[0]](np.random.default_rng([seed, NAMES.index(name)]))
