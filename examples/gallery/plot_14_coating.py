"""
A coated body
=============

A layer four times as stiff as its substrate. A thin one leaves Hertz's contact of the substrate, a thick one that of the layer; the coefficients
are exact in between.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

substrate = cs.HalfSpace(youngs_modulus=50e9, poisson_ratio=0.3)
layer = cs.HalfSpace(youngs_modulus=200e9, poisson_ratio=0.3)
rigid = cs.HalfSpace(youngs_modulus=np.inf, poisson_ratio=0.0)
load, cylinder = cs.LineLoad(1e5), cs.Cylinder(radius=0.01)
bare = [cs.Scene(load, (solid, rigid), (cylinder,)).hertz for solid in (substrate, layer)]
grid = cs.Grid(cells=(256, 1), extent=(3 * bare[0].half_width, 1e-4))

thicknesses = np.geomspace(1e-3, 1e3, 13) * bare[1].half_width
peaks = []
for thickness in thicknesses:
    coated = cs.CoatedHalfSpace(coating=layer, thickness=thickness, substrate=substrate)
    scene = cs.Scene(load, (coated, rigid), (cylinder,))
    peaks.append(cs.solve(scene.problem(grid, cs.ExactPeriodicity())).pressure.max())

figure, ax = plt.subplots(layout="constrained")
ax.semilogx(thicknesses / bare[1].half_width, np.array(peaks) / 1e6, "o-")
for hertz in bare:
    ax.axhline(hertz.peak_pressure / 1e6, linestyle=":", color="black")
ax.set(xlabel="thickness / half-width on the layer's material", ylabel="highest pressure [MPa]")

# %%
# Both limits are those of Hertz.

print(
    "highest pressure over both limits:",
    peaks[0] / bare[0].peak_pressure,
    peaks[-1] / bare[1].peak_pressure,
)
assert abs(peaks[0] / bare[0].peak_pressure - 1) < 0.01
assert abs(peaks[-1] / bare[1].peak_pressure - 1) < 0.01
assert (np.diff(peaks) > 0).all()
