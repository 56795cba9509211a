"""The named hard cases of the study `stability`; the tests have more of each kind."""

from dataclasses import replace
from math import inf

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array
from studies.definitions.hard_case import (
    AT_EDGE,
    CELLS,
    EXACT_TO_ROUNDING,
    FLAT,
    ROUGH,
    HardCase,
    grid,
    noise,
    with_heights,
)
from studies.reference.line_contact import HERTZ_HEIGHT, P_H, SCENE, STEEL, A


def between(first: cs.HalfSpace, second: cs.HalfSpace) -> HardCase:
    """Return a smooth contact of two materials, on a grid of its own half-width."""
    scene = replace(SCENE, solids=(first, second))
    hertz = scene.hertz
    assert hertz is not None
    return HardCase(scene, cs.Grid(CELLS, (2.4 * hertz.half_width, 1.2 * hertz.half_width)))


def _rough(heights: Array, scene: cs.Scene = SCENE) -> HardCase:
    """Return a contact with heights (x, y) over a²/(2R), which may reach the edges of the grid."""
    return HardCase(with_heights(heights, scene), grid(heights.shape), AT_EDGE)


def _corner(problem: cs.Problem, solver: cs.Solver) -> Array:
    """Return a pressure on one corner cell."""
    pressure = np.zeros_like(problem.undeformed_gap)
    pressure[0, 0] = 1.0
    return pressure


def _needle() -> Array:
    heights = np.zeros((32, 32))
    heights[16, 8] = 100.0
    return heights


def _step() -> Array:
    heights = np.zeros(CELLS)
    heights[:, 6:] = 0.5
    return heights


WAVY = replace(FLAT, shapes=(cs.Waviness(1e-3 * HERTZ_HEIGHT, along=1.2 * A),))
PUNCH = np.where(np.abs(grid().x)[:, None] < 0.5 * A, 0.0, -1e4) * np.ones(CELLS)
YIELDING = replace(with_heights(ROUGH), hardness=0.33 * P_H)  # 0.327 carries the load
TOO_SOFT = replace(SCENE, hardness=0.3 * P_H)
START = _rough(3 * ROUGH)
CASES: dict[str, HardCase] = {
    "period of 0.001 half-widths": HardCase(SCENE, grid((24, 6), period=1e-3)),
    "period of 1000 half-widths": HardCase(SCENE, grid((24, 6), period=1e3)),
    "cells 1000 times as long as wide": HardCase(SCENE, grid((24, 6), period=600.0)),
    "strips of plane strain": HardCase(SCENE, grid((48, 1)), paddings=("exact",)),
    "one cell touches": HardCase(with_heights(np.eye(1, 288, 150).reshape(CELLS) * 30), grid()),
    "full contact": HardCase(WAVY, grid(), AT_EDGE),
    "load of 1e-30 N/m": HardCase(replace(SCENE, load=cs.LineLoad(1e-30)), grid()),
    "rigid on elastic": between(cs.HalfSpace(inf, 0.3), STEEL),
    "moduli 1:1000000": between(STEEL, cs.HalfSpace(210e3, 0.3)),
    "hardness just above the mean pressure": HardCase(YIELDING, grid(width=4.8), AT_EDGE),
    "hardness below the mean pressure": HardCase(
        TOO_SOFT, grid(width=4.8), frozenset({cs.Status.NO_ADMISSIBLE_PRESSURE})
    ),
    "a needle": _rough(_needle()),
    "a step": _rough(_step()),
    "a flat punch": _rough(PUNCH, FLAT),
    "white noise": _rough(noise()),
    "tolerance 1e-14": replace(
        START, options=cs.SolveOptions(1e-14), ends=EXACT_TO_ROUNDING | AT_EDGE
    ),
    "single precision": replace(
        START,
        options=cs.SolveOptions(1e-10, precision=cs.Precision.SINGLE),
        ends=frozenset({cs.Status.PRECISION_LIMIT}),
    ),
    "one iteration": replace(
        START, options=cs.SolveOptions(1e-10, 1), ends=frozenset({cs.Status.ITERATION_LIMIT})
    ),
    "start at a wrong corner": replace(START, start=_corner),
}
