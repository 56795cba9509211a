"""
Fretting wear under an oscillating force
========================================

A tangential force oscillates under a constant normal load. The middle of the contact sticks and never wears; slip wears the
surface on both sides, until the middle carries all of the load. Each step jumps over a number of cycles, which grows.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

steel = cs.HalfSpace(youngs_modulus=210e9, poisson_ratio=0.3)
load, friction, fraction = cs.LineLoad(1e5), 0.3, 0.6
force = fraction * friction * load.per_length  # N/m
jumps = [1.3**n for n in range(40)]  # cycles
ends = 0.5 + np.cumsum(jumps)
times, forces = [0.0, 0.5], [0.0, force]
for end, jump in zip(ends, jumps, strict=True):
    times += [end - jump / 2, end]
    forces += [-force, force]
fretting = cs.Fretting(friction, tuple(forces), times=tuple(times), period=1.0)  # s
wear = cs.Wear(coefficient=1e-12, speed=0.0)  # only the slip wears
scene = cs.Scene(load, (steel, steel), (cs.Cylinder(0.01),), friction=fretting, wear=wear)
half_width = scene.hertz.half_width
grid = cs.Grid((256, 1), (2.6 * half_width, 1e-3))
shown = (0.0, *ends[[18, 22, 27, 39]])
steps = cs.TimeSteps(times=shown, error_estimator="none")
worn = cs.solve(scene, grid, cs.ExactPeriodicity(), times=steps)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
x = grid.x / half_width
for time, frame in zip(shown, worn.frames, strict=True):
    left.plot(x, frame.pressure[:, 0] / 1e6, label=f"{time:.0f}")
    right.plot(x, frame.state["wear_depth"].values[:, 0] * 1e9)
left.set(xlabel="x over the half-width", ylabel="pressure [MPa]", ylim=(0, 1500))
left.legend(title="cycles")
right.set(xlabel="x over the half-width", ylabel="wear depth [nm]")

# %%
# The wear volume is the energy lost by friction, times the specific wear rate over the coefficient of friction. The half-width of the
# stick zone is ``c = (1 - Q / (mu P))^(1/2)`` half-widths. In the limit of no further wear the pressure is that of a punch of this width.

volume, energy = (worn.quantities[name].value for name in ("wear_volume", "friction_energy"))
print(f"wear volume {volume:.3g} m^3/m after {ends[-1]:.0f} cycles")
assert abs(volume / (wear.coefficient / friction * energy) - 1) < 1e-12

c, last = (1 - fraction) ** 0.5, worn.frames[-1]
inside = np.abs(x) < 0.9 * c
hertz = scene.hertz.peak_pressure
punch = hertz * (0.5 + c**2 / 2 - x[inside] ** 2) / np.sqrt(c**2 - x[inside] ** 2)
left.plot(x[inside], punch / 1e6, "k:")
# the edge of the stick zone is known to a cell
assert np.abs(last.pressure[inside, 0] / punch - 1).max() < 2 * grid.cell_size[0] / (c * half_width)
assert last.state["wear_depth"].values[inside].max() == 0
