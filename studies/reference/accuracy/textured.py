"""Waves, grooves and dimples on the cylinder, against the same scene on a much finer grid."""

from collections.abc import Iterator
from math import inf, pi

import contactstudy as cs
from studies.reference.accuracy.case import EXACT, FLATTENED, A, AccuracyCase, Finer, scene

PROFILES = (cs.FlatBottomed(), cs.Parabolic(), cs.Cosine())


def waves() -> Iterator[AccuracyCase]:
    """Across, along and oblique."""
    for height in (0.3, 1.0, 5.0):
        for length, cells in ((0.5, 97), (0.5, 256), (0.23, 150), (0.23, 320)):
            wavy = scene(cs.Waviness(height * FLATTENED, across=length * A, phase=0.4))
            grid = cs.Grid((cells, 1), (2.4 * A + A * (2 * height / 1.2) ** 0.5, A))
            yield AccuracyCase("waves", wavy, grid, EXACT, Finer((16, 1), EXACT))
    for height in (0.2, 1.0):
        for across, along, cells in ((inf, 0.6, 48), (0.5, 1.2, 64), (0.7, 0.6, 90)):
            wavy = scene(cs.Waviness(height * FLATTENED, across=across * A, along=along * A))
            grid = cs.Grid((cells, cells // 2), (3.4 * A, 1.2 * A))
            yield AccuracyCase("waves", wavy, grid, EXACT, Finer((4, 4), EXACT))


def grooves() -> Iterator[AccuracyCase]:
    """Along the length: every profile, from narrow grooves to narrow lands, coarse and fine."""
    number = 0
    for profile in PROFILES:
        for share in (0.2, 0.5, 0.8, 0.9, 0.95, 0.98, 0.99, 0.995):
            for depth in (0.1, 0.5, 20.0):
                # pitches and cells by turns, so that lands fall anywhere between the centres
                pitch = (0.45, 0.1, 0.23)[number % 3]
                cells = (60, 131, 256, 701)[number % 4]
                number += 1
                groove = cs.Groove(depth * FLATTENED, share * pitch * A, profile)
                grooved = scene(cs.Texture(groove, (pitch * A, inf)))
                grid = cs.Grid((cells, 1), (2.6 * A + (depth == 20.0) * 0.4 * A, A))
                factor = max(16, round(8 * grid.extent[0] / cells / ((1 - share) * pitch * A)))
                truth = Finer((min(factor, 200), 1), EXACT)
                yield AccuracyCase("grooves along", grooved, grid, EXACT, truth)


def grooves_across() -> Iterator[AccuracyCase]:
    """Across the length."""
    for profile in PROFILES:
        for share, depth, cells in ((0.3, 0.3, 24), (0.7, 1.0, 50), (0.9, 0.2, 37)):
            groove = cs.Groove(depth * FLATTENED, share * 0.6 * A, profile)
            grooved = scene(cs.Texture(groove, (inf, 0.6 * A)))
            grid = cs.Grid((2 * cells, cells), (3.0 * A, 0.6 * A))
            yield AccuracyCase("grooves across", grooved, grid, EXACT, Finer((4, 6), EXACT))


def dimples() -> Iterator[AccuracyCase]:
    """From a few cells across a dimple on."""
    for profile in PROFILES:
        for share in (0.4, 0.9):
            for depth in (0.1, 1.0):
                for cells in (48, 100):
                    dimple = cs.Dimple(depth * FLATTENED, share * 0.6 * A, profile)
                    dimpled = scene(cs.Texture(dimple, (0.6 * A, 0.6 * A)))
                    grid = cs.Grid((cells, cells // 4), (2.6 * A, 0.6 * A))
                    yield AccuracyCase("dimples", dimpled, grid, EXACT, Finer((6, 6), EXACT))


def windows() -> Iterator[AccuracyCase]:
    """Every padding on a uniform and on a wavy contact, against all images."""
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
            continue  # a free length, which cuts off what varies along it
        for height in (0.3, 2.0):
            wavy = scene(cs.Waviness(height * FLATTENED, along=2.4 * A, phase=pi))
            grid = cs.Grid((90, 48), (4.6 * A, 2.4 * A))
            yield AccuracyCase("every padding", wavy, grid, padding, Finer((4, 4), EXACT))
