"""
Stress below the surface
========================

Von Mises' stress below a smooth line contact is highest 0.704 half-widths below the surface, at 0.557 of the highest pressure
(for a Poisson's ratio of 0.3).
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
smooth = cs.Scene(cs.LineLoad(1e5), (steel, steel), (cs.Cylinder(radius=0.01),))
a, p_hertz = smooth.hertz.half_width, smooth.hertz.peak_pressure
depths = tuple(np.linspace(0.1, 2.0, 96) * a)
scene = cs.Scene(smooth.load, smooth.solids, smooth.shapes, outputs=(cs.SubsurfaceStress(depths),))
grid = cs.Grid(cells=(256, 1), extent=(4 * a, a))
dataset = cs.solve(scene.problem(grid, cs.ExactPeriodicity())).to_dataset()

below = dataset["von_mises"].isel(y=0) / p_hertz
figure, ax = plt.subplots(layout="constrained")
filled = ax.contourf(below["x"] / a, below["z"] / a, below, 20)
ax.invert_yaxis()
ax.set(xlabel="across / a", ylabel="depth / a", title="von Mises stress / p_H")
figure.colorbar(filled)

# %%
highest = float(below.max())
depth = float(below.max("x").idxmax("z")) / a
print(f"highest: {highest:.4f} p_H at {depth:.2f} a")
assert abs(highest - 0.5575) < 1e-3
assert abs(depth - 0.704) < 0.02
