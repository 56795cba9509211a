"""Hard cases that are compared with an equivalent form of the same contact."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import contactstudy as cs
from contactstudy.accuracy.residual_errors import residual_errors
from contactstudy.domain.fields import Array
from contactstudy.domain.grid import across_and_along
from studies.definitions.hard_case import (
    AT_EDGE,
    PADDINGS,
    ROUGH,
    HardCase,
    grid,
    noise,
    with_heights,
)
from studies.reference.line_contact import HERTZ_HEIGHT, SCENE, STEEL
from tests.hard_cases.dense_solver import DenseAnswer


@dataclass(frozen=True)
class EquivalentForm:
    """An equivalent form of the same contact, and the function that converts its pressure to the original form.

    With `other_heights` the heights differ from those of the original form.
    """

    scene: cs.Scene
    grid: cs.Grid
    to_original: Callable[[Array], Array]
    other_heights: bool = False


@dataclass(frozen=True)
class EquivalentCase(HardCase):
    """A hard case whose reference is the solution of an equivalent `form`."""

    form: EquivalentForm | None = None

    def reference(
        self, solution: cs.Contact, padding: cs.Padding | cs.Paddings, dense: DenseAnswer
    ) -> tuple[Array, float]:
        """Return the converted pressure of the form, and a bound on its error.

        The bound is that of the form, that of rounding, and other heights over the compliance of the stiffest mode.
        """
        form = self.form
        assert form is not None
        problem = form.scene.problem(form.grid, padding)
        other = self.solve(problem, cs.PreconditionedCG())
        bound = residual_errors(other).l1 + dense.error
        if form.other_heights:
            change = problem.undeformed_gap - solution.problem.undeformed_gap
            moved = float(np.linalg.norm(change)) / problem.scales.gap
            # L1 of a pressure is at most the root of the number of cells times L2
            root = np.count_nonzero(dense.pressure) ** 0.5
            bound += moved * root / dense.smallest_eigenvalue / dense.pressure.sum()
        return form.to_original(other.pressure), bound


def units() -> dict[str, EquivalentCase]:
    """Return the rough contact with every number in another unit."""
    cases: dict[str, EquivalentCase] = {}
    for name, metre, newton in (
        ("in nm", 1e9, 1.0),
        ("in km", 1e-3, 1.0),
        ("in TPa", 1.0, 1e-12),
        ("in nm and TPa", 1e9, 1e6),
        ("in Gm and yPa", 1e-9, 1e6),
    ):
        pascal = newton / metre**2
        solid = replace(STEEL, youngs_modulus=STEEL.youngs_modulus * pascal)
        load = cs.LineLoad(SCENE.largest_load * newton / metre)
        plain = with_heights(ROUGH)
        heights = cs.MeasuredSurface(ROUGH * HERTZ_HEIGHT * metre)
        converted = cs.Scene(load, (solid, solid), (cs.Cylinder(0.01 * metre), heights))
        form = EquivalentForm(converted, grid(metre=metre), partial(np.multiply, 1 / pascal))
        cases[f"a scene {name}"] = EquivalentCase(
            plain, grid(), AT_EDGE, cs.SolveOptions(tolerance=1e-12), form=form
        )
    return cases


def perturbation() -> dict[str, EquivalentCase]:
    """Return the rough contact with changed heights, shifted, mirrored, over two periods, or with two curved bodies."""
    scene = with_heights(ROUGH)
    double = with_heights(np.tile(ROUGH, 2))
    half = replace(SCENE, shapes=(cs.Cylinder(0.02), cs.Cylinder(0.02)))
    on = grid()

    plain = EquivalentCase(scene, on, options=cs.SolveOptions(tolerance=1e-12))
    along = {name: across_and_along(padding)[1] for name, padding in PADDINGS.items()}
    wrapping = tuple(name for name, padding in along.items() if padding.wraps)
    endless = tuple(name for name, padding in along.items() if padding.window is None)
    rolled = with_heights(np.roll(ROUGH, 5, 1))
    back = partial(np.roll, shift=-5, axis=1)
    nudged = ROUGH + 1e-10 * ROUGH.std() * noise(seed=5)
    forms = {
        "heights nudged by 1e-10": EquivalentForm(
            with_heights(nudged), on, np.asarray, other_heights=True
        ),
        "moved by whole cells": EquivalentForm(rolled, on, back),
        "mirrored along": EquivalentForm(with_heights(ROUGH[:, ::-1]), on, np.fliplr),
        "mirrored across": EquivalentForm(with_heights(ROUGH[::-1]), on, np.flipud),
        "twice the period": EquivalentForm(
            double, grid((24, 24), period=2.4), lambda pressure: pressure[:, :12]
        ),
        "curved on both sides": EquivalentForm(with_heights(ROUGH, half), on, np.asarray),
    }
    paddings = {"moved by whole cells": wrapping, "twice the period": endless}
    return {
        name: replace(plain, form=form, paddings=paddings.get(name, plain.paddings))
        for name, form in forms.items()
    }
