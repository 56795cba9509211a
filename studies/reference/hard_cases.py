"""The hard cases, by name and group."""

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
    GAP_SCALE,
    P_H,
    ROUGH,
    A,
    HardCase,
    grid,
    noise,
    perturbation,
    units,
    with_heights,
)
from studies.reference.line_contact import SCENE, STEEL


def _discretisation() -> dict[str, HardCase]:
    """Return contacts with extreme periods, aspects and numbers of cells."""

    def case(hard: str, cells: tuple[int, int], width: float, period: float) -> HardCase:
        ends = AT_EDGE if cells[0] < 4 else ENDED
        return HardCase("discretisation", hard, SCENE, grid(cells, width, period), ends)

    periods = {
        f"period {period:g} a": case(f"a period of {period:g} half-widths", (24, 6), 2.4, period)
        for period in (1e-3, 1e-2, 1e2, 1e3)
    }
    aspects = {
        f"cells 1:{aspect:g}": case(
            f"cells {aspect:g} times as long as wide", (24, 6), 2.4, 0.6 * aspect
        )
        for aspect in (1e-3, 1e3)
    }
    counts = {
        f"{nx} x {ny} cells": case("few, odd or prime numbers of cells", (nx, ny), 2.4, 1.2)
        for nx, ny in ((24, 1), (24, 2), (2, 1), (3, 1), (25, 9), (23, 13))
    }
    return periods | aspects | counts


def _load() -> dict[str, HardCase]:
    """Return contacts with extreme loads and contact areas."""

    case = partial(HardCase, "load")
    faint = replace(SCENE, load=cs.LineLoad(1e-30))
    heavy = replace(SCENE, load=cs.LineLoad(1e30))
    spike = with_heights(np.eye(1, 288, 150).reshape(CELLS) * 30)
    far, coarse = with_heights(ROUGH + 1e6), with_heights(noise())
    wavy = replace(FLAT, shapes=(cs.Waviness(1e-3 * GAP_SCALE, along=1.2 * A),))
    return {
        "one row of cells touches": case(
            "a contact a twentieth of a cell wide", SCENE, grid((25, 4), 1000.0)
        ),
        "one cell touches": case("a spike alone carries the load", spike, grid()),
        "contact reaches the edge": case(
            "a width of 1.5 half-widths", SCENE, grid(width=1.5), AT_EDGE
        ),
        "full contact": case("no cell is free of pressure", wavy, grid(), AT_EDGE),
        "faint load": case("1e-30 N/m, a contact of 1e-17 cells", faint, grid()),
        "far from its datum": case("heights counted from 1e6 times a²/(2R)", far, grid()),
        "coarse cells": case(
            "rough cells 40 times as wide as the contact", coarse, grid(CELLS, 1e3, 1e3)
        ),
        "shape flattened": case(
            "1e30 N/m, the cylinder is no more than flat", heavy, grid(), AT_EDGE
        ),
    }


def _material() -> dict[str, HardCase]:
    """Return contacts with extreme moduli, Poisson's ratios and hardnesses."""

    rigid, cork = cs.HalfSpace(inf, 0.3), cs.HalfSpace(210e9, 0.0)
    rubber, foam = cs.HalfSpace(210e9, 0.5), cs.HalfSpace(210e3, 0.3)
    bodies = {
        "rigid on elastic": ((rigid, STEEL), "one body is rigid"),
        "Poisson's ratio 0": ((cork, cork), "nu = 0"),
        "Poisson's ratio 0.5": ((rubber, rubber), "nu = 0.5, incompressible"),
        "moduli 1:10^6": ((STEEL, foam), "moduli a factor of 10^6 apart"),
    }
    cases = {}
    for name, (solids, hard) in bodies.items():
        scene = replace(SCENE, solids=solids)
        hertz = scene.hertz
        assert hertz is not None
        extent = (2.4 * hertz.half_width, 1.2 * hertz.half_width)
        cases[name] = HardCase("material", hard, scene, cs.Grid(CELLS, extent))
    wide = grid(width=4.8)
    for fraction in (1.01, 0.99, 0.7, 0.4, 0.33, 0.328):
        scene = replace(with_heights(ROUGH), hardness=fraction * P_H)
        hard = f"a hardness of {fraction:g} p_H; 0.327 carries the load"
        cases[f"hardness {fraction:g} p_H"] = HardCase("material", hard, scene, wide, AT_EDGE)
    # where trial steps are shortened to zero: all but a few cells yield, or the cells are long and thin
    options = cs.SolveOptions(tolerance=1e-9)
    thin = with_heights(8.087711031384107e-4 * noise((15, 2), 23030886))
    thin, hard = (
        replace(thin, hardness=0.321 * P_H),
        "cells 30 times as wide as long, some at a hardness",
    )
    on = grid((15, 2), 110.95259085951773, 0.4464264239955842)
    cases["hardness on long cells"] = HardCase("material", hard, thin, on, AT_EDGE, options=options)
    full = with_heights(0.08086197949648571 * noise((7, 7), 632285552), FLAT)
    full, hard = replace(full, hardness=0.03661931369241763 * P_H), "all but two cells yield"
    on, ends = grid((7, 7), 44.29302973822934, 2.0062328974336388), AT_EDGE | {cs.Status.STALLED}
    cases["hardness beside the mean"] = HardCase("material", hard, full, on, ends, options=options)
    soft, hard = replace(SCENE, hardness=0.3 * P_H), "a hardness too low to carry the load"
    ends = frozenset({cs.Status.NO_ADMISSIBLE_PRESSURE})
    cases["hardness 0.3 p_H"] = HardCase("material", hard, soft, wide, ends)
    return cases


