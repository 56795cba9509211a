"""
Asperities that yield
=====================

A hardness caps the pressure. Below it nothing changes; where it is reached, other asperities carry the rest of the load.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
roughness = cs.Roughness(rms=1e-7, hurst=0.8, roll_off=6e-5, cut_off=1.5e-5, extent=(2.4e-4, 2.4e-4))
scene = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(radius=0.01), roughness))
grid = cs.Grid(cells=(128, 128), extent=(3.6e-4, 2.4e-4))

shares, areas = [], []
caps = np.array([3.0, 2.0, 1.5, 1.0, 0.8]) * 1e9
for hardness in caps:
    solution = cs.solve(replace(scene, hardness=hardness).problem(grid, cs.ExactPeriodicity()))
    touching = solution.pressure > 0
    shares.append(np.mean(solution.pressure[touching] == hardness))
    areas.append(touching.mean())
    assert solution.pressure.max() <= hardness

figure, ax = plt.subplots(layout="constrained")
ax.plot(caps / 1e9, shares, "o-", label="yielding, of the contact")
ax.plot(caps / 1e9, areas, "s-", label="in contact, of the grid")
ax.set(xlabel="hardness [GPa]", ylabel="share")
ax.legend()

# %%
# The softer the body, the more of the contact yields, and the larger it is.

print("yielding:", np.round(shares, 3))
assert (np.diff(shares) >= 0).all()
assert (np.diff(areas) > 0).all()
assert np.isclose(solution.pressure.sum() * grid.cell_area, 1e5 * grid.period, rtol=1e-7)
