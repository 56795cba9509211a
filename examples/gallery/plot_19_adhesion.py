"""
A soft roller that sticks to a rough flat
=========================================

A rubber roller is pressed on a flat with longitudinal ridges, and pulled off. The valleys jump into contact one after the other, each at a larger load
than the one at which it jumps out of contact: the curves of loading and unloading enclose a loop, whose area is the hysteresis loss.
"""

import matplotlib.pyplot as plt
import numpy as np

import contactstudy as cs

rubber = cs.HalfSpace(youngs_modulus=1e6, poisson_ratio=0.49)
rigid = cs.HalfSpace(youngs_modulus=np.inf, poisson_ratio=0.3)
roller = cs.Cylinder(radius=0.01)
ridges = cs.Waviness(2e-6, across=1.5e-4), cs.Waviness(1e-6, across=7.1e-5)
adhesion = cs.Adhesion(work=0.05)  # J/m^2; the range is the shortest that the grid can hold
grid, padding = cs.Grid((1024, 1), (1.2e-3, 1.2e-3)), cs.ExactPeriodicity()
first, largest = 0.5, 12.0  # N/m
history = cs.LoadHistory((0, 1, 2), (first, largest, -6.0))
scene = cs.Scene(history, (rubber, rigid), (roller, *ridges), adhesion=adhesion)
times = np.concatenate([np.linspace(0, 1, 20), np.linspace(1, 2, 30)[1:]])
loop = cs.solve(scene, grid, padding, times=times)

touching = [frame for frame in loop.frames if frame.status is not cs.Status.DETACHED]
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
loads = [frame.load_per_length for frame in touching]
widths = [np.mean(frame.pressure > 0) * grid.extent[0] * 1e3 for frame in touching]
left.plot([frame.approach * 1e6 for frame in touching], loads, ".-")
left.set(xlabel="approach [µm]", ylabel="load [N/m]")
right.plot(loads, widths, ".-")
right.set(xlabel="load [N/m]", ylabel="width in contact [mm]")

# %%
# The pull-off load of a smooth roller is found by bisection, and known in the limit of short ranges (Johnson, Kendall &
# Roberts): ``3 (pi E* w^2 R / 16)^(1/3)``. With ridges the pull-off load is smaller.

pulled = cs.Scene(cs.PullOff(largest), (rubber, rigid), (roller,), adhesion=adhesion)
smooth = cs.solve(pulled, cs.Grid((512, 1), grid.extent), padding).quantities["pull_off"]
closed = 3 * (np.pi * scene.contact_modulus * adhesion.work**2 * roller.radius / 16) ** (1 / 3)
rough, lost = loop.quantities["pull_off"], loop.quantities["net_work"]
left.axhline(-rough.value, color="0.4", linestyle="--", label="pull-off")
left.legend()
print(f"smooth: {smooth}; closed form {closed:.4g} N/m")
print(f"ridges: {rough}; net work {lost}")
assert abs(smooth.value - closed) < smooth.bound < 0.05 * closed
assert rough.value < smooth.value
# the elastic work from the first load to separation, counted from twice the radius, is part of it
assert 2.6e-5 < lost.value < 3.3e-5
