"""The whole matrix of accuracy cases, by name."""

from functools import cache

from studies.reference.accuracy import rough, smooth, textured
from studies.reference.accuracy.case import AccuracyCase

BUILDERS = (
    smooth.cylinders,
    smooth.few_cells,
    smooth.spheres,
    smooth.waves,
    smooth.sharp,
    smooth.yielding,
    textured.waves,
    textured.grooves,
    textured.grooves_across,
    textured.dimples,
    textured.windows,
    rough.rollers,
    rough.rough,
    rough.hard,
    rough.measured,
    rough.point_loads,
)


@cache
def matrix() -> dict[str, AccuracyCase]:
    """All cases, named by their kind and number."""
    found: dict[str, AccuracyCase] = {}
    for build in BUILDERS:
        for case in build():
            number = sum(one.kind == case.kind for one in found.values())
            found[f"{case.kind} {number}"] = case
    return found
