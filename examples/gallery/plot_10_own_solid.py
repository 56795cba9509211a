"""
A solid of your own
===================

A body is what gives influence coefficients. Here it is Winkler's foundation, a bed of independent springs, whose
contact with a cylinder has a parabolic pressure.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs


@dataclass(frozen=True)
class Springs:
    """A cell moves under its own pressure alone."""

    parity: ClassVar[tuple[int, int]] = (1, 1)

    def turned(self):
        return self

    def cell(self, x, y, dx, dy):
        return ((np.abs(x) < dx / 2) & (np.abs(y) < dy / 2)).astype(float)

    def row(self, x, y, dx, dy, period):
        return self.cell(x, y, dx, dy)

    def lattice(self, x, y, dx, dy, width, period):
        return self.cell(x, y, dx, dy)


@dataclass(frozen=True)
class Foundation:
    """Springs of so many Pa/m."""

    stiffness: float

    @property
    def compliance(self) -> float:
        return 1e-3 / self.stiffness  # sets the scales of the problem only

    def response(self, datum: float) -> Mapping[cs.Coefficients, float]:
        return {Springs(): 1 / self.stiffness}


# %%
stiffness, radius, half_width = 1e13, 0.01, 1e-4
load = 2 / 3 * stiffness * half_width**3 / radius
rigid = cs.HalfSpace(youngs_modulus=np.inf, poisson_ratio=0.0)
scene = cs.Scene(cs.LineLoad(load), (Foundation(stiffness), rigid), (cs.Cylinder(radius),))
grid = cs.Grid(cells=(200, 1), extent=(4 * half_width, half_width))
solution = cs.solve(scene.problem(grid, cs.ExactPeriodicity()))
exact = stiffness * np.clip(half_width**2 - grid.x**2, 0, None) / (2 * radius)

figure, ax = plt.subplots(layout="constrained")
ax.plot(grid.x * 1e6, solution.pressure[:, 0] / 1e6, label="solved")
ax.plot(grid.x * 1e6, exact / 1e6, ":", color="black", label="closed form")
ax.set(xlabel="across [um]", ylabel="pressure [MPa]")
ax.legend()

worst = np.abs(solution.pressure[:, 0] - exact).max() / exact.max()
print(f"largest difference: {worst:.1e} of the highest pressure")
assert worst < (grid.cell[0] / half_width) ** 2