def _surface() -> dict[str, HardCase]:
    """Return contacts with steps, spikes and rough surfaces."""

    def case(hard: str, heights: Array, width: float = 2.4) -> HardCase:
        return HardCase("surface", hard, with_heights(heights), grid(heights.shape, width), AT_EDGE)

    rng = np.random.default_rng(3)
    needle = np.zeros((32, 32))
    needle[16, 8] = 100.0
    spikes = np.where(rng.random(CELLS) < 0.05, 20.0, 0.0)
    step = np.zeros(CELLS)
    step[:, 6:] = 0.5
    checks = 0.3 * (np.indices(CELLS).sum(axis=0) % 2)
    plateau = np.where(np.abs(grid().x)[:, None] < 0.5 * A, 0.0, -1e4) * np.ones(CELLS)
    return {
        "0.1 % contact": case("one cell in 1024", needle),
        "spikes of one cell": case("one cell in twenty stands out by 20 times a²/(2R)", spikes),
        "a step": case("a step half as high as a²/(2R)", step),
        "noise of the grid's wavelength": case("every other cell is higher", checks),
        "white noise": case("white noise as high as a²/(2R)", noise()),
        "rms 100 times the approach": case("white noise, 100 times a²/(2R)", 100 * noise()),
        "a flat punch": HardCase(
            "surface", "a plateau with sharp edges", with_heights(plateau, FLAT), grid(), AT_EDGE
        ),
    }


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
    case = partial(replace, HardCase("solver", "", with_heights(3 * ROUGH), grid(), AT_EDGE))
    limited = frozenset({cs.Status.ITERATION_LIMIT})
    # heights of 0.1 flatten at four times their load
    pressed = replace(with_heights(ROUGH), load=cs.LineLoad(16 * SCENE.load.largest))
    capped = replace(with_heights(ROUGH, FLAT), hardness=1.0001 * SCENE.load.largest / (2.4 * A))
    near_start = with_heights(0.2 * ROUGH, FLAT)
    return {
        "tolerance 1e-14": case(
            hard="a tolerance beside rounding",
            options=cs.SolveOptions(tolerance=1e-14),
            ends=EXACT_TO_ROUNDING | AT_EDGE,
        ),
        "tolerance 1e-2": case(hard="a loose tolerance", options=cs.SolveOptions(tolerance=1e-2)),
        "one iteration": case(
            hard="a limit of one iteration", options=cs.SolveOptions(1e-10, 1), ends=limited
        ),
        "single precision": case(
            hard="a tolerance beyond single precision",
            options=cs.SolveOptions(1e-10, precision=cs.Precision.SINGLE),
            ends=frozenset({cs.Status.PRECISION_LIMIT}),
        ),
        "start at a wrong corner": case(hard="all load on a corner at first", start=_corner),
        "restart": case(hard="stopped after five iterations, then on", start=_interrupted),
        "cap at near-full contact": case(
            hard="a hardness one in 10^4 above the mean pressure", scene=capped
        ),
        "near-full rough contact": case(hard="the last deep valleys", scene=near_start),
        "overloaded rough contact": case(hard="16 times the load on the same width", scene=pressed),
    }


CASES: dict[str, HardCase] = (
    _discretisation() | _load() | units() | _material() | _surface() | perturbation() | _solver()
)
GROUPS = tuple(dict.fromkeys(case.group for case in CASES.values()))
