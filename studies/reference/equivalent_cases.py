"""Hard cases that are the same contact as another, told otherwise: in other units, moved, mirrored, doubled."""

from dataclasses import dataclass, replace

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array
from contactstudy.domain.padding import across_and_along
from studies.reference.hard_case import (
    AT_EDGE,
    ENDED,
    FLATTENED,
    PADDINGS,
    ROUGH,
    HardCase,
    Twin,
    bumpy,
    grid,
    noise,
)
from studies.reference.line_contact import SCENE, STEEL


def units() -> dict[str, HardCase]:
    """Return the rough contact with every number in another unit."""
    cases = {}
    for name, metre, newton in (
        ("in nm", 1e9, 1.0),
        ("in km", 1e-3, 1.0),
        ("in TPa", 1.0, 1e-12),
        ("in nm and TPa", 1e9, 1e6),
        ("in Gm and yPa", 1e-9, 1e6),
    ):
        pascal = newton / metre**2
        solid = replace(STEEL, youngs_modulus=STEEL.youngs_modulus * pascal)
        load = cs.LineLoad(SCENE.load.largest * newton / metre)
        plain = bumpy(ROUGH)
        heights = cs.MeasuredSurface(ROUGH * FLATTENED * metre)
        converted = cs.Scene(load, (solid, solid), (cs.Cylinder(0.01 * metre), heights))
        cases[f"a scene {name}"] = HardCase(
            "units",
            f"every number is another {name}",
            plain,
            grid(),
            AT_EDGE,
            Twin(converted, grid(metre=metre), _Divided(pascal), 1e-10),
            options=cs.SolveOptions(tolerance=1e-12),
        )
    return cases


def perturbation() -> dict[str, HardCase]:
    """Return the rough contact nudged, moved, mirrored, over two periods, or with its curvature shared."""
    scene = bumpy(ROUGH)
    double = np.tile(ROUGH, 2)
    half = replace(SCENE, shapes=(cs.Cylinder(0.02), cs.Cylinder(0.02)))
    on = grid()

    def case(hard: str, twin: Twin, paddings: tuple[str, ...] = tuple(PADDINGS)) -> HardCase:
        return HardCase(
            "perturbation",
            hard,
            scene,
            on,
            ENDED,
            twin,
            cs.SolveOptions(tolerance=1e-12),
            paddings=paddings,
        )

    wrapping = tuple(
        name for name, padding in PADDINGS.items() if across_and_along(padding)[1].wraps
    )
    endless = tuple(
        name for name, padding in PADDINGS.items() if across_and_along(padding)[1].window is None
    )

    nudged = ROUGH + 1e-10 * ROUGH.std() * noise(seed=5)
    return {
        "heights nudged by 1e-10": case(
            "heights move by 1e-10 of their rms",
            Twin(bumpy(nudged), on, _as_it_is, 1e-11, other_heights=True),
        ),
        "moved by whole cells": case(
            "the surface moves by five cells along",
            Twin(bumpy(np.roll(ROUGH, 5, 1)), on, _Rolled(-5), 1e-9),
            wrapping,
        ),
        "mirrored along": case(
            "the surface is mirrored along", Twin(bumpy(ROUGH[:, ::-1]), on, _Mirrored((1,)), 1e-9)
        ),
        "mirrored across": case(
            "the surface is mirrored across", Twin(bumpy(ROUGH[::-1]), on, _Mirrored((0,)), 1e-9)
        ),
        "twice the period": case(
            "two periods are one",
            Twin(bumpy(double), grid((24, 24), period=2.4), _First(12), 1e-9),
            endless,
        ),
        "curved on both sides": case(
            "half of the cylinder on either body", Twin(bumpy(ROUGH, half), on, _as_it_is, 1e-9)
        ),
    }


@dataclass(frozen=True)
class _Divided:
    """A pressure in another unit."""

    by: float

    def __call__(self, pressure: Array) -> Array:
        return pressure / self.by


@dataclass(frozen=True)
class _Rolled:
    """A pressure moved along the length."""

    by: int

    def __call__(self, pressure: Array) -> Array:
        return np.roll(pressure, self.by, axis=1)


@dataclass(frozen=True)
class _Mirrored:
    """A pressure mirrored along axes."""

    axes: tuple[int, ...]

    def __call__(self, pressure: Array) -> Array:
        return np.flip(pressure, self.axes)


@dataclass(frozen=True)
class _First:
    """A pressure over the first period of several."""

    cells: int

    def __call__(self, pressure: Array) -> Array:
        return pressure[:, : self.cells]


def _as_it_is(pressure: Array) -> Array:
    return pressure
