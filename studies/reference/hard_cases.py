"""The hard cases by group and name."""

from dataclasses import replace
from functools import partial
from math import inf

import numpy as np

import contactstudy as cs
from contactstudy.domain.fields import Array
from studies.reference.hard_case import (
    AT_EDGE,
    CELLS,
    ENDED,
    EXACT_TO_ROUNDING,
    FLAT,
    ROUGH,
    HardCase,
    grid,
    noise,
    perturbation,
    units,
    with_heights,
)
from studies.reference.line_contact import HERTZ_HEIGHT, P_H, SCENE, STEEL, A


def _discretisation() -> dict[str, HardCase]:
    """Return contacts with extreme periods, aspects and numbers of cells."""

    def case(cells: tuple[int, int], period: float) -> HardCase:
        return HardCase(SCENE, grid(cells, 2.4, period), AT_EDGE if cells[0] < 4 else ENDED)

    return {
        **{f"period {period:g} a": case((24, 6), period) for period in (1e-3, 1e-2, 1e2, 1e3)},
        **{f"cells 1:{aspect:g}": case((24, 6), 0.6 * aspect) for aspect in (1e-3, 1e3)},
        **{
            f"{nx} x {ny} cells": case((nx, ny), 1.2)
            for nx, ny in ((24, 1), (24, 2), (2, 1), (3, 1), (25, 9), (23, 13))
        },
    }


def _load() -> dict[str, HardCase]:
    """Return contacts with extreme loads and contact areas."""
    faint = replace(SCENE, load=cs.LineLoad(1e-30))  # a contact of 1e-17 cells
    heavy = replace(SCENE, load=cs.LineLoad(1e30))
    spike = with_heights(np.eye(1, 288, 150).reshape(CELLS) * 30)
    wavy = replace(FLAT, shapes=(cs.Waviness(1e-3 * HERTZ_HEIGHT, along=1.2 * A),))
    return {
        "one row of cells touches": HardCase(SCENE, grid((25, 4), 1000.0)),
        "one cell touches": HardCase(spike, grid()),
        "contact reaches the edge": HardCase(SCENE, grid(width=1.5), AT_EDGE),
        "full contact": HardCase(wavy, grid(), AT_EDGE),
        "faint load": HardCase(faint, grid()),
        "far from its datum": HardCase(with_heights(ROUGH + 1e6), grid()),
        "coarse cells": HardCase(with_heights(noise()), grid(CELLS, 1e3, 1e3)),
        "shape flattened": HardCase(heavy, grid(), AT_EDGE),
    }


def _material() -> dict[str, HardCase]:
    """Return contacts with extreme moduli, Poisson's ratios and hardnesses."""
    rigid, cork = cs.HalfSpace(inf, 0.3), cs.HalfSpace(210e9, 0.0)
    rubber, foam = cs.HalfSpace(210e9, 0.5), cs.HalfSpace(210e3, 0.3)
    cases = {}
    for name, solids in {
        "rigid on elastic": (rigid, STEEL),
        "Poisson's ratio 0": (cork, cork),
        "Poisson's ratio 0.5": (rubber, rubber),
        "moduli 1:10^6": (STEEL, foam),
    }.items():
        scene = replace(SCENE, solids=solids)
        hertz = scene.hertz
        assert hertz is not None
        extent = (2.4 * hertz.half_width, 1.2 * hertz.half_width)
        cases[name] = HardCase(scene, cs.Grid(CELLS, extent))
    wide = grid(width=4.8)
    for fraction in (1.01, 0.99, 0.7, 0.4, 0.33, 0.328):  # 0.327 carries the load
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
    ends = frozenset({cs.Status.NO_ADMISSIBLE_PRESSURE})
    cases["hardness 0.3 p_H"] = HardCase(replace(SCENE, hardness=0.3 * P_H), wide, ends)
    return cases


def _surface() -> dict[str, HardCase]:
    """Return contacts with steps, spikes and rough surfaces, with heights over a^2 / (2R)."""
    rng = np.random.default_rng(3)
    needle = np.zeros((32, 32))
    needle[16, 8] = 100.0
    step = np.zeros(CELLS)
    step[:, 6:] = 0.5
    plateau = np.where(np.abs(grid().x)[:, None] < 0.5 * A, 0.0, -1e4) * np.ones(CELLS)
    surfaces = {
        "0.1 % contact": needle,
        "spikes of one cell": np.where(rng.random(CELLS) < 0.05, 20.0, 0.0),
        "a step": step,
        "noise of the grid's wavelength": 0.3 * (np.indices(CELLS).sum(axis=0) % 2),
        "white noise": noise(),
        "rms 100 times the approach": 100 * noise(),
    }
    cases = {
        name: HardCase(with_heights(heights), grid(heights.shape), AT_EDGE)
        for name, heights in surfaces.items()
    }
    return cases | {"a flat punch": HardCase(with_heights(plateau, FLAT), grid(), AT_EDGE)}


def _corner(problem: cs.Problem, solver: cs.Solver) -> Array:
    """Return a pressure on one corner cell."""
    pressure = np.zeros_like(problem.undeformed_gap)
    pressure[0, 0] = 1.0
    return pressure


def _interrupted(problem: cs.Problem, solver: cs.Solver) -> Array:
    """Return the pressure after five iterations."""
    return cs.solve(problem, max_iterations=5, solver=solver).pressure


def _solver() -> dict[str, HardCase]:
    """Return contacts with extreme tolerances, limits and starts."""
    case = partial(replace, HardCase(with_heights(3 * ROUGH), grid(), AT_EDGE))
    # heights of 0.1 flatten at four times their load
    pressed = replace(with_heights(ROUGH), load=cs.LineLoad(16 * SCENE.largest_load))
    capped = replace(with_heights(ROUGH, FLAT), hardness=1.0001 * SCENE.largest_load / (2.4 * A))
    single = cs.SolveOptions(1e-10, precision=cs.Precision.SINGLE)
    return {
        "tolerance 1e-14": case(
            options=cs.SolveOptions(tolerance=1e-14), ends=EXACT_TO_ROUNDING | AT_EDGE
        ),
        "tolerance 1e-2": case(options=cs.SolveOptions(tolerance=1e-2)),
        "one iteration": case(
            options=cs.SolveOptions(1e-10, 1), ends=frozenset({cs.Status.ITERATION_LIMIT})
        ),
        "single precision": case(options=single, ends=frozenset({cs.Status.PRECISION_LIMIT})),
        "start at a wrong corner": case(start=_corner),
        "restart": case(start=_interrupted),
        "cap at near-full contact": case(scene=capped),
        "near-full rough contact": case(scene=with_heights(0.2 * ROUGH, FLAT)),
        "overloaded rough contact": case(scene=pressed),
    }


GROUPS: dict[str, dict[str, HardCase]] = {
    "discretisation": _discretisation(),
    "load": _load(),
    "units": units(),
    "material": _material(),
    "surface": _surface(),
    "perturbation": perturbation(),
    "solver": _solver(),
}
CASES = {name: case for cases in GROUPS.values() for name, case in cases.items()}
