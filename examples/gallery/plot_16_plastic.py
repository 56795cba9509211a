"""
A body that yields
==================

A rigid cylinder is pressed on a body to three times its yield stress and lifted. The pressure becomes flatter than Hertz's; a dent and
a residual stress are left.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

body = cs.ElasticPlasticHalfSpace(
    youngs_modulus=210e9, poisson_ratio=0.3, yield_stress=1e9, hardening_modulus=21e9
)
rigid = cs.HalfSpace(youngs_modulus=np.inf, poisson_ratio=0.3)
radius = 0.01
modulus = 210e9 / (1 - 0.3**2)
a = 2 * radius * 3e9 / modulus  # Hertz's half-width at p_H = 3 Y
load = np.pi / 2 * 3e9 * a
scene = cs.Scene(
    load=cs.LoadHistory(times=(0, 1, 2), per_length=(0, load, 0)),
    solids=(body, rigid),
    shapes=(cs.Cylinder(radius=radius),),
)
grid = cs.Grid(cells=(64, 1), extent=(6.4 * a, a))
times = [*np.linspace(0, 1, 9), 2]
dataset = cs.evolve(scene, grid, cs.ExactPeriodicity(), times=times).to_dataset().squeeze("y")

figure, (left, right) = plt.subplots(1, 2, layout="constrained", figsize=(9, 3.5))
for index in (2, 4, 6, 8):
    line = dataset["pressure"].isel(time=index) / 3e9
    left.plot(dataset["x"] / a, line, label=f"{index / 8:.3g} of the load")
left.set(xlabel="across / a", ylabel="pressure / p_H", xlim=(-1.5, 1.5))
left.legend()
strain = dataset["equivalent_plastic_strain"].isel(time=-1) * 100
mesh = right.pcolormesh(dataset["x"] / a, dataset["z"] / a, strain, shading="nearest")
right.set(xlabel="across / a", ylabel="depth / a", xlim=(-1.5, 1.5), ylim=(3, 0))
figure.colorbar(mesh, ax=right, label="equivalent plastic strain [%]")

# %%
# An independent finite-element march with the same eight steps has 0.7927 of Hertz's peak pressure, a plastic zone down to 2.5 half-widths, and
# a residual stress across of -0.234 of the yield stress.

highest = float(dataset["highest_pressure"].max()) / 3e9
residual = (
    float(dataset["residual_stress"].sel(component="xx").isel(time=-1, x=[31, 32]).min()) / 1e9
)
print(f"highest pressure {highest:.4f} p_H, residual stress on the axis {residual:.3f} Y")
assert abs(highest - 0.7927) < 3e-3
assert abs(residual + 0.234) < 3e-3
