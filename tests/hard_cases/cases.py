"""All hard cases by name: those of the study `stability`, and more of each kind."""

from dataclasses import replace
from functools import partial

import numpy as np

import contactstudy as cs
from contactstudy.domain.grid import Array
from studies.definitions.hard_cases import (
    AT_EDGE,
    CELLS,
    ENDED,
    FLAT,
    ROUGH,
    HardCase,
    between,
    grid,
    noise,
    with_heights,
)
from studies.definitions.hard_cases import CASES as NAMED
from studies.reference.line_contact import P_H, SCENE, A

FREE, EXACT = cs.ZeroPadding(), cs.ExactPeriodicity()
PADDINGS: dict[str, cs.Padding | cs.Paddings] = {
    "zero": FREE,
    "duplicated": cs.DuplicatedPadding(),
    "superposed": cs.Superposition(2),
    "circular": cs.CircularSuperposition(2),
    "exact": EXACT,
    "exact on both": (EXACT, EXACT),
    "circular on both": (cs.CircularSuperposition(1), cs.DuplicatedPadding()),
}


def _discretisation() -> dict[str, HardCase]:
    """Return contacts with extreme periods, aspects and numbers of cells."""

    def case(cells: tuple[int, int], period: float) -> HardCase:
        return HardCase(SCENE, grid(cells, 2.4, period), AT_EDGE if cells[0] < 4 else ENDED)

    return {
        **{f"period {period:g} a": case((24, 6), period) for period in (1e-2, 1e2)},
        "cells 1:0.001": case((24, 6), 0.6e-3),
        **{
            f"{nx} x {ny} cells": case((nx, ny), 1.2)
            for nx, ny in ((24, 1), (24, 2), (2, 1), (3, 1), (25, 9), (23, 13))
        },
    }


def _load() -> dict[str, HardCase]:
    """Return contacts with extreme loads and contact areas."""
    heavy = replace(SCENE, load=cs.LineLoad(1e30))
    return {
        "one row of cells touches": HardCase(SCENE, grid((25, 4), 1000.0)),
        "contact reaches the edge": HardCase(SCENE, grid(width=1.5), AT_EDGE),
        "far from its datum": HardCase(with_heights(ROUGH + 1e6), grid()),
        "coarse cells": HardCase(with_heights(noise()), grid(CELLS, 1e3, 1e3)),
        "shape flattened": HardCase(heavy, grid(), AT_EDGE),
    }


def _material() -> dict[str, HardCase]:
    """Return contacts with extreme moduli, Poisson's ratios and hardnesses."""
    cases = {}
    for ratio in (0.0, 0.5):
        body = cs.HalfSpace(210e9, ratio)
        cases[f"Poisson's ratio {ratio:g}"] = between(body, body)
    wide = grid(width=4.8)
    for fraction in (1.01, 0.99, 0.7, 0.4, 0.328):  # 0.327 carries the load
        scene = replace(with_heights(ROUGH), hardness=fraction * P_H)
        cases[f"hardness {fraction:g} p_H"] = HardCase(scene, wide, AT_EDGE)
    # where trial steps are shortened to zero: all but two cells yield, or the cells are 30 times as wide as long
    options = cs.SolveOptions(tolerance=1e-9)
    thin = with_heights(8.087711031384107e-4 * noise((15, 2), 23030886))
    thin = replace(thin, hardness=0.321 * P_H)
    on = grid((15, 2), 110.95259085951773, 0.4464264239955842)
    cases["hardness on long cells"] = HardCase(thin, on, AT_EDGE, options=options)
    full = with_heights(0.08086197949648571 * noise((7, 7), 632285552), FLAT)
    full = replace(full, hardness=0.03661931369241763 * P_H)
    on, ends = grid((7, 7), 44.29302973822934, 2.0062328974336388), AT_EDGE | {cs.Status.STALLED}
    cases["hardness beside the mean"] = HardCase(full, on, ends, options=options)
    return cases


def _surface() -> dict[str, HardCase]:
    """Return contacts with steps, spikes and rough surfaces, with heights over a^2 / (2R)."""
    rng = np.random.default_rng(3)
    surfaces = {
        "spikes of one cell": np.where(rng.random(CELLS) < 0.05, 20.0, 0.0),
        "noise of the grid's wavelength": 0.3 * (np.indices(CELLS).sum(axis=0) % 2),
        "rms 100 times the approach": 100 * noise(),
    }
    return {name: HardCase(with_heights(heights), grid(heights.shape), AT_EDGE) for name, heights in surfaces.items()}


def _interrupted(problem: cs.Problem, solver: cs.Solver) -> Array:
    """Return the pressure after five iterations."""
    return cs.solve(problem, max_iterations=5, solver=solver).pressure


def _solver() -> dict[str, HardCase]:
    """Return contacts with extreme tolerances, limits and starts."""
    case = partial(replace, HardCase(with_heights(3 * ROUGH), grid(), AT_EDGE))
    # heights of 0.1 flatten at four times their load
    pressed = replace(with_heights(ROUGH), load=cs.LineLoad(16 * SCENE.largest_load))
    capped = replace(with_heights(ROUGH, FLAT), hardness=1.0001 * SCENE.largest_load / (2.4 * A))
    return {
        "tolerance 1e-2": case(options=cs.SolveOptions(tolerance=1e-2)),
        "restart": case(start=_interrupted),
        "cap at near-full contact": case(scene=capped),
        "near-full rough contact": case(scene=with_heights(0.2 * ROUGH, FLAT)),
        "overloaded rough contact": case(scene=pressed),
    }


CASES: dict[str, HardCase] = {**NAMED, **_discretisation(), **_load(), **_material(), **_surface(), **_solver()}
