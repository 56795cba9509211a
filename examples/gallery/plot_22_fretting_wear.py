"""
Wear by a swinging force
========================

A tangential force swings beside a constant load. The middle of the contact sticks and never wears; the slip at its
sides wears the surface there, and what is worn away presses on the middle.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
load, friction, share = cs.LineLoad(1e5), 0.3, 0.6
force = share * friction * load.per_length  # N/m
cycles = 6
forces = (0.0, *(force, -force) * cycles, 0.0)
fretting = cs.Fretting(friction, forces, times=tuple(range(len(forces))))
wear = cs.Wear(coefficient=2e-10, speed=0.0)  # the slip is what wears
scene = cs.Scene(load, (steel, steel), (cs.Cylinder(0.01),), friction=fretting, wear=wear)
half_width = scene.hertz.half_width
grid = cs.Grid((160, 1), (2.6 * half_width, 1e-3))
times = np.arange(0.0, 2 * cycles + 2, 2)
worn = cs.solve(scene, grid, cs.ExactPeriodicity(), times=times)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
x = grid.x / half_width
for time, frame in zip(times, worn.frames, strict=True):
    left.plot(x, frame.pressure[:, 0] / 1e6, label=f"{time / 2:.0f}")
    right.plot(x, frame.state["worn_depth"].values[:, 0] * 1e9)
left.set(xlabel="x over the half-width", ylabel="pressure [MPa]")
left.legend(title="cycles")
right.set(xlabel="x over the half-width", ylabel="worn depth [nm]")

# %%
# The worn volume is the energy lost times the wear coefficient over that of friction, and the half-width of the stick
# zone is ``(1 - T / (mu P))^(1/2)`` half-widths.

volume, energy = (worn.quantities[name].value for name in ("worn_volume", "friction_energy"))
stuck = np.abs(x) < 0.95 * (1 - share) ** 0.5
depth = worn.frames[-1].state["worn_depth"].values[:, 0]
print(f"worn volume {volume:.3g} m^3/m, largest depth {depth.max() * 1e9:.0f} nm")
assert abs(volume / (wear.coefficient / friction * energy) - 1) < 1e-12
assert depth[stuck].max() == 0 < depth.max()
assert worn.frames[-1].pressure.max() > 1.01 * worn.frames[0].pressure.max()
