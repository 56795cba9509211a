"""The matrix of accuracy cases: closed forms, paddings and rollers, by name."""

from collections.abc import Iterator
from functools import cache
from math import pi

import contactstudy as cs
from studies.reference.line_contact import HERTZ, HERTZ_HEIGHT, SCENE, A
from tests.accuracy import smooth
from tests.accuracy.case import EXACT, FREE, MODULUS, AccuracyCase, Finer, scene

FINER = Finer((4, 4), EXACT)


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


def logarithmic() -> Iterator[AccuracyCase]:
    """Yield rollers whose profile drops steeply at the ends, where the mean of its heights depends on the cells."""
    for cells, length in (((60, 64), 12.0), ((38, 24), 30.0), ((44, 58), 8.0)):
        profile = cs.LundbergProfile.iso_16281(2 * HERTZ.radius, length * A)
        grid = cs.Grid(cells, (6 * A, length * A))
        roller = scene(profile, cs.FiniteLength(length * A))
        yield AccuracyCase("rollers", roller, grid, (FREE, FREE), Finer((6, 6), (FREE, FREE)))


BUILDERS = (
    smooth.cylinders, smooth.few_cells, smooth.spheres, smooth.waves, smooth.sharp, smooth.yielding, windows, rollers,
    smooth.powers, smooth.full, logarithmic,
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
