"""
The load-area curve of a rough surface
======================================

A flat, self-affine surface, periodic along both axes. At light loads the real contact area grows in proportion to the load:
``A / A0 = kappa p / (E* h')``, with the root-mean-square slope h' and a factor kappa near 2.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
rigid = cs.HalfSpace(youngs_modulus=np.inf, poisson_ratio=0.0)
slope, size = 0.05, 1e-4
surface = cs.Roughness(
    rms=cs.RmsSlope(slope), hurst=0.8, roll_off=size / 4, cut_off=size / 32, seed=3, extent=(size, size)
)
grid = cs.Grid(cells=(256, 256), extent=(size, size))
periodic = (cs.ExactPeriodicity(), cs.ExactPeriodicity())

# %%
# Each load starts from the pressure of the one before, which saves iterations.

pressures = np.geomspace(0.002, 0.1, 9)  # mean pressure over E* h'
areas, iterations, start = [], [], None
for reduced in pressures:
    scene = cs.Scene(cs.LineLoad(1.0), (steel, rigid), (surface,))
    mean = reduced * scene.contact_modulus * slope
    scene = cs.Scene(cs.LineLoad(mean * size), (steel, rigid), (surface,))
    solution = cs.solve(scene.problem(grid, periodic), tolerance=1e-6, start=start)
    start = solution.pressure
    areas.append(np.mean(solution.pressure > 0))
    iterations.append(solution.iterations)
areas = np.array(areas)
print("iterations:", iterations)

# %%
# The cells at the perimeter of the contact count in full, so the area is somewhat too large on any grid.

figure, ax = plt.subplots(layout="constrained")
ax.loglog(pressures, areas, "o-", label="256 x 256 cells")
ax.loglog(pressures, 2 * pressures, ":", color="black", label="kappa = 2")
ax.set(xlabel="mean pressure / (E* h')", ylabel="share in contact")
ax.legend()

kappa = areas / pressures
print("kappa:", np.round(kappa, 2))
assert 1.7 < kappa[-1] < kappa[0] < 3.0
